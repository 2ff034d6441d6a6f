"""What public reports of contact simulators broke, rebuilt small: right values are those on paper."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from field import FLOOR, G, Scene, box, scene, slope

LINK = '<body pos="0 0 1"><joint name="a" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass=".2"/></body>'
ACTUATORS = {
    "brake": ('<damper joint="a" kv="100" ctrlrange="0 1"/>', 1.0),
    "damper": ('<damper joint="a" kv="5" ctrlrange="0 1"/>', 1.0),
    "velocity": ('<velocity joint="a" kv="100"/>', 1.0),
    "position": ('<position joint="a" kp="200" kv="20"/>', 0.3),
    "dampratio": ('<position joint="a" kp="200" dampratio="1"/>', 0.3),
    "timeconst": ('<position joint="a" kp="200" kv="20" timeconst=".1"/>', 0.3),
    "intvelocity": ('<intvelocity joint="a" kp="200" kv="20" actrange="-1 1"/>', 0.5),
    "muscle": ('<muscle joint="a" lengthrange="-2 2" force="20"/>', 0.5),
    "delay": ('<motor joint="a" delay=".02" nsample="20"/>', 0.2),
    "dcmotor": ('<dcmotor joint="a" motorconst=".5" resistance=".1"/>', 2.0),
}


@pytest.mark.parametrize("name", ACTUATORS)
def test_actuators_are_those_of_mujoco(name: str) -> None:
    actuator, control = ACTUATORS[name]
    s = scene(LINK, f"<actuator>{actuator}</actuator>", 'integrator="implicitfast"')
    other = mujoco.MjData(s.model)
    for data in (s.data, other):
        data.qvel[0], data.ctrl[:] = 1.0, control
    s.step(250)
    mujoco.mj_step(s.model, other, 250)
    assert np.allclose([s.data.qpos[0], s.data.qvel[0]], [other.qpos[0], other.qvel[0]], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("above", [0.2, 1.0, 5.0])
@pytest.mark.parametrize("speed", [0.2, 1.0])
def test_a_vacuum_gripper_takes_what_it_touches_only(above: float, speed: float) -> None:
    pad = '<joint name="x" type="slide" axis="1 0 0"/><geom type="cylinder" size=".02 .005" mass=".3"/>'
    world = f'{FLOOR}<body name="b" pos="0 0 {0.045 + above / 1e3}">{pad}</body>{box(".02 .02 .02", ".15 0 .02", 0.05)}'
    actuators = '<actuator><adhesion body="b" ctrlrange="0 1" gain="5"/><velocity joint="x" kv="200"/></actuator>'
    s = scene(world, actuators, 'integrator="implicitfast"')
    s.data.ctrl[:] = 1, speed
    for _ in range(round(0.3 / speed / s.h)):
        s.step()
        assert np.abs(s.data.qpos[1:4] - [0.15, 0, 0.02]).max() < 1e-9
    assert s.is_clean()


@pytest.mark.parametrize("gap", [0.0, 1e-5, 1e-4, 5e-4, 2e-3])
def test_a_sticky_plate_holds_what_touches_it_only(gap: float) -> None:
    plate = '<geom type="box" size=".2 .2 .01" pos="0 0 .5" friction=".5 0 0" adhesion="10"/>'
    s = scene(plate + box(".05 .05 .05", f"0 0 {0.44 - gap}", 1.0, 0.5))
    fallen = s.data.qpos[2] - s.step(50).qpos[2]
    assert np.isclose(fallen, G * s.h**2 * 50 * 51 / 2 if gap else 0.0, atol=1e-9)


def test_a_sticky_wall_does_not_pull_what_flies_by() -> None:
    wall = '<geom type="box" size=".01 1 1" pos="-.01 0 0" adhesion="10"/>'
    s = scene(wall + box(".05 .05 .05", ".055 -.5 0"), option='gravity="0 0 0"')
    s.data.qvel[1] = 3.0
    assert np.allclose(s.step(150).qvel, [0, 3, 0, 0, 0, 0], atol=1e-12)


def test_forces_may_be_read_after_mj_forward() -> None:
    """MuJoCo's own law then; but margins are those of the model, and what else falls does not matter."""
    alone, both = (scene(FLOOR + box(".1 .1 .05", "0 0 .05", 2.0) + other) for other in ("", box(".1 .1 .05", ".5 0 .06", 2.0)))
    for s in (alone, both):
        s.step(2)  # from touching to the depth of rest
    for _ in range(60):
        readings = []
        for s in (alone, both):
            s.step()
            assert np.isclose(s.forces()[1], 2 * G, atol=1e-6)
            mujoco.mj_forward(s.model, s.data)
            readings.append(s.forces()[1])
        assert readings[0] == pytest.approx(readings[1], abs=1e-6) and 18.0 < readings[0] < 20.0


