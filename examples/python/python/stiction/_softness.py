"""Softness that a user asks for, by the names of a model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeAlias

import mujoco

Key: TypeAlias = "str | tuple[str | int, str | int]"
#: One number for all, or some for pairs of geoms and equalities (m/N).
Compliance: TypeAlias = "float | Mapping[Key, float]"
#: As the compiled side takes it: the compliance of all, whether ``solref`` is read, pairs of geoms, equalities.
Given: TypeAlias = "tuple[float, bool, dict[tuple[int, int], float], dict[int, float]]"


def softness(model: mujoco.MjModel, compliance: Compliance, soft: bool) -> Given:
    """Find the geoms and equalities that are named."""
    if not isinstance(compliance, Mapping):
        return _number("compliance", compliance), bool(soft), {}, {}
    pairs, equalities = {}, {}
    for key, given in compliance.items():
        name = f"compliance[{key!r}]"
        number = _number(name, given)
        try:
            if isinstance(key, str):
                equalities[model.equality(key).id] = number
            else:
                one, other = sorted(model.geom(geom).id for geom in key)
                pairs[one, other] = number
        except (IndexError, KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{name}: the model has no such equality or pair of geoms: {error}") from error
    return 0.0, bool(soft), pairs, equalities


def _number(name: str, given: float) -> float:
    if not 0 <= given < math.inf:
        raise ValueError(f"{name}: {given!r} is no compliance, which is finite and not negative")
    return float(given)
