"""What rests or is held stays where it is: for long, on heavy and light things, far away, beside large things, in a hand."""

from __future__ import annotations

import pathlib

import mujoco
import numpy as np
import pytest
from field import FLOOR, Array, G, Scene, box, scene

from stiction.mujoco import Stepper

QUADRUPED = pathlib.Path(__file__).resolve().parents[1] / "models/quadruped.xml"
PASS = 1e-12  # of the model's length: what the position pass may move of what rests, in a step
APART = 'contype="0" conaffinity="0"'


def mesh(name: str, x: float, y: float, z: float) -> str:
    """A box of these half edges, as a mesh."""
    corners = " ".join(f"{a * x} {b * y} {c * z}" for a in (-1, 1) for b in (-1, 1) for c in (-1, 1))
    return f'<mesh name="{name}" vertex="{corners}"/>'


def passed(s: Scene, steps: int) -> float:
    """The largest motion in a step that is not one of the velocity after it (m)."""
    moved, most = np.zeros(s.model.nv), 0.0
    for _ in range(steps):
        before = s.data.qpos.copy()
        s.step()
        mujoco.mj_differentiatePos(s.model, moved, 1.0, before, s.data.qpos)
        most = max(most, float(np.abs(moved - s.h * s.data.qvel).max()))
    return most


TURNED = '<body pos="0 0 .25" euler="0 0 23"><freejoint/><geom type="box" size=".25 .25 .25" mass="1"/></body>'
RESTING = {
    "box": (FLOOR + box(".1 .1 .1", "0 0 .1"), "", 1 / 240),
    "turned": (f'<geom type="box" size=".5 .5 .5" pos="0 0 -.5"/>{TURNED}', "", 1 / 240),
    "far": ('<geom type="box" size=".5 .5 .5" pos="1e6 1e6 -.5"/>' + box(".25 .25 .25", "1e6 1e6 .25"), "", 1 / 240),
    "slope": (FLOOR + box(".1 .1 .05", "0 0 .05", 2.0), 'gravity="-3 1 -9"', 0.002),
    "tower": (FLOOR + "".join(box(".05 .05 .05", f"0 0 {0.05 + 0.1 * i}") for i in range(4)), "", 0.005),
    "ball": (FLOOR + '<body pos="0 0 .05"><freejoint/><geom size=".05" friction="1 .01 .001" condim="6"/></body>', "", 0.002),
    "mesh": (
        '<geom type="mesh" mesh="g" pos="0 0 -.5"/><body pos="0 0 .05"><freejoint/><geom type="mesh" mesh="c"/></body>',
        "",
        0.002,
    ),
}


@pytest.mark.parametrize("tol", [1e-6, 1e-9])
@pytest.mark.parametrize("name", RESTING)
def test_the_position_pass_leaves_what_rests_alone(name: str, tol: float) -> None:
    world, option, h = RESTING[name]
    s = scene(world, option=option, h=h, tol=tol, head=f"<asset>{mesh('g', 1, 1, 0.5)}{mesh('c', 0.05, 0.05, 0.05)}</asset>")
    s.run(1.0)
    start = s.data.qpos.copy()
    assert passed(s, 1500) < PASS * s.model.stat.meansize
    assert np.abs(s.data.qpos - start).max() < 1e-8 and np.abs(s.data.qvel).max() < tol * G and s.is_clean()


@pytest.mark.parametrize("h", [0.002, 0.005])
def test_a_robot_that_lies_on_its_side_lies(h: float) -> None:
    model = mujoco.MjModel.from_xml_path(str(QUADRUPED))
    model.opt.timestep = h
    s = Scene(model, mujoco.MjData(model), Stepper(model, tol=1e-9))
    mujoco.mj_resetDataKeyframe(model, s.data, 0)
    s.data.qpos[2:7] += 0.1, *(np.array([0.6, 0.8, 0, 0]) - s.data.qpos[3:7])
    s.run(5.0)
    start = s.data.qpos.copy()
    assert passed(s, 1500) < PASS * model.stat.meansize
    assert np.abs(s.data.qpos - start).max() < 1e-8 and np.abs(s.data.qvel).max() < 1e-9 * G


