"""How a step of MuJoCo's models moves with the state and the controls before it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import mujoco
import numpy as np

from ._derivative import Facts
from ._near import Near
from ._tries import Try, tries
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
    #: How near the next change of a mode is, and what is unique. Without contacts and rows the margin is infinite. It tells nothing
    #: of what is not met in the step, nor that a contact at rest has another derivative where it is pressed in.
    facts: Facts


def derivatives(stepper: Stepper, data: mujoco.MjData, eps: float, tol: float) -> Derivatives:
    """Differentiate the step that a stepper takes, which is cold; ``tol`` is the error up to which it counts as solved."""
    if (stepper.model.actuator_trntype == mujoco.mjtTrn.mjTRN_BODY).any():
        raise ValueError("model: adhesion acts by the contacts that are listed, which has no derivative here")
    before = (stepper.fallbacks, stepper.contradictions, stepper.crowded)
    near = Near(stepper, data, eps)
    if stepper._own.is_soft:
        raise ValueError("data: in the step are contacts or equalities that are soft, which have no derivative here")
    if before != (stepper.fallbacks, stepper.contradictions, stepper.crowded) or not stepper.error <= tol:
        raise ValueError("data: the step has no exact solution, or none is found")
    moved: Array = np.zeros((2, 0, 0))
    for own in tries(near):
        changes = _changes(near, own)
        both = own.velocities(changes)
        if own.way is not None:
            both += moved.sum(axis=0) @ own.velocities(_changes_by_way(near, own))
        moved = both
    by, by_shift = moved
    size = changes.shape[1] - own.shift.size
    activations = changes[:, size - near.model.na : size]
    both = np.concatenate([_positions(near, by, by_shift), by, activations], axis=1).T
    states = 2 * near.model.nv + near.model.na
    return Derivatives(both[:, :states].copy(), both[:, states:].copy(), own.law.facts)


def _changes(near: Near, own: Try) -> Array:
    """How equations of a try move with position, velocity, activation and control: a line for each."""
    model, start, eps, lines = near.model, near.start, near.eps, []

    def add(name: str, ends: tuple[Array, Array], between: float) -> None:
        plus, minus = (own.equations(near.seen(own.touches, own.way, **{name: end})) for end in ends)
        lines.append((plus - minus) / between)

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
    return np.array(lines)


def _changes_by_way(near: Near, own: Try) -> Array:
    """The same with the velocity that leads to its new contacts."""
    ends = [[own.way + sign * step for sign in (1, -1)] for step in near.eps * np.eye(near.model.nv)]
    seen = [[own.equations(near.seen(own.touches, way, qpos=near.start.qpos)) for way in both] for both in ends]
    return np.array([(plus - minus) / (2 * near.eps) for plus, minus in seen])


def _positions(near: Near, by: Array, by_shift: Array) -> Array:
    """How positions at the end move, in their tangent space, where velocity and shift move by these lines."""
    start, eps, nv = near.start, near.eps, near.model.nv
    moved, turns = np.zeros_like(by), np.zeros_like(by)
    turns[:nv] = np.eye(nv)
    for own, line, shift, turn in zip(moved, by, by_shift, turns, strict=True):
        for sign in (eps, -eps):
            position = near.integrated(near.integrated(start.qpos, turn, sign), near.last.v + sign * line)
            position, difference = near.integrated(position, near.shift + sign * shift), np.zeros(nv)
            mujoco.mj_differentiatePos(near.model, difference, 2 * sign, near.end.qpos, position)
            own += difference
    return moved
