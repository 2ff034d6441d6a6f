"""What turns and what starts to move carries what stands on it or is held by it; what rolls on it rolls as on paper.

A step goes along a tangent, so that a circle is left by r (omega h)^2 / 2 in each: what sticks has to be taken back.
"""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from field import FLOOR, Array, G, Scene, box, scene

SLIP = 2e-5  # m
STEPS = (0.001, 0.002, 0.005)


def smooth(t: float, duration: float) -> float:
    """From 0 to 1, without a jump of its slope."""
    share = min(max(t / duration, 0.0), 1.0)
    return share * share * (3 - 2 * share)


def about_z(angle: float) -> Array:
    return np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])


def seen_from(place: Array, angle: float) -> Array:
    """A place on a table that has turned by this angle."""
    turned = complex(*place) * np.exp(-1j * angle)
    return np.array([turned.real, turned.imag])


@pytest.mark.parametrize("h", STEPS)
@pytest.mark.parametrize("kind", ["joint", "mocap"])
def test_a_turntable_carries_without_creep(kind: str, h: float) -> None:
    """Two turns at 3 rad/s: outward by less than what one step leaves the circle by, where 4 pi / (omega h) steps are taken."""
    speed, r, is_joint = 3.0, 0.3, kind == "joint"
    table = '<body pos="0 0 -.02"><joint axis="0 0 1"/>' if is_joint else '<body mocap="true" pos="0 0 -.02">'
    table += '<geom type="cylinder" size=".5 .02" mass="1000" friction="1 0 0"/></body>'
    s = scene(table + box(".01 .01 .01", f"{r} 0 .01", 0.5), h=h)
    s.data.qvel[-6:] = 0, speed * r, 0, 0, 0, speed
    if is_joint:
        s.data.qvel[0] = speed
    steps = round(4 * np.pi / speed / h)
    for i in range(steps):
        if not is_joint:
            s.data.mocap_quat[0] = about_z(speed * (i + 1) * h)
        s.step()
    angle = float(s.data.qpos[0]) if is_joint else speed * steps * h
    slip = seen_from(s.data.qpos[-7:-5], angle) - [r, 0]
    assert abs(slip[0]) < min(SLIP, r * (speed * h) ** 2 / 2) and s.is_clean()
    if not is_joint:
        assert abs(slip[1]) < SLIP


@pytest.mark.parametrize("h", STEPS)
def test_a_turntable_that_speeds_up_loses_one_step_of_it(h: float) -> None:
    """Moved by its pose: what it does in its first step is no motion yet, r alpha h^2. To 1.8 rad/s, 0.2 of what friction bears."""
    table = '<body mocap="true" pos="0 0 -.02"><geom type="cylinder" size=".5 .02" friction=".5 0 0"/></body>'
    s, angle, r, start = scene(table + box(".01 .01 .01", ".3 0 .01", 0.5, 0.5), h=h), 0.0, 0.3, 1.0
    for i in range(round(1.8 / h)):
        angle += start * (i + 1) * h * h
        s.data.mocap_quat[0] = about_z(angle)
        s.step()
    slip = np.linalg.norm(seen_from(s.data.qpos[:2], angle) - [r, 0])
    assert slip < r * start * h * h + r * (1.8 * h) ** 2 / 2 and s.is_clean()


TIPS = {
    "box": ('type="box" size=".015 .01 .015"', 3),
    "sphere, 3": ('type="sphere" size=".01"', 3),
    "sphere, 4": ('type="sphere" size=".01"', 4),
    "sphere, 6": ('type="sphere" size=".01"', 6),
    "capsule": ('type="capsule" size=".01 .01"', 4),
    "cylinder": ('type="cylinder" size=".012 .01" zaxis="0 1 0"', 3),
    "ellipsoid": ('type="ellipsoid" size=".02 .01 .02"', 4),
}


