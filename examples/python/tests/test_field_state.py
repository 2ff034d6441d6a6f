"""A run that is put back goes on bit for bit, by a state, a pickle or a copy; and nothing passes walls unseen."""

from __future__ import annotations

import copy
import pathlib
import pickle
from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from field import FLOOR, Array, Scene, box, scene
from test_mujoco_scenes import leave, shove, trot

from stiction.mujoco import Stepper

MODELS = pathlib.Path(__file__).resolve().parents[1] / "models"
KIND = mujoco.mjtState.mjSTATE_INTEGRATION
Controls = Callable[[mujoco.MjData, float], None]


def tumbling() -> mujoco.MjModel:
    """Five boxes that fall on a heap, and a pusher that comes."""
    random, world = np.random.default_rng(3), FLOOR
    for i in range(5):
        place = f"{random.normal() * 0.03} {random.normal() * 0.03} {0.2 + 0.15 * i}"
        turned = " ".join(map(str, random.normal(size=4)))
        world += f'<body pos="{place}" quat="{turned}"><freejoint/><geom type="box" size=".05 .04 .03" mass=".3"/></body>'
    world += '<body mocap="true" pos=".4 0 .05"><geom type="box" size=".05 .2 .05"/></body>'
    return scene(world).model


def push(data: mujoco.MjData, time: float) -> None:
    data.mocap_pos[0, 0] = 0.4 - 0.3 * time


def of_file(name: str) -> mujoco.MjModel:
    model = mujoco.MjModel.from_xml_path(str(MODELS / f"{name}.xml"))
    model.opt.timestep = 0.002
    return model


def go(stepper: Stepper, data: mujoco.MjData, controls: Controls, steps: int) -> Array:
    """Take steps; positions, velocities, forces and time after each."""
    way = []
    for _ in range(steps):
        controls(data, data.time)
        stepper.step(data)
        way.append(np.concatenate([data.qpos, data.qvel, data.qfrc_constraint, [data.time]]))
    return np.array(way)


RUNS: dict[str, tuple[Callable[[], mujoco.MjModel], Controls, int, int]] = {
    **{f"tumbling, {steps}": (tumbling, push, steps, 150) for steps in (50, 100, 150, 300)},
    "quadruped": (lambda: of_file("quadruped"), trot, 400, 300),
    "humanoid": (lambda: of_file("humanoid"), shove, 120, 100),
    "door": (lambda: of_file("door"), leave, 100, 100),
}


