"""How steps of MuJoCo's models move, beside MuJoCo's own differences where nothing touches and those of whole steps elsewhere."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from test_mujoco import BOX, FLOOR, build

from stiction._near import Near
from stiction._tries import tries
from stiction.mujoco import Derivatives, Stepper

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
MODELS = Path(__file__).parents[1] / "models"
BALL = '<body pos="0 0 .05"><freejoint/><geom size=".05" mass="2"/></body>'
ARM = """<body pos="0 0 1"><joint name="shoulder" axis="0 1 0" damping=".1"/><geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/>
    <body pos=".4 0 0"><joint name="elbow" axis="0 0 1" stiffness="3" damping=".02"/>
    <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/></body></body>"""
ACTUATORS = """<actuator><motor joint="shoulder" ctrlrange="-1 1" ctrllimited="true"/>
    <general joint="elbow" dyntype="filter" dynprm=".05" gainprm="3" biastype="affine" biasprm="0 -2 -.3"/></actuator>"""


def differences(model: mujoco.MjModel, data: mujoco.MjData, eps: float, sides: tuple[int, ...] = (1, -1)) -> Any:
    """``[A, B]`` by differences of whole steps, each from nothing."""
    stepper = Stepper(model, tol=1e-12)

    def stepped(change: Any) -> mujoco.MjData:
        end = copy.copy(data)
        dq, dv, da, du = np.split(change, np.cumsum([model.nv, model.nv, model.na]))
        mujoco.mj_integratePos(model, end.qpos, dq, 1.0)
        end.qvel += dv
        end.act += da
        end.ctrl += du
        stepper.reset()
        stepper.step(end)
        return end

    size = 2 * model.nv + model.na + model.nu
    base = stepped(np.zeros(size))
    columns = np.zeros((size, size - model.nu))
    for column, change in zip(columns, eps * np.eye(size), strict=True):
        for side in sides:
            end, moved = stepped(side * change), np.zeros(model.nv)
            mujoco.mj_differentiatePos(model, moved, 1.0, base.qpos, end.qpos)
            column += side * np.concatenate([moved, end.qvel - base.qvel, end.act - base.act]) / (len(sides) * eps)
    return columns.T


def off(told: Derivatives, known: Any, model: mujoco.MjModel) -> float:
    """The largest error, with velocities as what they move in a step; of controls over their largest effect."""
    n, size = model.nv, 2 * model.nv + model.na
    unit = np.ones(size)
    unit[n : 2 * n] = model.opt.timestep
    error = unit[:, None] * (np.concatenate([told.A, told.B], axis=1) - known)
    effect = np.abs(unit[:, None] * known[:, size:]).max(initial=1e-300)
    return float(max(np.abs(error[:, :size] / unit).max(), np.abs(error[:, size:]).max(initial=0.0) / effect))


def free_pendulum() -> tuple[mujoco.MjModel, mujoco.MjData]:
    model, data = build(ARM.replace("<joint", '<joint frictionloss="0"'))
    data.qpos[:], data.qvel[:] = [0.4, -0.2], [1.0, 2.0]
    return model, data


def free_body() -> tuple[mujoco.MjModel, mujoco.MjData]:
    model, data = build('<body pos="0 0 3"><freejoint/><geom type="box" size=".1 .2 .3" mass="2"/></body>')
    data.qvel[:] = [1, 2, 3, 2, 1, 0.5]
    data.xfrc_applied[1] = [1, 2, 3, 0.1, 0.2, 0.3]
    return model, data


def free_arm(integrator: str, ctrl: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model, data = build(ARM, ACTUATORS, f'integrator="{integrator}"')
    data.qpos[:], data.qvel[:], data.act[:], data.ctrl[:] = [0.3, 0.5], [1, -2], 0.3, [ctrl, 0.8]
    return model, data


@pytest.mark.parametrize(
    "scene",
    [free_pendulum, free_body, *(lambda i=i, c=c: free_arm(i, c) for i in ("Euler", "implicitfast") for c in (0.4, 1.0, -1.0))],
)
def test_without_contacts_it_is_that_of_mujoco(scene: Any) -> None:
    model, data = scene()
    told = Stepper(model).derivatives(data)
    size = 2 * model.nv + model.na
    A, B = np.zeros((size, size)), np.zeros((size, model.nu))
    mujoco.mjd_transitionFD(model, data, 1e-6, 1, A, B, None, None)
    assert off(told, np.concatenate([A, B], axis=1), model) < 1e-8
    assert told.facts.margin == np.inf


def put(body: str, floor: str, tilt: float, gap: float, velocity: list[float]) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A body above a floor that is tilted (°), with a velocity along and across it."""
    turn = np.radians(tilt)
    model, data = build(floor.replace("<geom", f'<geom euler="0 {tilt} 0"') + body)
    data.qpos[:3] = (0.05 + gap) * np.array([np.sin(turn), 0, np.cos(turn)])
    data.qpos[3:7] = [np.cos(turn / 2), 0, np.sin(turn / 2), 0]
    data.qvel[:] = velocity
    data.qvel[[0, 2]] = [np.cos(turn) * velocity[0], -np.sin(turn) * velocity[0]]
    return model, data


