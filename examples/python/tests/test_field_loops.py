"""Loops, gears and ties: closed to rounding, without forces along what no joint can move, and with the forces of statics."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from field import Array, G, Scene, box, scene

APART = 'contype="0" conaffinity="0"'
DEGREES = '<compiler angle="degree"/>'


def pressed(s: Scene, body: int) -> Array:
    """Normal forces of each contact of a body (N)."""
    forces, own = np.zeros((s.data.ncon, 6)), []
    for index, contact in enumerate(s.data.contact):
        mujoco.mj_contactForce(s.model, s.data, index, forces[index])
        if body in s.model.geom_bodyid[contact.geom]:
            own.append(forces[index, 0])
    return np.array(own)


@pytest.mark.parametrize("mounting", ["0 0 0", "10 20 30", "33 -71 12", "90 0 0", "45 45 45"])
def test_a_planar_loop_has_no_force_out_of_its_plane(mounting: str) -> None:
    """A four-bar presses a box against a wall by 2 N m over 0.1 m; of its pin, one row is rounding or copies the hinges.

    The pin bears the 20 N that go through it, and what it weighs.
    """
    bar = f'<geom type="capsule" fromto="0 0 0 {{}}" size=".005" mass=".05" {APART}/>'
    hinge, tip = '<joint axis="0 1 0"/>', '<geom type="box" pos="0 0 .1" size=".01 .02 .02" mass=".01"/>'
    rod = f'<body name="rod" pos="0 0 .1">{hinge}{bar.format(".1 0 0")}</body>'
    crank = f'<body><joint name="a" axis="0 1 0"/>{bar.format("0 0 .1")}{rod}</body>'
    other = f'<body name="b" pos=".1 0 0">{hinge}{bar.format("0 0 .1")}{tip}</body>'
    frame = f'<body euler="{mounting}">{crank}{other}<geom type="box" pos=".16 0 .1" size=".01 .1 .1"/></body>'
    held = f'<body name="held" euler="{mounting}"><freejoint/><geom type="box" size=".02 .02 .02" pos=".13 0 .1" mass=".2"/></body>'
    pin = '<equality><connect body1="rod" body2="b" anchor=".1 0 0"/></equality><actuator><motor joint="a"/></actuator>'
    s = scene(frame + held, pin, 'gravity="0 0 0"', head=DEGREES, tol=1e-6)
    s.data.ctrl[:] = 2.0
    s.step(200)
    along = s.data.xaxis[0].copy()
    s.model.opt.gravity[:] = G * along
    s.step(10)
    before = s.data.body("held").xipos.copy()
    for _ in range(1000):
        s.step()
        assert np.abs(s.data.qvel[-6:-3]).max() < 1e-6 * G
        assert np.abs(s.data.efc_force[: s.data.ne]).max() < 20 + 0.31 * G
    assert np.linalg.norm(s.data.body("held").xipos - before) < 1e-6 and s.is_clean()


CORNERS = [f"{x} {y} {z}" for x in (-0.01, 0.01) for y in (-0.01, 0.01) for z in (-0.01, 0.01)]
PAD = f'<asset><mesh name="pad" vertex="{" ".join(CORNERS)}"/></asset>'


@pytest.mark.parametrize(
    ("turned", "angle", "about"),
    [("0 0 0", 0.3, 0), ("0 0 0", 3, 0), ("3 0 0", -0.3, 0), ("10 20 30", 0, 0), ("10 20 30", 0, 0.01)],
)
def test_pads_that_touch_by_edges_hold_at_both_ends(turned: str, angle: float, about: float) -> None:
    """Two pads that lean by so much (degrees) press a box, which begins turned between them, by edges across which gravity pulls.

    MuJoCo 4.0 lists 2 or 3 points of 4, or 5 of 8, in many steps of some of these: the others are not lost.
    The box, 3 cm x 3 cm x 6 cm, is held while all ends are. Nothing holds pads and box along their joints, and an error of the law
    is a force of so much of 44 N.
    """
    pad = '<body pos="{} 0 0"><joint name="{}" type="slide" axis="{} 0 0"/><geom type="mesh" mesh="pad" euler="0 {} 0"/></body>'
    lean = np.deg2rad(angle)
    reach = 0.015 + 0.01 * np.cos(lean) + 0.01 * abs(np.sin(lean)) + 1e-5
    pads = pad.format(-reach, "l", 1, angle) + pad.format(reach, "r", -1, -angle)
    hand = f'<body euler="{turned}">{pads}</body>'
    geom = f'<geom type="box" size=".015 .015 .03" euler="0 0 {about}" mass=".3"/>'
    part = f'<body name="part" euler="{turned}"><freejoint/>{geom}</body>'
    motors = '<actuator><motor joint="l"/><motor joint="r"/></actuator>'
    s = scene(hand + part, motors, 'gravity="0 0 0"', head=DEGREES + PAD)
    s.data.ctrl[:] = 22.0
    s.step(200)
    s.model.opt.gravity[:] = G * s.data.body("part").xmat.reshape(3, 3)[:, 2]
    leaning = 44 * (1 / np.cos(lean) - 1) + 0.3 * G * abs(np.tan(lean)) + 1e-4  # normals are those of the box, of pads, or between
    start, wrong, mass = s.data.qpos.copy(), 1e-9 * 44, s.model.body_mass[s.model.body_mass > 0]
    for _ in range(1000):
        s.step()
        assert s.data.ncon == (8 if angle == 0 else 4)
        assert np.abs(s.data.qvel[:5]).max() < wrong * (4 * s.h / mass.min() + s.data.time / mass.sum())
        assert pressed(s, s.model.body("part").id).sum() == pytest.approx(44, abs=leaning)
    assert np.abs(s.data.qpos - start).max() < 1e-6 and s.is_clean()


ROTOR = '<inertial pos="0 0 0" mass="1" diaginertia="{0} {0} {0}"/>'


@pytest.mark.parametrize("inertia", [1e-6, 1e-7, 1e-8])
@pytest.mark.parametrize("h", [0.001, 0.005])
def test_a_lead_screw_of_a_light_rotor_stays_closed(inertia: float, h: float) -> None:
    """1 mm a radian: a torque T lifts m with (T - m g p) / (J / p + m p), whatever units a row has."""
    pitch, mass = 1e-3, 0.5
    screw = f'<body><joint name="screw" axis="0 0 1"/>{ROTOR.format(inertia)}</body>'
    nut = f'<body pos="1 0 0"><joint name="nut" type="slide" axis="0 0 1"/><geom size=".02" mass="{mass}"/></body>'
    tie = f'<equality><joint joint1="nut" joint2="screw" polycoef="0 {pitch} 0 0 0"/></equality>'
    s, torque = scene(screw + nut, tie + '<actuator><motor joint="screw"/></actuator>', h=h), 1.1 * mass * G * pitch
    s.data.ctrl[0] = torque
    for _ in range(round(0.5 / h)):
        s.step()
        assert abs(s.data.qpos[1] - pitch * s.data.qpos[0]) < 1e-9
    risen = (torque - mass * G * pitch) / (inertia / pitch + mass * pitch)
    assert s.data.qvel[1] == pytest.approx(risen * 0.5, rel=1e-6) and s.is_clean()


@pytest.mark.parametrize("inertia", [1e-6, 1e-8])
@pytest.mark.parametrize("ratio", [1e-3, 50.0])
def test_a_gear_train_of_light_rotors_is_one_inertia(inertia: float, ratio: float) -> None:
    """Three rotors in a row, the last one with a limit: it stops the first one, and its stop bears what the motor gives."""
    names, world = "abc", ""
    for name in names:
        stop = 'limited="true" range="-100 .001"' if name == "c" else ""
        world += f'<body><joint name="{name}" axis="0 0 1" {stop}/>{ROTOR.format(inertia)}</body>'
    ties = "".join(
        f'<joint joint1="{b}" joint2="{a}" polycoef="0 {r} 0 0 0"/>' for a, b, r in (("a", "b", ratio), ("b", "c", 1 / ratio))
    )
    motor = '<actuator><motor joint="a"/></actuator>'
    s = scene(world, f"<equality>{ties}</equality>{motor}", head='<compiler angle="radian"/>')
    whole = inertia * (2 + ratio**2)
    s.data.ctrl[0] = torque = whole * 0.1
    s.step(50)
    assert s.data.qvel[0] == pytest.approx(0.1 * 50 * s.h, rel=1e-6)
    s.step(450)
    assert np.abs(s.data.qpos - [0.001, 0.001 * ratio, 0.001]).max() < 1e-9 * max(1.0, ratio)
    assert np.abs(s.data.qvel).max() < 1e-9 * max(1.0, ratio) and s.is_clean()
    stops = np.flatnonzero(s.data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT))
    assert s.data.efc_force[stops] == pytest.approx([torque], rel=1e-6)


@pytest.mark.parametrize("h", [0.002, 0.01])
def test_a_rack_lifts_a_load_and_presses_it_against_the_ceiling(h: float) -> None:
    pinion = f'<body pos="0 0 1"><joint name="p" axis="0 1 0" armature="1e-4"/><geom size=".02" mass=".05" {APART}/></body>'
    rack = '<body pos=".2 0 .5"><joint name="r" type="slide" axis="0 0 1"/><geom type="box" size=".05 .05 .02" mass="1"/></body>'
    world = pinion + rack + box(".03 .03 .02", ".2 0 .54", 2.0) + '<geom type="box" size=".1 .1 .01" pos=".2 0 .67"/>'
    rest = '<equality><joint joint1="r" joint2="p" polycoef="0 .02 0 0 0"/></equality><actuator><motor joint="p"/></actuator>'
    s, torque = scene(world, rest, h=h), 1.2 * 3 * G * 0.02
    s.data.ctrl[0] = torque
    s.run(0.2)
    inertia = 1e-4 + 0.4 * 0.05 * 0.02**2 + 3 * 0.02**2
    assert s.data.qvel[1] == pytest.approx((torque - 3 * G * 0.02) / inertia * 0.02 * 0.2, rel=1e-6)
    s.run(1.0)
    assert abs(s.data.qpos[1] - 0.02 * s.data.qpos[0]) < 1e-9 and abs(s.data.qpos[4] - 0.64) < 1e-8
    on_load = pressed(s, 3).sum()  # by the rack and by the ceiling
    assert on_load == pytest.approx(torque / 0.02 - G + (torque / 0.02 - 3 * G), rel=1e-6) and s.is_clean()


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("share", [0.9, 0.999, 1.001, 1.5])
def test_friction_behind_a_gear_holds_up_to_its_torque(ratio: float, share: float) -> None:
    inertia, torque = 1e-3, 0.5 * ratio * share
    body = f'<body><joint name="{{}}" axis="0 0 1" {{}}/>{ROTOR.format(inertia)}</body>'
    tie = f'<equality><joint joint1="b" joint2="a" polycoef="0 {ratio} 0 0 0"/></equality><actuator><motor joint="a"/></actuator>'
    s = scene(body.format("a", "") + body.format("b", 'frictionloss=".5"'), tie)
    s.data.ctrl[0] = torque
    s.run(1.0)
    free = max(0.0, torque - 0.5 * ratio) / (inertia * (1 + ratio**2))
    assert s.data.qvel[0] == pytest.approx(free, rel=1e-6, abs=1e-7)
    assert abs(s.data.qpos[1] - ratio * s.data.qpos[0]) < 1e-9 and s.is_clean()


TIES = {
    "joint": '<equality><joint joint1="a" joint2="b"/></equality>',
    "tendon": '<tendon><fixed name="t"><joint joint="a" coef="1"/><joint joint="b" coef="-1"/></fixed></tendon>'
    '<equality><tendon tendon1="t"/></equality>',
}


@pytest.mark.parametrize("tie", TIES)
@pytest.mark.parametrize("h", [0.002, 0.005])
def test_tied_fingers_centre_what_they_lift(tie: str, h: float) -> None:
    """8 mm off the middle: both fingers come to it, then 8 N of one motor are 4 N of each; lifted by 0.1 m at most 5 m/s^2.

    Friction bears 2 x 0.6 x 4 N = 4.8 N, of which weight and lift ask 1.5 N.
    """
    finger = '<joint name="{}" type="slide" axis="{} 0 0" range="0 .06"/>'
    finger += '<geom type="box" size=".005 .01 .015" mass=".05" friction=".6 0 0"/>'
    fingers = f'<body pos="-.06 0 0">{finger.format("a", 1)}</body><body pos=".06 0 0">{finger.format("b", -1)}</body>'
    palm = f'<geom type="box" size=".06 .01 .01" pos="0 0 .1" mass=".5" {APART}/>'
    hand = f'<body pos="0 0 .02"><joint name="z" type="slide" axis="0 0 1"/>{palm}{fingers}</body>'
    world = '<geom type="plane" size="5 5 .1" friction=".6 0 0"/>' + hand + box(".02 .02 .02", ".008 0 .02", 0.1, 0.6)
    motors = '<actuator><motor joint="a"/><position joint="z" kp="20000" kv="400"/></actuator>'
    s = scene(world, TIES[tie] + motors, 'integrator="implicitfast"', h=h)
    s.data.ctrl[0] = 8
    s.run(1.0)
    assert abs(s.data.qpos[3]) < 1e-6 and abs(s.data.qpos[1] - s.data.qpos[2]) < 1e-9
    assert pressed(s, 2).sum() + pressed(s, 3).sum() == pytest.approx(8, abs=1e-6)  # the floor's friction has its share
    before = s.data.qpos[5] - s.data.qpos[0]
    for i in range(round(1.0 / h)):
        t = i * h
        s.data.ctrl[1] = 0.05 * (1 - np.cos(np.pi * min(t / 0.5, 1.0)))
        s.step()
        assert abs(s.data.qpos[1] - s.data.qpos[2]) < 1e-9
    assert abs(s.data.qpos[5] - s.data.qpos[0] - before) < 1e-6 and s.data.qpos[5] > 0.115 and s.is_clean()
    assert [pressed(s, finger).sum() for finger in (2, 3)] == pytest.approx([4, 4], abs=1e-5)
