"""How a step of MuJoCo's models moves with the state and the controls before it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import mujoco
import numpy as np

from . import _arrays
from ._batch import BatchSolution
from ._derivative import Facts, RowChange, SolutionChange
from ._near import Near, Pose
from ._types import Array, Rows

if TYPE_CHECKING:
    from .mujoco import Stepper

_LEVER = 1e-5  # as the compiled side has it: a normal is held by this share of what moves its bodies when they are free


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
    law = _Law(near, tol)
    changes = _changes(near)
    by = law.velocity(changes)
    if near.sees(Pose.END):  # which moves with the velocity itself
        late = [(near.equations(near.motion + step) - near.equations(near.motion - step)) / (2 * eps) for step in _steps(near)]
        by = by @ np.linalg.inv(np.eye(near.model.nv) - law.velocity(np.array(late)))
    both = np.concatenate([_positions(near, by), by, changes[:, changes.shape[1] - near.model.na :]], axis=1).T
    states = 2 * near.model.nv + near.model.na
    return Derivatives(both[:, :states].copy(), both[:, states:].copy(), law.facts)


def _steps(near: Near) -> Array:
    return near.eps * np.eye(near.model.nv)


def _changes(near: Near) -> Array:
    """Derivatives of the equations by position, velocity, activation and control, by differences: a line for each."""
    model, start, eps = near.model, near.start, near.eps
    lines = []
    for step in _steps(near):
        ends = [near.equations(qpos=near.integrated(start.qpos, sign * step, 1.0)) for sign in (1, -1)]
        lines.append((ends[0] - ends[1]) / (2 * eps))
    for name in ("qvel", "act", "ctrl"):
        before: Array = getattr(start, name)
        for i in range(len(before)):
            # A control is not moved out of its range, in which MuJoCo holds it.
            low, high = model.actuator_ctrlrange[i] if name == "ctrl" and model.actuator_ctrllimited[i] else (-np.inf, np.inf)
            ends, places = [], []
            for sign in (1, -1):
                moved = before.copy()
                moved[i] += sign * eps if low <= before[i] + sign * eps <= high else 0.0
                places.append(moved[i])
                ends.append(near.equations(**{name: moved}))
            between = places[0] - places[1]
            lines.append((ends[0] - ends[1]) / between if between else 0.0 * ends[0])
    return np.array(lines)


def _positions(near: Near, by: Array) -> Array:
    """How positions at the end move, in their tangent space, with velocities that move by these lines."""
    model, start, eps, nv = near.model, near.start, near.eps, near.model.nv
    moved = np.zeros_like(by)
    for i, line in enumerate(by):
        for sign in (1, -1):
            position = start.qpos if i >= nv else near.integrated(start.qpos, sign * _steps(near)[i], 1.0)
            position = near.integrated(near.integrated(position, near.v + sign * eps * line), near.shift)
            difference = np.zeros(nv)
            mujoco.mj_differentiatePos(model, difference, 1.0, near.end.qpos, position)
            moved[i] += sign * difference / (2 * eps)
    return moved


class _Law:
    """The contact law of a step, by islands of what touches."""

    def __init__(self, near: Near, tol: float) -> None:
        self.near, self.settings = near, (tol, 1000, False)
        self.facts = Facts(np.array(np.inf), np.array(True), np.array(True))

    def velocity(self, changes: Array) -> Array:
        """How the velocity moves where the equations move by these lines."""
        near, (c, d, nv) = self.near, self.near.H.shape
        p, u, s, _ = np.split(changes, np.cumsum([nv, c * d, len(near.J)]), axis=1)
        p = p.copy()
        for dofs, contacts, rows in _islands(near):
            told = self._told(dofs, contacts, rows, (p[:, dofs], u.reshape(-1, c, d)[:, contacts], s[:, rows]))
            p += np.einsum("cdn,bcd->bn", near.H[contacts, : told.r.shape[2]], told.r) + told.row_impulses @ near.J[rows]
            margin, *unique = (own[0] for own in vars(told.facts).values())
            self.facts = Facts(
                np.minimum(self.facts.margin, margin),
                self.facts.has_unique_impulses & unique[0],
                self.facts.has_unique_velocity & unique[1],
            )
        by: Array = np.linalg.solve(near.mass, p.T).T
        return by

    def _told(self, dofs: Array, contacts: Array, rows: Array, changes: tuple[Array, Array, Array]) -> SolutionChange:
        """How the impulses of an island move, with the momentum, the velocities of contacts and those of rows."""
        near, (p, u, s) = self.near, changes
        d = 3 if (near.dim[contacts] <= 3).all() else near.H.shape[1]
        mass, H, friction = near.mass[np.ix_(dofs, dofs)], near.H[contacts, :d][:, :, dofs], near.friction[contacts, : d - 1]
        is_shaped = d > 3 or (friction[:, 0] != friction[:, 1]).any()
        response = np.einsum("cn,nc->c", H[:, 0], np.linalg.solve(mass, H[:, 0].T))
        lever = np.maximum(_LEVER * near.mobility[contacts] - response, 0.0)
        compliance = np.stack([lever, 0 * lever], axis=1)[None] if lever.any() else None
        joint = Rows(near.J[None, rows][..., dofs], near.offset[None, rows], near.lower[None, rows], near.upper[None, rows])
        scene = _arrays.scene(
            (mass[None], H[None], near.impulse[None, dofs]),
            near.w[None, contacts, :d],
            friction[None] if is_shaped else friction[None, :, 0],
            compliance,
            None,
            joint if len(rows) else None,
            _arrays.DOUBLE,
            lead=1,
        )
        found = BatchSolution.empty(len(p), len(dofs), len(contacts), d, len(rows))
        found.v[:], found.r[:], found.row_impulses[:] = near.v[dofs], near.r[contacts, :d], near.row_impulses[rows]
        object.__setattr__(found, "_solved", (scene, self.settings))
        return found.jvp(free_impulse=p, w=u[:, :, :d], rows=RowChange(offset=s))


def _islands(near: Near) -> Iterator[tuple[Array, Array, Array]]:
    """Velocities, contacts and joint rows that move each other, as places in the lists."""
    c, nv = len(near.H), near.model.nv
    touched = np.concatenate([(near.H != 0).any(axis=1), near.J != 0])
    joined = near.mass != 0
    for row in touched:
        joined |= np.outer(row, row)
    island = np.arange(nv)
    while True:
        least = np.where(joined, island, nv).min(axis=1)
        if np.array_equal(least, island):
            break
        island = least
    of_row = np.where(touched, island, nv).min(axis=1, initial=nv)
    for first in np.unique(of_row[of_row < nv]):
        own = np.flatnonzero(of_row == first)
        yield np.flatnonzero(island == first), own[own < c], own[own >= c] - c