@pytest.mark.parametrize("tol", [1e-6, 1e-9])
@pytest.mark.parametrize("apart", [0.0, 1.0, 10.0, 631.0, 1e3, 1e5, 1e6])
def test_a_minute_changes_nothing(apart: float, tol: float) -> None:
    """A cube of 0.5 m on a larger one, at 240 Hz: a fiftieth of the speed that the tolerance allows, and digits.

    On impulses that stay the same a cube is a pendulum on its tip: it tips, by e times in 1/7 s, until the error exceeds the
    tolerance every few seconds. So it moves in proportion to the tolerance. Of 37 distances from 0.1 m to 1000 km, to 1e-6,
    the worst moved by a hundredth. Digits are 1e-16 of the distance from the origin in a step.
    """
    place = f"{apart} {apart}"
    world = f'<geom type="box" size=".5 .5 .5" pos="{place} -.5"/>' + TURNED.replace("0 0 .25", f"{place} .25", 1)
    s = scene(world, h=1 / 240, tol=tol)
    s.step(10)
    start = s.data.qpos.copy()
    s.run(60.0)
    creep = tol * G * s.h / 50
    assert np.abs(s.data.qpos - start).max() < 60 * creep + 14400e-16 * apart and s.is_clean()


@pytest.mark.parametrize("ratio", [1e2, 1e4, 1e6])
@pytest.mark.parametrize("heavy", [0, 1])
def test_heavy_boxes_stand_on_light_ones(ratio: float, heavy: int) -> None:
    """Five, at 10 ms. An error of a velocity is one of a light box, at any of 20 corners; a heavy one makes `ratio` times that."""
    masses = [10 if i % 2 == heavy else 10 / ratio for i in range(5)]
    s = scene(FLOOR + "".join(box(".2 .2 .2", f"0 0 {0.2 + 0.4 * i}", m) for i, m in enumerate(masses)), h=0.01)
    s.run(1.0)
    start, wrong = s.data.qpos.copy(), 2e-8 * ratio
    for _ in range(200):
        s.step()
        assert s.forces()[1] == pytest.approx(sum(masses) * G, rel=max(1e-6, wrong))
    assert np.abs(s.data.qpos - start).max() < 1e-7 + wrong * G * 0.01**2 * 200 and s.is_clean()


@pytest.mark.parametrize("size", [1.0, 100.0])
@pytest.mark.parametrize("edge", [0.05, 0.005, 0.001])
def test_small_things_rest_beside_large_ones(size: float, edge: float) -> None:
    """Lengths are shares of the model's mean size: a millionth of it may a cube sink in, and lean by that over its edge."""
    hall = f'<body pos="{3 * size} 0 0"><geom type="box" size="{size} {size} {size}" {APART}/></body>'
    cube = f'<geom type="box" size="{edge / 2} {edge / 2} {edge / 2}" density="8000"/>'
    world = f'{hall}{FLOOR}<body pos="0 0 {0.7 * edge}" quat=".98 .1 .17 0"><freejoint/>{cube}</body>'
    s = scene(world, h=0.001, tol=1e-6)
    s.run(1.5)
    sunk, turned = 1e-6 * s.model.stat.meansize, np.zeros(9)
    mujoco.mju_quat2Mat(turned, s.data.qpos[3:7])
    assert abs(s.data.qpos[2] - edge / 2) < sunk + 1e-9 and np.abs(turned[6:]).max() > 1 - (sunk / edge) ** 2 - 1e-9
    assert np.abs(s.data.qvel).max() < 1e-4 and s.is_clean()


@pytest.mark.parametrize("size", [1.0, 100.0, 1e4])
@pytest.mark.parametrize("share", [0.0, 0.37])
def test_a_mesh_rests_and_slides_on_a_large_mesh(size: float, share: float) -> None:
    """It stops after v^2 / (2 mu g), in steps v h / 2 earlier."""
    thick, place = 0.5 * max(1.0, size / 100), share * size
    head = f"<asset>{mesh('g', size, size, thick)}{mesh('c', 0.05, 0.05, 0.05)}</asset>"
    ground = f'<geom type="mesh" mesh="g" pos="0 0 {-thick}" friction=".4 0 0"/>'
    cube = f'<body pos="{place} 0 .05"><freejoint/><geom type="mesh" mesh="c" mass="1" friction=".4 0 0"/></body>'
    s = scene(ground + cube, head=head, tol=1e-8)
    s.step(200)
    assert np.abs(s.data.qpos[:3] - [place, 0, 0.05]).max() < 1e-8 and s.forces()[1] == pytest.approx(G, rel=1e-6)
    s.data.qvel[0] = 1.0
    s.step(200)
    assert s.data.qpos[0] - place == pytest.approx(1 / (0.8 * G) - 0.5 * s.h, abs=0.4 * G * s.h**2)
    assert np.abs(s.data.qpos[1:3] - [0, 0.05]).max() < 1e-7 and s.is_clean()