@pytest.mark.parametrize("h", [0.001, 0.005])
def test_a_rope_over_a_pulley_does_not_stretch(h: float) -> None:
    weights = '<site name="t1" pos="-.1 0 2"/><site name="t2" pos=".1 0 2"/>'
    for x, mass, name in ((-0.1, 2, "a"), (0.1, 1, "b")):
        joint = '<joint type="slide" axis="0 0 1"/>'
        weights += f'<body pos="{x} 0 1">{joint}<geom size=".05" mass="{mass}"/><site name="{name}"/></body>'
    rope = '<site site="a"/><site site="t1"/><site site="t2"/><site site="b"/>'
    s = scene(weights, f'<tendon><spatial limited="true" range="0 2.2">{rope}</spatial></tendon>', h=h)
    data = s.run(0.5)
    assert np.isclose(data.qvel[0], -G / 3 * 0.5, atol=1e-4) and data.ten_length[0] < 2.2 + 1e-8
    assert np.isclose(data.efc_force[0], 4 / 3 * G, atol=1e-6) and s.is_clean()


@pytest.mark.parametrize("h", [0.001, 0.005])
def test_backlash_stays_within_its_play(h: float) -> None:
    gear = '<joint name="m" axis="0 0 1" armature=".002" damping=".01"/>'
    gear += '<inertial pos="0 0 0" mass=".01" diaginertia="1e-6 1e-6 1e-6"/>'
    arm = '<joint axis="0 0 1" limited="true" range="-.573 .573"/>'
    arm += '<geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass=".5" contype="0"/>'
    servo = '<actuator><position joint="m" kp="20" kv="1"/></actuator>'
    s = scene(f"<body>{gear}<body>{arm}</body></body>", servo, 'gravity="0 0 0" integrator="implicitfast"', h=h)
    for i in range(int(4 / h)):
        s.data.ctrl[0] = 0.3 * np.sin(np.pi * i * h)
        assert abs(s.step().qpos[1]) < np.deg2rad(0.573) + 1e-6
    assert s.is_clean()


@pytest.mark.parametrize(("mu", "belt"), [(0.9, 0.0), (0.9, 0.5), (1.1, 0.0), (1.1, 0.5)])
def test_a_belt_on_a_slope_is_a_ramp_or_carries(mu: float, belt: float) -> None:
    tilted = 'euler="0 -45 0"'
    world = f'<geom type="box" size="20 1 .1" pos="0 0 -.1" {tilted} friction="{mu} 0 0" surfacevel="{belt} 0 0 0 0 0"/>'
    world += f'<body {tilted}><freejoint/><geom type="box" size=".1 .1 .05" pos="0 0 .08" mass="1" friction="{mu} 0 0"/></body>'
    s, up = scene(world), np.array([1, 0, 1]) / np.sqrt(2)
    before = float(s.step(100).qvel[:3] @ up)
    after = float(s.step(200).qvel[:3] @ up)
    gained = G * 0.4 * (mu - 1) / np.sqrt(2)
    assert after == pytest.approx(before + gained if mu < 1 else min(belt, before + gained), abs=1e-6)


