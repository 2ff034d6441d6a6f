"""What is moved from outside, what overlaps, and what leads to large speeds: public reports and stock models, rebuilt small."""

from __future__ import annotations

import pathlib
import threading

import mujoco
import numpy as np
import pytest
from field import FLOOR, G, Scene, box, scene

from stiction.mujoco import Stepper

ROUGH = '<geom type="plane" size="5 5 1" friction=".5 0 0"/>'


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.3, 1.0])
def test_a_pusher_of_motion_capture_pushes(speed: float) -> None:
    pusher = '<body mocap="true" pos="-.11 0 .05"><geom type="box" size=".05 .05 .045" friction=".5 0 0"/></body>'
    s = scene(ROUGH + pusher + box(".05 .05 .05", "0 0 .05", 1.0, 0.5))
    for i in range(round(0.5 / speed / s.h)):
        s.data.mocap_pos[0, 0] = -0.11 + speed * (i + 1) * s.h
        s.step()
    assert np.abs(s.data.qpos[:3] - [s.data.mocap_pos[0, 0] + 0.1, 0, 0.05]).max() < 1e-4
    assert s.data.qvel[0] == pytest.approx(speed, rel=1e-3) and s.is_clean()


@pytest.mark.parametrize(("axis", "speed"), [(0, 0.2), (2, 0.05), (2, 0.3)])
def test_a_tray_of_motion_capture_carries(axis: int, speed: float) -> None:
    tray = '<body mocap="true"><geom type="box" size=".3 .3 .02" friction=".8 0 0"/></body>'
    s = scene(tray + box(".05 .05 .05", "0 0 .07", 1.0, 0.8))
    for i in range(500):
        s.data.mocap_pos[0, axis] = speed * (i + 1) * s.h
        s.step()
    want = np.array([0, 0, 0.07])
    want[axis] += speed
    slid = speed**2 / (2 * 0.8 * G) + 2 * speed * s.h if axis == 0 else 0.0  # until the box is as fast
    assert np.abs(s.data.qpos[:3] - want).max() < slid + 1e-4
    assert s.data.qvel[axis] == pytest.approx(speed, rel=1e-3) and s.is_clean()


