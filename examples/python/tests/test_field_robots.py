"""What is built of several bodies: wheels, feet, links, dominoes. Their shares of a load are those of statics, and energy falls."""

from __future__ import annotations

from itertools import pairwise

import mujoco
import numpy as np
import pytest
from field import FLOOR, Array, G, box, scene, slope
from test_field_laws import energy

APART = 'contype="0" conaffinity="0"'


@pytest.mark.parametrize("mu", [0.3, 0.8])
@pytest.mark.parametrize("h", [0.002, 0.01])
def test_driven_wheels_climb_and_locked_ones_slide(mu: float, h: float) -> None:
    """Two wheels and 24 kg on 10 degrees, servos of 50 N m s: they turn slower by m g sin(a) r / (2 kv), and slip by nothing."""
    wheel = '<body pos="{} 0 -.05"><joint name="w{}" axis="0 1 0"/><geom size=".1" mass="1" friction="{} 0 0"/></body>'
    wheels = wheel.format(-0.3, 0, mu) + wheel.format(0.3, 1, mu)
    slides = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint axis="0 1 0"/>'
    world = f'<geom type="plane" size="50 50 .1" friction="{mu} 0 0"/>'
    world += f'<body pos="0 0 .15">{slides}<geom type="box" size=".4 .2 .05" mass="22" {APART}/>{wheels}</body>'
    servos = '<actuator><velocity joint="w0" kv="50"/><velocity joint="w1" kv="50"/></actuator>'
    angle = np.deg2rad(10)
    s = scene(world, servos, slope(angle) + ' integrator="implicitfast"', h=h)
    s.data.ctrl[:] = 10.0
    s.run(3.0)
    want = 10 - 24 * G * np.sin(angle) * 0.1 / (2 * 50)
    assert s.data.qvel[3:5] == pytest.approx([want, want], rel=1e-6) and s.data.qvel[0] == pytest.approx(0.1 * want, rel=1e-6)
    s.data.ctrl[:] = 0.0
    s.model.opt.gravity[:] = 0, 0, -G
    s.model.actuator_gainprm[:, 0], s.model.actuator_biasprm[:, 2] = 1e6, -1e6
    start, speed = s.data.qpos[0], s.data.qvel[0]
    s.run(2.0)
    steps = np.arange(1, round(2.0 / h) + 1)
    slid = h * np.maximum(speed - mu * G * h * steps, 0).sum()  # while wheels stop, in a step, they add no more than one
    assert s.data.qpos[0] - start == pytest.approx(slid, abs=speed * h) and abs(s.data.qvel[0]) < 1e-6 and s.is_clean()


@pytest.mark.parametrize("h", [0.001, 0.005])
def test_a_payload_moves_its_weight_from_foot_to_foot(h: float) -> None:
    """2 kg go over a table of four feet: a rigid table's least shares are affine in the place, and so smooth."""
    feet = "".join(
        f'<geom size=".02" pos="{0.4 * x} {0.3 * y} -.4" mass=".1" friction=".8 0 0"/>' for x in (-1, 1) for y in (-1, 1)
    )
    load = '<joint type="slide" axis="1 0 0" name="x"/>' + f'<geom type="box" size=".05 .05 .05" mass="2" {APART}/>'
    table = f'<freejoint/><geom type="box" size=".5 .4 .02" mass="5" {APART}/>{feet}<body pos="-.3 .05 .1">{load}</body>'
    world = f'<geom type="plane" size="5 5 .1" friction=".8 0 0"/><body pos="0 0 .42">{table}</body>'
    s = scene(world, '<actuator><velocity joint="x" kv="1000"/></actuator>', 'integrator="implicitfast"', h=h)
    s.data.ctrl[0] = 0.1
    s.run(0.5)
    corners = np.array([(x, y) for x in (-1, 1) for y in (-1, 1)])
    for _ in range(round(2.0 / h)):
        place, shares, force = s.data.qpos[7] - 0.3, np.zeros(4), np.zeros(6)
        s.step()
        for index, contact in enumerate(s.data.contact):
            mujoco.mj_contactForce(s.model, s.data, index, force)
            shares[contact.geom.max() - 2] += force[0]
        want = 5.4 * G / 4 + 2 * G * (0.25 + corners @ [place / 1.6, 0.05 / 1.2])
        assert np.abs(shares - want).max() < 1e-3
    assert np.abs(s.data.qpos[:2]).max() < 1e-8 and s.is_clean()


def link(index: int, height: float, more: str = "") -> str:
    """A link of a chain: a stadium of capsules, each second one turned."""
    r, w, half, c = 0.004, 0.011, 0.015, np.sqrt(0.5)
    pieces = "".join(f'<geom type="capsule" size="{r}" mass=".005" fromto="{x} 0 {-half} {x} 0 {half}"/>' for x in (-w, w))
    for side in (1, -1):
        bow = [(w * np.cos(t), side * (half + w * np.sin(t))) for t in np.linspace(0, np.pi, 5)]
        for p, q in pairwise(bow):
            pieces += f'<geom type="capsule" size="{r}" mass=".005" fromto="{p[0]} 0 {p[1]} {q[0]} 0 {q[1]}"/>'
    turned = "" if index % 2 else f'quat="{c} 0 0 {c}"'
    return f'<body pos="0 0 {height}" {turned}><freejoint/>{pieces}{more}</body>'


