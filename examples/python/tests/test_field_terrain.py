"""What contacts must not be: seams, sides of prisms, walls ahead, normals without a lever."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from field import FLOOR, Array, G, Scene, box, scene

SPEED, MU = 1.5, 0.5
TILES = "".join(
    f'<geom type="box" size=".05 .1 .05" pos="{x / 10:.1f} {y / 5:.1f} -.05" friction="{MU} 0 0"/>'
    for x in range(-1, 9)
    for y in (-1, 0)
)
PLANE = f'<geom type="plane" size="5 5 1" friction="{MU} 0 0"/>'
ROUND = {
    "sphere": '<geom size=".03" mass=".5" friction=".5 0 0"/>',
    "capsule": '<geom type="capsule" fromto="-.04 0 0 .04 0 0" size=".03" mass=".5" friction=".5 0 0"/>',
    "across": '<geom type="capsule" fromto="0 -.04 0 0 .04 0" size=".03" mass=".5" friction=".5 0 0"/>',
    "ellipsoid": '<geom type="ellipsoid" size=".06 .04 .03" mass=".5" friction=".5 0 0"/>',
    "box": '<geom type="box" size=".04 .03 .03" mass=".5" friction=".5 0 0"/>',
}


def slides(floor: str, geom: str, h: float = 0.002, rest: str = "", turned: float = 0.0, time: float = 0.6) -> tuple[Scene, Array]:
    """Throw a thing along x, flat on a floor; returns all positions."""
    half = np.cos(turned / 2), np.sin(turned / 2)
    world = f'{floor}<body pos=".013 .007 .03" quat="{half[0]} 0 0 {half[1]}"><freejoint/>{geom}</body>'
    s = scene(world, h=h, tol=1e-8, head=rest)
    s.data.qvel[0] = SPEED
    return s, np.array([s.step().qpos[:7].copy() for _ in range(round(time / h))])


@pytest.mark.parametrize(
    ("shape", "h"), [(shape, h) for shape in ROUND for h in (0.002, 0.005) if (shape, h) != ("ellipsoid", 0.005)]
)
def test_seams_of_tiles_are_no_walls(shape: str, h: float) -> None:
    """Things go as on a plane, and hop no more than there."""
    turned = 0.3 if shape == "box" else 0.0
    s, path = slides(TILES, ROUND[shape], h, turned=turned)
    _, plain = slides(PLANE, ROUND[shape], h, turned=turned)
    assert path[-1, 0] > 0.15 and s.stepper.unsolved == s.stepper.fallbacks == 0
    assert np.abs(path[:, :3] - plain[:, :3]).max() < 1e-4  # both, where two tiles meet
    assert path[:, 2].max() < max(plain[:, 2].max(), 0.03) + 1e-6


THROWN = {
    "marble": '<geom size=".008" mass=".0167" friction=".6 0 0"/>',
    "box": '<geom type="box" size=".008 .008 .008" mass=".0167" friction=".05 0 0"/>',
    "capsule": '<geom type="capsule" fromto="-.02 0 0 .02 0 0" size=".008" mass=".0167" friction=".05 0 0"/>',
}


@pytest.mark.parametrize(("shape", "turned"), [("marble", 0.0), ("box", 0.0), ("box", np.pi / 4), ("capsule", 0.0)])
@pytest.mark.parametrize(
    ("size", "speed", "h"), [(40, 2, 1 / 60), (40, 5, 0.005), (40, -5, 0.01), (40, 10, 0.005), (100, 5, 1 / 60), (100, 10, 1 / 60)]
)
def test_seams_do_not_act_however_far_a_step_leads(shape: str, turned: float, size: int, speed: float, h: float) -> None:
    """Up to four tiles in a step, each starting elsewhere: the height stays, a marble rolls on, others lose what friction takes."""
    mu = 0.6 if shape == "marble" else 0.05
    tiles = "".join(
        f'<geom type="box" size="{size / 2000} .1 .01" pos="{i * size / 1000:.3f} 0 -.01" friction="{mu} 0 0"/>'
        for i in range(-round(4000 / size), round(4000 / size))
    )
    half = np.cos(turned / 2), np.sin(turned / 2)
    for start in (0.0, 0.3, 0.5, 0.8):
        x, steps = start * size / 1000, round(min(0.5, 3 / abs(speed)) / h)
        body = f'<body pos="{x} 0 .008" quat="{half[0]} 0 0 {half[1]}"><freejoint/>{THROWN[shape]}</body>'
        s = scene(tiles + body, h=h)
        s.data.qvel[0] = speed
        lost = mu * G * steps * h
        if shape == "marble":
            s.data.qvel[4], lost = speed / 0.008, 0.0
        for _ in range(steps):
            assert abs(s.step().qpos[2] - 0.008) < 1e-4
        assert abs(s.data.qvel[0]) == pytest.approx(abs(speed) - lost, abs=1e-3) and s.is_clean()


@pytest.mark.parametrize(("speed", "h"), [(5, 0.005), (10, 0.005), (10, 1 / 60)])
def test_a_wall_behind_seams_stops_what_comes_far_in_a_step(speed: float, h: float) -> None:
    tiles = "".join(f'<geom type="box" size=".02 .1 .01" pos="{i / 25} 0 -.01" friction=".05 0 0"/>' for i in range(-5, 11))
    wall = '<geom type="box" size=".005 .1 .2" pos=".425 0 .1" friction=".05 0 0"/>'
    for start in (0.0, 0.007, 0.02, 0.027):
        s = scene(f'{tiles}{wall}<body pos="{start} 0 .008"><freejoint/>{THROWN["box"]}</body>', h=h)
        s.data.qvel[0] = speed
        s.step(round(0.2 / h))
        assert np.abs(s.data.qpos[:3] - [0.412, 0, 0.008]).max() < 1e-5 and np.abs(s.data.qvel).max() < 1e-3


@pytest.mark.parametrize("turned", [0.0, 0.3])
@pytest.mark.parametrize("cells", [20, 100, 200, 300])
def test_a_flat_height_field_is_a_plane(cells: int, turned: float) -> None:
    assets = f'<asset><hfield name="f" nrow="{cells}" ncol="{cells}" size="1 1 .1 .1"/></asset>'
    field = f'<geom type="hfield" hfield="f" friction="{MU} 0 0"/>'
    s, path = slides(field, ROUND["box"], rest=assets, turned=turned, time=0.4)
    _, plain = slides(PLANE, ROUND["box"], turned=turned, time=0.4)
    assert np.rad2deg(2 * np.abs(path[:, 4:6]).max()) < 0.02 and np.abs(path[:, 2] - 0.03).max() < 1e-5
    assert np.abs(path[:, :2] - plain[:, :2]).max() < 3e-4  # more contacts, of which any share bears the box
    assert s.stepper.unsolved == s.stepper.fallbacks == 0


@pytest.mark.parametrize("h", [0.002, 0.01])
def test_a_real_step_is_a_wall(h: float) -> None:
    stair = '<geom type="box" size=".2 .5 .01" pos=".33 0 .01" friction=".5 0 0"/>'
    s = scene(PLANE + stair + box(".05 .05 .01", "0 0 .01", 1.0, MU), h=h)
    s.data.qvel[0] = SPEED
    for _ in range(round(0.6 / h)):
        s.step()
        assert s.overlap() < 1e-6 * s.model.stat.meansize
    assert np.abs(s.data.qpos[:3] - [0.08, 0, 0.01]).max() < 1e-6 and np.abs(s.data.qvel).max() < 1e-6


@pytest.mark.parametrize("radius", [0.01, 0.003])
@pytest.mark.parametrize("start", [0.0, 0.013, 0.027])
def test_a_bullet_does_not_pass_a_thin_wall(radius: float, start: float) -> None:
    """20 m/s are 40 mm in a step, the wall is 5 mm thick."""
    wall = '<geom type="box" size=".0025 .5 .5" pos=".5 0 0" friction="0 0 0"/>'
    ball = f'<body pos="{start} 0 0"><freejoint/><geom size="{radius}" mass=".1" friction="0 0 0"/></body>'
    s = scene(wall + ball, option='gravity="0 0 0"')
    s.data.qvel[0] = 20.0
    s.step(100)
    assert s.data.qpos[0] == pytest.approx(0.4975 - radius, abs=1e-6) and np.abs(s.data.qvel).max() < 1e-6


@pytest.mark.parametrize(
    ("shape", "contacts"),
    [('size=".01"', 1), ('type="capsule" size=".01 .05" euler="0 90 0"', 2), ('type="box" size=".01 .01 .01"', 4)],
)
def test_what_travels_far_in_a_step_touches_once(shape: str, contacts: int) -> None:
    """It is looked for at eight poses of its way, 16 cm down and 10 cm along."""
    s = scene(PLANE + f'<body pos="0 0 .05"><freejoint/><geom mass="1" {shape}/></body>', h=0.02)
    s.data.qvel[:3] = [5.0, 0.0, -8.0]
    assert s.step().ncon == contacts
    assert s.overlap() < 1e-6 * s.model.stat.meansize and s.is_clean()


LEVERS = [0.0, 1e-9, 1e-6, 1e-4, 1e-3, 3e-3, 1e-2]


@pytest.mark.parametrize("lever", LEVERS)
@pytest.mark.parametrize("depth", [0.0, 1e-6, 1e-3])
def test_an_overlap_near_an_axis_turns_nothing_faster_than_it_falls(lever: float, depth: float) -> None:
    """A pendulum whose hub, a sphere about its hinge, lies in a fixed sphere beside it."""
    hub, arm = (
        '<geom size=".05" mass=".1"/>',
        '<geom type="capsule" fromto="0 0 0 .4 0 0" size=".02" mass="1" contype="0" conaffinity="0"/>',
    )
    fixed = f'<geom size=".05" pos="0 {depth - 0.1} 1"/>'
    moved = hub.replace("<geom", f'<geom pos="0 0 {-lever}"').replace("/>", ' name="hub"/>')
    s = scene(fixed + f'<body pos="0 0 1"><joint axis="1 0 0"/>{moved}{arm.replace(".4 0 0", "0 .4 0")}</body>', tol=1e-8)
    free = scene(f'<body pos="0 0 1"><joint axis="1 0 0"/>{moved}{arm.replace(".4 0 0", "0 .4 0")}</body>')
    fastest = 0.0
    for _ in range(500):
        s.step()
        fastest = max(fastest, abs(float(free.step().qvel[0])))
        assert abs(s.data.qvel[0]) < 1.01 * fastest + 1e-6
        assert np.abs(s.data.efc_force).max(initial=0.0) < 1e5
    assert s.stepper.unsolved == 0


@pytest.mark.parametrize("degrees", [1.0, 3.0, 6.0])
@pytest.mark.parametrize("lower", [0.0, 1e-4, 1e-3, 2e-3])
def test_a_wedge_jams_or_comes_out_slowly(degrees: float, lower: float) -> None:
    """A cube of 0.1 kg under a lid that is tilted, pressed in by so much: nothing flies.

    What a jam presses with has no law; pushing the cube out would take 1e18 N.
    """
    angle = np.deg2rad(degrees)
    height = 0.04 + 0.02 * np.tan(angle) - lower  # of the lid's face over the cube's middle
    centre = np.array([0.0, 0.0, height]) + 0.02 * np.array([-np.sin(angle), 0, np.cos(angle)])
    lid = f'<geom type="box" size=".2 .2 .02" pos="{centre[0]} 0 {centre[2]}" euler="0 {-degrees} 0"/>'
    s = scene(FLOOR + lid + box(".02 .02 .02", "0 0 .02", 0.1), tol=1e-6)
    for _ in range(500):
        s.step()
        assert np.abs(s.data.qvel[:3]).max() < 0.1
        assert np.abs(s.data.efc_force).max(initial=0.0) < 1000.0
    assert np.linalg.norm(s.data.qpos[:3] - [0, 0, 0.02]) < 0.01 and s.stepper.fallbacks == 0


@pytest.mark.parametrize("h", [0.002, 0.01])
def test_a_chain_in_free_fall_touches_nothing(h: float) -> None:
    link = '<body pos=".1 0 0"><joint type="ball" damping=".01"/><geom type="capsule" fromto=".035 0 0 .08 0 0" size=".015"/>'
    world = FLOOR + f'<body pos="0 0 50"><freejoint/><geom size=".03"/>{link * 6}{"</body>" * 6}</body>'
    s = scene(world, h=h)
    for _ in range(round(1 / h)):
        assert s.step().ncon == 0
    assert s.data.qvel[2] == pytest.approx(-G, rel=1e-9)


def test_an_overlap_of_hinged_faces_leaves_a_loop_closed() -> None:
    """Two plates of one hinge overlap for ever, and nothing can part them; a loop of four bars and a cube do not mind."""
    plate = '<geom type="box" size=".1 .1 .01" pos=".1 0 0"/>'
    hinge = f'<body pos="0 2 1">{plate}<body pos="0 0 .019"><joint axis="0 0 1"/>{plate}</body></body>'
    bar = '<body name="{}" pos="{} 0 3"><joint axis="0 1 0"/>'
    bar += '<geom contype="0" conaffinity="0" type="capsule" fromto="0 0 0 .3 0 .1" size=".01"/>'
    loop = f"{bar.format('a', 0)}{bar.format('b', '.3').replace(' 3', ' 0')}</body></body>{bar.format('c', '.4')}</body>"
    connect = '<equality><connect body1="b" body2="c" anchor=".2 0 0"/></equality>'
    s, opened = scene(FLOOR + hinge + loop + box(".05 .05 .05", "1 0 .049"), connect, tol=1e-6), 0.0
    for _ in range(1000):
        s.step()
        opened = max(opened, float(np.linalg.norm(s.data.efc_pos[s.data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)])))
    assert opened < 2e-4 and s.data.qpos[-5] == pytest.approx(0.05, abs=1e-6)
    assert s.stepper.contradictions == s.stepper.unsolved == s.stepper.fallbacks == 0
    assert np.abs(s.data.qvel[0]) < 1e-6
