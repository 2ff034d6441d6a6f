"""What holds on paper holds at the default tolerance: rests, wedges, clutches, suction, heavy bodies on light ones."""

from __future__ import annotations

import numpy as np
import pytest
from field import G, Scene, box, scene, slope

TOL = 1e-6  # the default
STEPS = [0.0005, 0.001, 0.002, 0.005]


@pytest.mark.parametrize("shape", ["box", "mesh"])
@pytest.mark.parametrize("h", STEPS)
def test_a_box_that_is_pushed_stays_for_half_a_minute(h: float, shape: str) -> None:
    """2 kg on 20 degrees, mu .6, pushed across by 4 N and turned by 1 and .6 N m: statics needs .81 of the friction."""
    corners = " ".join(f"{x} {y} {z}" for x in (-0.2, 0.2) for y in (-0.15, 0.15) for z in (-0.1, 0.1))
    head = f'<asset><mesh name="m" vertex="{corners}"/></asset>' if shape == "mesh" else ""
    body = box(".2 .15 .1", "0 0 .1", 2.0, 0.6).replace('type="box"', 'type="mesh" mesh="m"' if head else 'type="box"')
    body = body.replace('size=".2 .15 .1"', "") if head else body
    s = scene(f'<geom type="plane" size="9 9 .1" friction=".6 0 0"/>{body}', "", slope(np.deg2rad(20)), h=h, tol=TOL, head=head)
    s.run(0.2)
    s.data.xfrc_applied[1] = 0, 4, 0, 1, 0, 0.6
    s.run(30.0)
    assert np.abs(s.data.qpos[:3] - [0, 0, 0.1]).max() < 1e-6 and np.abs(s.data.qvel).max() < 1e-6 and s.is_clean()


def door_stop(angle: float, h: float, tol: float) -> Scene:
    """A wedge (mesh) on a floor under a door of 30 kg that slides along x and touches it with a ball; ``angle`` over 2 atan mu."""
    mu, foot = 0.5, 0.02
    slant = angle * 2 * np.arctan(mu)
    ball = np.array([0, 0, foot]) + 0.005 * np.array([-np.sin(slant), 0, np.cos(slant)])
    toe, heel = -foot / np.tan(slant), 0.03
    ends = [(toe, 0.0), (heel, 0.0), (heel, (heel - toe) * np.tan(slant))]
    corners = " ".join(f"{x} {y} {z}" for y in (-0.02, 0.02) for x, z in ends)
    world = f'<geom type="plane" size="3 3 .1" friction="{mu}"/>'
    world += f'<body><freejoint/><geom type="mesh" mesh="w" mass=".05" friction="{mu}"/></body>'
    world += f'<body pos="{ball[0]} 0 {ball[2]}"><joint name="d" type="slide" axis="1 0 0"/>'
    world += f'<geom size=".005" mass="30" friction="{mu}"/></body>'
    head = f'<asset><mesh name="w" vertex="{corners}"/></asset>'
    return scene(world, '<actuator><motor joint="d"/></actuator>', h=h, tol=tol, head=head)