@pytest.mark.parametrize("boxes", [3, 5, 6, 8])
def test_towers_stand(boxes: int) -> None:
    s = scene(FLOOR + "".join(box(".05 .05 .05", f"0 0 {0.05 + 0.1 * i}") for i in range(boxes)), h=0.005, tol=1e-8)
    start = s.data.qpos.copy()
    assert np.abs(s.run(1.0).qpos - start).max() < 1e-6 and np.abs(s.data.qvel).max() < 1e-6
    assert s.is_clean()


def test_plates_stand_in_a_bin_without_friction() -> None:
    slick = 'condim="1"'
    world = FLOOR.replace("/>", f" {slick}/>")
    for a, b, x, y in ((0.01, 0.2, -0.13, 0), (0.01, 0.2, 0.13, 0), (0.2, 0.01, 0, -0.13), (0.2, 0.01, 0, 0.13)):
        world += f'<geom type="box" size="{a} {b} .2" pos="{x} {y} .2" {slick}/>'
    s = scene(world + "".join(box(".11 .11 .005", f"0 0 {0.005 + 0.01 * i}", 0.3, more=slick) for i in range(5)), tol=1e-8)
    start = s.data.qpos.copy()
    assert np.abs(s.run(1.0).qpos - start).max() < 1e-5 and s.is_clean()


def test_restitution_of_solref_is_not_read() -> None:
    soft = 'solref="-10000 0"'
    s = scene(FLOOR.replace("/>", f" {soft}/>") + f'<body pos="0 0 .55"><freejoint/><geom size=".05" {soft}/></body>', h=0.001)
    heights = [float(s.step().qpos[2]) for _ in range(600)]
    assert min(heights) > 0.05 - 1e-8 and max(heights[400:]) < 0.05 + 1e-8


@pytest.mark.parametrize("torque", [0.45, 0.4999, 0.5, 0.5001, 0.55])
def test_a_brake_holds_up_to_its_torque(torque: float) -> None:
    joint = '<joint axis="0 0 1" frictionloss=".5" armature="1e-4"/>'
    s = scene(f'<body>{joint}<inertial pos="0 0 0" mass="1" diaginertia=".01 .01 .01"/></body>')
    s.data.qfrc_applied[0] = torque
    assert s.run(1.0).qvel[0] == pytest.approx(max(0.0, torque - 0.5) / 0.0101, abs=1e-7) and s.is_clean()


@pytest.mark.parametrize("push", [4.85, 4.9, 4.9049, 4.905, 4.9051, 4.91])
def test_a_push_moves_a_box_from_the_critical_one_on(push: float) -> None:
    s = scene('<geom type="plane" size="5 5 1" friction=".5 0 0"/>' + box(".1 .1 .05", "0 0 .05", 1.0, 0.5), tol=1e-8)
    s.data.xfrc_applied[1, [0, 4]] = push, -0.05 * push
    s.run(2.0)
    assert s.data.qvel[0] == pytest.approx(max(0.0, push - 4.905) * 2, abs=1e-6) and s.is_clean()
    assert s.data.qpos[0] < 1e-6 if push <= 4.905 else s.data.qpos[0] > 1e-5


def on_slope(degrees: float, mu: float) -> Scene:
    angle = np.deg2rad(degrees)
    floor = f'<geom type="plane" size="5 5 1" friction="{mu} 0 0"/>'
    return scene(floor + box(".2 .15 .1", "0 0 .1", 2.0, mu), option=slope(angle))


@pytest.mark.parametrize("degrees", [0, 10, 20])
def test_corners_on_a_slope_bear_what_statics_says(degrees: float) -> None:
    s, angle = on_slope(degrees, 0.6), np.deg2rad(degrees)
    data = s.run(1.0)
    force, share = np.zeros(6), {(1, 1): 0.0, (1, -1): 0.0, (-1, 1): 0.0, (-1, -1): 0.0}
    for index, contact in enumerate(data.contact):
        mujoco.mj_contactForce(s.model, data, index, force)
        share[int(np.sign(contact.pos[0] - data.qpos[0])), int(np.sign(contact.pos[1]))] += force[0]
    for side in (-1, 1):  # uphill, downhill: gravity points to -x
        want = (2 * G * np.cos(angle) - side * 2 * G * np.sin(angle) * 0.1 / 0.2) / 2
        assert share[side, 1] + share[side, -1] == pytest.approx(want, abs=1e-5)
        assert share[side, 1] == pytest.approx(share[side, -1], abs=0.1)
    assert s.is_clean()