@pytest.mark.parametrize("h", [0.002, 0.005])
@pytest.mark.parametrize("tip", TIPS)
def test_a_swung_arm_keeps_what_it_holds(tip: str, h: float) -> None:
    """By half a turn in a second, 0.5 m from its axis: tangents alone would lose r h / 2 times the integral of omega^2."""
    shape, condim = TIPS[tip]
    finger = f'<geom {shape} pos=".5 {{}} 0" mass=".05" friction="1 .02 .001" condim="{condim}"/>'
    world = '<body pos="0 0 1"><joint name="arm" axis="0 0 1"/>'
    world += '<geom type="box" size=".25 .02 .02" pos=".2 0 .1" mass="5" contype="0" conaffinity="0"/>' + finger.format(-0.0301)
    world += f'<body><joint name="squeeze" type="slide" axis="0 -1 0"/>{finger.format(0.0301)}</body></body>'
    world += '<body pos=".5 0 1"><freejoint/><geom type="box" size=".02 .0201 .02" mass=".1" friction="1 .02 .001"/></body>'
    motors = '<actuator><motor joint="squeeze"/><position joint="arm" kp="3e5" kv="6e3"/></actuator>'
    s = scene(world, motors, 'integrator="implicitfast" gravity="0 0 0"', h=h, tol=1e-6)

    def held() -> Array:
        mujoco.mj_kinematics(s.model, s.data)
        place: Array = s.data.xmat[1].reshape(3, 3).T @ (s.data.xpos[3] - s.data.xpos[1])
        return place

    s.data.ctrl[0] = 20
    s.run(0.2)
    before = held()
    for i in range(round(1 / h)):
        s.data.ctrl[1] = np.pi * smooth(i * h, 1.0)
        s.step()
    s.run(0.2)
    tangents = 0.5 * 0.5 * h * 1.2 * np.pi**2
    assert np.linalg.norm(held() - before) < SLIP < 0.01 * tangents and s.is_clean()


@pytest.mark.parametrize("h", [0.001, 0.002, 0.004])
def test_a_ball_on_a_turntable_rolls_in_a_circle(h: float) -> None:
    """Its velocity turns with k = 2/7 of the table's speed. Steps add k h / 2 to it a radian, and the first one turns nothing."""
    table = '<body pos="0 0 -.02"><joint axis="0 0 1"/><geom type="box" size="2 2 .02" mass="1e5" friction="1 0 0"/></body>'
    ball = '<body pos=".3 0 .02"><freejoint/><geom size=".02" mass=".1" friction="1 0 0"/></body>'
    s, turning, k = scene(table + ball, h=h), 3.0, 2 * 3.0 / 7
    speed = 0.3
    s.data.qvel[:] = turning, 0, speed, 0, (turning * 0.3 - speed) / 0.02, 0, 0  # the point that touches goes with the table
    time = 2 * np.pi / k
    s.run(time)
    angle = k * round(time / h) * h
    want = speed * np.array([-np.sin(angle), np.cos(angle)])
    assert np.linalg.norm(s.data.qvel[1:3] - want) < 1.01 * speed * k * h * np.hypot(angle / 2, 1)
    assert abs(s.data.qpos[3] - 0.02) < 1e-8 and s.is_clean()


def index(s: Scene, moves: int, speed: float, mu: float, way: str) -> float:
    """Move a tray from stop to stop, at most with half of what friction bears; how far it went."""
    rise, h, place = 1.5 * speed / (0.5 * mu * G), s.h, 0.0
    s.step(20)
    for _ in range(moves):
        for i in range(round((2 * rise + 0.3) / h) + 50):
            step = h * speed * (smooth(i * h, rise) - smooth(i * h - rise - 0.3, rise))
            place += step
            if way == "mocap":
                s.data.mocap_pos[0, 0] = place
            else:
                s.data.qpos[0], s.data.qvel[0] = place, step / h if way == "qpos and qvel" else 0.0
            s.step()
    return place


TRAY = '<geom type="box" size="9 .5 .02" mass="50" friction=".8 0 0"/>'


@pytest.mark.parametrize(
    ("way", "moves", "speed", "h"),
    [
        ("mocap", 10, 0.3, 0.002),
        ("mocap", 10, 0.3, 0.005),
        ("mocap", 1, 1.0, 0.001),
        ("mocap", 1, 1.0, 0.005),
        ("qpos", 10, 0.3, 0.005),
        ("qpos", 1, 1.0, 0.002),
        ("qpos and qvel", 1, 1.0, 0.002),
    ],
)
def test_a_tray_that_starts_and_stops_leaves_nothing_behind(way: str, moves: int, speed: float, h: float) -> None:
    joint = '<body mocap="true" pos="0 0 -.02">' if way == "mocap" else '<body pos="0 0 -.02"><joint type="slide" axis="1 0 0"/>'
    s = scene(joint + TRAY + "</body>" + box(".03 .03 .03", "0 0 .03", 0.5, 0.8), h=h)
    place = index(s, moves, speed, 0.8, way)
    assert abs(s.data.qpos[-7] - place) < SLIP and s.overlap() < 1e-6 * s.model.stat.meansize and s.is_clean()
    assert np.abs(s.data.qvel[-6:]).max() < 1e-6


