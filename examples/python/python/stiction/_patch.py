"""Environments of other packages that step through this law, and their copies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from .mujoco import Stepper

_NAME = "_stiction"  # of the law, on what is patched
_OF_CLASSES = ("__dict__", "__weakref__", "__doc__", "__module__")


class Law:
    """A stepper, whichever model it is for now, that moves bodies of motion capture evenly over the frames of a step.

    So they have a velocity, and carry.
    """

    def __init__(self, settings: dict[str, Any], model: mujoco.MjModel) -> None:
        """Take the first model."""
        self.settings = settings
        self.stepper, self.end = Stepper(model, **settings), (-1.0, np.zeros((0, 3)))

    def of(self, model: mujoco.MjModel) -> Stepper:
        """The stepper, on this model; packages build models anew at resets. Its counts go on."""
        if self.stepper.model is not model:
            fresh = Stepper(model, **self.settings)
            fresh._own.tally = self.stepper._own.tally
            self.stepper._model, self.stepper._own, self.end = fresh.model, fresh._own, (-1.0, np.zeros((0, 3)))
            self.stepper._softness = fresh._softness
        return self.stepper

    def step(self, model: mujoco.MjModel, data: mujoco.MjData, frames: int) -> None:
        """Take so many steps, to the place that is written."""
        stepper, (time, start), goal = self.of(model), self.end, data.mocap_pos.copy()
        if time != data.time or np.array_equal(start, goal):  # a reset, or nothing moves
            stepper.step(data, frames)
        else:
            for frame in range(1, frames + 1):
                data.mocap_pos[:] = start + (goal - start) * (frame / frames)
                stepper.step(data)
        self.end = (data.time, goal)


class Patched:
    """What all objects that are patched have: their copies are patched, too."""

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Copy as the package does, and patch the copy."""
        own: Any = type(self)
        made, arguments, *rest = own._original.__reduce_ex__(self, protocol)
        plain = [own._original if argument is own else argument for argument in arguments]
        return (_again, (own._kind, vars(self)[_NAME].settings, made, plain), *rest)

    def __setstate__(self, state: Any) -> None:
        """Take over a state, or be built anew, as the package has it; then there is no law yet."""
        own: Any = type(self)
        settings = vars(self).pop(_NAME)
        if hasattr(own._original, "__setstate__"):
            own._original.__setstate__(self, state)
        else:
            vars(self).update(state)
        if _NAME not in vars(self):
            _patch_as(self, own._kind, settings)


def _again(kind: type, settings: dict[str, Any], made: Callable[..., Any], arguments: list[Any]) -> Any:
    """A copy without its state, which comes next."""
    return dressed(made(*arguments), kind, settings)


def dressed(thing: Any, kind: type, law: Any) -> Any:
    """The same object with the methods of a kind in front of its own."""
    own = type(thing)
    if not hasattr(own, "_kind"):
        if hasattr(own, "__deepcopy__"):
            raise ValueError(f"env: {own.__name__} copies itself in its own way, and its copies would step by MuJoCo's law")
        names = {"_original": own, "_kind": kind, "__module__": own.__module__, "__qualname__": own.__qualname__}
        # A base beside the package's class would change the layout of its objects.
        methods = {name: method for base in (Patched, kind) for name, method in vars(base).items() if name not in _OF_CLASSES}
        thing.__class__ = type(own.__name__, (own,), methods | names)
    vars(thing)[_NAME] = law
    return thing


class Gymnasium:
    """Environments of gymnasium and metaworld."""

    _model, _held = "model", None

    def _step_mujoco_simulation(self: Any, ctrl: ArrayLike, n_frames: int) -> None:
        self.data.ctrl[:] = ctrl
        vars(self)[_NAME].step(self.model, self.data, n_frames)
        mujoco.mj_rnePostConstraint(self.model, self.data)


class Robotics:
    """Environments of gymnasium-robotics."""

    _model, _held = "model", None

    def _mujoco_step(self: Any, action: ArrayLike) -> None:
        vars(self)[_NAME].step(self.model, self.data, self.n_substeps)


class Physics:
    """The physics of dm_control."""

    _model, _held = "model.ptr", None

    def step(self: Any, nstep: int = 1) -> None:
        """Step, and find positions and velocities of what follows, if dm_control does."""
        with self.check_invalid_state():
            vars(self)[_NAME].step(self.model.ptr, self.data.ptr, nstep)
            if self.legacy_step:
                mujoco.mj_step1(self.model.ptr, self.data.ptr)


class Simulation:
    """The simulation of robosuite."""

    _model, _held = "model._model", None

    def step(self: Any, with_udd: bool = True) -> None:
        """Step."""
        vars(self)[_NAME].step(self.model._model, self.data._data, 1)

    def step1(self: Any) -> None:
        """What comes before controls."""
        vars(self)[_NAME].of(self.model._model).step1(self.data._data)

    def step2(self: Any) -> None:
        """What comes after controls."""
        vars(self)[_NAME].of(self.model._model).step2(self.data._data)


def _holder(name: str, kind: type) -> property:
    """What an environment steps; it is made anew at resets, and patched as it is asked for."""

    def read(self: Any) -> Any:
        thing = vars(self)[name]
        return thing if thing is None else dressed(thing, kind, vars(self)[_NAME])

    def write(self: Any, thing: Any) -> None:
        vars(self)[name] = thing

    return property(read, write)


class Control:
    """Environments of dm_control."""

    _model, _held = "_physics.model.ptr", "_physics"
    _physics = _holder("_physics", Physics)


class Robosuite:
    """Environments of robosuite."""

    _model, _held = "sim.model._model", "sim"
    sim = _holder("sim", Simulation)


# What is patched, by the method that steps it.
_KINDS: dict[Any, str] = {Control: "step", Robosuite: "step1", Gymnasium: "_step_mujoco_simulation", Robotics: "_mujoco_step"}


def _found(thing: Any, path: str) -> Any:
    """What a path of attributes leads to; ``None`` if it does not."""
    for name in path.split(".") if path else ():
        thing = getattr(thing, name, None)
    return thing


def _patch_as(thing: Any, kind: Any, settings: dict[str, Any]) -> Stepper:
    """Patch something that is of a kind."""
    law = Law(settings, _found(thing, kind._model))
    dressed(thing, kind, law)
    return law.stepper


def patch_bare(bare: Any, settings: dict[str, Any]) -> Stepper:
    """Patch an environment that has no wrappers."""
    if hasattr(bare, "num_envs"):
        raise ValueError(
            "env: a vector of environments; patch each: patch(env.envs[i]) of a SyncVectorEnv, and of an AsyncVectorEnv in the "
            "function that makes one"
        )
    for kind, method in _KINDS.items():
        if isinstance(_found(bare, kind._model), mujoco.MjModel) and hasattr(_found(bare, kind._held or ""), method):
            return _patch_as(bare, kind, settings)
    raise ValueError(
        "env: no environment of gymnasium, gymnasium-robotics, metaworld, dm_control or robosuite with a model of MuJoCo; "
        "call Stepper.step in place of mujoco.mj_step"
    )


__all__ = ["Law", "patch_bare"]
