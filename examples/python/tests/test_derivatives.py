from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import stiction
from stiction import RowChange, Rows

from conftest import SCENES
from judge import read

EYE, PUSH, W, MU = np.eye(3) * 2.0, np.array([0.03, 0.0, -0.02]), np.zeros((1, 3)), np.array([0.8])
H = np.array([[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
TIGHT: dict[str, Any] = {"tol": 1e-12, "budget": 10_000}


def changes(rng: np.random.Generator, M: Any, H: Any, push: Any, w: Any, mu: Any) -> dict[str, Any]:
    """A random change of all data, and none of zeros: a leg in the air stays there."""
    half = rng.normal(size=M.shape) * np.sqrt(np.outer(np.diag(M), np.diag(M)))
    return {
        "M": (half + half.T) / 2 * (M != 0),
        "H": rng.normal(size=H.shape) * (H != 0),
        "free_impulse": rng.normal(size=push.shape) * np.abs(push).max(),
        "w": rng.normal(size=w.shape) * max(np.abs(push).max() / np.diag(M).max(), 1e-3),
        "mu": rng.normal(size=mu.shape) * mu,
    }


def moved(arguments: list[Any], change: dict[str, Any], share: float) -> list[Any]:
    return [array + share * change[name] for array, name in zip(arguments, ("M", "H", "free_impulse", "w", "mu"), strict=True)]


def test_forward_is_a_difference() -> None:
    tried = 0
    for path in SCENES:
        arguments = list(read(json.loads(path.read_text())))
        found = stiction.solve(*arguments, **TIGHT)
        if not found.is_usable(1e-9):
            continue
        change = changes(np.random.default_rng(1), *arguments)
        told = found.jvp(**change)
        if told.facts.margin < 1e-3 or not told.facts.has_unique_impulses:
            continue  # a change of mode is near, or hyperstatic legs cannot all keep their modes
        tried += 1
        share = 1e-5 * float(told.facts.margin)
        ends = [stiction.solve(*moved(arguments, change, steps * share), **TIGHT) for steps in (1, -1, 2, -2)]
        assert all(np.array_equal(end.modes, found.modes) for end in ends), path.stem
        for name in ("v", "r"):
            near, minus_near, far, minus_far = (getattr(end, name) for end in ends)
            difference = (8 * (near - minus_near) - (far - minus_far)) / (12 * share)  # of fourth order
            assert np.abs(getattr(told, name) - difference).max() <= 1e-6 * np.abs(difference).max(), (path.stem, name)
    assert tried >= 15


def test_a_block_that_slides() -> None:
    found = stiction.solve(EYE, H, PUSH, W, MU, **TIGHT)
    told = found.jvp(mu=1.0)
    assert np.allclose(told.v, [-0.01, 0, 0]) and np.allclose(told.r, [[0, -0.02, 0]])
    told = found.jvp(free_impulse=[0, 0, -1.0])
    assert np.allclose(told.v, [-0.4, 0, 0])
    told = found.jvp(M=np.eye(3))
    assert np.allclose(told.v, -found.v / 2)
    assert np.isclose(found.vjp(v=[1.0, 0, 0]).mu[0], -0.01)
    assert told.facts.has_unique_velocity and told.facts.margin > 0.1


def test_backward_is_the_transpose_of_forward(bundled: dict[str, Any]) -> None:
    arguments = list(read(bundled))
    found = stiction.solve(*arguments, **TIGHT)
    if not found.is_usable(1e-9):
        return
    rng = np.random.default_rng(2)
    change = changes(rng, *arguments)
    told = found.jvp(**change)
    weights: dict[str, Any] = {"v": rng.normal(size=found.v.shape), "r": rng.normal(size=found.r.shape)}
    gradient = found.vjp(**weights)
    forward = [(weights["v"] * told.v).sum(), (weights["r"] * told.r).sum()]
    backward = [(getattr(gradient, name) * own).sum() for name, own in change.items()]
    terms = np.abs(forward).sum() + np.abs(backward).sum()
    assert abs(sum(forward) - sum(backward)) <= 1e-7 * terms


def test_joint_rows() -> None:
    """A motor at its limit, and a stop that holds."""
    M, push = np.diag([1.0, 2.0]), np.array([1.0, -1.0])
    rows = Rows(jacobian=np.eye(2), lower=[-0.3, 0.0], upper=[0.3, np.inf])
    empty = (np.zeros((0, 3, 2)), push, np.zeros((0, 3)), np.zeros(0))
    found = stiction.solve(M, *empty, rows=rows, **TIGHT)
    assert np.allclose(found.v, [0.7, 0.0]) and np.allclose(found.row_impulses, [-0.3, 1.0])
    told = found.jvp(rows=RowChange(lower=[1.0, 0.0]))
    assert np.allclose(told.v, [1.0, 0.0]) and np.allclose(told.row_impulses, [1.0, 0.0])
    told = found.jvp(rows=RowChange(offset=[0.0, 1.0]))
    assert np.allclose(told.v, [0.0, -1.0])
    gradient = found.vjp(v=[1.0, 1.0]).rows
    assert (
        np.allclose(gradient.lower, [1.0, 0.0]) and np.allclose(gradient.upper, 0.0) and np.allclose(gradient.offset, [0.0, -1.0])
    )


def test_a_batch_is_its_scenes(trot: list[dict[str, Any]]) -> None:
    five = [step for step in map(read, trot) if len(step[4]) == len(read(trot[0])[4])][:5]
    arrays = [np.stack(part) for part in zip(*five, strict=True)]
    found = stiction.solve_batch(*arrays, tol=1e-9)
    told, gradient = found.jvp(mu=1.0), found.vjp(v=np.ones_like(found.v))
    for i, step in enumerate(five):
        alone = stiction.solve(*step, tol=1e-9)
        assert np.array_equal(alone.jvp(mu=1.0).v, told.v[i])
        one = alone.vjp(v=np.ones_like(alone.v))
        for name in ("M", "H", "free_impulse", "w", "mu"):
            assert np.array_equal(getattr(one, name), getattr(gradient, name)[i]), name
    assert told.facts.margin.shape == (len(five),)


def test_more_velocities_than_any_kernel() -> None:
    """As many coordinates as there are rows: forward is a difference, and backward its transpose; a batch is its scenes."""
    rng, (n, c, k) = np.random.default_rng(3), (90, 12, 5)
    half = rng.normal(size=(n, n))
    M, H, push = half @ half.T / n + np.eye(n), rng.normal(size=(c, 3, n)), 3 * rng.normal(size=n)
    w, mu, J = rng.normal(size=(c, 3)) * 0.1 + [0.3, 0, 0], np.full(c, 0.5), rng.normal(size=(k, n))
    change, turned = changes(rng, M, H, push, w, mu), rng.normal(size=J.shape)

    def solved(share: float) -> stiction.Solution:
        rows = Rows(J + share * turned, lower=-0.2, upper=0.3)
        return stiction.solve(*moved([M, H, push, w, mu], change, share), rows=rows, **TIGHT)

    found, (plus, minus) = solved(0.0), (solved(share) for share in (1e-7, -1e-7))
    assert set(found.modes) == {0, 2} and len(set(found.row_modes)) == 3
    told = found.jvp(**change, rows=RowChange(jacobian=turned))
    assert told.facts.margin > 0.05
    for name in ("v", "r", "row_impulses"):
        difference = (getattr(plus, name) - getattr(minus, name)) / 2e-7
        assert np.abs(getattr(told, name) - difference).max() <= 1e-6 * np.abs(difference).max(), name
    weights = {name: rng.normal(size=getattr(found, name).shape) for name in ("v", "r", "row_impulses")}
    gradient = found.vjp(**weights)
    forward = sum(float((own * getattr(told, name)).sum()) for name, own in weights.items())
    backward = sum(float((getattr(gradient, name) * own).sum()) for name, own in change.items())
    assert np.isclose(forward, backward + (np.asarray(gradient.rows.jacobian) * turned).sum(), rtol=1e-9)
    rows = Rows(J[None], lower=-0.2, upper=0.3)
    batch = stiction.solve_batch(M[None], H[None], np.stack([push, 1.1 * push]), w[None], mu[None], rows=rows, **TIGHT)
    assert np.allclose(batch.jvp(mu=1.0).v[0], found.jvp(mu=1.0).v, atol=1e-9)
    with pytest.raises(ValueError, match="^solution: no kernel looks into 90 velocities"):
        stiction.solve(M, np.concatenate([H, H, H]), push, np.tile(w, (3, 1)), np.tile(mu, 3)).jvp(mu=1.0)


def test_a_warm_start_changes_nothing() -> None:
    kernel = stiction.Kernel(3, 1)
    kernel.solve(EYE, H, PUSH * 1.1, W, MU, tol=1e-12)
    warm = kernel.solve(EYE, H, PUSH, W, MU, tol=1e-12)
    cold = stiction.solve(EYE, H, PUSH, W, MU, tol=1e-12)
    assert np.allclose(warm.jvp(mu=1.0).v, cold.jvp(mu=1.0).v, rtol=1e-9)


def test_what_has_no_derivative_says_so() -> None:
    found = stiction.solve(EYE, H, PUSH, W, MU)
    with pytest.raises(ValueError, match="^w: shape"):
        found.jvp(w=np.zeros((2, 3)))
    with pytest.raises(ValueError, match="^v: shape"):
        found.vjp(v=np.zeros(2))
    with pytest.raises(ValueError, match="^solution: its scene is not known"):
        stiction.solve_delassus(np.eye(3), PUSH, MU).jvp(mu=1.0)
    push = PUSH.copy()
    found = stiction.solve(EYE, H, push, W, MU)
    push *= -3.0
    with pytest.raises(ValueError, match="^solution: the arrays that were solved have changed"):
        found.jvp(mu=1.0)
    table = [[0.3, 0.3, 0], [-0.3, 0.3, 0], [0.3, -0.3, 0], [-0.3, -0.3, 0]]
    legs = np.array([[[0, 0, 1, y, -x, 0], [1, 0, 0, 0, 0, -y], [0, 1, 0, 0, 0, x]] for x, y, _ in table])
    stands = stiction.solve(np.eye(6), legs, np.array([0.0, 0, -1, 0, 0, 0]), np.zeros((4, 3)), 0.5)
    assert not stands.jvp(mu=1.0).facts.has_unique_impulses


JAX = """
import jax, numpy as np, stiction
jax.config.update("jax_enable_x64", True)
from stiction.jax import solve
M, push, w, mu = np.eye(3) * 2.0, np.array([0.03, 0.0, -0.02]), np.zeros((1, 3)), np.array([0.8])
H = np.array([[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
speed = lambda mu, push: solve(M, H, push, w, mu)[0][0]
by_mu, by_push = jax.grad(speed, argnums=(0, 1))(mu, push)
gradient = stiction.solve(M, H, push, w, mu, tol=1e-9).vjp(v=[1.0, 0, 0])
assert np.allclose(by_mu, gradient.mu) and np.allclose(by_push, gradient.free_impulse)
_, forward = jax.jvp(speed, (mu, push), (np.ones(1), np.array([1.0, 2, 3])))
assert np.allclose(forward, by_mu[0] + by_push @ np.array([1.0, 2, 3]))
for way in (jax.jacfwd, jax.jacrev):
    assert np.allclose(jax.jit(way(speed))(mu, push), by_mu)
both = jax.vmap(jax.grad(speed), in_axes=(0, None))(np.array([[0.8], [0.5]]), push)
assert np.allclose(both, [[-0.01], [-0.01]])
# Along x a motor at its limit of 0.003 N·s, along y a stop that holds; the gradient is that of the solution; numbers are arrays.
def limited(J, upper, push, softness=0.1):
    rows = stiction.Rows(J, lower=[-upper, 0.0], upper=[upper, np.inf])
    v, r = solve(M, H, push, None, 0.8, tol=1e-12, rows=rows, compliance=softness)
    return v[0] + 3 * r[0, 1]
J, upper, pushed = np.eye(3)[:2], 0.003, np.array([0.03, -0.01, -0.02])
found = stiction.solve(
    M, H, pushed, None, 0.8, tol=1e-12, rows=stiction.Rows(J, lower=[-upper, 0.0], upper=[upper, np.inf]), compliance=0.1
)
assert np.isclose(limited(J, upper, pushed), found.v[0] + 3 * found.r[0, 1], atol=1e-12) and found.row_modes.tolist() == [2, 1]
told = found.vjp(v=[1.0, 0, 0], r=[[0, 3.0, 0]])
by_J, by_upper, by_push = jax.grad(limited, argnums=(0, 1, 2))(J, upper, pushed)
assert np.allclose(by_J, told.rows.jacobian) and np.isclose(by_upper, told.rows.upper[0] - told.rows.lower[0]) and by_upper < -0.4
assert np.allclose(by_push, told.free_impulse)
assert np.isclose(jax.jacfwd(limited, argnums=1)(J, upper, pushed), by_upper)
assert np.allclose(jax.jit(jax.vmap(limited, (None, 0, None)))(J, np.array([upper, 0.0]), pushed)[0], limited(J, upper, pushed))
try:
    jax.grad(limited, argnums=3)(J, upper, pushed, 0.1)
    raise AssertionError("there is a derivative by compliance")
except ValueError as error:
    assert str(error).startswith("compliance: ")
# Joint rows alone; how far the answer of a loose tolerance is off.
alone = solve(M, None, pushed, rows=stiction.Rows(J, lower=-0.003, upper=0.003))
assert np.allclose(alone[0], [0.0135, -0.0035, -0.01]) and alone[1].shape == (0, 3)
legs = np.array([[[0, 0, 1, y, -x, 0], [1, 0, 0, 0, 0, -y], [0, 1, 0, 0, 0, x]] for x in (0.3, -0.3) for y in (0.3, -0.3)])
table = (np.eye(6), legs, np.array([0.01, 0.02, -1, 0.2, 0.3, 0.1]), None, 0.5)
off = [np.abs(solve(*table, tol=tol)[0] - stiction.solve(*table, tol=1e-12).v).max() for tol in (1e-3, 1e-12)]
assert off[0] > 1e-6 and off[1] < 1e-12, off
"""

TORCH = """
import numpy as np, torch
from stiction import Rows
from stiction.torch import solve
H = [[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]
scene = [np.eye(3) * 2.0, np.array(H), np.array([0.03, 0.0, -0.02]), np.zeros((1, 3))]
mu = torch.tensor([0.8], dtype=torch.float64, requires_grad=True)
solve(*map(torch.tensor, scene), mu)[0][0].backward()
assert np.allclose(mu.grad, [-0.01])
upper = torch.tensor(0.003, dtype=torch.float64, requires_grad=True)
rows = Rows(torch.eye(3, dtype=torch.float64)[:1], lower=-0.003, upper=upper)
v, r = solve(*map(torch.tensor, scene[:2]), -torch.tensor(scene[2]), None, 0.8, tol=1e-12, rows=rows, compliance=0.1)
v[0].backward()
assert np.allclose(v.detach(), [-0.0135, 0.0, 0.01]) and np.allclose(upper.grad, 0.5)
"""


@pytest.mark.parametrize(("name", "code"), [("jax", JAX), ("torch", TORCH)])
def test_learning_frameworks(name: str, code: str) -> None:
    """Each in a process of its own: other tests fork, and these start threads."""
    if importlib.util.find_spec(name) is None:
        pytest.skip(f"{name} is not installed")
    subprocess.run([sys.executable, "-c", code], check=True)
