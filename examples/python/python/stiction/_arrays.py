"""Arguments made arrays of one type; complaints name the argument."""

from __future__ import annotations

import operator
import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ._types import Array, Rows

#: The scene as the compiled side takes it.
Scene = tuple[Any, ...]


DOUBLE = np.dtype(np.float64)


def number_type(dtype: DTypeLike) -> np.dtype[Any]:
    """``float32`` or ``float64``."""
    if dtype is DOUBLE:
        return DOUBLE
    try:
        found = np.dtype(dtype)
    except TypeError as error:
        raise ValueError(f"dtype: {error}") from None
    if found not in (np.float32, np.float64):
        raise ValueError(f"dtype: {found} is not float32 or float64")
    return found


def array(name: str, given: ArrayLike, dtype: np.dtype[Any]) -> Array:
    """An array of this type, contiguous; the one that was given, if it is so already."""
    if isinstance(given, np.ndarray) and given.dtype == dtype and given.flags.c_contiguous and given.flags.aligned:
        return given
    try:
        found = np.asarray(given)
        if found.dtype.kind not in "fiub":
            raise TypeError(f"numbers of type {found.dtype}")
        return np.require(found, dtype, ("C", "A")).reshape(found.shape)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{name}: {error}") from None


def keys_array(name: str, given: ArrayLike) -> NDArray[np.uint32]:
    """Keys, which fit in 32 bits."""
    found = np.asarray(given)
    if found.dtype.kind not in "iu" or (found.size and (found.min() < 0 or found.max() >= 2**32)):
        raise ValueError(f"{name}: not integers from 0 to 2**32 - 1")
    return np.require(found, np.uint32, ("C", "A")).reshape(found.shape)


def friction(mu: ArrayLike, offsets: ArrayLike, jacobian: ArrayLike, dtype: np.dtype[Any], lead: int) -> Array:
    """Coefficients; one number is that of all contacts, whose number tell offsets or Jacobian with an axis of contacts."""
    found = array("mu", mu, dtype)
    if found.ndim > 0:
        return found
    shape = np.asarray(offsets).shape
    if len(shape) < lead + 2 and np.asarray(jacobian).ndim == lead + 3:
        shape = np.asarray(jacobian).shape
    if len(shape) < lead + 2:
        raise ValueError("w: one mu for all does not tell how many contacts there are; give w as (contacts, rows)")
    return np.full((1,) * lead + (shape[lead],), found, dtype)


def both_ways(compliance: ArrayLike, contacts: int, dtype: np.dtype[Any], lead: int) -> Array:
    """Compliance along normal and tangents; one number is that of all contacts, one of each contact that of both ways."""
    found = array("compliance", compliance, dtype)
    if found.ndim == 0:
        return np.full((1,) * lead + (contacts, 2), found, dtype)
    return np.repeat(found[..., None], 2, axis=-1) if found.ndim == lead + 1 else found


def jacobians(given: ArrayLike) -> Array:
    """Contact Jacobians with an axis of contacts, ``(c, d, n)``."""
    found = array("H", given, DOUBLE)
    if found.ndim != 3:
        raise ValueError(f"H: shape {list(found.shape)} is not (contacts, rows, velocities)")
    return found


def led(name: str, given: ArrayLike, own: int, dtype: np.dtype[Any]) -> Array:
    """An array with a leading axis; one of ``own`` axes, which has none, is that of all scenes."""
    found = given if isinstance(given, np.ndarray) else array(name, given, dtype)
    return found[None] if found.ndim == own else found


def rows_tuple(rows: Rows, dtype: np.dtype[Any], lead: int) -> tuple[Any, ...]:
    """Joint rows, with one number for all made arrays."""
    numbers = {name: array(f"rows.{name}", getattr(rows, name), dtype) for name in ("offset", "lower", "upper", "compliance")}
    keys = keys_array("rows.keys", rows.keys)
    if rows.jacobian is None:
        raise ValueError("rows.jacobian: there is none")
    jacobian = array("rows.jacobian", rows.jacobian, dtype)
    if lead:
        numbers = {name: led(name, found, 1, dtype) for name, found in numbers.items()}
        jacobian, keys = led("rows.jacobian", jacobian, 2, dtype), keys[None] if keys.ndim == 1 else keys
    if jacobian.ndim != lead + 2:
        raise ValueError(f"rows.jacobian: shape {list(jacobian.shape)} is not (rows, velocities)")
    one = (1,) * lead + jacobian.shape[lead:-1]
    full = [found if found.ndim > 0 else np.full(one, found, dtype) for found in numbers.values()]
    return (jacobian, *full, keys if keys.ndim > 0 else np.full(one, keys, np.uint32))


def scene(
    dynamics: tuple[ArrayLike | None, ...],
    w: ArrayLike | None,
    mu: ArrayLike | None,
    compliance: ArrayLike | None,
    keys: ArrayLike | None,
    rows: Rows | None,
    dtype: np.dtype[Any],
    lead: int = 0,
) -> Scene:
    """A scene, or a batch of them with ``lead`` = 1; the compiled side calls :func:`array` for what is none.

    ``dynamics`` is ``M``, ``H`` and the free impulse.
    """
    jacobian = dynamics[1]
    if jacobian is None:
        if lead or w is not None or dynamics[0] is None:
            raise ValueError("H: there is none")
        jacobian = np.zeros((0, 3, *np.shape(dynamics[0])[-1:]), dtype)
        dynamics, w, mu = (dynamics[0], jacobian, dynamics[2]), np.zeros((0, 3), dtype), np.zeros(0, dtype)
    if mu is None:
        raise ValueError("mu: there is none, but there are contacts")
    if w is None:
        w = np.zeros(np.shape(jacobian)[:-1], dtype)
    if rows is not None and not isinstance(rows, Rows):
        raise ValueError(f"rows: {type(rows).__name__} is not Rows")

    coefficients = mu if isinstance(mu, np.ndarray) and mu.ndim else friction(mu, w, jacobian, dtype, lead)
    contacts = coefficients.shape[lead] if coefficients.ndim > lead else 0
    return (
        *dynamics,
        w,
        coefficients,
        None if compliance is None else both_ways(compliance, contacts, dtype, lead),
        None if keys is None else keys_array("keys", keys),
        None if rows is None else rows_tuple(rows, dtype, lead),
    )


def count(name: str, given: int) -> int:
    """A number that is not negative, of whatever integer type."""
    try:
        found = operator.index(given)
    except TypeError:
        found = -1
    if found < 0:
        raise ValueError(f"{name}: {given!r} is not a number of them")
    return found


def threads_of(given: int | None) -> int:
    """How many threads to start: never more than there are cores for this process; ``None`` is as many."""
    affinity = getattr(os, "sched_getaffinity", None)
    cores = len(affinity(0)) if affinity else os.cpu_count() or 1
    if given is None:
        return cores
    if count("threads", given) == 0:
        raise ValueError("threads: there has to be one")
    return min(given, cores)