@pytest.mark.parametrize(("mu", "torque"), [(0.6, 1.0), (0.6, 0.4), (0.66, 1.0), (0.8, 1.0)])
@pytest.mark.parametrize("is_cold", [False, True])
def test_a_nudge_that_friction_can_hold_moves_nothing(mu: float, torque: float, is_cold: bool) -> None:
    s = on_slope(20, mu)
    s.step(200)
    s.data.xfrc_applied[1] = 0, 4, 0, torque, 0, 0.6
    for _ in range(200):
        if is_cold:
            s.stepper.reset()
        s.step()
    assert np.abs(s.data.qpos - [0, 0, 0.1, 1, 0, 0, 0]).max() < 1e-6 and s.is_clean()


W = '<actuator><velocity joint="w" kv="200"/></actuator>'


@pytest.mark.parametrize("roll", [0.0, 0.001, 0.005, 0.01])
def test_a_wheel_creeps_by_what_one_cone_for_slip_and_roll_says(roll: float) -> None:
    """Slip over roll is as the shares of the cone: v_slip / omega = (roll / mu) share / sqrt(1 - share^2)."""
    surface, R = f'condim="6" friction=".8 0 {roll}"', 0.1
    joints = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint name="w" axis="0 1 0"/>'
    wheel = f'<body pos="0 0 {R}">{joints}<geom size="{R}" mass="5" {surface}/></body>'
    s = scene(f'<geom type="plane" size="50 50 1" {surface}/>{wheel}', W, slope(np.deg2rad(20)) + ' integrator="implicitfast"')
    s.data.ctrl[0] = 5.0
    data, force = s.run(2.0), np.zeros(6)
    mujoco.mj_contactForce(s.model, data, 0, force)
    share = np.hypot(force[1], force[2]) / (0.8 * force[0])
    slip = 1 - data.qvel[0] / (data.qvel[2] * R)
    roll = max(roll, 1e-5)  # MuJoCo's least
    assert slip == pytest.approx(roll / (0.8 * R) * share / np.sqrt(1 - share**2), abs=1e-6) and 0.4 < share < 0.5


@pytest.mark.parametrize(("size", "mass", "drop"), [(0.01, 1e-3, 0.01), (2.5e-4, 1e-6, 5e-4)])
@pytest.mark.parametrize("h", [0.002, 0.01])
def test_tiny_things_rest(size: float, mass: float, drop: float, h: float) -> None:
    s = scene(FLOOR + box(f"{size} {size} {size}", f"0 0 {size + drop}", mass), h=h)
    data = s.run(0.5)
    assert abs(data.qpos[2] - size) < 1e-9 and np.abs(data.qvel).max() < 1e-6
    assert s.forces()[1] == pytest.approx(mass * G, rel=1e-6) and s.is_clean()


def test_units_do_not_matter() -> None:
    ends = []
    for length, mass in ((1.0, 1.0), (1000.0, 1000.0), (0.001, 0.001)):
        floor = f'<geom type="plane" size="{9 * length} {9 * length} {length}" friction=".3 0 0"/>'
        half = 0.05 * length
        cube = box(f"{half} {half} {half}", f"0 0 {0.048 * length}", mass, 0.3)
        s = scene(floor + cube, option=f'gravity="0 0 {-G * length}"')
        s.data.qvel[0] = length
        s.step(100)
        ends.append(np.concatenate([s.data.qpos[:3] / length, s.data.qvel[:3] / length]))
    assert np.allclose(ends[1:], ends[0], atol=1e-8) and ends[0][2] == pytest.approx(0.05, abs=1e-6)
    assert ends[0][0] == pytest.approx(0.140551, abs=1e-4)
