"""Forces that mean something: least impulses, reserves, and what MuJoCo's arrays read."""

from __future__ import annotations

import json

import mujoco
import numpy as np
import pytest
from field import Array, G, scene

import stiction
from stiction.mujoco import Stepper

from conftest import SCENES
from judge import read

LEGS = "".join(
    f'<geom type="sphere" size=".02" pos="{0.2 * x} {0.2 * y} -.4" mass=".1" friction=".5"/>' for x in (-1, 1) for y in (-1, 1)
)
TABLE = f"""<geom type="plane" size="5 5 .1" friction=".5"/><body pos="0 0 .42"><freejoint/>
<geom type="box" size=".22 .22 .02" mass="5" contype="0" conaffinity="0"/>{LEGS}</body>"""
WEIGHT = 5.4 * G


def box_on_corners(push: float) -> tuple[Array, Array, Array, Array]:
    """A box of 2 kg on four corners, and its arrays; the push is a share of what friction bears, for a second."""
    corners = np.array([(x, y, -0.05) for x in (0.1, -0.1) for y in (0.1, -0.1)])
    H = np.zeros((4, 3, 6))
    for rows, (x, y, z) in zip(H, corners, strict=True):
        rows[:] = [[0, 0, 1, y, -x, 0], [1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x]]
    p = np.array([push * 0.5 * 2 * G, 0, -2 * G, 0, 0, 0])
    return np.diag([2.0, 2, 2, 0.01, 0.01, 0.01]), H, p, np.zeros((4, 3))


@pytest.mark.parametrize("tap", [0.0, 0.05, 1.0])
@pytest.mark.parametrize("h", [0.001, 0.002, 0.005])
def test_a_dragged_table_bears_on_all_its_feet(h: float, tap: float) -> None:
    s = scene(TABLE, h=h)
    s.run(0.2)
    s.data.xfrc_applied[1, :6] = [tap * 20, tap * 13, 0, tap * 3, tap * 2, 0]
    s.run(0.1)
    s.data.xfrc_applied[:] = 0
    s.run(0.5)
    forces: list[Array] = []
    for _ in range(round(0.5 / h)):
        mujoco.mj_kinematics(s.model, s.data)
        s.data.qfrc_applied[:] = 0
        force, place = [1.01 * 0.5 * WEIGHT, 0, 0], s.data.xpos[1] * [1, 1, 0]
        mujoco.mj_applyFT(s.model, s.data, force, [0, 0, 0], place, 1, s.data.qfrc_applied)
        s.step()
        own = np.zeros((4, 6))
        for index in range(s.data.ncon):
            mujoco.mj_contactForce(s.model, s.data, index, own[index])
        forces.append(own[:, 0].copy())
    # The centre is 0.4 m above the floor: what slides leans back by m a z / (4 x) a foot, on feet 0.2 m from it.
    lean = 5.4 * 0.01 * 0.5 * G * s.data.xpos[1, 2] / 0.8
    assert np.sort(forces[-1]) == pytest.approx(WEIGHT / 4 + lean * np.array([-1, -1, 1, 1]), abs=0.03)
    assert np.abs(np.diff(forces[10:], axis=0)).max() < 1e-4
    assert s.is_clean()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("tol", [1e-6, 1e-7, 1e-8])