@pytest.mark.parametrize("tol", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("h", STEPS[1:])
@pytest.mark.parametrize("angle", [0.3, 0.6])
def test_a_door_stop_holds(angle: float, h: float, tol: float) -> None:
    """MuJoCo lists the corners of the mesh in another order now and then; below the critical angle a wedge locks at any load."""
    s = door_stop(angle, h, tol)
    for i in range(round(2 / h)):
        s.data.ctrl[0] = 50 * min(1.0, i * h / 0.1)
        s.step()
    assert abs(s.data.qpos[7]) < 1e-7 and s.is_clean()


@pytest.mark.parametrize("h", STEPS[1:])
def test_a_door_stop_above_its_angle_is_pushed_away(h: float) -> None:
    s = door_stop(1.05, h, TOL)
    s.data.ctrl[0] = 50.0
    s.run(0.5)
    assert s.data.qpos[7] > 1e-3


@pytest.mark.parametrize("sideways", [0.0, 2.0])
@pytest.mark.parametrize("excess", [0.97, 1.03, 1.06, 1.1, 1.2])
def test_suction_lifts_what_it_can_lift(excess: float, sideways: float) -> None:
    """1 kg below a pad, lifted at 5 m/s² and moved sideways: it needs m (g + a), and m a_x more as its edge would peel off."""
    need = G + 5 + sideways
    lost = []
    for h in (0.001, 0.002, 0.003, 0.005):
        for overlap in (0, 1e-7, 1e-6, 1e-5):
            slides = '<joint name="z" type="slide" axis="0 0 1"/><joint name="x" type="slide" axis="1 0 0"/>'
            cube = '<geom type="box" size=".05 .05 .05" mass="1" friction="2"/></body>'
            world = f'<body name="g" pos="0 0 .5">{slides}{cube}<body pos="0 0 {0.4 + overlap}"><freejoint/>{cube}'
            pull = f'<adhesion body="g" ctrlrange="0 1" gain="{excess * need}"/><motor joint="z"/><motor joint="x"/>'
            s = scene(world, f"<actuator>{pull}</actuator>", h=h)
            s.data.ctrl[:] = 1, 2 * G, 0
            s.run(0.2)
            s.data.ctrl[1:] = 2 * (G + 5), 2 * sideways
            s.run(0.3)
            lost.append(s.data.xpos[1, 2] - s.data.xpos[2, 2] - 0.1 > 1e-3)
            assert s.is_clean()
    assert not any(lost) if excess > 1 else all(lost)


def clutch(share: float, ball: float, h: float) -> Scene:
    """A plate of 1 kg that slides, a ball (g) on it, and a ramp above at ``share`` of the angle 2 atan mu up to which it locks."""
    mu, r = 0.2, 0.01
    angle = share * 2 * np.arctan(mu)
    ramp = np.array([0, 0, r]) + (r + 0.05) * np.array([np.sin(angle), 0, np.cos(angle)])
    rubs = f'friction="{mu}" priority="1"'
    world = '<body pos="0 0 -.01"><joint name="p" type="slide" axis="1 0 0"/>'
    world += f'<geom type="box" size=".5 .1 .01" mass="1" {rubs}/></body>'
    world += f'<geom type="box" size=".5 .1 .05" pos="{ramp[0]} 0 {ramp[2]}" euler="0 {np.degrees(angle)} 0" {rubs}'
    world += f' contype="2" conaffinity="2"/><body pos="0 0 {r}"><joint type="slide" axis="1 0 0"/>'
    world += '<joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>'
    world += f'<geom size="{r}" mass="{ball / 1000}" friction="{mu}" contype="3" conaffinity="3"/></body>'
    return scene(world, '<actuator><motor joint="p"/></actuator>', h=h, tol=TOL)


@pytest.mark.parametrize("force", [300.0, 3e3])
@pytest.mark.parametrize("ball", [0.5, 20.0])
@pytest.mark.parametrize("h", [0.001, 0.005])
def test_a_clutch_that_is_loaded_at_once_locks(h: float, ball: float, force: float) -> None:
    """Plate and ramp press the ball by F / tan(angle / 2)."""
    s = clutch(0.9, ball, h)
    s.data.ctrl[0] = force
    s.run(0.2)
    pressed = [s.data.efc_force[contact.efc_address] for contact in s.data.contact]
    assert abs(s.data.qpos[0]) < 1e-6 and s.is_clean()
    assert pressed == pytest.approx([force / np.tan(0.9 * np.arctan(0.2))] * 2, rel=1e-3)


@pytest.mark.parametrize("h", [0.001, 0.005])
def test_a_clutch_beyond_its_angle_slips(h: float) -> None:
    s = clutch(1.1, 20.0, h)
    s.data.ctrl[0] = 300.0
    s.run(0.1)
    assert s.data.qpos[0] > 0.1


@pytest.mark.parametrize("ball", [0.02, 0.2, 2.0])
@pytest.mark.parametrize("h", STEPS[1:])
def test_a_light_ball_locks_a_heavy_plate(h: float, ball: float) -> None:
    s = clutch(0.5, ball, h)
    for i in range(round(1 / h)):
        s.data.ctrl[0] = 300 * min(1.0, i * h / 0.1)
        s.step()
    assert abs(s.data.qpos[0]) < 1e-6 and s.is_clean()


@pytest.mark.parametrize("shim", [0.02, 0.2, 2.0])
@pytest.mark.parametrize("h", [0.001, 0.005])
def test_a_plate_stands_on_a_light_shim(h: float, shim: float) -> None:
    """1 kg under 1 kN on a shim of so many grams, pulled by half of its friction for 2 s."""
    floor = '<geom type="plane" size="3 3 .1" friction=".2 0 0"/>'
    thin = box(".02 .02 .001", "0 0 .001", shim / 1000, 0.2)
    s = scene(floor + thin + box(".05 .05 .05", "0 0 .052", 1.0, 0.2), h=h, tol=TOL)
    for i in range(round(2 / h)):
        s.data.xfrc_applied[2, :5] = min(1.0, i * h / 0.1) * np.array([100, 0, -1000, 0, -5])
        s.step()
    borne = sum(s.data.efc_force[contact.efc_address] for contact in s.data.contact if 0 in contact.geom)
    assert abs(s.data.qpos[7]) < 1e-7 and borne == pytest.approx(1000 + (1 + shim / 1000) * G, rel=1e-6) and s.is_clean()
