"""How a step of MuJoCo's models moves with the state and the controls before it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import mujoco
import numpy as np

from ._derivative import Facts
from ._near import Near, Pose
from ._types import Array

if TYPE_CHECKING:
    from .mujoco import Stepper


class Derivatives(NamedTuple):
    """How the state after a step moves with the state and the controls before it, as ``mujoco.mjd_transitionFD`` lays it out.

    A state is a position in its tangent space, velocities, activations: ``2 nv + na`` numbers.
    """

    #: ``(2 nv + na, 2 nv + na)``, with the state before.
    A: Array
    #: ``(2 nv + na, nu)``, with the controls.
    B: Array
    #: How near the next change of a mode is, and what is unique. Without contacts and rows the margin is infinite.
    facts: Facts


def derivatives(stepper: Stepper, data: mujoco.MjData, eps: float, tol: float) -> Derivatives:
    """Differentiate the step that a stepper takes, which is cold; ``tol`` is the error up to which it counts as solved."""
    before = (stepper.fallbacks, stepper.contradictions, stepper.crowded)
    near = Near(stepper, data, eps)
    if before != (stepper.fallbacks, stepper.contradictions, stepper.crowded) or not stepper.error <= tol:
        raise ValueError("data: the step has no exact solution, or none is found")
    nv = near.model.nv
    first, last = near.laws
    changes = _changes(near)
    by = last.velocity(near.last, changes[1])
    if near.sees(Pose.FIRST):
        by = by + first.velocity(near.first, changes[0]) @ _by_way(near, Pose.FIRST)
    if near.sees(Pose.END):
        by = by @ np.linalg.inv(np.eye(nv) - _by_way(near, Pose.END))
    activations = changes[1][:, changes[1].shape[1] - near.model.na :]
    both = np.concatenate([_positions(near, by), by, activations], axis=1).T
    states = 2 * nv + near.model.na
    return Derivatives(both[:, :states].copy(), both[:, states:].copy(), last.facts)


def _changes(near: Near) -> tuple[Array, Array]:
    """How the equations of the first motion and of the last move with state and controls: a line for each of these."""
    model, start, eps = near.model, near.start, near.eps
    lines: tuple[list[Array], list[Array]] = ([], [])

    def add(name: str, ends: tuple[Array, Array], between: float) -> None:
        plus, minus = (near.seen(**{name: end}) for end in ends)
        for line, motion in zip(lines, (near.first, near.last), strict=True):
            line.append((motion.equations(plus) - motion.equations(minus)) / between)

    for turn in np.eye(model.nv):
        add("qpos", (near.integrated(start.qpos, turn, eps), near.integrated(start.qpos, turn, -eps)), 2 * eps)
    for name in ("qvel", "act", "ctrl"):
        before: Array = getattr(start, name)
        low, high = np.full((2, len(before)), [[-np.inf], [np.inf]])
        if name == "ctrl":  # which MuJoCo holds in its range
            is_limited = model.actuator_ctrllimited.astype(bool)
            low[is_limited], high[is_limited] = model.actuator_ctrlrange[is_limited].T
        for i in range(len(before)):
            plus, minus = before.copy(), before.copy()
            plus[i], minus[i] = (np.clip(before[i] + step, low[i], high[i]) for step in (eps, -eps))
            add(name, (plus, minus), max(plus[i] - minus[i], eps))
    return np.array(lines[0]), np.array(lines[1])


def _by_way(near: Near, pose: Pose) -> Array:
    """How the velocity moves with the one that leads to a pose, by the contacts that are seen there."""
    lines = []
    for step in near.eps * np.eye(near.model.nv):
        plus, minus = (near.last.equations(near.seen_from(pose, near.ways[pose] + sign * step)) for sign in (1, -1))
        lines.append((plus - minus) / (2 * near.eps))
    return near.laws[1].velocity(near.last, np.array(lines))


def _positions(near: Near, by: Array) -> Array:
    """How positions at the end move, in their tangent space, where velocities move by these lines."""
    start, eps, nv = near.start, near.eps, near.model.nv
    moved, turns = np.zeros_like(by), np.zeros_like(by)
    turns[:nv] = np.eye(nv)
    for own, line, turn in zip(moved, by, turns, strict=True):
        for sign in (eps, -eps):
            position = near.integrated(near.integrated(start.qpos, turn, sign), near.last.v + sign * line)
            difference = np.zeros(nv)
            mujoco.mj_differentiatePos(near.model, difference, 2 * sign, near.end.qpos, near.integrated(position, near.shift))
            own += difference
    return moved