@pytest.mark.parametrize("name", RUNS)
def test_a_run_that_is_put_back_is_the_run_that_went_on(name: str) -> None:
    build, controls, before, after = RUNS[name]
    model = build()
    data, stepper = mujoco.MjData(model), Stepper(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    go(stepper, data, controls, before)
    state = np.zeros(mujoco.mj_stateSize(model, KIND))
    mujoco.mj_getState(model, data, state, KIND)
    own = stepper.state()
    copied = copy.copy(stepper), copy.copy(data)
    deep, pickled = copy.deepcopy((stepper, data)), pickle.loads(pickle.dumps((stepper, data)))
    way = go(stepper, data, controls, after)
    for other, its in (copied, deep, pickled):
        assert np.array_equal(go(other, its, controls, after), way)
    for other, its in ((stepper, data), (Stepper(model), mujoco.MjData(model))):
        for _ in range(2):
            mujoco.mj_setState(model, its, state, KIND)
            other.set_state(its, pickle.loads(pickle.dumps(own)))
            assert np.array_equal(go(other, its, controls, after), way)


def test_without_its_state_a_run_is_another() -> None:
    """What the test above would not see if states were nothing: a cold start in the heap."""
    model = tumbling()
    data, stepper = mujoco.MjData(model), Stepper(model)
    go(stepper, data, push, 300)
    state = np.zeros(mujoco.mj_stateSize(model, KIND))
    mujoco.mj_getState(model, data, state, KIND)
    way = go(stepper, data, push, 100)
    other = mujoco.MjData(model)
    mujoco.mj_setState(model, other, state, KIND)
    assert not np.array_equal(go(Stepper(model), other, push, 100), way)


@pytest.mark.parametrize("is_pushed", [True, False])
def test_what_if_from_one_state_may_be_asked_often(is_pushed: bool) -> None:
    """Rows of boxes, pushed by what moves from outside or by a force: branches, and back to the trunk."""
    world = FLOOR + "".join(box(".05 .04 .03", f"{0.2 * i} 0 .0301", 0.3) for i in range(3))
    s = scene(world + '<body mocap="true" pos="-.2 0 .05"><geom type="box" size=".05 .2 .05"/></body>', tol=1e-6)

    def drive(data: mujoco.MjData, time: float) -> None:
        if is_pushed:
            data.mocap_pos[0, 0] = -0.2 + 0.3 * time
        else:
            data.xfrc_applied[1, 0] = 1.2 * np.sin(9 * time)

    go(s.stepper, s.data, drive, 400)
    state = np.zeros(mujoco.mj_stateSize(s.model, KIND))
    mujoco.mj_getState(s.model, s.data, state, KIND)
    own, ways = s.stepper.state(), []
    for disturbance in (0.0, 0.5, -2.0, 0.0):
        mujoco.mj_setState(s.model, s.data, state, KIND)
        s.stepper.set_state(s.data, own)
        s.data.qvel[6] += disturbance
        ways.append(go(s.stepper, s.data, drive, 60))
    assert np.array_equal(ways[0], ways[3]) and not np.array_equal(ways[0], ways[1])


def test_a_state_belongs_to_its_model() -> None:
    one, two = scene(FLOOR + box(".1 .1 .1", "0 0 .1")), scene(FLOOR + box(".1 .1 .1", "0 0 .1") + box(".1 .1 .1", "1 0 .1"))
    for s in (one, two):
        s.step(3)
    for s, other in ((one, two), (two, one)):
        with pytest.raises(ValueError, match="state"):
            s.stepper.set_state(s.data, other.stepper.state())
        for wrong in (s.stepper.state()[:-1], np.zeros(0, np.uint64), np.zeros(7, np.uint64)):
            with pytest.raises(ValueError, match="state"):
                s.stepper.set_state(s.data, wrong)
        s.step(3)
        assert s.is_clean()


def test_a_stepper_keeps_its_model() -> None:
    s = scene(FLOOR + box(".1 .1 .1", "0 0 .1"))
    with pytest.raises(AttributeError):
        s.stepper.model = s.model  # type: ignore[misc]
    assert s.stepper.model is s.model


def shot(speed: float, height: float, shape: str = 'size=".005"') -> Scene:
    """A ball of 5 mm on its way to a plate of 2 mm, without gravity, at 2 ms."""
    plate, ball = '<geom type="box" size="1 1 .001"/>', f'<body pos=".1 0 {height}"><freejoint/><geom {shape} mass=".01"/></body>'
    s = scene(plate + ball, option='gravity="0 0 0"')
    s.data.qvel[2] = -speed
    return s


@pytest.mark.parametrize("speed", [5, 45, 60, 120, 300, 700])
def test_what_is_shot_at_a_thin_plate_stops_at_it(speed: float) -> None:
    """Up to 1.4 m a step, from 20 heights: 0.001 + 0.005 m is where it touches."""
    for height in 0.5 + 0.3 * np.random.default_rng(0).random(20):
        s = shot(speed, height)
        s.step(int(1.5 / speed / s.h) + 4)
        assert s.data.qpos[2] == pytest.approx(0.006, abs=1e-6) and np.abs(s.data.qvel).max() < 1e-6
        assert s.is_clean() and s.stepper.blind == 0


@pytest.mark.parametrize("shape", ['size=".005"', 'type="box" size=".005 .005 .005"', 'type="capsule" size=".003 .005"'])
def test_what_is_too_fast_to_be_seen_is_counted(shape: str) -> None:
    """20 km/s are 40 m a step: more poses than are looked at. It has passed or not; that step is counted, and no other."""
    s = shot(2e4, 0.7, shape)
    s.step()
    assert s.stepper.blind == 1
    slow = shot(200, 0.7, shape)
    slow.step(10)
    assert slow.stepper.blind == 0 and slow.data.qpos[2] > 0


@pytest.mark.parametrize(("speed", "blind"), [(760, 0), (780, 1)])
def test_256_poses_are_looked_at(speed: float, blind: int) -> None:
    """One for each 6 mm, the thickness of both: to 768 m/s at 2 ms."""
    s = shot(speed, 50.0)
    s.step(3)
    assert s.stepper.blind == 3 * blind


def met(speed: float, start: float) -> Scene:
    """Two balls of 5 mm, each so far from the middle, that have flown at each other for as long as it takes them to meet."""
    ball = '<body pos="{} 0 0"><freejoint/><geom size=".005" mass=".01"/></body>'
    s = scene(ball.format(-start) + ball.format(start), option='gravity="0 0 0"')
    s.data.qvel[[0, 6]] = speed, -speed
    s.step(round(0.7 / speed / s.h) + 3)
    return s


@pytest.mark.parametrize("speed", [5, 20])
def test_balls_that_meet_in_flight_meet(speed: float) -> None:
    """8 cm a step at most: the law takes all of their speed, and they touch."""
    for start in np.linspace(0.4, 0.65, 10):
        s = met(speed, start)
        assert np.abs(s.data.qvel).max() < 1e-6 and s.data.qpos[7] - s.data.qpos[0] == pytest.approx(0.01, abs=1e-6)
        assert abs(s.data.qpos[7] + s.data.qpos[0]) < 1e-6 and s.is_clean() and s.stepper.blind == 0


@pytest.mark.parametrize("speed", [50, 100, 200])
def test_balls_that_meet_at_any_speed_do_not_pass(speed: float) -> None:
    """Two against each other move twice as far between poses as each by itself."""
    for start in np.linspace(0.4, 0.65, 40):
        s = met(speed, start)
        assert s.data.qpos[0] < s.data.qpos[7] or s.stepper.blind