@pytest.mark.parametrize(("load", "h"), [(100, 0.001), (100, 0.005)])
def test_a_chain_of_real_links_bears_its_weight(load: float, h: float) -> None:
    """Six links that begin 1.4 mm deep in each other, with a load of 100 of them; the hook bears all.

    Over a second, by momentum: to what the velocities at its ends make of it.
    """
    pitch, weight = 0.03 + 2 * 0.011 - 2 * 0.004, f'<geom size=".03" pos="0 0 -.056" mass="{0.05 * load}" {APART}/>'
    world = f'<geom type="capsule" size=".004" fromto="-.05 0 {0.015 + 0.011 - 0.008} .05 0 {0.015 + 0.011 - 0.008}"/>'
    s = scene(world + "".join(link(i, -i * pitch, weight if i == 5 else "") for i in range(6)), h=h, tol=1e-6)
    s.run(1.0)
    mass = s.model.body_mass[1:]
    before, forces = mass @ s.data.qvel[2::6], []
    for _ in range(round(1.0 / h)):
        s.step()
        forces.append(s.data.qfrc_constraint[2::6].sum())
    after = mass @ s.data.qvel[2::6]
    assert np.mean(forces) == pytest.approx(mass.sum() * G + (after - before), rel=1e-6)
    assert -0.01 < s.data.qpos[-5] + 5 * pitch < 0.01 and s.is_clean()


@pytest.mark.parametrize("count", [4, 6])
@pytest.mark.parametrize("h", [0.01, 0.002])
def test_dominoes_fall_in_turn(count: int, h: float) -> None:
    """48 mm high, 25 mm apart, 7.5 mm thick: none is missed, all but the last lean on the next, and energy only falls."""
    floor = '<geom type="plane" size="5 5 .1" friction=".6 0 0"/>'
    s = scene(floor + "".join(box(".00375 .012 .024", f"{0.025 * i} 0 .024", 0.01, 0.3) for i in range(count)), h=h, tol=1e-6)
    s.data.qvel[[0, 2, 4]] = 4 * 0.024, 4 * 0.00375, 4.0
    energies, fallen = [energy(s)], []
    for _ in range(round(1.0 / h)):
        s.step()
        energies.append(energy(s))
        leans = [abs(2 * np.arctan2(pose[5], pose[3])) for pose in s.data.qpos.reshape(count, 7)]
        fallen += [i for i in range(count) if leans[i] > 0.05 and i not in fallen]
    assert fallen == list(range(count)) and leans[-1] == pytest.approx(np.pi / 2, abs=1e-6)
    assert min(leans[:-1]) > 1.0 and np.diff(energies).max() < 1e-6 * energies[0] and s.is_clean()


@pytest.mark.parametrize("h", [0.001, 0.002, 0.005])
def test_feet_of_a_robot_that_sways_stay(h: float) -> None:
    """Round feet of 5 mm roll to and fro under a trunk that is rocked by 0.1 rad at 1 Hz; less what they have rolled, they stay."""

    def leg(x: float, name: int) -> str:
        bar = f'<geom type="capsule" size=".01" fromto="0 0 0 0 0 -.2" mass="{{}}" {APART}/>'
        foot = f'<geom name="f{name}" size=".005" pos="0 0 -.2" mass=".02"/>'
        shin = f'<body pos="0 0 -.2"><joint name="k{name}" axis="0 1 0"/>{bar.format(0.1)}{foot}</body>'
        return f'<body pos="{x} 0 0"><joint name="h{name}" axis="0 1 0"/>{bar.format(0.2)}{shin}</body>'

    slides = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint axis="0 1 0"/>'
    trunk = f'<geom type="box" size=".25 .1 .03" mass="6" {APART}/>'
    world = f'{FLOOR}<body pos="0 0 .405">{slides}{trunk}{leg(-0.2, 0)}{leg(0.2, 1)}</body>'
    servos = "".join(f'<position joint="{name}" kp="3000" kv="60"/>' for name in ("h0", "k0", "h1", "k1"))
    s = scene(world, f"<actuator>{servos}</actuator>", 'integrator="implicitfast"', h=h)
    s.data.qpos[3:] = stance = np.array([-0.4, 0.8, -0.4, 0.8])
    mujoco.mj_kinematics(s.model, s.data)
    s.data.qpos[1] -= s.data.geom("f0").xpos[2] - 0.005

    def feet() -> Array:
        """Where they are, less what they have rolled."""
        mujoco.mj_kinematics(s.model, s.data)
        turned = np.array([np.arctan2(*s.data.geom(f"f{i}").xmat[[2, 0]]) for i in (0, 1)])
        return np.array([s.data.geom(f"f{i}").xpos[0] for i in (0, 1)]) - 0.005 * turned

    s.data.ctrl[:] = stance
    s.run(1.0)
    start = feet()
    for i in range(round(4.0 / h)):
        t = i * h
        sway = 0.1 * np.sin(2 * np.pi * t) * min(t, 1.0)
        s.data.ctrl[:] = stance + sway * np.array([1, -0.5, 1, -0.5])
        s.step()
    assert np.abs(feet() - start).max() < 2e-5 and s.is_clean()
