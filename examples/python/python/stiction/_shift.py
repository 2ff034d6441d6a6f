"""The motion that takes overlaps and open equalities back in a step of MuJoCo's models, and is not kept as a velocity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ._law import Bounds, Law, Motion, Terms, islands
from ._types import Array

if TYPE_CHECKING:
    from ._near import Near

# As the compiled side has them: the share of an overlap that is taken back; compliance of contacts, of those that press, and of
# rows, over what moves them, and the least of that, over what moves their bodies when they are free; the fastest recovery, over the
# model's own speed; what has no lever; what is open of rows, and overlaps, that are left, over the model's length.
_SHARE, _CONTACT, _PRESSED, _ROW, _LEAST, _RECOVERY, _NO_LEVER, _LEFT = 0.8, 1e-4, 1e-5, 0.02, 1e-2, 0.2, 1e-6, 1e-9
_SLOP = 1e-7
# It is solved to little accuracy, and differs from what the step has moved by as much as this, over the largest.
_SAME = 1e-3
_STICKS = 1e-9  # slip up to which a contact sticks, over the model's length in a step


class Shift:
    """It is asked for as a step does that has found this motion with these contacts."""

    def __init__(self, near: Near, terms: Terms, motion: Motion, contacts: Array) -> None:
        """Solve it."""
        bounds, self.v, self.h, self.is_held = near.bounds, motion.v, near.h, False
        response, row_response = (
            np.einsum("cn,nc->c", rows, np.linalg.solve(terms.mass, rows.T)) for rows in (terms.H[:, 0], terms.J)
        )
        # Friction loss has no part in it, nor has what nothing moves.
        self.rows = np.flatnonzero(near.is_limit | np.isinf(bounds.upper))
        contacts = contacts[(response >= _NO_LEVER * near.mobility)[contacts]]
        speed = np.sqrt((np.linalg.norm(near.model.opt.gravity) or 9.81) * near.size)
        most = self.h * _RECOVERY * speed * np.minimum(response / np.maximum(near.mobility, 1e-300), 1.0)
        self.open = terms.gap + self.h * terms.H[:, 0] @ self.v
        # What is from the step itself is taken back in it.
        old = np.maximum(-self.open - np.where(near.is_new, np.maximum(-terms.gap, 0.0), near.curve), 0.0)
        is_left = old <= _SLOP * near.size
        is_old, is_fast = (self.open < 0) & ~(is_left & near.is_new), _SHARE * old > most
        back = np.where(is_left, 0.0, np.minimum(_SHARE * old, most))
        self.offset = np.where(is_old, self.open + old - back, self.open) / self.h
        self.slope = np.where(is_old, np.where(is_fast | is_left, 0.0, _SHARE), 1.0) / self.h
        row_open = terms.row_gap[self.rows] + self.h * terms.J[self.rows] @ self.v
        self.row_slope = np.where(near.is_limit[self.rows] & (row_open < 0), _SHARE, 1.0) / self.h
        self.start, holds = self._start(near, terms, motion, contacts)
        is_pressed = self.start[:, 0] > 0
        soft = np.where(is_pressed, _PRESSED, _CONTACT) * np.maximum(response, _LEAST * near.mobility)
        self.soft, self.slips = soft, (is_pressed & holds)[:, None] & np.isin(np.arange(terms.w.shape[1]), (1, 2))
        own = Bounds(
            friction=bounds.friction * (np.arange(bounds.friction.shape[1]) < 2) * (holds | ~is_pressed)[:, None],
            dim=np.minimum(bounds.dim, 3),
            compliance=np.stack([soft, soft], axis=1),
            lower=bounds.lower[self.rows],
            upper=bounds.upper[self.rows],
            row_compliance=_ROW * row_response[self.rows],
        )
        self.law = Law(self.terms(terms), own, contacts, near.error)
        self.motion = self.law.solved()
        self.size = len(self.equations(terms))

    def _start(self, near: Near, terms: Terms, motion: Motion, contacts: Array) -> tuple[Array, Array]:
        """Impulses that press, in islands in which a contact sticks, for the motion to change; and which contacts stick."""
        start, slip = np.zeros_like(terms.w), np.linalg.norm((terms.H @ motion.v + terms.w)[:, 1:3], axis=1)
        holds = (motion.r[:, 0] > 0) & (slip < _STICKS * near.size / near.h)
        for _, own, _ in islands(terms._replace(J=terms.J[self.rows]), contacts):
            if holds[own].any():
                start[own, 0] = motion.r[own, 0]
        return start, holds

    def hold(self, near: Near) -> None:
        """Hold it if it is not what the step has moved by."""
        off = np.abs(self.motion.v - near.shift).max()
        self.is_held = not off <= _SAME * np.abs(near.shift).max() + _LEFT * near.size / self.h

    def terms(self, terms: Terms) -> Terms:
        """What its law is asked about."""
        d, J = terms.H.shape[1], terms.J[self.rows]
        w = np.where(self.slips, terms.H @ self.v + terms.w, 0.0) - self.soft[:, None] * self.start
        w[:, 0] += self.offset + self.slope * (terms.gap + self.h * terms.H[:, 0] @ self.v - self.open)
        offset = self.row_slope * (terms.row_gap[self.rows] + self.h * J @ self.v)
        impulse = -np.einsum("cdn,cd->n", terms.H, self.start)
        return terms._replace(impulse=impulse, H=terms.H * (np.arange(d) < 3)[:, None], w=w, J=J, offset=offset)

    def equations(self, terms: Terms) -> Array:
        """Its equations, with the velocity of the step."""
        return self.motion.equations(self.terms(terms))

    def velocity(self, changes: Array, by: Array) -> Array:
        """How it moves where its equations move by these lines, and the velocity by those."""
        if self.is_held:
            return 0 * by
        terms, changes = self.law.terms, changes.copy()
        c, d, nv = terms.H.shape
        normals = self.h * self.slope[:, None] * (np.arange(d) == 0)
        changes[:, nv : nv + c * d] += ((self.slips + normals) * np.einsum("cdn,bn->bcd", terms.H, by)).reshape(len(by), -1)
        changes[:, nv + c * d : nv + c * d + len(self.rows)] += self.h * self.row_slope * (by @ terms.J.T)
        return self.law.velocity(self.motion, changes)
