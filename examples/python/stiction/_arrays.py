"""Arguments made arrays of one type; complaints name the argument."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ._types import Array, Rows

#: The scene as the compiled side takes it.
Scene = tuple[Array | None, ...]


def number_type(dtype: DTypeLike) -> np.dtype[Any]:
    """``float32`` or ``float64``."""
    found = np.dtype(dtype)
    if found not in (np.float32, np.float64):
        raise ValueError(f"dtype: {found} is not float32 or float64")
    return found


def array(name: str, given: ArrayLike, dtype: np.dtype[Any]) -> Array:
    """An array of this type, contiguous; the one that was given, if it is so already."""
    if isinstance(given, np.ndarray) and given.dtype == dtype and given.flags.c_contiguous:
        return given
    try:
        found = np.asarray(given)
        if found.dtype.kind not in "fiub":
            raise TypeError(f"numbers of type {found.dtype}")
        return np.ascontiguousarray(found, dtype=dtype).reshape(found.shape)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{name}: {error}") from None


def keys_array(name: str, given: ArrayLike) -> NDArray[np.uint32]:
    """Keys, which fit in 32 bits."""
    found = np.asarray(given)
    if found.dtype.kind not in "iu" or (found.size and (found.min() < 0 or found.max() >= 2**32)):
        raise ValueError(f"{name}: not integers from 0 to 2**32 - 1")
    return np.ascontiguousarray(found, dtype=np.uint32).reshape(found.shape)


def friction(mu: ArrayLike, offsets: Array, dtype: np.dtype[Any], lead: int) -> Array:
    """Coefficients; one number is that of all contacts."""
    found = array("mu", mu, dtype)
    if found.ndim > 0:
        return found
    if offsets.ndim < lead + 2:
        raise ValueError("mu: one number does not tell how many contacts there are; give w as (contacts, rows)")
    return np.full((1,) * lead + (offsets.shape[lead],), found, dtype)


def rows_tuple(rows: Rows | None, dtype: np.dtype[Any], lead: int, is_delassus: bool) -> tuple[Any, ...] | None:
    """Joint rows, with one number for all made arrays."""
    if rows is None:
        return None
    jacobian = None
    numbers = {
        name: array(f"rows.{name}", getattr(rows, name), dtype) for name in ("offset", "lower", "upper", "compliance")
    }
    keys = keys_array("rows.keys", rows.keys)
    given = [found for found in (*numbers.values(), keys) if found.ndim > 0]
    if not is_delassus:
        if rows.jacobian is None:
            raise ValueError("rows.jacobian: there is none")
        jacobian = array("rows.jacobian", rows.jacobian, dtype)
        if jacobian.ndim != lead + 2:
            raise ValueError(f"rows.jacobian: shape {list(jacobian.shape)} is not (rows, velocities)")
        shape = jacobian.shape[:-1]
    elif given:
        shape = max((found.shape for found in given), key=len)
    else:
        raise ValueError("rows.offset: one number does not tell how many rows there are")
    one = (1,) * lead + shape[lead:]
    full = [found if found.ndim > 0 else np.full(one, found, dtype) for found in numbers.values()]
    return (jacobian, *full, keys if keys.ndim > 0 else np.full(one, keys, np.uint32))


def scene(
    dynamics: tuple[ArrayLike | None, ArrayLike | None, ArrayLike | None],
    w: ArrayLike,
    mu: ArrayLike,
    compliance: ArrayLike | None,
    keys: ArrayLike | None,
    rows: Rows | None,
    dtype: np.dtype[Any],
    lead: int = 0,
) -> Scene:
    """A scene, or a batch of them with ``lead`` = 1."""
    first, jacobian, push = dynamics
    is_delassus = jacobian is None
    offsets = array("q" if is_delassus else "w", w, dtype)
    return (
        array("W" if is_delassus else "M", first, dtype),  # type: ignore[arg-type]
        None if jacobian is None else array("H", jacobian, dtype),
        None if push is None else array("free_impulse", push, dtype),
        offsets,
        friction(mu, offsets, dtype, lead),
        None if compliance is None else array("compliance", compliance, dtype),
        None if keys is None else keys_array("keys", keys),
        rows_tuple(rows, dtype, lead, is_delassus),  # type: ignore[return-value]
    )


def settings(tol: float, budget: int, relaxed: bool) -> tuple[float, int, bool]:
    """Tolerance, budget and law, of the types that the compiled side takes."""
    try:
        tolerance = float(tol)
    except (TypeError, ValueError):
        raise ValueError(f"tol: {tol!r} is not a number") from None
    if isinstance(budget, bool) or not isinstance(budget, int | np.integer) or budget < 0:
        raise ValueError(f"budget: {budget!r} is not a number of iterations")
    return tolerance, int(budget), bool(relaxed)
