"""Environments that are patched, of packages that are not installed here by objects like theirs; their copies; mended packages."""

from __future__ import annotations

import contextlib
import copy
import pickle
import warnings
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest

from stiction import _compat
from stiction.mujoco import Stepper, compat, patch

BALL = '<body name="ball" pos="0 0 .05"><freejoint/><geom size=".05"/></body>'
XML = f'<mujoco><worldbody><geom type="plane" size="1 1 1"/>{BALL}</worldbody></mujoco>'
COPIES = [copy.deepcopy, lambda own: pickle.loads(pickle.dumps(own))]


def refuse(*_: object) -> None:
    raise AssertionError("MuJoCo's law")


class Simulation:
    """As robosuite's."""

    def __init__(self) -> None:
        self.model = SimpleNamespace(_model=mujoco.MjModel.from_xml_string(XML))
        self.data = SimpleNamespace(_data=mujoco.MjData(self.model._model))

    step = step1 = step2 = refuse


class Robosuite:
    """It builds its simulation anew at resets."""

    sim: Any

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        self.sim = Simulation()

    def step(self) -> float:
        self.sim.step1()
        self.sim.step2()
        self.sim.step()
        return float(self.sim.data._data.time)


class Physics:
    """As dm_control's."""

    def __init__(self) -> None:
        self.legacy_step = True
        self._take(mujoco.MjData(mujoco.MjModel.from_xml_string(XML)))

    def _take(self, data: mujoco.MjData) -> None:
        self.model, self.data = SimpleNamespace(ptr=data.model), SimpleNamespace(ptr=data)

    def __getstate__(self) -> mujoco.MjData:
        return self.data.ptr

    def __setstate__(self, data: mujoco.MjData) -> None:
        self.legacy_step = True
        self._take(data)

    def check_invalid_state(self) -> Any:
        return contextlib.nullcontext()

    step = refuse


class Control:
    """It makes its physics anew at resets."""

    _physics: Any

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        self._physics = None
        self._physics = Physics()

    def step(self) -> float:
        self._physics.step(2)
        return float(self._physics.data.ptr.time)


@pytest.mark.parametrize("kind", [Robosuite, Control])
@pytest.mark.parametrize("again", COPIES)
def test_what_builds_its_model_anew_stays_patched(kind: Callable[[], Any], again: Callable[[Any], Any]) -> None:
    env = kind()
    stepper = patch(env, tol=1e-8)
    assert isinstance(env, kind)  # type: ignore[arg-type]
    for _ in range(2):
        env.reset()
        for step in range(1, 4):
            assert env.step() == pytest.approx(step * 2 * 0.002)
    assert stepper.steps == 12 and stepper.unsolved == 0
    other = again(env)
    assert isinstance(other, kind)  # type: ignore[arg-type]
    other.step()
    other.reset()
    other.step()
    assert stepper.steps == 12


@pytest.mark.parametrize("again", COPIES)
def test_a_copy_of_an_environment_is_patched(again: Callable[[Any], Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Gymnasium builds copies anew."""
    env = gymnasium.make("Hopper-v5")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # RK4
        stepper = patch(env, tol=1e-7)
        other = again(env)
    taken: list[Stepper] = []
    step = Stepper.step

    def noted(own: Stepper, *rest: Any) -> None:
        taken.append(own)
        step(own, *rest)

    monkeypatch.setattr(Stepper, "step", noted)
    other.reset(seed=1)
    other.step(other.action_space.sample())
    env.reset(seed=1)
    env.step(env.action_space.sample())
    assert [own is stepper for own in taken] == [False, True] and taken[0].model is other.unwrapped.model
    assert taken[0]._settings == taken[1]._settings and taken[0].steps == 4


def test_what_copies_itself_is_refused() -> None:
    class Own:
        model, data = mujoco.MjModel.from_xml_string(XML), None
        _step_mujoco_simulation = refuse

        def __deepcopy__(self, memo: object) -> Own:
            return Own()

    with pytest.raises(ValueError, match="^env: Own copies itself"):
        patch(Own())


def test_of_a_vector_each_is_patched() -> None:
    vector = gymnasium.vector.SyncVectorEnv([lambda: gymnasium.make("HalfCheetah-v5")] * 2)
    with pytest.raises(ValueError, match=r"^env: .*patch\(env.envs\[i\]\)"):
        patch(vector)
    steppers = [patch(env) for env in vector.envs]
    vector.reset(seed=1)
    vector.step(vector.action_space.sample())
    assert [stepper.steps for stepper in steppers] == [5, 5]


@pytest.mark.skipif(mujoco.mj_version() < 4_000_000, reason="less is to mend")
def test_packages_are_mended_once(monkeypatch: pytest.MonkeyPatch) -> None:
    class Mocap:
        model: Any

        def reset_mocap_welds(self) -> None:
            self.model.eq_data[0] = np.arange(11)

    class Data:
        def __init__(self, data: mujoco.MjData) -> None:
            self._data = data

    modules: dict[str, Any] = {
        "gymnasium_robotics.utils.mujoco_utils": SimpleNamespace(mujoco=mujoco),
        "robosuite.utils.binding_utils": SimpleNamespace(mujoco=mujoco, MjData=Data),
        "robosuite.controllers.parts.controller": SimpleNamespace(mujoco=mujoco),
        "dm_control.mujoco.wrapper.mjbindings.sizes": SimpleNamespace(
            array_sizes={"mjmodel": {"body_mass": ("nbody",), "flex_vertedge": ()}, "mjdata": {"qpos": ("nq",)}}
        ),
        "metaworld.sawyer_xyz_env": SimpleNamespace(SawyerMocapBase=Mocap),
    }
    monkeypatch.setattr(_compat, "_module", lambda name: modules.get(name))
    assert len(compat()) == 5 and compat() == []
    kinds = modules["gymnasium_robotics.utils.mujoco_utils"].mujoco.mjtJoint
    assert np.int32(3) in (kinds.mjJNT_SLIDE, kinds.mjJNT_HINGE)
    weld = '<equality><weld body1="ball"/></equality>'
    model = mujoco.MjModel.from_xml_string(XML.replace("</mujoco>", weld + "</mujoco>"))
    data, mass = mujoco.MjData(model), np.zeros((6, 6))
    mujoco.mj_forward(model, data)
    modules["robosuite.controllers.parts.controller"].mujoco.mj_fullM(model, mass, Data(data).qM)  # type: ignore[attr-defined]
    assert mass[0, 0] == model.body_mass[1]
    assert list(modules["dm_control.mujoco.wrapper.mjbindings.sizes"].array_sizes["mjmodel"]) == ["body_mass"]
    env = Mocap()
    env.model = model
    env.reset_mocap_welds()
    assert model.eq_data[0, 10] == 5
    modules.clear()
    assert compat() == []
