"""Impacts, arches and toys by the kernel, at once: closed forms, limit analysis, energy."""

from __future__ import annotations

import numpy as np
import pytest
from field import Array, G

import stiction
from stiction import Status


def bounced(v: Array, w: Array, restitution: float, mu: float, R: float, m: float) -> tuple[Array, Array]:
    """Routh: P = (1 + e) m |v_n|; friction min(mu P, 2/7 m |u|) against u, as a sphere has 2/5 m R^2."""
    u = (v + np.cross(w, [0, 0, -R])) * [1, 1, 0]
    normal = (1 + restitution) * m * -v[2]
    size = float(np.linalg.norm(u))
    rub = -u / size * min(mu * normal, 2 / 7 * m * size)
    return v + (rub + np.array([0, 0, normal])) / m, w + np.cross([0, 0, -R], rub) / (0.4 * m * R * R)


@pytest.mark.parametrize(("dtype", "tol", "off"), [(np.float64, 1e-10, 1e-9), (np.float32, 1e-5, 1e-3)])
def test_a_superball_bounces_as_on_paper(dtype: type, tol: float, off: float) -> None:
    R, m, random = 0.05, 0.1, np.random.default_rng(0)
    M = np.diag([m] * 3 + [0.4 * m * R * R] * 3)
    H = np.array([[[0, 0, 1.0, 0, 0, 0], [1, 0, 0, 0, -R, 0], [0, 1, 0, R, 0, 0]]])
    for _ in range(500):
        v, w = 3 * random.normal(size=3), 60 * random.normal(size=3)
        v[2] = -abs(v[2]) - 0.1
        e, mu = random.uniform(), random.uniform(0, 1.2)
        found = stiction.solve(M, H, M @ np.r_[v, w], [[e * v[2], 0, 0]], mu, tol=tol, dtype=dtype)
        along, about = bounced(v, w, e, mu, R, m)
        assert found.status is Status.SOLVED
        assert np.abs(found.v[:3] - along).max() < off and R * np.abs(found.v[3:] - about).max() < off
        assert found.v @ M @ found.v < (1 + 10 * tol) * (M @ np.r_[v, w]) @ np.r_[v, w]


def test_a_linkage_that_strikes_the_ground_without_a_bounce_loses_energy() -> None:
    """Kane and Levinson's double pendulum, in its plane. With e > 0 and friction, Newton's law of restitution may add to it."""
    random = np.random.default_rng(1)
    for _ in range(500):
        a, b = random.uniform(-1.2, 1.2, 2)
        before, mu = random.normal(size=2), random.uniform(0, 1.5)
        middles = [(0.5, 0.0), (1.0, 0.5)]

        def lever(p: float, q: float, a: float = a, b: float = b) -> Array:
            """Of a point that is p along the first rod and q along the second: rows x, z."""
            return np.array([[np.cos(a) * p, np.cos(b) * q], [np.sin(a) * p, np.sin(b) * q]])

        M = sum((lever(p, q).T @ lever(p, q) for p, q in middles), np.eye(2) / 12)
        H = lever(1, 1)[None, ::-1]
        for e, rough in ((0.0, mu), (random.uniform(), 0.0)):
            speed = min(float(H[0, 0] @ before), 0.0)
            found = stiction.solve(M, H, M @ before, np.array([[e * speed, 0.0]]), rough, tol=1e-9)
            assert found.status is Status.SOLVED and found.v @ M @ found.v < (1 + 1e-8) * before @ M @ before


def arch(thickness: float, voussoirs: int = 13, h: float = 1e-3) -> tuple[Array, Array, Array]:
    """A dry semicircle of mean radius 1: mass, Jacobians and the impulse of weight in a step from rest."""
    outer, inner, width = 1 + thickness / 2, 1 - thickness / 2, 0.3
    turn = np.pi / voussoirs
    mass = 2000 * width * turn * (outer**2 - inner**2) / 2
    middle = 2 / 3 * np.sin(turn / 2) / (turn / 2) * (outer**3 - inner**3) / (outer**2 - inner**2)
    inertia = mass * (outer**2 + inner**2) / 2 - mass * middle**2
    centres = [middle * np.array([np.cos(angle), 0, np.sin(angle)]) for angle in turn * (np.arange(voussoirs) + 0.5)]
    rows = []
    for joint in range(voussoirs + 1):
        c, s = np.cos(joint * turn), np.sin(joint * turn)
        frame = np.array([[-s, 0, c], [c, 0, s], [0, 1, 0]])
        for r, y in ((r, y) for r in (inner, outer) for y in (-width / 2, width / 2)):
            row = np.zeros((3, 6 * voussoirs))
            for block, sign in ((joint, 1), (joint - 1, -1)):
                if 0 <= block < voussoirs:
                    row[:, 6 * block : 6 * block + 3] = sign * frame
                    row[:, 6 * block + 3 : 6 * block + 6] = sign * np.cross([r * c, y, r * s] - centres[block], frame)
            rows.append(row)
    M = np.diag(np.tile([mass] * 3 + [inertia] * 3, voussoirs))
    return M, np.array(rows), np.tile([0, 0, -mass * G * h, 0, 0, 0], voussoirs)