@pytest.mark.parametrize("h", [1e-6, 1e-5, 1e-4, 1e-3, 0.02, 0.05])
def test_steps_of_a_microsecond_and_of_50_ms(h: float) -> None:
    """A box rests and another slides by the sum of its steps; below 0.1 ms impulses are small beside the digits of a gap over h."""
    floor = '<geom type="plane" size="5 5 .1" friction=".3 0 0"/>'
    s = scene(floor + box(".05 .05 .05", "0 0 .05", 1.0, 0.3) + box(".05 .05 .05", "1 0 .05", 1.0, 0.3), h=h, tol=1e-6)
    s.data.qvel[6], forces = 1.0, []
    s.step(2)
    for _ in range(2000 if h < 1e-4 else max(20, round(0.5 / h))):
        s.step()
        forces.append(s.forces()[1])
    steps = np.arange(1, round(s.data.time / h) + 1)
    slid = h * np.maximum(1 - 0.3 * G * h * steps, 0).sum()
    depth = 1e-6 * s.model.stat.meansize
    assert np.abs(s.data.qpos[:3] - [0, 0, 0.05]).max() < depth and abs(s.data.qpos[9] - 0.05) < depth
    assert s.data.qpos[7] - 1 == pytest.approx(slid, rel=1e-5, abs=1e-9)
    assert np.mean(forces) == pytest.approx(G, rel=1e-3) and s.is_clean()


