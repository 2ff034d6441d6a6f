"""What versions of MuJoCo have under other names, or not at all."""

from __future__ import annotations

import mujoco
import numpy as np

from ._types import Array

#: Do the margins of two geoms add up? Before 3.5 the larger counted.
MARGINS_ADD = mujoco.mj_version() >= 3_005_000

_MASS_OF_DATA = mujoco.mj_version() >= 3_010_000
_DISABLE = mujoco.mjtDisableBit
_DAMPER = getattr(_DISABLE, "mjDSBL_DAMPER", None) or _DISABLE.mjDSBL_PASSIVE
_NO_DAMPING = int(_DISABLE.mjDSBL_EULERDAMP) | int(_DAMPER)


def flag(kind: type, name: str) -> int:
    """A flag of a model, 0 where a version has none of this name."""
    return int(getattr(kind, name, 0))


def is_damped(model: mujoco.MjModel) -> bool:
    """Does damping of joints act, and is it implicit?"""
    return not model.opt.disableflags & _NO_DAMPING


def solve_as_one(model: mujoco.MjModel) -> None:
    """Have MuJoCo list constraints without islands."""
    model.opt.disableflags |= flag(_DISABLE, "mjDSBL_ISLAND")
    model.opt.enableflags &= ~flag(mujoco.mjtEnableBit, "mjENBL_ISLAND")


def mass_matrix(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """The mass matrix, ``(nv, nv)``."""
    mass = np.zeros((model.nv, model.nv))
    if _MASS_OF_DATA:
        mujoco.mj_fullM(model, data, mass)
    else:
        mujoco.mj_fullM(model, mass, data.qM)
    return mass


def velocity_derivative(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """The derivative of smooth forces by velocities, ``(nv, nv)``."""
    D: Array = np.zeros((model.nv, model.nv))
    has = model if hasattr(model, "D_rownnz") else data
    D[np.repeat(np.arange(model.nv), has.D_rownnz), has.D_colind] = data.qDeriv
    return D


def surface_velocities(data: mujoco.MjData) -> Array:
    """How surfaces move at contacts, ``(ncon, 3)``: before 4.0 they do not."""
    moved: Array | None = getattr(data.contact, "surfacevel", None)
    return np.zeros((data.ncon, 3)) if moved is None else moved
