"""A solve that JAX differentiates, forward and backward. Who imports this module imports JAX."""

from __future__ import annotations

from functools import partial
from itertools import compress
from operator import attrgetter
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.custom_derivatives import SymbolicZero
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from ._derivative import RowChange
from ._kernel import solve as _solve
from ._layers import CONSTANT, arguments, named
from ._solution import Solution
from ._types import Rows

#: The names of arrays, and the tolerance.
_Asked = tuple[tuple[str, ...], float]


def _solved(asked: _Asked, arrays: Any) -> Solution:
    names, tol = asked
    return _solve(**arguments(names, arrays, Rows), tol=tol)


def _call(host: Any, shapes: Any, *arrays: Any) -> Any:
    """Call the host with arrays, and give its results the shapes and types of others."""
    structures = [jax.ShapeDtypeStruct(like.shape, like.dtype) for like in shapes]  # type: ignore[no-untyped-call]

    def cast(*given: Any) -> list[Any]:
        return [np.asarray(found, like.dtype).reshape(like.shape) for found, like in zip(host(*given), structures, strict=True)]

    return jax.pure_callback(cast, structures, *arrays, vmap_method="sequential")


def solve(
    M: Any,
    H: Any,
    free_impulse: Any,
    w: Any = None,
    mu: Any = None,
    *,
    tol: float = 1e-9,
    rows: Rows | None = None,
    compliance: Any = None,
) -> tuple[Any, Any]:
    """Velocity and impulses of :func:`stiction.solve`, for arrays of JAX.

    Args:
        M: generalised mass matrix, ``(n, n)``; kg, kg·m, kg·m² by the units of the velocities.
        H: contact Jacobians, ``(c, d, n)`` or ``(c·d, n)``, rows with the normal first; 1 or m. ``None`` for a scene of joint rows
            alone.
        free_impulse: ``M v + h F``, ``(n,)``; N·s, N·m·s.
        w: offsets, ``(c, d)``; m/s. ``None`` is 0.
        mu: friction coefficients, ``(c,)`` or one number, no unit.
        tol: error up to which the scene counts as solved, relative to the impulses; no unit. A derivative is as exact.
        rows: joint rows, with arrays of JAX; it is differentiated by all but keys, which are not read.
        compliance: of contacts, ``(c,)`` or one number, 1/kg; or along the normal and along the tangents, ``(c, 2)``; ``None`` is
            rigid. It is a constant: a derivative by it is refused.

    Returns:
        The velocity at the end of the step, ``(n,)``, m/s and rad/s, and the contact impulses, ``(c, d)``, N·s, normal first.
    """

    def spread(given: Any, shape: tuple[int, ...]) -> Any:
        return jnp.broadcast_to(jnp.asarray(given), shape)

    arrays = named((M, H, free_impulse, w, mu), compliance, rows, jnp.zeros, spread)
    v, r = _found((tuple(arrays), float(tol)), *arrays.values())
    return v, r


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _found(asked: _Asked, *arrays: Any) -> Any:
    def host(*given: Any) -> tuple[Any, Any]:
        found = _solved(asked, given)
        return found.v, found.r

    return _call(host, arrays[2:4], *arrays)


@partial(_found.defjvp, symbolic_zeros=True)
def _changed(asked: _Asked, arrays: Any, changes: Any) -> tuple[Any, Any]:
    moves = tuple(not isinstance(change, SymbolicZero) for change in changes)
    if "compliance" in compress(asked[0], moves):
        raise ValueError(CONSTANT)
    changed = _CHANGE.bind(*arrays, *compress(changes, moves), asked=asked, moves=moves)  # type: ignore[no-untyped-call]
    return _found(asked, *arrays), changed


#: How velocity and impulses move with those arrays that do: linear in their changes, which come after all arrays.
_CHANGE = Primitive("stiction_change")
_CHANGE.multiple_results = True


@_CHANGE.def_impl  # type: ignore[untyped-decorator]
def _forward(*operands: Any, asked: _Asked, moves: tuple[bool, ...]) -> Any:
    count = len(moves)

    def host(*given: Any) -> tuple[Any, Any]:
        found = _solved(asked, given[:count]).jvp(**arguments(compress(asked[0], moves), given[count:], RowChange))
        return found.v, found.r

    return _call(host, operands[2:4], *operands)


def _backward(weights: Any, *operands: Any, asked: _Asked, moves: tuple[bool, ...]) -> list[Any]:
    """How a sum of velocities and impulses moves with the arrays: the transpose."""
    count = len(moves)
    arrays = operands[:count]

    def host(v: Any, r: Any, *given: Any) -> tuple[Any, ...]:
        found = _solved(asked, given).vjp(v=np.asarray(v, np.float64), r=np.asarray(r, np.float64))
        return tuple(attrgetter(name)(found) for name in compress(asked[0], moves))

    v, r = (ad.instantiate_zeros(weight) for weight in weights)  # type: ignore[no-untyped-call]
    gradients = _call(host, tuple(compress(arrays, moves)), v, r, *arrays)
    wanted = (ad.is_undefined_primal(change) for change in operands[count:])  # type: ignore[no-untyped-call]
    return [None] * count + [gradient if is_wanted else None for gradient, is_wanted in zip(gradients, wanted, strict=True)]


def _batched(operands: Any, axes: Any, **asked: Any) -> Any:
    """One after the other."""
    size = next(operand.shape[axis] for operand, axis in zip(operands, axes, strict=True) if axis is not None)
    leading = [
        jnp.broadcast_to(operand, (size, *operand.shape)) if axis is None else jnp.moveaxis(operand, axis, 0)
        for operand, axis in zip(operands, axes, strict=True)
    ]
    bind = partial(_CHANGE.bind, **asked)
    return jax.lax.map(lambda own: bind(*own), tuple(leading)), [0, 0]


_CHANGE.def_abstract_eval(lambda *operands, **_: list(operands[2:4]))  # type: ignore[no-untyped-call]
ad.primitive_transposes[_CHANGE] = _backward
batching.primitive_batchers[_CHANGE] = _batched
mlir.register_lowering(_CHANGE, mlir.lower_fun(_forward, multiple_results=True))
