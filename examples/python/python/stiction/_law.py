"""The contact law of a step of MuJoCo's models, by islands of what touches."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from . import _arrays
from ._batch import BatchSolution, solve_batch
from ._derivative import Facts, RowChange, SolutionChange
from ._types import Array, Rows

#: ``M``, ``H``, free impulse, ``w``, ``mu``, compliance, rows.
_Scene = tuple[Array, Array, Array, Array, Array, Array | None, Rows | None]


class Terms(NamedTuple):
    """What the law is asked about: of all contacts with 6 rows, those that they have not being 0."""

    mass: Array
    impulse: Array
    H: Array
    w: Array
    J: Array
    offset: Array
    #: Gaps of contacts and of joint rows (m, rad) as the step begins.
    gap: Array
    row_gap: Array
    #: Activations after the step.
    act: Array


class Bounds(NamedTuple):
    """What bounds impulses, and what gives way to them."""

    friction: Array
    dim: Array
    #: Along normal and tangents.
    compliance: Array
    lower: Array
    upper: Array
    row_compliance: Array


class Motion(NamedTuple):
    """Velocity and impulses."""

    v: Array
    r: Array
    row_impulses: Array

    def equations(self, terms: Terms) -> Array:
        """Momentum that is missing, velocities of contacts and joint rows, and activations, if this is the motion."""
        momentum = terms.impulse - terms.mass @ self.v + np.einsum("cdn,cd->n", terms.H, self.r) + self.row_impulses @ terms.J
        return np.concatenate([momentum, (terms.H @ self.v + terms.w).ravel(), terms.J @ self.v + terms.offset, terms.act])


class Law:
    """The law with some of the contacts, and its derivative."""

    def __init__(self, terms: Terms, bounds: Bounds, contacts: Array, tol: float) -> None:
        """Take the contacts of these places, and all rows; ``tol`` is the error of motions."""
        self.terms, self.bounds, self.tol = terms, bounds, tol
        self.islands = list(islands(terms, contacts))
        self.facts = Facts(np.array(np.inf), np.array(True), np.array(True))

    def solved(self) -> Motion:
        """Solve it from nothing."""
        terms = self.terms
        motion = Motion(np.linalg.solve(terms.mass, terms.impulse), np.zeros(terms.w.shape), np.zeros(terms.offset.shape))
        for dofs, contacts, rows in self.islands:
            M, H, p, w, mu, compliance, joint = self._scene(dofs, contacts, rows)
            found = solve_batch(M, H, p, w, mu, rows=joint, compliance=compliance, tol=1e-10)
            motion.v[dofs], motion.r[contacts, : H.shape[2]], motion.row_impulses[rows] = found.v, found.r, found.row_impulses
        return motion

    def velocity(self, motion: Motion, changes: Array) -> Array:
        """How the velocity of a solution moves where its equations move by these lines."""
        (c, d, nv), (lines, _) = self.terms.H.shape, changes.shape
        p, u, s, _ = np.split(changes, np.cumsum([nv, c * d, len(self.terms.J)]), axis=1)
        p, u = p.copy(), u.reshape(lines, c, d)
        for dofs, contacts, rows in self.islands:
            told = self._told(motion, (dofs, contacts, rows), (p[:, dofs], u[:, contacts], s[:, rows]))
            p += np.einsum("cdn,bcd->bn", self.terms.H[contacts, : told.r.shape[2]], told.r)
            p += told.row_impulses @ self.terms.J[rows]
            found, known = told.facts, self.facts
            self.facts = Facts(
                np.minimum(known.margin, found.margin[0]),
                known.has_unique_impulses & found.has_unique_impulses[0],
                known.has_unique_velocity & found.has_unique_velocity[0],
            )
        by: Array = np.linalg.solve(self.terms.mass, p.T).T
        return by

    def _scene(self, dofs: Array, contacts: Array, rows: Array) -> _Scene:
        """The arrays of an island, with a leading axis."""
        terms, bounds = self.terms, self.bounds
        d = 3 if (bounds.dim[contacts] <= 3).all() else terms.H.shape[1]
        mass, H, friction = terms.mass[np.ix_(dofs, dofs)], terms.H[contacts, :d][:, :, dofs], bounds.friction[contacts, : d - 1]
        is_shaped = d > 3 or (friction[:, 0] != friction[:, 1]).any()
        soft = bounds.compliance[contacts]
        own = (terms.J[rows][:, dofs], terms.offset[rows], bounds.lower[rows], bounds.upper[rows], bounds.row_compliance[rows])
        return (
            mass[None],
            H[None],
            terms.impulse[None, dofs],
            terms.w[None, contacts, :d],
            friction[None] if is_shaped else friction[None, :, 0],
            soft[None] if soft.any() else None,
            Rows(*(numbers[None] for numbers in own)) if len(rows) else None,
        )

    def _told(self, motion: Motion, island: tuple[Array, Array, Array], changes: tuple[Array, Array, Array]) -> SolutionChange:
        """How the impulses of an island move with missing momentum, and the velocities of contacts and of rows."""
        (dofs, contacts, rows), (p, u, s) = island, changes
        *arrays, w, mu, compliance, joint = self._scene(*island)
        scene = _arrays.scene(tuple(arrays), w, mu, compliance, None, joint, _arrays.DOUBLE, lead=1)
        d = w.shape[2]
        found = BatchSolution.empty(len(p), len(dofs), len(contacts), d, len(rows))
        found.v[:], found.r[:], found.row_impulses[:] = motion.v[dofs], motion.r[contacts, :d], motion.row_impulses[rows]
        object.__setattr__(found, "_solved", (scene, (self.tol, 1000, False), None))
        return found.jvp(free_impulse=p, w=u[:, :, :d], rows=RowChange(offset=s))


def islands(terms: Terms, contacts: Array) -> Iterator[tuple[Array, Array, Array]]:
    """Velocities, contacts and joint rows that move each other, as places in the lists."""
    c, nv = len(contacts), len(terms.mass)
    touched = np.concatenate([(terms.H[contacts] != 0).any(axis=1), terms.J != 0])
    joined = terms.mass != 0
    for row in touched:
        joined |= np.outer(row, row)
    island, last = np.arange(nv), None
    while last is None or not np.array_equal(island, last):
        island, last = np.where(joined, island, nv).min(axis=1), island
    of_row = np.where(touched, island, nv).min(axis=1)
    for first in np.unique(of_row[of_row < nv]):
        own = np.flatnonzero(of_row == first)
        yield np.flatnonzero(island == first), contacts[own[own < c]], own[own >= c] - c
