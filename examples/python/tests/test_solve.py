from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stiction
from stiction import Mode, RowMode, Rows, Status

from judge import error, read

EYE, PUSH, W, MU = np.eye(3) * 2.0, np.array([0.03, 0.0, -0.02]), np.zeros((1, 3)), np.array([0.8])
H = np.array([[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])


@pytest.mark.parametrize("tol", [1e-4, 1e-9])
def test_solved_is_a_promise(bundled: dict[str, Any], tol: float) -> None:
    M, H, push, w, mu = read(bundled)
    found = stiction.solve(M, H, push, w, mu, tol=tol)
    if bundled["name"] == "infeasible_squeeze":
        assert found.status is Status.INFEASIBLE
        d = found.certificate[:, 0]
        assert d.min() >= 0 and not found.certificate[:, 1:].any()
        assert np.abs(d @ H[:, 0]).max() <= 1e-9 * d.max()
        assert d @ w[:, 0] < 0
        return
    assert found.solved and found.error <= tol
    assert error(M, H, push, w, mu, found.v, found.r) <= tol
    assert np.allclose(found.u, H @ found.v + w, atol=1e-9 * np.abs(found.v).max())


def test_an_error_is_an_error() -> None:
    found = stiction.solve(EYE, H, PUSH, W, MU, tol=1e-9)
    assert error(EYE, H, PUSH, W, MU, found.v, found.r * (1 + 1e-7)) > 1e-8


def test_modes_and_types() -> None:
    found = stiction.solve(EYE, H, PUSH, W, MU)
    assert found.modes.tolist() == [Mode.SLIP] and np.array_equal(found.modes == Mode.SLIP, [True])
    assert str(found.modes) == repr(found.modes[:]) == "[Mode.SLIP]" and repr(found.modes + 1) == "array([3], dtype=int8)"
    assert np.array_equal(found.forces(0.5), 2.0 * found.r)
    assert found.work.total > 0 and found.is_usable(0.0)
    assert np.allclose(found.r, [[0.02, -0.016, 0.0]])
    assert stiction.solve(EYE, H, PUSH, W, 2.0).modes.tolist() == [Mode.STICK]
    assert stiction.solve(EYE, H, -PUSH, W, MU).modes.tolist() == [Mode.OPEN]
    with pytest.raises(AttributeError):
        found.v = PUSH  # type: ignore[misc]


def test_lists_flat_rows_and_no_contacts_are_taken() -> None:
    found = stiction.solve(EYE.tolist(), H[0].tolist(), PUSH.tolist(), W[0].tolist(), MU.tolist(), tol=1e-9)
    assert np.array_equal(found.v, stiction.solve(EYE, H, PUSH, W, MU, tol=1e-9).v)
    free = stiction.solve(EYE, np.zeros((0, 3, 3)), PUSH, np.zeros((0, 3)), np.zeros(0))
    assert np.allclose(free.v, PUSH / 2.0)


def test_padding_changes_no_answer(bundled: dict[str, Any]) -> None:
    """A scene with velocities that nothing touches is the scene."""
    M, H, push, w, mu = read(bundled)
    n, more = len(M), 3
    wide = np.eye(n + more) * 0.7
    wide[:n, :n] = M
    a = stiction.solve(M, H, push, w, mu, tol=1e-9)
    b = stiction.solve(wide, np.pad(H, ((0, 0), (0, 0), (0, more))), np.pad(push, (0, more)), w, mu, tol=1e-9)
    assert a.status == b.status
    if a.solved:
        assert np.allclose(a.v, b.v[:n], atol=1e-6 * max(1.0, np.abs(a.v).max()))
        assert not b.v[n:].any()


def test_delassus() -> None:
    rng = np.random.default_rng(1)
    J = rng.normal(size=(12, 10))
    q, mu = rng.normal(size=(4, 3)), np.full(4, 0.5)
    given = stiction.solve_delassus(J @ J.T, q, mu, tol=1e-9)
    free = stiction.solve(np.eye(10), J, np.zeros(10), q, mu, tol=1e-9)
    assert given.solved and free.solved
    assert np.allclose(given.u, free.u, atol=1e-7)
    assert given.v.size == 0
    W = J @ J.T
    for wrong in (W[:9, :9], W[:, :9], W + np.diag(np.ones(11), 1), W - np.eye(12), W * np.nan):
        with pytest.raises(ValueError, match="^W:"):
            stiction.solve_delassus(wrong, q, mu)


def test_delassus_in_unlike_units() -> None:
    """Rows of 1e-8 of the others are still there."""
    rng = np.random.default_rng(2)
    J = rng.normal(size=(6, 6)) * np.repeat([1.0, 1e-8], 3)[:, None]
    q = rng.normal(size=(2, 3)) * [[1.0], [1e-8]]
    given = stiction.solve_delassus(J @ J.T, q, 0.5, tol=1e-9)
    free = stiction.solve(np.eye(6), J, np.zeros(6), q, 0.5, tol=1e-9)
    assert given.solved and free.solved
    assert np.allclose(given.u / [[1.0], [1e-8]], free.u / [[1.0], [1e-8]], atol=1e-6)


def test_rows() -> None:
    # A pendulum of 0.5 kg m² falls at 2 rad/s onto its stop; beside it dry friction and an equality.
    M, none = np.diag([0.5, 0.5, 0.5]), (np.zeros((0, 3, 3)), np.array([-1.0, 1.0, 1.0]), np.zeros((0, 3)), np.zeros(0))
    rows = Rows(np.eye(3), lower=[0.0, -0.25, -np.inf], upper=[np.inf, 0.25, np.inf], keys=[0, 1, 2])
    found = stiction.solve(M, *none, rows=rows, tol=1e-9)
    assert found.row_modes.tolist() == [RowMode.AT_LIMIT, RowMode.AT_LOWER, RowMode.HOLDING]
    assert np.allclose(found.row_impulses, [1.0, -0.25, -1.0])
    assert np.allclose(found.v, [0.0, 1.5, 0.0])
    W = np.diag([2.0, 2.0, 2.0])
    q = Rows(None, offset=[-2.0, 2.0, 2.0], lower=rows.lower, upper=rows.upper)
    assert np.allclose(stiction.solve_delassus(W, np.zeros((0, 3)), [], rows=q).row_impulses, [1.0, -0.25, -1.0])
    soft = stiction.solve(M, *none, rows=Rows(np.eye(3)[:1], compliance=2.0), tol=1e-9)
    assert np.allclose(soft.row_impulses, 2.0 / (2.0 + 2.0))  # s = v - v_free without: 2 rad/s over W + R


def test_rows_without_contacts() -> None:
    rows = Rows(jacobian=[[1.0, 0.0]], lower=-0.5, upper=0.5)  # dry friction
    for solution in (
        stiction.solve(np.eye(2), None, [2.0, 1.0], None, None, rows=rows),
        stiction.Kernel(2, 0, rows=1).solve(np.eye(2), None, [2.0, 1.0], None, None, rows=rows),
    ):
        assert solution.solved and solution.r.shape == (0, 3)
        np.testing.assert_allclose(solution.v, [1.5, 1.0], rtol=1e-6)
    with pytest.raises(ValueError, match="^mu: there is none"):
        stiction.solve(np.eye(3), np.eye(3)[None], np.zeros(3))


def test_offsets_are_zero_unless_they_are_given() -> None:
    told = stiction.solve(EYE, H, PUSH, W, MU)
    batch = stiction.solve_batch(EYE, H, np.stack([PUSH, PUSH]), mu=0.8)
    alike = (
        stiction.solve(EYE, H, PUSH, mu=0.8),
        stiction.solve(EYE, H[0], PUSH, mu=MU),
        stiction.Kernel(3, 1).solve(EYE, H, PUSH, mu=MU),
    )
    assert all(np.array_equal(found.v, told.v) for found in alike) and np.array_equal(batch.v, [told.v, told.v])
    assert np.array_equal(alike[1].jvp(w=[0.1, 0.0, 0.0]).v, told.jvp(w=[0.1, 0.0, 0.0]).v)


def test_contradictions_are_proved() -> None:
    rows = Rows([[1.0], [-1.0]], offset=-1.0)
    found = stiction.solve([[1.0]], np.zeros((0, 3, 1)), [0.0], np.zeros((0, 3)), [], rows=rows)
    assert found.status is Status.INFEASIBLE and not found.is_usable(1.0)
    assert np.all(found.row_certificate > 0)


def test_shapes_of_friction() -> None:
    push = np.array([0.03, 0.03, -0.02])
    track = stiction.solve(EYE, H, push, W, np.array([[0.9, 0.3]]), tol=1e-9)
    assert np.isclose((track.r[0, 1] / 0.9) ** 2 + (track.r[0, 2] / 0.3) ** 2, track.r[0, 0] ** 2)
    # A ball on its point turns about the normal, and a torsional coefficient brakes it.
    M, J = np.diag([1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3]), np.zeros((1, 4, 6))
    J[0, [0, 1, 2, 3], [2, 0, 1, 5]] = 1.0
    spin = np.array([0.0, 0.0, -0.01, 0.0, 0.0, 1e-3])
    found = stiction.solve(M, J, spin, np.zeros((1, 4)), [[0.5, 0.5, 0.02]], tol=1e-9)
    assert np.isclose(found.r[0, 3], -0.02 * 0.01)
    rolls = np.pad(J, ((0, 0), (0, 2), (0, 0)))
    same = stiction.solve(M, rolls, spin, np.zeros((1, 6)), [[0.5, 0.5, 0.02, 0.0, 0.0]], tol=1e-9)
    assert np.allclose(same.v, found.v)


def test_compliance() -> None:
    found = stiction.solve(EYE, H, PUSH, W, MU, compliance=[[0.5, 0.0]], tol=1e-9)
    assert np.isclose(found.r[0, 0], 0.01 / (0.5 + 0.5))  # q over W + R


def test_compliance_of_all_of_each_and_of_each_way_is_the_same() -> None:
    two, push = np.concatenate([H, H]), [0.03, 0.0, -0.02]
    full = stiction.solve(EYE, two, push, np.zeros((2, 3)), 0.8, compliance=[[0.5, 0.5], [0.25, 0.25]], tol=1e-9)
    each = stiction.solve(EYE, two, push, np.zeros((2, 3)), 0.8, compliance=[0.5, 0.25], tol=1e-9)
    assert np.array_equal(full.r, each.r) and full.r[1, 0] > full.r[0, 0]
    one = stiction.solve(EYE, two, push, np.zeros((2, 3)), 0.8, compliance=0.5, tol=1e-9)
    assert np.array_equal(one.r, stiction.solve(EYE, two, push, np.zeros((2, 3)), 0.8, compliance=[0.5, 0.5], tol=1e-9).r)
    assert one.jvp(w=[[0.1, 0.0, 0.0], [0.0, 0.0, 0.0]]).r[0, 0] != 0.0  # the scene is known as it was solved
    kernel = stiction.Kernel(3, 2, surfaces=True)
    assert np.array_equal(kernel.solve(EYE, two, push, np.zeros((2, 3)), 0.8, compliance=0.5, tol=1e-9).r, one.r)


def test_the_relaxed_law_lifts_off() -> None:
    assert stiction.solve(EYE, H, PUSH, W, MU, tol=1e-9, relaxed=True).u[0, 0] > 1e-3


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("M", {"M": np.eye(2)}),
        ("M", {"M": np.full((3, 3), np.nan)}),
        ("M", {"M": -EYE}),
        ("M", {"M": "heavy"}),
        ("M", {"M": EYE * 1j}),
        ("M", {"M": [[1.0, 2.0], [3.0]]}),
        ("H", {"H": H[:, :, :2]}),
        ("H", {"H": H + np.inf}),
        ("H", {"H": np.zeros((1, 5, 3))}),
        ("free_impulse", {"free_impulse": PUSH[:2]}),
        ("free_impulse", {"free_impulse": PUSH * np.nan}),
        ("w", {"w": np.zeros((2, 3))}),
        ("w", {"w": W * np.nan}),
        ("mu", {"mu": np.array([-1.0])}),
        ("mu", {"mu": np.ones((1, 3))}),
        ("tol", {"tol": -1.0}),
        ("tol", {"tol": "small"}),
        ("budget", {"budget": -1}),
        ("budget", {"budget": 0.5}),
        ("compliance", {"compliance": [[-1.0, 0.0]]}),
        ("compliance", {"compliance": [1.0, 2.0]}),
        ("compliance", {"compliance": -1.0}),
        ("rows", {"rows": Rows(np.eye(3), lower=1.0, upper=-1.0)}),
        ("rows.jacobian", {"rows": Rows(np.eye(2))}),
        ("rows.keys", {"rows": Rows(np.eye(3), keys=-1)}),
        ("rows.offset", {"rows": Rows(np.eye(3), offset=[1.0])}),
        ("rows", {"rows": np.eye(3)}),
        ("dtype", {"dtype": np.int32}),
        ("dtype", {"dtype": "floats"}),
        ("H", {"H": None}),
        ("free_impulse", {"free_impulse": None}),
    ],
)
def test_an_error_names_its_argument(name: str, change: dict[str, Any]) -> None:
    good: dict[str, Any] = {"M": EYE, "H": H, "free_impulse": PUSH, "w": W, "mu": MU}
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        stiction.solve(**{**good, **change})