@pytest.mark.parametrize("h", [0.002, 0.005])
@pytest.mark.parametrize("jump", [1e-4, 1e-3, 1e-2, 0.1, 1.0])
def test_a_tray_that_jumps_carries_by_what_friction_does_in_a_step(jump: float, h: float) -> None:
    """Each 20th step: at most mu g h^2 a jump, in whose direction it is, and no velocity is left."""
    s = scene(f'<body mocap="true" pos="0 0 -.02">{TRAY}</body>' + box(".03 .03 .03", "0 0 .03", 0.5, 0.8), h=h)
    depth = 3e-9 * s.model.stat.meansize
    s.step(2)  # from touching to the depth of rest
    for i in range(160):
        s.data.mocap_pos[0, 0], before = jump * (i // 20), s.data.qpos[0]
        s.step()
        moved = s.data.qpos[0] - before
        assert -depth < moved < (min(jump, 0.8 * G * h * h) if i % 20 == 0 and i else 0.0) + depth
        assert np.abs(s.data.qvel * ([1] * 3 + [0.03] * 3)).max() < depth / h
    assert abs(s.data.qpos[2] - 0.03) < 2 * depth and s.is_clean()


@pytest.mark.parametrize("h", [0.002, 0.01])
def test_a_tray_that_tilts_lets_go_at_the_angle_of_friction(h: float) -> None:
    """And a little later it has slid by 0.1 mm: s'' = g (sin a - mu cos a) + omega^2 (s + mu z) + 2 mu omega s'."""
    rate, mu, z = 0.1, 0.5, 0.05
    tray = '<body mocap="true"><geom type="box" size=".5 .5 .02" friction=".5 0 0"/></body>'
    s, angle, slid = scene(tray + box(".03 .03 .03", f"0 0 {z}", 0.5, mu), h=h), 0.0, 0.0
    while abs(slid) < 1e-4 and angle < 1:
        angle = rate * (s.data.time + h)
        s.data.mocap_quat[0] = np.cos(angle / 2), 0, np.sin(angle / 2), 0
        s.step()
        slid = float(s.data.qpos[0] * np.cos(angle) - s.data.qpos[2] * np.sin(angle))
    a = np.arctan(mu)
    way = velocity = 0.0
    while way < 1e-4:
        push = G * (np.sin(a) - mu * np.cos(a)) + rate**2 * (way + mu * z) + 2 * mu * rate * velocity
        velocity += 1e-5 * push
        way += 1e-5 * velocity
        a += rate * 1e-5
    assert abs(angle - a) < 2 * rate * h and s.is_clean()


@pytest.mark.parametrize(("frequency", "amplitude"), [(5, 0.01), (20, 0.001), (50, 0.0005)])
@pytest.mark.parametrize("h", [0.001, 0.002])
def test_a_shaken_plate_drives_as_friction_does(frequency: float, amplitude: float, h: float) -> None:
    """By 3 to 17 times what friction bears: step by step v + clip(plate - v, -mu g h, mu g h)."""
    plate = '<geom type="box" size="1 1 .05" mass="1e6" friction=".3 0 0"/>'
    plate = f'<body pos="0 0 -.05"><joint axis="1 0 0" type="slide"/>{plate}</body>'
    s, v, x = scene(plate + box(".03 .03 .02", "0 0 .02", 0.1, 0.3), h=h), 0.0, 0.0
    for i in range(round(0.5 / h)):
        now, then = (amplitude * np.sin(2 * np.pi * frequency * k * h) for k in (i, i + 1))
        s.data.qpos[0], s.data.qvel[0] = now, (then - now) / h
        s.step()
        v += np.clip((then - now) / h - v, -0.3 * G * h, 0.3 * G * h)
        x += h * v
    assert s.data.qpos[1] == pytest.approx(x, abs=1e-6) and s.data.qvel[1] == pytest.approx(v, abs=1e-5) and s.is_clean()


@pytest.mark.parametrize("h", [0.001, 0.004])
def test_a_belt_that_turns_things_is_a_polygon(h: float) -> None:
    """Its surface has a velocity and no places: things go along tangents, out by omega h / 2 in each radian.

    As the box turns about itself as well, its corners leave their tangents by their share of the radius.
    """
    world = FLOOR.replace("/>", ' surfacevel="0 0 0 0 0 1"/>') + box(".01 .01 .01", ".3 0 .01", 0.5)
    s = scene(world, h=h)
    s.data.qvel[:] = 0, 0.3, 0, 0, 0, 1
    s.run(3.0)
    assert np.hypot(*s.data.qpos[:2]) == pytest.approx(0.3 * (1 + h * h) ** (1.5 / h), abs=0.3 * h * h + 0.0141 * 1.5 * h)
    assert np.arctan2(s.data.qpos[1], s.data.qpos[0]) == pytest.approx(3.0, abs=3 * h) and s.is_clean()
