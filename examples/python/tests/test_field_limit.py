"""What is carried near the limit of friction."""

from __future__ import annotations

import numpy as np
import pytest
from field import G, box, scene
from test_field_turning import about_z, seen_from, smooth


@pytest.mark.parametrize("h", [0.001, 0.002, 0.005])
@pytest.mark.parametrize("share", [0.7, 0.9])
@pytest.mark.parametrize("kind", ["joint", "mocap"])
def test_a_turntable_near_the_limit_of_friction_carries(kind: str, share: float, h: float) -> None:
    """Friction is used by share < 1, so it sticks. What takes the creep back, omega^2 r h^2 / 2, has all friction to itself."""
    mu, r = 0.5, 0.3
    w = np.sqrt(share * mu * G / r)
    table = '<body pos="0 0 -.02"><joint axis="0 0 1"/>' if kind == "joint" else '<body mocap="true" pos="0 0 -.02">'
    table += f'<geom type="cylinder" size=".5 .02" mass="1e5" friction="{mu} 0 0"/></body>'
    s = scene(table + box(".01 .01 .01", f"{r} 0 .01", 0.5, mu), h=h)
    s.data.qvel[-6:] = 0, w * r, 0, 0, 0, w
    if kind == "joint":
        s.data.qvel[0] = w
    for i in range(round(1 / h)):
        if kind == "mocap":
            s.data.mocap_quat[0] = about_z(w * (i + 1) * h)
        s.step()
    assert abs(np.hypot(*s.data.qpos[-7:-5]) - r) < 2e-5


@pytest.mark.parametrize("h", [0.001, 0.002, 0.005])
@pytest.mark.parametrize("share", [0.6, 0.9])
@pytest.mark.parametrize("way", ["mocap", "qpos"])
def test_a_tray_that_speeds_up_near_the_limit_of_friction_carries(way: str, share: float, h: float) -> None:
    """One start and stop to 2.4 m/s at 0.9 of mu g: the tray is always a h^2 ahead of its last velocity."""
    mu, rise = 0.8, 0.5
    speed, place = share * mu * G * rise / 1.5, 0.0
    joint = '<body mocap="true" pos="0 0 -.02">' if way == "mocap" else '<body pos="0 0 -.02"><joint type="slide" axis="1 0 0"/>'
    tray = '<geom type="box" size="3 .5 .02" mass="50" friction=".8 0 0"/></body>'
    s = scene(joint + tray + box(".03 .03 .03", "0 0 .03", 0.5, mu), h=h)
    s.step(20)
    for i in range(round((2 * rise + 0.4) / h)):
        place += h * speed * (smooth(i * h, rise) - smooth(i * h - rise - 0.2, rise))
        if way == "mocap":
            s.data.mocap_pos[0, 0] = place
        else:
            s.data.qpos[0], s.data.qvel[0] = place, 0.0
        s.step()
    assert abs(s.data.qpos[-7] - place) < 2e-5


@pytest.mark.parametrize("h", [0.002, 0.005])
def test_a_turntable_that_is_a_joint_carries_along_its_circle(h: float) -> None:
    """Two turns of 3 rad/s: neither outward nor ahead of the table, as if the creep were taken back askew."""
    w, r = 3.0, 0.3
    table = '<body pos="0 0 -.02"><joint axis="0 0 1"/><geom type="cylinder" size=".5 .02" mass="1000" friction="1 0 0"/></body>'
    s = scene(table + box(".01 .01 .01", f"{r} 0 .01", 0.5), h=h)
    s.data.qvel[:] = w, 0, w * r, 0, 0, 0, w
    s.run(4 * np.pi / w)
    assert np.linalg.norm(seen_from(s.data.qpos[1:3], float(s.data.qpos[0])) - [r, 0]) < 2e-5


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_jam_gives_no_energy(seed: int) -> None:
    """As of metaworld's pick_out_of_hole: a part of 0.01 kg whose inertia is 1e5 kg m^2 begins 40 mm inside both walls."""
    inertia = 1e5
    walls = "".join(f'<geom type="box" size=".05 .2 .2" pos="{x} 0 0"/>' for x in (-0.08, 0.08))
    part = f'<inertial pos="0 0 0" mass=".01" diaginertia="{inertia} {inertia} {inertia}"/><geom type="box" size=".07 .05 .05"/>'
    s = scene(f"{walls}<body><freejoint/>{part}</body>", option='gravity="0 0 0"', tol=1e-6)
    s.data.qvel[:] = np.random.default_rng(seed).normal(size=6) * [0.5, 0.5, 0.5, 1, 1, 1]
    energies = []
    for _ in range(300):
        energies.append(0.005 * float((s.data.qvel[:3] ** 2).sum()) + inertia / 2 * float((s.data.qvel[3:] ** 2).sum()))
        s.step()
    assert np.diff(energies).max() < 1e-6 * energies[0] or not s.is_clean()