@pytest.mark.parametrize("share", [0.9, 0.99, 0.998, 1.002, 1.01, 1.1, 2.0])
def test_an_arch_stands_from_its_critical_thickness_on(share: float) -> None:
    """0.10284 of its radius with 13 voussoirs, by linear programming of what cones admit; Milankovitch's 0.1075 is that of many."""
    M, H, weight = arch(0.1028357 * share)
    found = stiction.solve(M, H, weight, np.zeros((len(H), 3)), 0.8, tol=1e-8)
    assert found.status is Status.SOLVED
    fastest = np.abs(found.v).max() / (G * 1e-3)
    assert fastest < 1e-5 if share > 1 else fastest > 1e-4
    if share > 1:
        lifted = [
            sum(float(H[c, :, 6 * block + 2] @ found.r[c]) for c in own) for own, block in ((range(4), 0), (range(52, 56), 12))
        ]
        assert lifted == pytest.approx([-weight.sum() / 2] * 2, rel=1e-4)


# Glocker's woodpecker: heights of sleeve and bird (m, rad), tiny inertias; it hits the pole with its beak, and its sleeve jams.
SLEEVE, BIRD = (3e-4, 5e-9), (4.5e-3, 7e-7)
SPRING, POLE, RIM, HALF, BEAK = 5.6e-3, 2.5e-3, 3.1e-3, 5.8e-3, 0.02
TO_SPRING, TO_BIRD, TO_BEAK = 0.010, 0.015, 0.0201


def woodpecker(h: float, time: float, dtype: type = np.float64, tol: float = 1e-9) -> tuple[float, float, int]:
    """The period and the fall in it, of the last five, and how many steps were not solved."""
    m, J = BIRD
    M = np.array(
        [
            [m + SLEEVE[0], m * TO_SPRING, m * TO_BIRD],
            [m * TO_SPRING, SLEEVE[1] + m * TO_SPRING**2, m * TO_SPRING * TO_BIRD],
            [m * TO_BIRD, m * TO_SPRING * TO_BIRD, J + m * TO_BIRD**2],
        ]
    )
    H = np.array(
        [
            [[0, 0, -BEAK], [1, TO_SPRING, TO_BIRD - TO_BEAK]],
            [[0, HALF, 0], [1, RIM, 0]],
            [[0, -HALF, 0], [1, RIM, 0]],
        ]
    )
    stiffness = SPRING * np.array([[0, 0, 0], [0, 1, -1], [0, -1, 1]])
    weight = -G * np.array([m + SLEEVE[0], m * TO_SPRING, m * TO_BIRD])
    q, v = np.array([0, -0.1036, -0.2788]), np.array([-0.3411, 0, -7.4583])
    hits, wrong = [], 0
    for step in range(round(time / h)):
        gaps = np.array([TO_SPRING + TO_BIRD - TO_BEAK - POLE - BEAK * q[2], RIM - POLE + HALF * q[1], RIM - POLE - HALF * q[1]])
        w = np.zeros((3, 2))
        w[:, 0] = np.maximum(gaps, 0) / h
        speed = float(H[0, 0] @ v)
        if w[0, 0] + speed <= 0 and speed < -0.02:
            w[0, 0] = 0.5 * speed
            hits.append((step * h, q[0]))
        found = stiction.solve(M + h * h * stiffness, H, M @ v + h * (weight - stiffness @ q), w, 0.3, tol=tol, dtype=dtype)
        wrong += found.status is not Status.SOLVED
        v = np.asarray(found.v, float)
        q = q + h * v
    period, fall = np.diff(hits[-6:], axis=0).mean(axis=0)
    return float(period), float(fall), wrong


def test_a_woodpecker_pecks_seven_times_a_second() -> None:
    """0.1453 s a period as steps vanish; from two steps, of which the error is of first order."""
    (coarse, _, wrong), (fine, fall, wrong_too) = woodpecker(1e-4, 1.2), woodpecker(5e-5, 1.2)
    assert wrong == wrong_too == 0
    assert 2 * fine - coarse == pytest.approx(0.1453, abs=1e-3) and fall < -5e-3


def test_a_woodpecker_pecks_in_single_precision() -> None:
    """Inertias of 5e-9 kg m^2, to what digits allow."""
    double, single = woodpecker(1e-4, 1.2), woodpecker(1e-4, 1.2, np.float32, 1e-4)
    assert single[2] == 0 and single[0] == pytest.approx(double[0], rel=0.02)
