"""Packages that need another MuJoCo than the one that is installed, mended in memory."""

from __future__ import annotations

import importlib
import importlib.util
from types import ModuleType, SimpleNamespace
from typing import Any

import mujoco
import numpy as np


def _module(name: str) -> ModuleType | None:
    """A module, if its package is installed."""
    return importlib.import_module(name) if importlib.util.find_spec(name.partition(".")[0]) else None


def _older(module: ModuleType, **names: Any) -> None:
    """Let a module see a MuJoCo with these names in place of its own."""
    module.mujoco = SimpleNamespace(**{**vars(module.mujoco), **names})  # type: ignore[attr-defined]


def _joints() -> list[str]:
    """A kind of joint was equal to a number of numpy."""
    kinds = mujoco.mjtJoint
    if kinds.mjJNT_HINGE == np.int32(int(kinds.mjJNT_HINGE)):
        return []
    numbers = SimpleNamespace(**{name: int(getattr(kinds, name)) for name in dir(kinds) if name.startswith("mjJNT_")})
    done = []
    for name in ("gymnasium_robotics.utils.mujoco_utils", "robosuite.utils.binding_utils"):
        module = _module(name)
        if module is not None and module.mujoco.mjtJoint is kinds:
            _older(module, mjtJoint=numbers)
            done.append(f"{name}: kinds of joints are numbers")
    return done


def _mass() -> list[str]:
    """The mass matrix had a place in the data."""
    name = "robosuite.controllers.parts.controller"
    module, data = _module(name), _module("robosuite.utils.binding_utils")
    if hasattr(mujoco.MjData, "qM") or module is None or data is None or hasattr(data.MjData, "qM"):
        return []
    data.MjData.qM = property(lambda own: own._data)
    _older(module, mj_fullM=lambda model, mass, own: mujoco.mj_fullM(model, own, mass))
    return [f"{name}: mj_fullM takes the data"]


def _arrays() -> list[str]:
    """Arrays that there are no more."""
    name, done = "dm_control.mujoco.wrapper.mjbindings.sizes", []
    module = _module(name)
    for key, kind in (("mjmodel", mujoco.MjModel), ("mjdata", mujoco.MjData)):
        arrays = module.array_sizes[key] if module is not None else {}
        for array in [array for array in arrays if not hasattr(kind, array)]:
            del arrays[array]
            done.append(f"{name}: without {array}")
    return done


def _welds() -> list[str]:
    """A weld had 11 numbers."""
    name = "metaworld.sawyer_xyz_env"
    module = _module(name) if mujoco.mjNEQDATA > 11 else None
    if module is None or module.SawyerMocapBase.reset_mocap_welds is _reset_welds:
        return []
    module.SawyerMocapBase.reset_mocap_welds = _reset_welds
    return [f"{name}: numbers of a weld"]


def _reset_welds(env: Any) -> None:
    """As metaworld has it, of the first 11 numbers."""
    env.model.eq_data[env.model.eq_type == mujoco.mjtEq.mjEQ_WELD, :11] = (0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 5)


def mend() -> list[str]:
    """Mend what is installed; what is mended already, or right, stays as it is."""
    return [*_joints(), *_mass(), *_arrays(), *_welds()]