@pytest.mark.parametrize("h", [0.001, 0.005])
def test_a_foot_that_lands_on_an_edge_tips_to_a_face(h: float) -> None:
    """From 24 poses near the balance on an edge, where nothing but the law says which way."""
    size, s = np.array([0.047, 0.0675, 0.015]), None
    for k in range(0, 24, 1 if h > 0.001 else 4):
        across = 0 if k % 2 else 1
        angle = np.arctan2(size[across], size[2]) + (k // 2 - 5.5) * 1e-4
        about = (0, np.sin(angle / 2), 0) if k % 2 else (np.sin(angle / 2), 0, 0)
        foot = '<freejoint/><geom type="box" size=".047 .0675 .015" mass=".4"/>'
        s = scene(
            f'{FLOOR}<body pos="0 0 .12" quat="{np.cos(angle / 2)} {about[0]} {about[1]} {about[2]}">{foot}</body>', h=h, tol=1e-6
        )
        s.run(3.0)
        turned = np.zeros(9)
        mujoco.mju_quat2Mat(turned, s.data.qpos[3:7])
        face = np.abs(turned[6:])
        assert face.max() > 1 - 1e-10 and abs(s.data.qpos[2] - size[face.argmax()]) < 1e-6
        assert np.abs(s.data.qvel).max() < 1e-4 and s.is_clean()


@pytest.mark.parametrize("h", [0.002, 0.01])
def test_a_shaken_grasp_does_not_slip(h: float) -> None:
    """Fingers of 50 g on a base of 500 kg, 20 N each, shaken by 10 m/s^2: friction bears 32 N, and weight and shaking ask 14 N."""
    fingers = "".join(
        f'<body pos="{side * 0.05} 0 0"><joint name="f{side}" type="slide" axis="{-side} 0 0"/>'
        '<geom type="box" size=".01 .015 .02" mass=".05" friction=".8 0 0"/></body>'
        for side in (-1, 1)
    )
    base = f'<geom type="box" size=".1 .1 .02" pos="0 0 .1" mass="500" {APART}/>'
    slides = '<joint name="x" type="slide" axis="0 1 0"/><joint name="z" type="slide" axis="0 0 1"/>'
    held = box(".04 .03 .05", "0 .01 .49", 1.0, 0.8)
    servos = "".join(f'<position joint="{name}" kp="1e7" kv="1e5"/>' for name in "zx")
    motors = f'<actuator><motor joint="f-1"/><motor joint="f1"/>{servos}</actuator>'
    s = scene(f'<body pos="0 0 .5">{slides}{base}{fingers}</body>{held}', motors, 'integrator="implicitfast"', h=h, tol=1e-8)

    def seen() -> Array:
        base = np.array([0, s.data.qpos[0], s.data.qpos[1], 0, 0, 0, 0])
        part: Array = s.data.qpos[4:11] - base
        return part

    s.data.ctrl[:2] = 20.0
    s.run(0.5)
    before = seen()
    for i in range(round(4 / h)):
        s.data.ctrl[3] = 0.01 * np.sin(10 * np.pi * i * h) * min(1.0, i * h)
        s.step()
    pressing, force = np.zeros(2), np.zeros(6)
    for index, contact in enumerate(s.data.contact):
        mujoco.mj_contactForce(s.model, s.data, index, force)
        pressing[0 if 2 in s.model.geom_bodyid[contact.geom] else 1] += force[0]
    assert np.abs(seen() - before).max() < 1e-6 and pressing == pytest.approx([20, 20], rel=1e-6) and s.is_clean()


@pytest.mark.parametrize("h", [0.002, 0.005])
def test_a_pinched_capsule_stays(h: float) -> None:
    """Round, of 45 g, between pads of mu 0.7 whose servos go on for 2 mm: at 16 N each, friction bears 50 times its weight."""
    surface = 'friction=".7 .005 .0001" condim="4"'
    pad = '<body pos="{} 0 0"><joint name="{}" type="slide" axis="{} 0 0" damping="5"/>'
    pad += f'<geom type="box" size=".008 .02 .02" mass=".1" {surface}/></body>'
    capsule = f'<freejoint/><geom type="capsule" size=".004 .015" euler="90 0 0" mass=".045" {surface}/>'
    world = pad.format(-0.014, "l", 1) + pad.format(0.014, "r", -1) + f"<body>{capsule}</body>"
    servo = '<position joint="{}" kp="8000" kv="20" forcerange="-40 40"/>'
    s = scene(world, f"<actuator>{servo.format('l')}{servo.format('r')}</actuator>", 'integrator="implicitfast"', h=h)
    s.data.ctrl[:] = 0.004
    s.run(0.2)
    start = s.data.qpos.copy()
    assert passed(s, 1000) < PASS * s.model.stat.meansize
    assert np.abs(s.data.qpos - start).max() < 1e-8 and start[4] > -1e-3 and s.is_clean()


def holding(condim: int, h: float) -> Scene:
    """An arm of four stiffly damped joints that is welded to a pose, and holds a block; one joint is 0.6 rad below its limit.

    In its plane it has a joint more than it needs, so that one comes back slowly while the hand stays.
    """
    surface = f'condim="{condim}" friction="1 .05 .01"'
    bar = f'<geom type="capsule" fromto="0 0 0 .25 0 0" size=".03" mass="1.5" {APART}/>'
    joint = '<joint name="{}" axis="0 1 0" damping="1000" {}/>'
    hand = f'{joint.format("d", "")}<geom type="box" size=".02 .05 .02" mass=".5" {APART}/>'
    for side in (1, -1):
        slide = f'<joint name="f{side}" type="slide" axis="0 {-side} 0" damping="100" range="0 .05"/>'
        pad = f'<geom type="box" size=".01 .005 .015" mass=".05" {surface}/>'
        hand += f'<body pos=".06 {side * 0.0255} 0">{slide}{pad}</body>'
    arm = f'<body name="hand" pos=".25 0 0" euler="0 .6 0">{hand}</body>'
    for name, angle in (("c", -1.0), ("b", 1.2)):
        arm = f'<body pos=".25 0 0" euler="0 {angle} 0">{joint.format(name, "")}{bar}{arm}</body>'
    limited = joint.format("a", 'range=".6 2"')
    arm = f'<body pos="0 0 .6" euler="0 -.8 0">{limited}{bar}{arm}</body>'
    radians = '<compiler angle="radian"/>'
    first = scene(arm, head=radians)
    where = first.data
    mujoco.mj_kinematics(first.model, where)
    place, turned = where.body("hand").xpos, where.body("hand").xmat.reshape(3, 3)
    turn = " ".join(map(str, where.body("hand").xquat))
    pose, held = (f'pos="{" ".join(map(str, p))}" quat="{turn}"' for p in (place, place + turned @ [0.06, 0, 0]))
    world = f'{arm}<body mocap="true" name="m" {pose}/>'
    world += f'<body name="block" {held}><freejoint/><geom type="box" size=".02 .02 .02" mass=".2" {surface}/></body>'
    rest = '<equality><weld body1="m" body2="hand"/></equality><actuator><motor joint="f1"/><motor joint="f-1"/></actuator>'
    s = scene(world, rest, 'integrator="implicitfast"', h=h, head=radians)
    s.data.ctrl[:] = 10.0
    return s


@pytest.mark.parametrize(("condim", "h", "lift"), [(3, 0.002, 0.0), (4, 0.002, 0.05), (6, 0.002, 0.0), (4, 0.005, 0.0)])
def test_a_held_block_goes_with_the_hand(condim: int, h: float, lift: float) -> None:
    """To 1e-9 m a step, while a joint recovers from far below its limit, and while the hand is lifted."""
    s = holding(condim, h)
    s.step(50)
    steps, before = round(1 / h), None
    for i in range(steps):
        t = i * h
        s.data.mocap_pos[0, 2] += lift * h * 6 * t * (1 - t)
        s.step()
        mujoco.mj_kinematics(s.model, s.data)
        hand, block = s.data.body("hand"), s.data.body("block")
        place = hand.xmat.reshape(3, 3).T @ (block.xpos - hand.xpos)
        assert before is None or np.abs(place - before).max() < 1e-9
        before = place
    assert np.linalg.norm(s.data.body("hand").xpos - s.data.mocap_pos[0]) < 1e-5 and s.is_clean()
    assert 0 < s.data.joint("a").qpos[0] < 0.6
