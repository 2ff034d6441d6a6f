"""What slides, rolls, rocks and swings does so as on paper: exact solutions, or the sum of steps where these are what counts."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from field import FLOOR, G, Scene, box, scene, slope

APART = 'contype="0" conaffinity="0"'


def energy(s: Scene) -> float:
    """Of motion and weight, where things are now (J)."""
    mujoco.mj_kinematics(s.model, s.data)
    mujoco.mj_comPos(s.model, s.data)
    mujoco.mj_crb(s.model, s.data)
    mujoco.mj_energyPos(s.model, s.data)
    mujoco.mj_energyVel(s.model, s.data)
    return float(s.data.energy.sum())


def about_y(angle: float) -> str:
    return f"{np.cos(angle / 2)} 0 {np.sin(angle / 2)} 0"


@pytest.mark.parametrize("lean", [10, 25, 40])
@pytest.mark.parametrize("h", [0.002, 0.01])
def test_two_cards_stand_from_their_friction_on(lean: float, h: float) -> None:
    """They lean on each other, 80 mm long, with edges of r = 0.5 mm: mu = (L sin b / 2) / (L cos b + r)."""
    b, L, r, ends = np.deg2rad(lean), 0.08, 0.0005, []
    for share in (0.99, 1.01):
        mu, cards = share * L * np.sin(b) / 2 / (L * np.cos(b) + r), ""
        for side in (-1, 1):
            edge = f'<geom type="capsule" size="{r}" mass="1e-6" fromto="0 -.03 {{0}} 0 .03 {{0}}" friction="{mu} 0 0"/>'
            place = f"{side * (L / 2 * np.sin(b) + r)} 0 {L / 2 * np.cos(b) + r}"
            card = f'<geom type="box" size=".0002 .03 {L / 2}" mass=".0018" {APART}/>' + edge.format(-L / 2) + edge.format(L / 2)
            cards += f'<body pos="{place}" quat="{about_y(-side * b)}"><freejoint/>{card}</body>'
        s = scene('<geom type="plane" size="5 5 .1" friction="1e-4 0 0"/>' + cards, h=h)
        start = s.data.qpos[2]
        ends.append(start - s.run(1.0).qpos[2])
        assert s.stepper.fallbacks == 0 and (share < 1 or s.is_clean())
    assert ends[0] > 0.01 and abs(ends[1]) < 1e-7


@pytest.mark.parametrize("h", [1 / 240, 1 / 60])
@pytest.mark.parametrize("degrees", [1, 10, 25, 40, 60])
def test_ramps_hold_or_let_go(degrees: float, h: float) -> None:
    for more in (-0.2, -0.01, -1e-3, -1e-5, 1e-5, 1e-3, 0.01, 0.2):
        angle = np.deg2rad(degrees)
        mu = np.tan(angle) * (1 + more)
        floor = f'<geom type="plane" size="9 9 .1" friction="{mu} 0 0"/>'
        s = scene(floor + box(".05 .05 .02", "0 0 .02", 1.0, mu), option=slope(angle), h=h)
        want = -max(0.0, G * (np.sin(angle) - mu * np.cos(angle)))
        assert s.run(1.0).qvel[0] == pytest.approx(want, abs=1e-6) and s.is_clean()


@pytest.mark.parametrize("mu", [0.5, 1.4, 2.0])
@pytest.mark.parametrize("speed", [2.0, 8.0])
@pytest.mark.parametrize("h", [0.002, 0.01])
def test_a_rod_that_jams_loses_energy(mu: float, speed: float, h: float) -> None:
    """Painleve's: 1 m long, sliding on an end at 60 degrees from the ground; from mu = 4/3 on no force holds it there."""
    angle = np.deg2rad(60)
    rod = '<inertial pos="0 0 0" mass="1" diaginertia=".08333 .08333 .001"/>'
    rod += f'<geom type="capsule" size=".01" fromto="0 0 -.5 0 0 .5" friction="{mu} 0 0"/>'
    place = f"{-0.5 * np.cos(angle)} 0 {0.5 * np.sin(angle) + 0.01}"
    floor = f'<geom type="plane" size="50 50 .1" friction="{mu} 0 0"/>'
    s = scene(f'{floor}<body pos="{place}" quat="{about_y(np.pi / 2 - angle)}"><freejoint/>{rod}</body>', h=h)
    s.data.qvel[0] = -speed
    energies = [energy(s)]
    for _ in range(round(0.5 / h)):
        s.step()
        energies.append(energy(s))
        assert s.overlap() < 1e-6 * s.model.stat.meansize
    assert np.diff(energies).max() < 1e-9 * energies[0] and s.is_clean()
    assert np.abs(s.data.qpos[[1, 4, 6]]).max() < 1e-9  # in its plane