@pytest.mark.parametrize("h", [0.002, 0.005])
def test_a_box_that_slides_bears_on_its_four_corners(h: float, tol: float, seed: int) -> None:
    slope, mu = np.radians(20), 0.2
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><option timestep="{h}" gravity="{G * np.sin(slope)} 0 {-G * np.cos(slope)}"/>
    <worldbody><geom type="plane" size="50 50 1" friction="{mu}"/><body pos="0 0 .05"><freejoint/>
    <geom type="box" size=".1 .07 .05" mass="2" friction="{mu}" condim="3"/></body></worldbody></mujoco>""")
    data, stepper = mujoco.MjData(model), Stepper(model, tol=tol)
    data.qvel[0] = 0.5 + 0.2 * seed
    load = 2 * G * np.cos(slope)
    lean = mu * load * 0.05 / 0.4  # friction at the floor tips it forward
    off = 0
    for _ in range(500):
        stepper.step(data)
        forces = np.sort(data.efc_force[[contact.efc_address for contact in data.contact]])  # along the normals
        off += forces.tolist() != pytest.approx(load / 4 + lean * np.array([-1, -1, 1, 1]), abs=1e-3)
    assert off <= 1 and stepper.unsolved == 0, off  # the first step lands it


@pytest.mark.parametrize("count", [4, 8])
@pytest.mark.parametrize("h", [0.001, 0.005])
def test_cables_share_a_platform(h: float, count: int) -> None:
    corners = [(x, y) for x in (-1, 1) for y in (-1, 1)]
    above = [((2 * x, 2 * y, 3), (0.3 * x, 0.3 * y, 0.2)) for x, y in corners]
    below = [((2 * x, 2 * y, 0), (0.3 * x, 0.3 * y, -0.2)) for x, y in corners]
    sites, own, tendons = "", "", ""
    for i, (a, b) in enumerate((above + below)[:count]):
        sites += f'<site name="a{i}" pos="{a[0]} {a[1]} {a[2]}"/>'
        own += f'<site name="b{i}" pos="{b[0]} {b[1]} {b[2]}"/>'
        length = np.linalg.norm(np.subtract(a, b) - [0, 0, 1.5])
        tendons += f'<spatial limited="true" range="0 {length}"><site site="a{i}"/><site site="b{i}"/></spatial>'
    platform = f'<body pos="0 0 1.5"><freejoint/><geom type="box" size=".3 .3 .2" mass="10"/>{own}</body>'
    s = scene(sites + platform, f"<tendon>{tendons}</tendon>", h=h)
    s.run(0.5)
    s.data.xfrc_applied[1, 0] = 0.02 if count == 4 else 30
    s.run(0.5)
    s.data.xfrc_applied[1, 0] = 0
    s.run(1.0)
    forces = np.zeros(count)
    for row in np.flatnonzero(s.data.efc_type == mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON):
        forces[s.data.efc_id[row]] = s.data.efc_force[row]
    along = np.subtract(*above[0]) - [0, 0, 1.5]
    each = 10 * G / 4 * np.linalg.norm(along) / along[2]
    # A platform on four cables sways a little for ever.
    assert forces[:4] == pytest.approx(np.full(4, each), rel=1e-3)
    assert np.abs(forces[4:]).max(initial=0.0) < 1e-3 * each


def test_least_impulses_have_no_past() -> None:
    M, H, p, w = box_on_corners(0.7)
    least = []
    for seed in range(3):
        kernel, random = stiction.Kernel(6, 4), np.random.default_rng(seed)
        for _ in range(5 * seed):
            kernel.solve(M, H, p * (1 + 0.3 * random.normal(size=6)) + random.normal(size=6), w, np.full(4, 0.5), tol=1e-9)
        found = kernel.solve(M, H, p, w, np.full(4, 0.5), tol=1e-9)
        assert found.solved and (found.modes == stiction.Mode.STICK).all()
        least.append(found.least())
        assert least[-1].momentum_error < 1e-9 and H.reshape(12, 6).T @ least[-1].r.ravel() == pytest.approx(-p, abs=1e-7)
    assert np.abs(least[0].r - least[1].r).max() < 1e-6 and np.abs(least[0].r - least[2].r).max() < 1e-6
    assert least[0].use.max() == pytest.approx(0.7 * 2 * G / 4 / (2 * G / 4 * (1 - 0.7 * 0.5 * 0.05 / 0.1)), abs=1e-6)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_reserves_are_those_of_statics(dtype: type) -> None:
    for push in (0.2, 0.8, 0.99):
        M, H, p, w = box_on_corners(push)
        found = stiction.solve(M, H, p, w, 0.5, tol=1e-5, dtype=dtype)
        assert found.slip_reserve() == pytest.approx(push, rel=1e-3)
        assert stiction.rest_reserve(M, H, p, 0.5) == pytest.approx(push, rel=1e-3)
        further = found.load_reserve([1, 0, 0, 0, 0, 0])
        assert further == pytest.approx((1 - push) * 0.5 * 2 * G, rel=1e-2)
    M, H, p, w = box_on_corners(1.5)
    assert stiction.rest_reserve(M, H, p, 0.5) == pytest.approx(1.5, rel=1e-3)
    p[4] = 2.0  # and tips
    assert stiction.rest_reserve(M, H, p, 0.5) == np.inf
    with pytest.raises(ValueError, match=r"^load: shape \[2\] is not \[6\]"):
        found.load_reserve([1.0, 2.0])
    with pytest.raises(ValueError, match=r"entry \(0, 0\) is not finite"):
        found.load_reserve([np.nan] * 6)
    with pytest.raises(ValueError, match=r"^H: shape \[12, 6\]"):
        stiction.rest_reserve(M, H.reshape(12, 6), p, 0.5)


def test_a_solution_knows_the_arrays_that_were_solved() -> None:
    M, H, p, w = box_on_corners(0.7)
    found = stiction.solve(M, H, p, w, np.full(4, 0.5), tol=1e-9)
    mass = M * 2
    M *= 2  # where it stands: nothing of the impulses tells
    changed = pytest.raises(ValueError, match="^solution: the arrays that were solved have changed")
    for call in (
        found.least,
        found.slip_reserve,
        lambda: found.load_reserve(p),
        lambda: found.vjp(v=p),
        lambda: found.jvp(free_impulse=p),
    ):
        with changed:
            call()
    M /= 2
    assert (mass / 2 == M).all() and found.least().momentum_error < 1e-8
    batch = stiction.solve_batch(M[None], H[None], p[None], w[None], np.full((1, 4), 0.5), tol=1e-9)
    assert batch.vjp(v=p[None]).M.shape == (1, 6, 6)
    p[0] += 1e-9
    with changed:
        batch.vjp(v=p[None])
    # Three steps in one buffer: the derivatives of the first are those of the first, or none.
    x, m = np.zeros((0, 3, 1)), np.ones((1, 1))
    first = stiction.solve(m, x, [1.0], np.zeros((0, 3)), np.zeros(0))
    m[:] = 2.0
    with changed:
        first.vjp(v=[1.0])


def test_a_refused_solve_leaves_the_scene_that_can_go_on() -> None:
    M, H, p, w = box_on_corners(0.7)
    kernel, mu = stiction.Kernel(6, 4), np.full(4, 0.5)
    paused = kernel.solve(M, H, p, w, mu, tol=1e-9, budget=1)
    with pytest.raises(ValueError, match="^tol"):
        kernel.solve(2 * M, H, p, w, mu, tol="x")  # type: ignore[arg-type]
    found = kernel.resume(tol=1e-9, budget=5000)
    assert not paused.solved and found.solved
    expected = stiction.solve(M, H, p, w, mu, tol=1e-9).vjp(v=np.eye(6)[0])
    assert found.vjp(v=np.eye(6)[0]).free_impulse == pytest.approx(expected.free_impulse, abs=1e-6)


@pytest.mark.parametrize(("name", "share"), [("card_house", 0.6109), ("g1_single_support", 0.2415), ("go2_trot_mixed", 0.4839)])
def test_what_sticks_has_a_reserve_while_something_else_slips(name: str, share: float) -> None:
    # With a thousandth less none of them balances: a second-order cone solver says so.
    path = next(path for path in SCENES if path.stem == name)
    found = stiction.solve(*read(json.loads(path.read_text())), tol=1e-9, budget=5000)
    assert found.solved and found.slip_reserve() == pytest.approx(share, abs=1e-4)