def test_a_tray_that_jumps_now_and_then_brings_things_along() -> None:
    """Each 20th step by 10 mm: a jump is no speed."""
    pusher = '<body mocap="true" pos="-.11 0 .05"><geom type="box" size=".05 .05 .045" friction=".5 0 0"/></body>'
    s = scene(ROUGH + pusher + box(".05 .05 .05", "0 0 .05", 1.0, 0.5))
    for i in range(1000):
        s.data.mocap_pos[0, 0] = -0.11 + 0.01 * (i // 20 + 1)
        s.step()
        assert np.abs(s.data.qvel).max() < 0.01
    assert s.data.qpos[0] == pytest.approx(s.data.mocap_pos[0, 0] + 0.1, abs=2e-4)


def test_a_lid_that_jumps_down_by_10_mm_squeezes_quietly() -> None:
    """There is no room: floor and lid share what overlaps, and nothing squirts away; the lid lifted, all is as before."""
    lid = '<body mocap="true" pos="0 0 .11"><geom type="box" size=".1 .1 .01" friction=".5 0 0"/></body>'
    s = scene(ROUGH + lid + box(".05 .05 .05", "0 0 .05", 1.0, 0.5))
    s.step(10)
    s.data.mocap_pos[0, 2] = 0.1
    for _ in range(500):
        s.step()
        assert np.abs(s.data.qvel).max() < 1e-6 and np.abs(s.data.efc_force).max() < 200.0
    assert np.abs(s.data.qpos[[0, 1, 4, 5, 6]]).max() < 1e-6 and 0.04 - 1e-6 < s.data.qpos[2] < 0.045 + 1e-6
    s.data.mocap_pos[0, 2] = 0.11
    assert np.abs(s.run(1.0).qpos - [0, 0, 0.05, 1, 0, 0, 0]).max() < 1e-6


def test_a_weld_to_what_jumps_and_turns_is_closed_without_a_speed() -> None:
    hand = '<body name="hand" pos="0 0 1"><freejoint/><geom type="box" size=".1 .05 .05" mass="1"/></body>'
    s = scene('<body name="m" mocap="true" pos="0 0 1"/>' + hand, '<equality><weld body1="m" body2="hand"/></equality>')
    s.step(10)
    s.data.mocap_pos[0], s.data.mocap_quat[0] = (0.5, 0.3, 1.3), np.array([1.0, 1.0, 0.0, 0.0]) / np.sqrt(2)
    for _ in range(1500):
        assert np.abs(s.step().qvel).max() < 1e-6
    assert np.abs(s.data.qpos[:3] - s.data.mocap_pos[0]).max() < 1e-6
    assert abs(s.data.qpos[3:7] @ s.data.mocap_quat[0]) == pytest.approx(1.0, abs=1e-9) and s.is_clean()


def test_a_pusher_that_stops_lets_go() -> None:
    """At 1 m/s: the cube slides v^2 / (2 mu g) on."""
    pusher = '<body mocap="true" pos="-.11 0 .05"><geom type="box" size=".05 .05 .045" friction=".5 0 0"/></body>'
    s = scene(ROUGH + pusher + box(".05 .05 .05", "0 0 .05", 1.0, 0.5))
    for i in range(500):
        s.data.mocap_pos[0, 0] = -0.11 + min(s.h * (i + 1), 0.5)
        s.step()
    assert s.data.qpos[0] - 0.49 == pytest.approx(1 / (2 * 0.5 * G), abs=2 * s.h)


@pytest.mark.parametrize("writes_speed", [False, True])
@pytest.mark.parametrize("speed", [0.05, 0.3, 1.0])
def test_a_joint_whose_position_is_written_pushes(speed: float, writes_speed: bool) -> None:
    pusher = '<joint type="slide" axis="1 0 0"/><geom type="box" size=".05 .05 .045" mass="1000" friction=".5 0 0"/>'
    s = scene(ROUGH + f'<body pos="-.11 0 .05">{pusher}</body>' + box(".05 .05 .05", "0 0 .05", 1.0, 0.5), tol=1e-8)
    steps = round(0.5 / speed / s.h)
    for i in range(steps):
        s.data.qpos[0], s.data.qvel[0] = speed * i * s.h, speed if writes_speed else 0.0
        s.step()
    written = speed * (steps - 1) * s.h
    assert written - 0.01 - 1e-4 < s.data.qpos[1] < written + speed * s.h - 0.01 + 1e-4
    assert s.data.qpos[3] == pytest.approx(0.05, abs=1e-6) and s.stepper.unsolved == 0


def test_a_hand_is_stopped_by_a_cube_on_a_table() -> None:
    world = FLOOR + '<body name="t" mocap="true" pos="0 0 .2"/>'
    world += '<body name="hand" pos="0 0 .2"><freejoint/><geom type="box" size=".04 .04 .02" mass=".5"/></body>'
    world += box(".03 .03 .03", "0 0 .03", 0.1) + box(".03 .03 .03", ".5 0 .0298", 0.1)
    s = scene(world, '<equality><weld body1="t" body2="hand"/></equality>', tol=1e-6)
    peak = 0.0
    for i in range(1500):
        s.data.mocap_pos[0, 2] = max(0.2 - 0.1 * i * s.h, 0.06)
        s.step()
        peak = max(peak, float(np.abs(s.data.efc_force).max(initial=0.0)))
    assert abs(s.data.qpos[2] - 0.08) < 2e-4 and peak < 200.0
    assert abs(s.data.qpos[9] - 0.03) < 2e-4 and abs(s.data.qpos[16] - 0.03) < 1e-6
    for i in range(750):
        s.data.mocap_pos[0, 2] = min(0.06 + 0.1 * i * s.h, 0.2)
        s.step()
    assert abs(s.data.qpos[2] - 0.2) < 1e-3 and np.abs(s.data.qpos[7:10] - [0, 0, 0.03]).max() < 1e-3
    assert s.stepper.contradictions <= 1 and s.stepper.unsolved <= 1


@pytest.mark.parametrize("h", [0.002, 0.01])
def test_the_pin_of_a_ram_stays_closed(h: float) -> None:
    apart = 'contype="0" conaffinity="0"'
    world = f"""<body name="boom" pos="0 0 1"><joint axis="0 -1 0" frictionloss="2" damping="20"/>
        <geom type="capsule" fromto="0 0 0 4 0 1" size=".15" mass="2000" {apart}/></body>
        <body pos=".6 0 .2"><joint axis="0 -1 0"/><geom type="capsule" fromto="0 0 0 .3 0 .4" size=".05" mass="60" {apart}/>
        <body name="rod" pos=".3 0 .4"><joint name="r" type="slide" axis=".6 0 .8" range="-.3 .4" frictionloss="50"/>
        <geom type="capsule" fromto="0 0 0 .4 0 .5333" size=".03" mass="20" {apart}/></body></body>"""
    pin = '<equality><connect body1="boom" body2="rod" anchor="1.3 0 .1333"/></equality>'
    servo = '<actuator><position joint="r" kp="2e6" kv="2e5" forcerange="-2e5 2e5"/></actuator>'
    s, opened = scene(world, pin + servo, 'integrator="implicitfast"', h=h), 0.0
    for i in range(int(4 / h)):
        s.data.ctrl[0] = 0.25 * np.sin(i * h)
        s.step()
        opened = max(opened, float(np.linalg.norm(s.data.efc_pos[s.data.efc_type == 0])))
    assert opened < (1.5e-7 if h < 0.01 else 3e-6) and s.stepper.unsolved == 0
    assert abs(s.data.qpos[2] - s.data.ctrl[0]) < 0.02


@pytest.mark.parametrize("kp", [1e3, 1e4])
@pytest.mark.parametrize("h", [0.001, 0.005])
def test_a_servo_presses_with_the_force_it_has(kp: float, h: float) -> None:
    finger = '<body><joint name="x" type="slide" axis="1 0 0"/><geom type="sphere" size=".01" mass=".05"/></body>'
    servo = f'<actuator><position joint="x" kp="{kp}" kv="{20 if kp == 1e3 else 50}" forcerange="-15 15"/></actuator>'
    wall = '<geom type="box" size=".01 .1 .1" pos=".05 0 0"/>'
    s = scene(finger + wall, servo, 'gravity="0 0 0" integrator="implicitfast"', h=h)
    s.data.ctrl[0] = 0.05
    s.run(0.5)
    for _ in range(50):
        s.step()
        pressed = [force for force, kind in zip(s.data.efc_force, s.data.efc_type, strict=True) if force and kind > 4]
        assert np.allclose(pressed, [15.0], atol=1e-9) and abs(s.data.qpos[0] - 0.03) < 1e-8
    s.data.ctrl[0] = 0.0
    assert abs(s.run(0.5).qpos[0]) < 1e-3 and s.is_clean()


@pytest.mark.parametrize("cubes", [1, 3, 5])
@pytest.mark.parametrize(("size", "depth", "h"), [(0.01, 1e-3, 0.001), (0.01, 1e-3, 0.005), (5e-4, 1e-4, 0.001)])
def test_what_overlaps_rises_and_rests(cubes: int, size: float, depth: float, h: float) -> None:
    places = [(2 * i + 1) * size - (i + 1) * depth for i in range(cubes)]
    mass = 0.02 if size == 0.01 else 1e-6
    s, top = scene(FLOOR + "".join(box(f"{size} {size} {size}", f"0 0 {z}", mass) for z in places), h=h), (2 * cubes - 1) * size
    for _ in range(int(0.5 / h)):
        assert s.step().qpos[-5] < top + 1e-8
    assert s.data.qpos[-5] == pytest.approx(top, abs=cubes * 1e-7 * s.model.stat.meansize + 1e-9)
    assert np.abs(s.data.qvel).max() < 1e-6 and s.is_clean()


def test_a_joint_beyond_its_stop_comes_back_without_a_speed() -> None:
    link = '<joint axis="0 1 0" range="-30 30"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02" mass="1"/>'
    s = scene(f'<body pos="0 0 1">{link}</body>', option='gravity="0 0 0"')
    s.data.qpos[0] = np.deg2rad(31)
    s.step(1000)
    assert abs(s.data.qvel[0]) < 1e-9 and s.data.qpos[0] == pytest.approx(np.deg2rad(30), abs=1e-6)


ARM = """<body name="target" mocap="true" pos="{} 0 0"/><body><joint axis="0 0 1" damping=".1"/>
<geom type="capsule" fromto="0 0 0 .5 0 0" size=".03"/><body pos=".5 0 0"><joint axis="0 0 1" damping=".1"/>
<geom type="capsule" fromto="0 0 0 .5 0 0" size=".03"/><body name="hand" pos=".5 0 0"><geom size=".03"/></body></body></body>"""


@pytest.mark.parametrize("reach", [0.9, 1.01, 1.5])
def test_a_weld_out_of_reach_breaks_nothing(reach: float) -> None:
    weld = '<equality><weld body1="target" body2="hand" relpose="0 0 0 1 0 0 0"/></equality>'
    s = scene(ARM.format(reach), weld, 'gravity="0 0 0"')
    s.data.qpos[:] = 0.6, -1.2
    start = s.data.qpos.copy()
    for _ in range(1000):
        before = s.data.qpos.copy()
        s.step()
        assert np.abs(s.data.qvel).max() < 1e-6 and np.abs(s.data.qpos - before).max() < 0.1
    mujoco.mj_kinematics(s.model, s.data)
    assert np.abs(s.data.qpos - before).max() < 1e-4  # and does not tremble
    off = float(np.linalg.norm(s.data.body("hand").xpos - [reach, 0, 0]))
    assert off < np.linalg.norm([reach - np.cos(start[0]), 0]) and s.stepper.unsolved == 0


def test_an_arm_comes_to_a_weld_that_is_far_open() -> None:
    """As environments reset: the arm is stretched, its target is elsewhere and turned."""
    link = '<joint axis="0 0 1" damping=".1"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>'
    arm = f'<body>{link}<body pos=".3 0 0">{link}<body name="hand" pos=".3 0 0">{link}</body></body></body>'
    target = '<body name="target" mocap="true" pos=".1 .2 0" quat="1 0 0 1"/>'
    weld = '<equality><weld body1="target" body2="hand" relpose="0 0 0 1 0 0 0"/></equality>'
    s = scene(target + arm, weld, 'gravity="0 0 0"')
    for _ in range(300):
        assert np.abs(s.step().qvel).max() < 1e-6
    hand = s.data.body("hand")
    assert np.abs(hand.xpos - [0.1, 0.2, 0]).max() < 1e-6 and np.abs(hand.xmat[:2] - [0, -1]).max() < 1e-6 and s.is_clean()


def test_a_hand_that_is_blocked_presses_as_its_weld_pulls() -> None:
    """With a free body's force at MuJoCo's `solref`; led back, it follows again."""
    world = '<geom type="box" size=".05 .2 .2" pos=".2 0 0"/><body name="t" mocap="true"/>'
    world += '<body name="hand"><joint type="slide" axis="1 0 0"/><geom type="box" size=".05 .02 .02" mass="2"/></body>'
    s = scene(world, '<equality><weld body1="t" body2="hand"/></equality>', 'gravity="0 0 0"', tol=1e-8)
    for i in range(500):
        s.data.mocap_pos[0, 0] = min(0.5 * i * s.h, 0.2)
        s.step()
    stiffness = 0.95 / (0.95 * 0.02) ** 2  # solimp's share of what solref and it ask for
    pressed = float(s.data.qfrc_constraint[0] - s.data.efc_force[0] * s.data.efc_J.reshape(-1, 1)[0, 0])
    assert s.data.qpos[0] == pytest.approx(0.1, abs=1e-7) and -pressed == pytest.approx(2 * stiffness * 0.1, rel=0.05)
    for i in range(500):
        s.data.mocap_pos[0, 0] = max(0.2 - 0.5 * i * s.h, 0.0)
        s.step()
    assert abs(s.data.qpos[0]) < 1e-6 and s.stepper.unsolved == 0 and s.stepper.contradictions <= 1


def test_an_overlap_that_no_joint_can_open_leaves_the_rest_alone() -> None:
    world = '<geom type="plane" size="2 2 .1"/><body pos="0 0 .0499"><joint type="slide" axis="1 0 0"/>'
    world += '<joint type="slide" axis="0 1 0"/><geom type="cylinder" size=".1 .05"/></body>'
    world += '<body name="m" mocap="true" pos="1 0 .5"/><body name="hand" pos="1 0 .5"><freejoint/><geom size=".05"/></body>'
    s = scene(world, '<equality><weld body1="m" body2="hand"/></equality>', tol=1e-6)
    for _ in range(1000):
        s.data.mocap_pos[0] = 1 + 0.1 * min(s.data.time, 1.0), 0, 0.5
        s.step()
    assert s.data.body("hand").xpos[0] == pytest.approx(1.1, abs=1e-4) and s.is_clean()


def test_a_second_stepper_on_a_used_model_is_as_the_first() -> None:
    s = scene(FLOOR + box(".1 .1 .1", "0 0 1"))
    s.step(150)
    second = Scene(s.model, mujoco.MjData(s.model), Stepper(s.model))
    assert second.step(1500).qpos[2] == pytest.approx(0.1, abs=1e-8)


def test_limits_of_thirty_joints_are_no_matter() -> None:
    geom = '<geom type="capsule" fromto="0 0 0 0 0 -.2" size=".02" contype="0" conaffinity="0"/>'
    link = f'<joint axis="0 1 0" range="-60 60" frictionloss=".01"/>{geom}'
    s = scene("".join(f'<body pos="{i / 10} 0 1">{link}</body>' for i in range(30)), h=0.005)
    s.step(100)
    s.data.qvel[0] = 120.0
    assert np.abs(s.step(10).qpos).max() < np.deg2rad(60) + 1e-6 and s.is_clean()


def test_a_hand_of_28_joints_may_be_driven_fast() -> None:
    """Dry friction and two stops each, in chains of four."""
    geom = '<geom type="capsule" fromto="0 0 0 0 0 -.05" size=".008" contype="0" conaffinity="0"/>'
    world = ""
    for finger in range(7):
        world += f'<body pos="{0.03 * finger} 0 1">'
        for k in range(4):
            joint = f'<joint axis="{"0 1 0" if k == 0 else "1 0 0"}" range="-20 20" frictionloss=".01" armature=".001"/>'
            world += f'<body pos="0 0 {-0.05 if k else 0}">{joint}{geom}'
        world += "</body>" * 5
    s = scene(world)
    for i in range(600):
        s.data.qfrc_applied[:] = 0.3 * np.sign(np.sin(0.02 * i + np.arange(28)))
        s.step()
    assert np.abs(s.data.qpos).max() < np.deg2rad(20) + 1e-6 and s.is_clean()


def test_one_stepper_may_step_several_data() -> None:
    """In turns, and as each would alone: the other one's poses are no motion from outside."""
    s = scene(ROUGH + box(".05 .05 .05", "0 0 .1", 1.0, 0.5))
    others = [mujoco.MjData(s.model) for _ in range(2)]
    for data, speed in zip((s.data, *others), (1.0, 1.0, -2.0), strict=True):
        data.qvel[0] = speed
    alone = Stepper(s.model, tol=1e-9)
    for _ in range(400):
        s.stepper.step(others[0])
        s.stepper.step(others[1])
        alone.step(s.data)
    assert np.abs(others[0].qpos - s.data.qpos).max() < 1e-6 and s.is_clean()


def test_a_state_may_be_put_back() -> None:
    s = scene(ROUGH + box(".05 .05 .05", "0 0 .3", 1.0, 0.5))
    s.data.qvel[[0, 4]] = 1.0, 3.0
    s.step(100)
    state, ends = (s.data.qpos.copy(), s.data.qvel.copy()), []
    for _ in range(2):
        s.data.qpos[:], s.data.qvel[:] = state
        s.stepper.reset()
        ends.append(s.step(200).qpos.copy())
    assert np.array_equal(ends[0], ends[1])


def test_threads_may_share_a_model() -> None:
    path = pathlib.Path(__file__).resolve().parents[1] / "models/quadruped.xml"
    model = mujoco.MjModel.from_xml_path(str(path))
    flags, steppers, copies = model.opt.disableflags, [Stepper(model) for _ in range(5)], []
    for i in (0, 1, 2, 3, 3):
        copies.append(mujoco.MjData(model))
        mujoco.mj_resetDataKeyframe(model, copies[-1], 0)
        copies[-1].qpos[2] += 0.02 * i
    steppers[4].step(copies[4], 500)
    threads = [threading.Thread(target=s.step, args=(d, 500)) for s, d in zip(steppers[:4], copies[:4], strict=True)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert np.array_equal(copies[3].qpos, copies[4].qpos) and model.opt.disableflags == flags
