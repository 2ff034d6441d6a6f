"""A solve that JAX differentiates, backward. Who imports this module imports JAX."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

from ._kernel import solve as _solve


def _solved(arrays: tuple[Any, ...]) -> Any:
    return _solve(*(np.asarray(array, np.float64) for array in arrays), tol=1e-9)


def _call(host: Any, shapes: Any, *arrays: Any) -> Any:
    """Call the host with arrays, and give its results the shapes and types of others."""
    structures = [jax.ShapeDtypeStruct(like.shape, like.dtype) for like in shapes]  # type: ignore[no-untyped-call]

    def cast(*given: Any) -> list[Any]:
        return [np.asarray(found, like.dtype).reshape(like.shape) for found, like in zip(host(*given), structures, strict=True)]

    return jax.pure_callback(cast, structures, *arrays, vmap_method="sequential")


@jax.custom_vjp
def solve(M: Any, H: Any, free_impulse: Any, w: Any, mu: Any) -> tuple[Any, Any]:
    """Velocity and impulses of :func:`stiction.solve` to 1e-9, for arrays of JAX: ``w`` is ``(c, d)``, ``mu`` ``(c,)``."""

    def host(*arrays: Any) -> tuple[Any, Any]:
        found = _solved(arrays)
        return found.v, found.r

    v, r = _call(host, (free_impulse, w), M, H, free_impulse, w, mu)
    return v, r


def _forward(*arrays: Any) -> tuple[Any, Any]:
    return solve(*arrays), arrays


def _backward(arrays: Any, weights: Any) -> tuple[Any, ...]:
    def host(v: Any, r: Any, *arrays: Any) -> tuple[Any, ...]:
        found = _solved(arrays).vjp(v=np.asarray(v, np.float64), r=np.asarray(r, np.float64))
        return found.M, found.H, found.free_impulse, found.w, found.mu

    return tuple(_call(host, arrays, *weights, *arrays))


solve.defvjp(_forward, _backward)
