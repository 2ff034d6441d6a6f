"""A solve that JAX differentiates, forward and backward. Who imports this module imports JAX."""

from __future__ import annotations

from functools import partial
from itertools import compress
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.custom_derivatives import SymbolicZero
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from ._kernel import solve as _solve

_NAMES = ("M", "H", "free_impulse", "w", "mu")


def _solved(arrays: tuple[Any, ...]) -> Any:
    return _solve(*(np.asarray(array, np.float64) for array in arrays), tol=1e-9)


def _call(host: Any, shapes: Any, *arrays: Any) -> Any:
    """Call the host with arrays, and give its results the shapes and types of others."""
    structures = [jax.ShapeDtypeStruct(like.shape, like.dtype) for like in shapes]  # type: ignore[no-untyped-call]

    def cast(*given: Any) -> list[Any]:
        return [np.asarray(found, like.dtype).reshape(like.shape) for found, like in zip(host(*given), structures, strict=True)]

    return jax.pure_callback(cast, structures, *arrays, vmap_method="sequential")


@jax.custom_jvp
def solve(M: Any, H: Any, free_impulse: Any, w: Any, mu: Any) -> tuple[Any, Any]:
    """Velocity and impulses of :func:`stiction.solve` to 1e-9, for arrays of JAX.

    Args:
        M: generalised mass matrix, ``(n, n)``; kg, kg·m, kg·m² by the units of the velocities.
        H: contact Jacobians, ``(c, d, n)`` or ``(c·d, n)``, rows with the normal first; 1 or m.
        free_impulse: ``M v + h F``, ``(n,)``; N·s, N·m·s.
        w: offsets, ``(c, d)``; m/s.
        mu: friction coefficients, ``(c,)``, no unit.

    Returns:
        The velocity at the end of the step, ``(n,)``, m/s and rad/s, and the contact impulses, ``(c, d)``, N·s, normal first.
    """

    def host(*arrays: Any) -> tuple[Any, Any]:
        found = _solved(arrays)
        return found.v, found.r

    v, r = _call(host, (free_impulse, w), M, H, free_impulse, w, mu)
    return v, r


@partial(solve.defjvp, symbolic_zeros=True)
def _changed(arrays: Any, changes: Any) -> tuple[Any, Any]:
    moves = tuple(not isinstance(change, SymbolicZero) for change in changes)
    v, r = _CHANGE.bind(*arrays, *compress(changes, moves), moves=moves)  # type: ignore[no-untyped-call]
    return solve(*arrays), (v, r)


#: How velocity and impulses move with those arrays that do: linear in their changes, which come after all arrays.
_CHANGE = Primitive("stiction_change")
_CHANGE.multiple_results = True


@_CHANGE.def_impl  # type: ignore[untyped-decorator]
def _forward(*operands: Any, moves: tuple[bool, ...]) -> Any:
    def host(*given: Any) -> tuple[Any, Any]:
        changes = (np.asarray(change, np.float64) for change in given[len(_NAMES) :])
        found = _solved(given[: len(_NAMES)]).jvp(**dict(zip(compress(_NAMES, moves), changes, strict=True)))
        return found.v, found.r

    return _call(host, operands[2:4], *operands)


def _backward(weights: Any, *operands: Any, moves: tuple[bool, ...]) -> list[Any]:
    """How a sum of velocities and impulses moves with the arrays: the transpose."""
    arrays = operands[: len(_NAMES)]

    def host(v: Any, r: Any, *given: Any) -> tuple[Any, ...]:
        found = _solved(given).vjp(v=np.asarray(v, np.float64), r=np.asarray(r, np.float64))
        return tuple(getattr(found, name) for name in compress(_NAMES, moves))

    v, r = (ad.instantiate_zeros(weight) for weight in weights)  # type: ignore[no-untyped-call]
    gradients = _call(host, tuple(compress(arrays, moves)), v, r, *arrays)
    asked = (ad.is_undefined_primal(change) for change in operands[len(_NAMES) :])  # type: ignore[no-untyped-call]
    return [None] * len(_NAMES) + [gradient if is_asked else None for gradient, is_asked in zip(gradients, asked, strict=True)]


def _batched(operands: Any, axes: Any, *, moves: tuple[bool, ...]) -> Any:
    """One after the other."""
    size = next(operand.shape[axis] for operand, axis in zip(operands, axes, strict=True) if axis is not None)
    leading = [
        jnp.broadcast_to(operand, (size, *operand.shape)) if axis is None else jnp.moveaxis(operand, axis, 0)
        for operand, axis in zip(operands, axes, strict=True)
    ]
    bind = partial(_CHANGE.bind, moves=moves)
    return jax.lax.map(lambda own: bind(*own), tuple(leading)), [0, 0]


_CHANGE.def_abstract_eval(lambda *operands, moves: list(operands[2:4]))  # type: ignore[no-untyped-call]
ad.primitive_transposes[_CHANGE] = _backward
batching.primitive_batchers[_CHANGE] = _batched
mlir.register_lowering(_CHANGE, mlir.lower_fun(_forward, multiple_results=True))