ROUGH, SMOOTH = FLOOR.replace("/>", ' friction=".8"/>'), FLOOR.replace("/>", ' friction=".2 .01 .004"/>')
CASES: dict[str, tuple[str, str, float, list[float]]] = {
    "a ball that sticks": (BALL, ROUGH, 0, [0, 0, 0, 0, 0, 0]),
    "a box that sticks": (BOX, ROUGH, 0, [0, 0, 0, 0, 0, 0]),
    "a ball that slides": (BALL, SMOOTH, 0, [1, 0.3, 0, 2, 1, 3]),
    "a box that slides": (BOX, SMOOTH, 0, [1, 0.3, 0, 0, 0, 0]),
    "a ball that rolls": (BALL, ROUGH, 0, [0.5, 0, 0, 0, 10, 0]),
    "a ball that rolls down": (BALL, ROUGH, 20, [0, 0, 0, 0, 0, 0]),
    "a box that holds on a slope": (BOX, ROUGH, 20, [0, 0, 0, 0, 0, 0]),
    "a ball that slides down": (BALL, SMOOTH, 30, [0.5, 0, 0, 0, 0, 0]),
    "a box that slides down": (BOX, SMOOTH, 20, [0.5, 0, 0, 0, 0, 0]),
    "a ball with rolling friction": (BALL, SMOOTH.replace("/>", ' condim="6"/>'), 0, [0.5, 0.2, 0, 1, 10, 2]),
    "a ball on a conveyor": (BALL, SMOOTH.replace("/>", ' condim="4" surfacevel=".3 .1 0 0 0 .5"/>'), 0, [0, 0, 0, 0, 0, 1]),
}


@pytest.mark.parametrize("gap", [2e-8, 1e-5], ids=["that touches", "that lands"])
@pytest.mark.parametrize("case", CASES)
def test_a_contact_moves_as_the_step_does(case: str, gap: float) -> None:
    """Listed as the step begins, or found at its end."""
    body, floor, tilt, velocity = CASES[case]
    model, data = put(body, floor, tilt, gap, velocity)
    told = Stepper(model, tol=1e-10).derivatives(data)
    assert told.facts.margin > 0.05 and told.facts.has_unique_velocity
    # Rounding of steps over eps is most of what they differ by.
    assert off(told, differences(model, data, gap / 4 if gap < 1e-6 else gap / 200), model) < 1e-5


