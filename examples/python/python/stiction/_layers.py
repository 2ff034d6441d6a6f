"""What the solves of JAX and PyTorch share: a scene as arrays with names, and back."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import fields
from typing import Any

import numpy as np

from ._derivative import RowChange
from ._types import Rows

CONSTANT = "compliance: that of contacts is a constant, by which nothing is differentiated"


def named(
    scene: tuple[Any, ...], compliance: Any, rows: Rows | None, zeros: Callable[..., Any], spread: Callable[..., Any]
) -> dict[str, Any]:
    """Arrays by name: ``M``, ``H``, ``free_impulse``, ``w``, ``mu``; then ``compliance`` and joint rows (``rows.offset``), if any.

    ``zeros(shape)`` makes an array, ``spread(given, shape)`` makes one of a number or an array.
    """
    M, H, free_impulse, w, mu = scene
    if H is None:
        H, mu = zeros((0, 3, *np.shape(free_impulse))), zeros(0)
    if mu is None:
        raise ValueError("mu: there is none, but there are contacts")
    if w is None:
        w = zeros(np.shape(H)[:-1])
    if np.ndim(mu) == 0:
        mu = spread(mu, np.shape(w)[:1])
    found = {"M": M, "H": H, "free_impulse": free_impulse, "w": w, "mu": mu}
    if compliance is not None:
        found["compliance"] = spread(compliance, np.shape(compliance))
    if rows is not None:
        jacobian: Any = rows.jacobian
        shape = np.shape(jacobian)
        for name in (field.name for field in fields(RowChange)):
            found[f"rows.{name}"] = spread(getattr(rows, name), shape if name == "jacobian" else shape[:1])
    return found


def arguments(names: Iterable[str], arrays: Iterable[Any], kind: type[Rows] | type[RowChange]) -> dict[str, Any]:
    """Arguments of a solve or a derivative, in double precision, with those of joint rows in one of this kind."""
    found = {name: np.array(array, np.float64) for name, array in zip(names, arrays, strict=True)}
    rows = {name.removeprefix("rows."): found.pop(name) for name in [*found] if name.startswith("rows.")}
    return {**found, "rows": kind(**rows)} if rows else found
