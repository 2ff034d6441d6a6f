"""Models of the folder `models`, stepped at 1, 2, 5 and 10 ms: law, momentum and energy of each step, judged apart.

Then what is known of them on paper, and MuJoCo's own contacts where its law is the same. Lengths in m.
"""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import mujoco
import numpy as np
import pytest
from scene_judge import Array, Judge

from stiction.mujoco import Stepper

MODELS = pathlib.Path(__file__).resolve().parents[1] / "models"
STEPS = (0.001, 0.002, 0.005, 0.01)
TOLERANCE = 1e-8
GRAVITY, MU, SPEED = 9.81, 0.5, 6.0


def load(name: str, h: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_path(str(MODELS / f"{name}.xml"))
    model.opt.timestep = h
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    return model, data


Controls = Callable[[mujoco.MjData, float], None]


def leave(data: mujoco.MjData, time: float) -> None:
    """Change nothing."""


def trot(data: mujoco.MjData, time: float) -> None:
    """Stand, take a push of 4 N·s from the side, and trot from 0.5 s on, with growing steps."""
    data.qfrc_applied[1] = 40.0 if 0.2 < time < 0.3 else 0.0
    phase, growing = 4 * np.pi * (time - 0.5), min(1.0, 2 * (time - 0.5))
    if growing <= 0:
        return
    for leg, shift in enumerate((0.0, np.pi, np.pi, 0.0)):
        lift = max(0.0, np.sin(phase + shift)) * growing
        data.ctrl[3 * leg + 1] = 0.7 + 0.35 * lift + 0.15 * growing * np.cos(phase + shift)
        data.ctrl[3 * leg + 2] = -1.4 - 0.7 * lift


def shove(data: mujoco.MjData, time: float) -> None:
    """Push the torso with 6 N·s from behind."""
    data.qfrc_applied[0] = 60.0 if 0.2 < time < 0.3 else 0.0


def hand(data: mujoco.MjData, time: float) -> None:
    """Throw the door open."""
    data.ctrl[0] = 150.0 if time < 0.5 else 0.0


def judged_step(judge: Judge, stepper: Stepper, data: mujoco.MjData) -> None:
    judge.set_out(data)
    stepper.step1(data)
    listed = data.ncon
    stepper.step2(data)
    judge.judge(data, stepper.modes, listed)


@dataclass
class Run:
    judge: Judge
    stepper: Stepper
    data: mujoco.MjData
    poses: Array


# model, how long (s), what is done to it, velocity at the start, and how much energy may grow (J, J/s of the step length): in
# a step of bodies that turn about each other, M(q) and gravity are those of its start, an error of first order.
SCENES: dict[str, tuple[str, float, Controls, tuple[float, ...], tuple[float, float]]] = {
    "cube": ("cube", 1.5, leave, (), (1e-9, 0.0)),
    "cube that tumbles": ("cube", 1.5, leave, (3, 0, 2, 7, 5, 2), (1e-9, 0.0)),
    "gripper": ("gripper", 1.0, leave, (), (1e-9, 0.0)),
    "quadruped": ("quadruped", 2.5, trot, (), (1e-9, 3.0)),
    "humanoid": ("humanoid", 1.0, shove, (), (1e-9, 3.0)),
    "door": ("door", 4.0, hand, (), (1e-9, 3.0)),
}


@cache
def run(scene: str, h: float) -> Run:
    """Step a scene, every step judged."""
    name, end, controls, velocity, _ = SCENES[scene]
    model, data = load(name, h)
    if velocity:
        data.qvel[:] = velocity
    judge, stepper, poses = Judge(load(name, h)[0]), Stepper(model, tol=TOLERANCE), []
    for step in range(round(end / h)):
        controls(data, step * h)
        judged_step(judge, stepper, data)
        poses.append(data.qpos.copy())
    return Run(judge, stepper, data, np.array(poses))


@pytest.mark.parametrize("h", STEPS)
@pytest.mark.parametrize("scene", SCENES)
def test_each_step_obeys_the_law_and_gains_no_energy(scene: str, h: float) -> None:
    done, (rounding, rate) = run(scene, h), SCENES[scene][-1]
    assert done.stepper.unsolved == 0 and done.stepper.contradictions == 0 and done.stepper.fallbacks == 0
    assert done.judge.momentum < TOLERANCE
    # Least impulses count the creep of a contact in full, of which an impulse on the cone counts less.
    assert done.judge.law < 10 * TOLERANCE
    assert done.judge.fed < 1e-9
    assert done.judge.growth() < rounding + rate * h


@pytest.mark.parametrize("h", STEPS)
@pytest.mark.parametrize("scene", SCENES)
def test_nothing_overlaps_and_nothing_opens(scene: str, h: float) -> None:
    """After a step; but a joint that turns about a pin opens it by what turning within the step brings."""
    done = run(scene, h)
    assert done.judge.deepest < 1e-6 * done.stepper.model.stat.meansize
    assert done.judge.opened < 4.0 * h * h


@pytest.mark.parametrize(("steps", "size"), [(5, 1.0001), (0, 1.0001), (0, 1.01)])
def test_the_judge_sees_a_wrong_force(steps: int, size: float) -> None:
    """At a contact that is there when the step begins, and at one that is found at its end."""
    model, data = load("cube", 0.01)
    judge, stepper = Judge(load("cube", 0.01)[0]), Stepper(model, tol=TOLERANCE)
    if not steps:
        data.qpos[2] += 1e-4  # of the 1 mm that it falls in the step
    stepper.step(data, steps)
    judge.set_out(data)
    stepper.step1(data)
    listed = data.ncon
    stepper.step2(data)
    contact = data.contact[stepper.modes.index(next(mode for mode in stepper.modes if mode >= 0))]
    data.efc_force[contact.efc_address] *= size
    judge.judge(data, stepper.modes, listed)
    assert judge.added == (0 if steps else 4)
    assert judge.momentum > 1e-7 and judge.law > 1e-6


def test_the_judge_sees_a_wrong_velocity() -> None:
    """One that a correction of positions has left behind."""
    model, data = load("cube", 0.01)
    judge, stepper = Judge(load("cube", 0.01)[0]), Stepper(model, tol=TOLERANCE)
    judge.set_out(data)
    stepper.step1(data)
    listed = data.ncon
    stepper.step2(data)
    data.qvel[2] += 1e-6
    judge.judge(data, stepper.modes, listed)
    assert judge.momentum > 1e-8 and judge.law > 1e-7


@pytest.mark.parametrize("h", STEPS)
def test_the_cube_stops_where_it_does_on_paper(h: float) -> None:
    done = run("cube", h)
    steps = np.arange(1, len(done.poses) + 1)
    paper = np.cumsum(h * np.maximum(SPEED - steps * MU * GRAVITY * h, 0.0))
    assert np.abs(done.poses[:, 0] - paper).max() < 1e-6
    if h == 0.01:
        assert abs(done.data.qpos[0] - 3.640) < 1e-3
    assert np.abs(done.poses[:, 1:] - [0, 0.05, 1, 0, 0, 0]).max() < 1e-8  # aside, up, tilt
    assert done.judge.modes["slip"] > 0.7 * done.judge.modes["stick"]


@pytest.mark.parametrize("h", STEPS)
@pytest.mark.parametrize("share", [0.90, 0.98, 1.00, 1.02, 1.10])
def test_the_gripper_holds_from_the_critical_friction_on(share: float, h: float) -> None:
    """At exactly 1.00 holding is the law's only answer too, and nothing is left to brake: errors of all steps add up."""
    model, data = load("gripper", h)
    model.geom_friction[:, 0] = share * MU
    stepper, end = Stepper(model, tol=TOLERANCE), 0.25 if share < 1 else 2.0
    stepper.step(data, round(end / h))
    drop = 0.5 - data.qpos[4]
    paper = 0.5 * (1 - share) * GRAVITY * end * (end + h) if share < 1 else 0.0
    assert stepper.unsolved == 0
    assert abs(drop - paper) < (1e-5 if share < 1 else 1e-6)


@pytest.mark.parametrize("h", STEPS)
def test_fingers_at_rest_stay_on_the_block_without_gravity(h: float) -> None:
    """Nothing moves and nothing falls, and the motors press: what touches has to be found all the same, and nothing else."""
    model, data = load("gripper", h)
    model.opt.gravity[:] = 0.0
    data.ctrl[:] = 50.0  # 500 m/s² for a finger alone
    stepper, before = Stepper(model, tol=TOLERANCE), data.qpos.copy()
    depth = 3e-9 * model.stat.meansize  # what rests goes there in its first step
    for step in range(50):
        stepper.step(data)
        assert sum(mode > 0 for mode in stepper.modes) in ((2, 4) if step == 0 else (4,))
        assert np.abs(data.qvel[:5]).max() < (depth / h if step == 0 else 0.0) + 4 * TOLERANCE * 500.0 * h
        assert np.abs(data.qpos - before).max() < 2 * depth + 4 * (step + 1) * TOLERANCE * 500.0 * h * h
    assert stepper.unsolved == 0


@pytest.mark.parametrize("h", STEPS)
def test_robots_stay_on_their_feet(h: float) -> None:
    trotting, standing = run("quadruped", h), run("humanoid", h)
    assert trotting.poses[:, 2].min() > 0.26 and trotting.poses[-1, 0] > 0.15
    pressed = trotting.judge.modes["stick"] + trotting.judge.modes["slip"]
    assert 4 * len(trotting.poses) - pressed > 50 and trotting.judge.modes["slip"] > 50  # feet in the air, and slipping
    assert standing.poses[:, 2].min() > 0.78 and standing.judge.modes["slip"] == 0
    model, data = load("quadruped", h)
    Stepper(model, tol=TOLERANCE).step(data, round(1 / h))
    force, total = np.zeros(6), np.zeros(3)
    for index, contact in enumerate(data.contact):
        mujoco.mj_contactForce(model, data, index, force)
        total += contact.frame.reshape(3, 3).T @ force[:3]
    assert np.allclose(total, [0, 0, GRAVITY * model.body_mass.sum()], atol=1e-3)


@pytest.mark.parametrize("h", STEPS)
def test_the_door_shuts_itself(h: float) -> None:
    done = run("door", h)
    angles = done.poses[:, 0]
    assert 1.7 - 1e-6 < angles.max() < 1.7 + 1e-6 and angles.min() > -1e-6
    assert abs(angles[-1]) < 1e-6 and np.abs(done.data.qvel).max() < 1e-6
    assert np.abs(done.poses[-1]).max() < 1e-6  # arm and rod are where they were: the loop is closed


# Where MuJoCo's law is the same: without friction, and where nothing slips. What is left is its softness.
SOFT, HARD, HARDEST = ((0.02, 1.0), 0.9), ((0.01, 1.0), 0.99), ((1e-6, 1.0), 0.9999)


def in_mujoco(model: mujoco.MjModel, softness: tuple[tuple[float, float], float]) -> None:
    model.opt.cone, model.opt.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 100
    model.opt.iterations, model.opt.tolerance = 200, 1e-12
    for kind in ("geom", "dof", "jnt", "eq"):
        getattr(model, f"{kind}_solref")[:] = softness[0]
        getattr(model, f"{kind}_solimp")[:, :2] = softness[1]


@pytest.mark.parametrize("h", STEPS)
@pytest.mark.parametrize("softness", [SOFT, HARD, HARDEST])
def test_without_friction_it_differs_from_mujoco_by_how_deep_that_sinks(
    softness: tuple[tuple[float, float], float], h: float
) -> None:
    ends, depth = [], 0.0
    for ours in (True, False):
        model, data = load("cube", h)
        model.geom_friction[:] = 0.0
        model.opt.gravity[:] = GRAVITY * np.array([np.sin(0.35), 0.0, -np.cos(0.35)])
        data.qvel[:] = 0.0
        in_mujoco(model, softness)
        stepper = Stepper(model, tol=TOLERANCE) if ours else None
        for _ in range(round(1 / h)):
            stepper.step(data) if stepper else mujoco.mj_step(model, data)
            depth = max(depth, -float(data.contact.dist.min(initial=0.0)))
        ends.append(data.qpos.copy())
    assert 1e-6 < depth < 1e-3
    assert np.abs(ends[0] - ends[1]).max() < 1.01 * depth


@pytest.mark.parametrize(("name", "controls"), [("quadruped", leave), ("humanoid", shove)])
def test_where_nothing_slips_it_differs_from_mujoco_by_how_that_gives_way(name: str, controls: Controls) -> None:
    """Sinking and creeping of a foot turn joints; the shortest lever between two feet or two corners of a foot is 0.09 m."""
    h, ends, ways = 0.001, [], []
    for softness in (None, SOFT, HARD):
        model, data = load(name, h)
        in_mujoco(model, softness or SOFT)
        stepper = None if softness else Stepper(model, tol=TOLERANCE)
        depth = crept = 0.0
        for step in range(round(2 / h)):
            controls(data, step * h)
            stepper.step(data) if stepper else mujoco.mj_step(model, data)
            touching = data.contact.efc_address[data.contact.dist < 0] if softness else []
            depth = max(depth, -float(data.contact.dist.min(initial=0.0)))
            crept += h * max((float(np.linalg.norm(data.efc_vel[row + 1 : row + 3])) for row in touching), default=0.0)
        ends.append(data.qpos.copy())
        ways.append(depth + crept)
    soft, hard = (float(np.abs(end - ends[0]).max()) for end in ends[1:])
    assert soft < ways[1] / 0.09 and hard < ways[2] / 0.09
    assert hard < 0.5 * soft and ways[0] < 1e-6


def test_a_door_of_hard_constraints_is_this_one() -> None:
    ends = [run("door", 0.001).poses[-1]]
    for softness in (SOFT, HARD, HARDEST):
        model, data = load("door", 0.001)
        in_mujoco(model, softness)
        for step in range(4000):
            hand(data, step * 0.001)
            mujoco.mj_step(model, data)
        ends.append(data.qpos.copy())
    soft, hard, hardest = (np.abs(end - ends[0]).max() for end in ends[1:])
    assert soft > 10 * hard > 100 * hardest and hardest < 1e-6
