"""The helpers of a time step: what the Rust library's documentation asserts, and the scenes of its guide."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf, nan
from typing import Any

import numpy as np
import pytest

import stiction
from stiction import Mode, RowMode, Rows
from stiction.time_stepping import (
    ClosedLoop,
    DryFriction,
    Gap,
    JointLimit,
    Motor,
    Restitution,
    Spring,
    StaticFriction,
    Suction,
    contact_frame,
    contact_rows,
    free_impulse,
    moving_surface,
)


def numbers(rows: Rows) -> list[Any]:
    return [rows.offset, rows.lower, rows.upper, rows.compliance, rows.keys]


def test_frames_of_any_normal() -> None:
    np.testing.assert_array_equal(contact_frame([0, 0, 1.0]), [[0, 0, 1], [1, 0, 0], [0, 1, 0]])  # the tangents are the first axes
    normal = np.array([2.0, -1.0, 2.0]) / 3.0
    frame = contact_frame(normal)
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(frame[0], normal, atol=1e-15)
    corner = np.array([[1.0, 0.0, 0.25], [0.0, 1.0, -0.5]])  # of a plate, from (x, height, angle)
    np.testing.assert_array_equal(contact_rows([0.0, 1.0], corner)[0], corner[1])
    with pytest.raises(ValueError, match="^normal: "):
        contact_frame([0.0, 2.0])
    with pytest.raises(ValueError, match="^normal: "):
        contact_frame([1.0])
    with pytest.raises(ValueError, match="^velocity: "):
        contact_rows(normal, corner)


def test_offsets() -> None:
    near = Gap(recovery=0.1, reach=3.0)
    assert [replace(near, distance=far).offset(0.25) for far in (0.5, -0.5, 8.0)] == [2.0, -0.1, 3.0]
    assert Gap(-0.5).offset(0.25) == 0.0 and Gap(-0.5, recovery=inf).offset(0.25) == -2.0 and Gap(8.0) == Gap(8.0, 0.0, inf)
    ball = Restitution(coefficient=0.5, threshold=0.25)
    assert [ball.offset(-3.0, 0.0), ball.offset(-0.125, 0.0), ball.offset(-3.0, Gap(1.0).offset(0.25))] == [-1.5, 0.0, 4.0]
    rubber = Spring(stiffness=2.0, relaxation=0.25)
    assert rubber.compliance(0.25) == 4.0 and rubber.offset(Gap(-0.25, recovery=0.1), 0.25) == -0.5
    frame = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    assert moving_surface(frame, [0.5, 0.0, 0.0]).tolist() == [0.0, -0.5, 0.0]
    assert free_impulse(2.0 * np.eye(2), [1.0, 0.0], [0.0, -16.0], 0.5).tolist() == [2.0, -8.0]
    wood = StaticFriction(at_rest=0.5, sliding=0.3)
    assert [wood.mu(last) for last in (Mode.SLIP, np.int8(2), Mode.STICK, Mode.OPEN, None)] == [0.3, 0.3, 0.5, 0.5, 0.5]


def test_rows() -> None:
    assert JointLimit is Gap
    assert numbers(JointLimit(0.125, recovery=0.5).row([0.0, 1.0], 0.25, 7)) == [0.5, 0.0, inf, 0.0, 7]
    assert numbers(DryFriction(0.5).row([1.0], 0.25)) == [0.0, -0.125, 0.125, 0.0, 0]
    knee = Motor(stiffness=4.0, damping=1.0, limit=8.0, ahead=0.5)
    assert numbers(knee.row([1.0], 0.25)) == [1.0, -2.0, 2.0, 2.0, 0]
    assert numbers(replace(knee, limit=inf).row([1.0], 0.25)) == [1.0, -inf, inf, 2.0, 0]
    assert Motor(4.0, 1.0, 0.0, 8.0, 0.5, 0.0) == knee
    finger = ClosedLoop(drift=0.5, recovery=1.0).row([1.0, -1.0], 0.25)
    assert numbers(finger) == [1.0, -inf, inf, 0.0, 0] and np.array_equal(finger.jacobian, [[1.0, -1.0]])  # type: ignore[arg-type]


def test_motor_and_stop_of_the_guide() -> None:
    step, motor = 1e-3, Motor(stiffness=400.0, damping=20.0, limit=30.0, ahead=0.3)
    stop = JointLimit(0.0, recovery=0.1, reach=100.0).row([0.0, 1.0], step, 1)
    none = np.zeros((0, 3, 2)), [0.0, -0.1], np.zeros((0, 3)), np.zeros(0)
    kernel = stiction.Kernel(2, 0, rows=2)

    def solve(motor: Motor) -> stiction.Solution:
        return kernel.solve(np.diag([0.2, 0.05]), *none, rows=Rows.of(motor.row([1.0, 0.0], step), stop), tol=1e-9)

    found = solve(motor)
    assert found.solved and found.row_impulses[0] / step == pytest.approx(-30.0, rel=1e-12)  # N·m
    assert found.row_modes.tolist() == [RowMode.AT_LOWER, RowMode.AT_LIMIT]
    found = solve(replace(motor, ahead=0.02))
    torque = -400.0 * (0.02 + step * found.v[0]) - 20.0 * found.v[0]
    assert found.row_modes[0] == RowMode.HOLDING and found.row_impulses[0] / step == pytest.approx(torque, rel=1e-9)


def test_what_falls_comes_to_rest_on_the_floor() -> None:
    mass, h, H = 2.0 * np.eye(2), 0.001, [[[0.0, 1.0], [1.0, 0.0]]]
    position, v, kernel = np.array([0.0, 0.01]), np.array([1.0, 0.0]), stiction.Kernel(2, 1, dim=2)
    for _ in range(1000):
        w = [[Gap(position[1], recovery=0.1, reach=10.0).offset(h), 0.0]]
        v = kernel.solve(mass, H, free_impulse(mass, v, [0.0, -2.0 * 9.81], h), w, mu=0.4, tol=1e-9).v
        position = position + h * v
    assert np.linalg.norm(v) < 1e-9 and abs(position[1]) < 1e-9 and position[0] > 0.1


def test_a_suction_cup_holds_and_lets_go() -> None:
    step, H, push = 0.5, np.array([[[-1.0]]]), np.array([-9.81 * 0.5])
    for force in (16.0, 8.0):
        cup = Suction(force=force, touches=True)
        found = stiction.solve([[1.0]], H, cup.push_back(H[0], step, push), [[0.0]], 0.0, tol=1e-9)
        pull = cup.impulse(found.r[0], step)
        assert pull[0] == pytest.approx(-min(9.81, force) * step, abs=1e-8) and push[0] == -9.81 * step
        assert (abs(found.v[0]) < 1e-9) == (force > 9.81)
    away = Suction(force=16.0, touches=False)
    assert away.push_back(H[0], step, push).tolist() == push.tolist() and away.impulse([2.0, 1.0], step).tolist() == [2.0, 1.0]


REFUSED: list[tuple[str, Callable[[], Any]]] = [
    ("distance: gap is NaN", lambda: Gap(nan).offset(0.1)),
    ("distance: distance of a joint", lambda: JointLimit(nan).row([1.0], 0.1)),
    ("distance", lambda: Gap("far").offset(0.1)),  # type: ignore[arg-type]
    ("recovery", lambda: Gap(0.0, recovery=-1.0).offset(0.1)),
    ("reach", lambda: Gap(0.0, reach=nan).offset(0.1)),
    ("step", lambda: Gap(0.0).offset(0.0)),
    ("step", lambda: DryFriction(1.0).row([1.0], None)),  # type: ignore[arg-type]
    ("torque", lambda: DryFriction(-1.0).row([1.0], 0.1)),
    ("row", lambda: DryFriction(1.0).row([[1.0]], 0.1)),
    ("stiffness: gains", lambda: Motor().row([1.0], 0.1)),
    ("stiffness", lambda: Motor(stiffness=-1.0).row([1.0], 0.1)),
    ("damping", lambda: Motor(damping=inf).row([1.0], 0.1)),
    ("feedforward", lambda: Motor(damping=1.0, feedforward=nan).row([1.0], 0.1)),
    ("limit", lambda: Motor(damping=1.0, limit=-1.0).row([1.0], 0.1)),
    ("ahead", lambda: Motor(damping=1.0, ahead=inf).row([1.0], 0.1)),
    ("target", lambda: Motor(damping=1.0, target=nan).row([1.0], 0.1)),
    ("drift", lambda: ClosedLoop(inf).row([1.0], 0.1)),
    ("coefficient", lambda: Restitution(1.5, 0.0).offset(-1.0, 0.0)),
    ("threshold", lambda: Restitution(0.5, -1.0).offset(-1.0, 0.0)),
    ("approach", lambda: Restitution(0.5, 0.0).offset(nan, 0.0)),
    ("gap_offset", lambda: Restitution(0.5, 0.0).offset(-1.0, inf)),
    ("stiffness", lambda: Spring(0.0, 0.1).compliance(0.1)),
    ("relaxation", lambda: Spring(1.0, -0.1).offset(Gap(0.0), 0.1)),
    ("gap", lambda: Spring(1.0, 0.1).offset(0.0, 0.1)),  # type: ignore[arg-type]
    ("force", lambda: Suction(-1.0, True).impulse([1.0], 0.1)),
    ("jacobian", lambda: Suction(1.0, True).push_back([1.0], 0.1, [1.0])),
    ("free_impulse", lambda: Suction(1.0, True).push_back([[1.0, 0.0]], 0.1, [1.0])),
    ("solved", lambda: Suction(1.0, True).impulse([], 0.1)),
    ("mass", lambda: free_impulse([1.0], [1.0], [1.0], 0.1)),
    ("velocity", lambda: moving_surface(np.eye(3), [1.0])),
    ("force", lambda: free_impulse(np.eye(2), [1.0, 1.0], 1.0, 0.1)),
    ("parts", lambda: Rows.of()),
    ("parts", lambda: Rows.of(Rows([[1.0]]), Rows([[1.0, 0.0]]))),
]


@pytest.mark.parametrize(("name", "call"), REFUSED)
def test_errors_begin_with_a_name(name: str, call: Callable[[], Any]) -> None:
    with pytest.raises(ValueError, match=f"^{name}"):
        call()


def test_rows_join_in_order_with_their_keys() -> None:
    joined = Rows.of(
        Rows(np.eye(3), upper=[1.0, 2.0, 3.0], keys=[7, 8, 9]), ClosedLoop(0.5, recovery=1.0).row([1.0, -1.0, 0.0], 0.5, 2)
    )
    assert np.array_equal(joined.jacobian, [*np.eye(3), [1.0, -1.0, 0.0]])  # type: ignore[arg-type]
    assert np.array_equal(joined.upper, [1.0, 2.0, 3.0, inf]) and np.array_equal(joined.lower, [0.0, 0.0, 0.0, -inf])
    assert np.array_equal(joined.keys, [7, 8, 9, 2]) and np.array_equal(joined.offset, [0.0, 0.0, 0.0, 1.0])