@pytest.mark.parametrize("kind", ["contact", "frictionloss"])
@pytest.mark.parametrize("h", [0.01, 0.002, 0.0005])
def test_a_spring_with_friction_stops_where_it_should(kind: str, h: float) -> None:
    """Each half cycle takes 2 mu m g / k of its amplitude; steps change it by (omega h)^2 / 8 of itself."""
    k, mu, start, omega = 100.0, 0.2, 0.31, 10.0
    held = mu * G / k
    joint = (
        f'<joint type="slide" axis="1 0 0" stiffness="{k}" {f"""frictionloss="{mu * G}" """ if kind == "frictionloss" else ""}/>'
    )
    body = f'<geom type="box" size=".05 .05 .05" mass="1" friction="{mu} 0 0"/></body>'
    if kind == "contact":
        floor = f'<geom type="plane" size="5 5 .1" friction="{mu} 0 0"/>'
        s = scene(f'{floor}<body pos="0 0 .05">{joint}<joint type="slide" axis="0 0 1"/>{body}', h=h)
    else:
        s = scene(f'<body pos="0 0 .05">{joint}{body}', h=h)
    s.data.qpos[0] = x = start
    s.run(3.0)
    paper, halves = start, 0
    while abs(paper) > held:
        paper, halves = -np.sign(paper) * (abs(paper) - 2 * held), halves + 1
    v = 0.0
    for _ in range(round(3.0 / h)):
        v -= h * k * x
        v -= np.clip(v, -mu * G * h, mu * G * h)
        x += h * v
    assert s.data.qpos[0] == pytest.approx(x, abs=1e-7) and abs(s.data.qvel[0]) < 1e-9 and s.is_clean()
    assert s.data.qpos[0] == pytest.approx(paper, abs=halves * start * (omega * h) ** 2 / 8)


@pytest.mark.parametrize("h", [0.01, 0.002])
def test_a_spring_on_a_belt_swings_for_ever(h: float) -> None:
    """It sticks until k x = mu m g, then swings by V / omega about that: lost is nothing, and h / 2 of V is between steps."""
    belt, spring = 0.1, '<joint type="slide" axis="1 0 0" stiffness="100"/><joint type="slide" axis="0 0 1"/>'
    world = f'<geom type="box" size="5 1 .05" pos="0 0 -.05" friction=".2 0 0" surfacevel="{belt} 0 0 0 0 0"/>'
    world += f'<body pos="0 0 .05">{spring}<geom type="box" size=".05 .05 .05" mass="1" friction=".2 0 0"/></body>'
    s = scene(world, h=h)
    s.run(20.0)
    way = [float(s.step().qpos[0]) for _ in range(round(2.0 / h))]
    assert np.ptp(way) / 2 == pytest.approx(belt / 10, rel=10 * h) and s.is_clean()
    assert (max(way) + min(way)) / 2 == pytest.approx(0.2 * G / 100, abs=belt * h)


@pytest.mark.parametrize("h", [0.001, 0.0002])
def test_a_struck_ball_curves_and_rolls(h: float) -> None:
    """The point that touches slides straight; it rolls from 2 |u| / (7 mu g) on, with v - 2 u / 7. A step is what is unsure."""
    R, mu, v, w = 0.0286, 0.2, np.array([2.0, 0, 0]), np.array([60.0, 40, 50])
    surface = f'friction="{mu} 0 0"'
    ball = f'<body pos="0 0 {R}"><freejoint/><geom size="{R}" mass=".17" {surface}/></body>'
    s = scene(f'<geom type="plane" size="5 5 .1" {surface}/>{ball}', h=h)
    s.data.qvel[:3], s.data.qvel[3:] = v, w
    s.run(1.0)
    u = v + np.cross(w, [0, 0, -R])
    size = float(np.linalg.norm(u))
    rolls = 2 * size / (7 * mu * G)
    after = v - 2 / 7 * u
    place = v * rolls - 0.5 * mu * G * u / size * rolls**2 + after * (1 - rolls)
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, s.data.qpos[3:7])
    spin = turned.reshape(3, 3) @ s.data.qvel[3:]
    assert np.abs(s.data.qvel[:2] - after[:2]).max() < mu * G * h
    assert np.abs(s.data.qpos[:2] - place[:2]).max() < mu * G * rolls * h
    assert np.linalg.norm(s.data.qvel[:3] + np.cross(spin, [0, 0, -R])) < 1e-6  # rolls
    assert spin[2] == pytest.approx(50, rel=float(np.linalg.norm(w) * h) ** 2) and s.is_clean()


def test_a_rocking_block_loses_what_housner_says() -> None:
    """0.2 m x 0.8 m: the speed after an impact is 1 - 1.5 sin(a)^2 of that before. The rest is of first order."""
    h, half, tall = 0.0002, 0.1, 0.4
    a = np.arctan2(half, tall)
    q = 0.5 * a
    x, z = half - (half * np.cos(q) - tall * np.sin(q)), half * np.sin(q) + tall * np.cos(q)
    block = f'<freejoint/><geom type="box" size="{half} .1 {tall}" mass="4"/>'
    s = scene(f'{FLOOR}<body pos="{x} 0 {z}" quat="{about_y(q)}">{block}</body>', h=h)
    angles = []
    for _ in range(round(2.0 / h)):
        s.step()
        angles.append(abs(2 * np.arctan2(s.data.qpos[5], s.data.qpos[3])))
    way = np.array(angles)
    peaks = way[1:-1][(way[1:-1] >= way[:-2]) & (way[1:-1] > way[2:]) & (way[1:-1] > 0.01 * a)]
    want = []
    for _ in range(3):
        q = a - np.arccos(np.cos(a) + (np.cos(a - q) - np.cos(a)) * (1 - 1.5 * np.sin(a) ** 2) ** 2)
        want.append(q)
    assert peaks[:3] / a == pytest.approx(np.array(want) / a, abs=0.01) and (peaks[:3] < want).all() and s.is_clean()