def stands(loss: float, push: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The quadruped, with or without friction loss, when it stands, or has been pushed by its motors."""
    model = mujoco.MjModel.from_xml_path(str(MODELS / "quadruped.xml"))
    model.opt.timestep, model.dof_frictionloss[6:] = 0.005, loss
    data, stepper = mujoco.MjData(model), Stepper(model, tol=1e-10)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    stepper.step(data, 200)
    if push:
        data.ctrl += np.linspace(-push, push, model.nu)
        stepper.step(data, 4)
    data.ctrl += 0.01 * np.cos(np.arange(model.nu))
    return model, data


def test_a_quadruped_that_stands() -> None:
    """On four feet, which are lifted by less than they fall."""
    model, data = stands(0.0, 0.0)
    data.qpos[2] += 1e-5
    told = Stepper(model, tol=1e-10).derivatives(data)
    assert told.facts.margin > 0.02 and told.facts.has_unique_velocity
    assert off(told, differences(model, data, 1e-7), model) < 1e-5


def test_a_quadruped_that_is_pushed_in() -> None:
    """Two feet slip: one overlaps already, the other is found as the step ends; what takes them back moves as well."""
    model, data = stands(0.0, 0.3)
    data.qpos[2] -= 1e-5
    last = tries(Near(Stepper(model, tol=1e-10), data, 1e-6))[-1]
    assert {touch.is_new for touch in last.touches} == {True, False} and np.abs(last.shift.motion.v).max() > 0.1
    told = Stepper(model, tol=1e-10).derivatives(data)
    assert told.facts.margin > 0.05
    assert off(told, differences(model, data, 1e-7), model) < 1e-5


def test_a_quadruped_that_lands() -> None:
    """On two feet, with friction loss in its joints."""
    model, data = stands(0.1, 0.3)
    data.qpos[2] += 1e-3
    data.qvel[2] -= 0.5
    told = Stepper(model, tol=1e-10).derivatives(data)
    assert told.facts.margin > 0.02
    assert off(told, differences(model, data, 1e-7), model) < 1e-5
    assert not np.allclose(told.B[18:24], 0.0)  # legs move the trunk


def test_many_of_them() -> None:
    """Twelve boxes have 72 velocities, more than any kernel has, in islands of their own: each moves as if it were alone."""
    one, data = put(BOX, SMOOTH, 0, 1e-5, [1, 0.3, 0, 0, 0, 0])
    alone = Stepper(one, tol=1e-10).derivatives(data)
    model, all_data = build(SMOOTH + "".join(BOX.replace("0 0 .05", f"{x} 0 .05") for x in range(12)))
    for i in range(12):
        all_data.qpos[7 * i + 2], all_data.qvel[6 * i : 6 * i + 2] = 0.05 + 1e-5, [1, 0.3]
    told = Stepper(model, tol=1e-10).derivatives(all_data)
    for i in range(12):
        own = np.r_[6 * i : 6 * i + 6, 72 + 6 * i : 78 + 6 * i]
        assert np.allclose(told.A[np.ix_(own, own)], alone.A, atol=1e-6)
        assert np.abs(np.delete(told.A[own], own, axis=1)).max() < 1e-6


LOOP = """<body pos="0 0 1"><joint name="crank" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".03"/>
    <body name="bar" pos="0 0 -.3"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .4 0 0" size=".02"/></body></body>
    <body name="rocker" pos=".4 0 1"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".03"/></body>"""
CLOSED = """<equality><connect body1="bar" body2="rocker" anchor=".4 0 0"/></equality>
    <contact><exclude body1="bar" body2="rocker"/></contact><actuator><motor joint="crank"/></actuator>"""
LIMITED = """<body pos="0 0 1"><joint name="shoulder" axis="0 1 0" range="-30 20" damping=".3"/>
    <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03" mass="1"/>
    <body pos=".4 0 0"><joint name="elbow" axis="0 1 0" frictionloss=".1"/>
    <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass=".3"/></body></body>"""


@pytest.mark.parametrize("gap", [1e-6, 1e-3])
def test_limits_and_friction_loss(gap: float) -> None:
    model, data = build(LIMITED, '<actuator><motor joint="shoulder"/><motor joint="elbow"/></actuator>')
    data.qpos[:], data.qvel[:], data.ctrl[:] = [np.radians(20) - gap, 0.3], [1.0, -2.0], [0.5, 0.2]
    told = Stepper(model, tol=1e-10).derivatives(data)
    assert told.facts.margin > 0.05
    assert off(told, differences(model, data, gap / 4), model) < 1e-5
    assert np.isclose(told.A[2, 0], -1 / model.opt.timestep) and np.allclose(told.B[2], 0.0)


def test_what_turns_as_it_lands() -> None:
    """Its contact is looked for again where the step leads, as that is not where it would lead without contacts."""
    body = '<body><freejoint/><geom type="ellipsoid" size=".2 .15 .1" mass="1"/></body>'
    model, data = build(SMOOTH + body, h=0.005)
    data.qpos[2], data.qvel[:] = 0.1 + 1e-3, [0.5, 0.2, -1.0, 0.5, 8.0, 1.0]
    near = Near(Stepper(model, tol=1e-10), data, 1e-6)
    assert len(tries(near)) > 2
    told = Stepper(model, tol=1e-10).derivatives(data)
    assert off(told, differences(model, data, 1e-7), model) < 1e-5


@pytest.mark.parametrize("case", ["a box that sticks", "a ball that rolls", "a ball that slides down"])
def test_overlaps_are_taken_back(case: str) -> None:
    body, floor, tilt, velocity = CASES[case]
    model, data = put(body, floor, tilt, -1e-5, velocity)
    told = Stepper(model, tol=1e-10).derivatives(data)
    assert off(told, differences(model, data, 1e-7), model) < 1e-6


def test_a_passed_limit_and_an_open_loop() -> None:
    model, data = build(LIMITED)
    data.qpos[:], data.qvel[:] = [np.radians(20) + 1e-5, 0.3], [1.0, -2.0]
    assert off(Stepper(model, tol=1e-10).derivatives(data), differences(model, data, 1e-7), model) < 1e-5
    model, data = build(LOOP, CLOSED)
    data.ctrl[:] = 5.0
    stepper = Stepper(model, tol=1e-10)
    stepper.step(data, 50)
    data.qpos[0] += 1e-4
    assert off(stepper.derivatives(data), differences(model, data, 1e-6), model) < 1e-4  # its compliance, 0.02, is held


def test_what_rests_is_lifted() -> None:
    """At rest one side has no gap: what is told is the side on which it comes back, and turning by the floor changes nothing."""
    model, data = put(BALL, ROUGH, 0, 0.0, [0.0] * 6)
    stepper = Stepper(model, tol=1e-12)
    stepper.step(data, 30)
    told = stepper.derivatives(data)
    known = differences(model, data, 1e-8, (1,))
    h = model.opt.timestep
    assert np.allclose(told.A[:, 2], known[:, 2], atol=1e-5 / h)
    assert np.isclose(told.A[8, 2], -1 / h) and np.isclose(told.A[2, 2], 0.0)


def test_nothing_is_changed() -> None:
    model, data = stands(0.1, 0.3)
    stepper = Stepper(model)
    stepper.step(data)
    arrays = ("efc_force", "efc_J", "qacc", "qacc_warmstart", "xpos", "qfrc_constraint", "sensordata")
    own = copy.copy(vars(stepper))
    state, modes = np.empty(mujoco.mj_stateSize(model, STATE)), stepper.modes
    mujoco.mj_getState(model, data, state, STATE)
    kept, margins = [getattr(data, name).copy() for name in arrays], model.geom_margin.copy()
    distances, after, other = data.contact.dist.copy(), np.empty_like(state), copy.copy(data)
    told = stepper.derivatives(data)
    mujoco.mj_getState(model, data, after, STATE)
    assert np.array_equal(state, after) and np.array_equal(distances, data.contact.dist)
    assert all(np.array_equal(getattr(data, name), before) for name, before in zip(arrays, kept, strict=True))
    assert np.array_equal(model.geom_margin, margins) and vars(stepper) == own and stepper.modes == modes
    assert np.array_equal(stepper.derivatives(other).A, told.A)


def test_what_is_refused_says_why() -> None:
    model, _ = build(FLOOR + BOX)
    with pytest.raises(ValueError, match="^data: of another model"):
        Stepper(model).derivatives(build(ARM)[1])
    model, data = put(BOX, SMOOTH, 0, 1e-8, [1, 0.3, 0, 0, 0, 3])
    with pytest.raises(ValueError, match="^data: the step has no exact solution, or none is found"):
        Stepper(model, budget=0).derivatives(data)
    with pytest.raises(ValueError, match="^data: the step has no exact solution, or none is found"):
        Stepper(model, tol=1e-18).derivatives(data)
    sticky = '<actuator><adhesion body="pad" ctrlrange="0 1"/></actuator>'
    model, data = build(FLOOR + BOX.replace("<body", '<body name="pad"'), sticky)
    with pytest.raises(ValueError, match="^model: adhesion"):
        Stepper(model).derivatives(data)