def test_what_is_too_large_is_told_what_to_do() -> None:
    n = max(size[0] for size in stiction.SIZES) + 1
    with pytest.raises(ValueError, match="compiled"):
        stiction.solve(np.eye(n), np.zeros((1, 3, n)), np.zeros(n), W, MU)
    with pytest.raises(ValueError, match="compiled"):
        stiction.Kernel(3, 1000)


def test_a_jaw_that_jams_is_proved() -> None:
    H = np.array([[[np.sin(0.0873)], [np.cos(0.0873)], [0]]])
    found = stiction.solve(np.eye(1), H, [0.0], [[-0.1, 0, 0]], 1.0, tol=1e-6)
    assert found.status is Status.JAMMED and not found.is_usable(1.0)
    ((normal, x, y),) = found.certificate
    assert np.hypot(x, y) <= normal and abs(np.sum(H[0, :, 0] * found.certificate[0])) <= 1e-12 * normal


def test_one_coefficient_is_that_of_all_contacts() -> None:
    """Whose number tell offsets with an axis of contacts, or a Jacobian with one."""
    H, push = np.zeros((2, 3, 3)), [0.0, 0, -1]
    H[:, 0, 2] = H[:, 1, 0] = H[:, 2, 1] = 1.0
    for w in (np.zeros((2, 3)), np.zeros(6)):
        assert stiction.solve(np.eye(3), H, push, w, 0.5).status is stiction.Status.SOLVED
    with pytest.raises(ValueError, match="^w:"):
        stiction.solve(np.eye(3), H.reshape(6, 3), push, np.zeros(6), 0.5)
    with pytest.raises(ValueError, match="^w:"):
        stiction.solve_delassus(np.eye(6), np.zeros(6), 0.5)
