"""The motion that takes overlaps and open equalities back in a step of MuJoCo's models, and is not kept as a velocity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ._law import Bounds, Law, Motion, Terms
from ._types import Array

if TYPE_CHECKING:
    from ._near import Near

# As the compiled side has them: the share of an overlap that is taken back; compliance of contacts and of rows, over what moves
# them, and the least of that, over what moves their bodies when they are free; the fastest recovery, over the model's own speed;
# what has no lever; errors that are left, over the model's length.
_SHARE, _CONTACT, _ROW, _LEAST, _RECOVERY, _NO_LEVER, _LEFT = 0.8, 1e-4, 0.02, 1e-2, 0.2, 1e-6, 1e-9
# It is solved to little accuracy, and differs from what the step has moved by as much as this, over the largest.
_SAME = 1e-3


class Shift:
    """It is asked for as a step does that has found this motion with these contacts."""

    def __init__(self, near: Near, terms: Terms, motion: Motion, contacts: Array) -> None:
        """Solve it."""
        bounds, self.v, self.h, self.is_held = near.bounds, motion.v, near.h, False
        response, row_response = (
            np.einsum("cn,nc->c", rows, np.linalg.solve(terms.mass, rows.T)) for rows in (terms.H[:, 0], terms.J)
        )
        # Friction loss has no part in it, nor has what nothing moves.
        is_row = (near.is_limit | np.isinf(bounds.upper)) & (row_response > _NO_LEVER**2 * row_response.max(initial=0.0))
        self.rows, contacts = np.flatnonzero(is_row), contacts[(response >= _NO_LEVER * near.mobility)[contacts]]
        speed = np.sqrt((np.linalg.norm(near.model.opt.gravity) or 9.81) * near.size)
        most = self.h * _RECOVERY * speed * np.minimum(response / np.maximum(near.mobility, 1e-300), 1.0)
        self.open = terms.gap + self.h * terms.H[:, 0] @ self.v
        # What is from the step itself is taken back in it.
        old = np.maximum(-self.open - np.where(near.is_new, np.maximum(-terms.gap, 0.0), near.curve), 0.0)
        is_old, is_fast = (self.open < 0) & (old > _LEFT * near.size), _SHARE * old > most
        self.offset = np.where(is_old, self.open + old - np.minimum(_SHARE * old, most), self.open) / self.h
        self.slope = np.where(is_old, np.where(is_fast, 0.0, _SHARE), 1.0) / self.h
        row_open = terms.row_gap[self.rows] + self.h * terms.J[self.rows] @ self.v
        self.row_slope = np.where(near.is_limit[self.rows] & (row_open < 0), _SHARE, 1.0) / self.h
        soft = _CONTACT * np.maximum(response, _LEAST * near.mobility)
        own = Bounds(
            friction=bounds.friction * (np.arange(bounds.friction.shape[1]) < 2),
            dim=np.minimum(bounds.dim, 3),
            compliance=np.stack([soft, soft], axis=1),
            lower=bounds.lower[self.rows],
            upper=bounds.upper[self.rows],
            row_compliance=_ROW * row_response[self.rows],
        )
        self.law = Law(self.terms(terms), own, contacts, near.error)
        self.motion = self.law.solved()
        self.size = len(self.equations(terms))

    def hold(self, near: Near) -> None:
        """Hold it if it is not what the step has moved by."""
        off = np.abs(self.motion.v - near.shift).max()
        self.is_held = not off <= _SAME * np.abs(near.shift).max() + _LEFT * near.size / self.h

    def terms(self, terms: Terms) -> Terms:
        """What its law is asked about."""
        d, J, w = terms.H.shape[1], terms.J[self.rows], np.zeros_like(terms.w)
        w[:, 0] = self.offset + self.slope * (terms.gap + self.h * terms.H[:, 0] @ self.v - self.open)
        offset = self.row_slope * (terms.row_gap[self.rows] + self.h * J @ self.v)
        return terms._replace(impulse=0 * terms.impulse, H=terms.H * (np.arange(d) < 3)[:, None], w=w, J=J, offset=offset)

    def equations(self, terms: Terms) -> Array:
        """Its equations, with the velocity of the step."""
        return self.motion.equations(self.terms(terms))

    def velocity(self, changes: Array, by: Array) -> Array:
        """How it moves where its equations move by these lines, and the velocity by those."""
        if self.is_held:
            return 0 * by
        terms, changes = self.law.terms, changes.copy()
        c, d, nv = terms.H.shape
        changes[:, nv : nv + c * d : d] += self.h * self.slope * (by @ terms.H[:, 0].T)
        changes[:, nv + c * d : nv + c * d + len(self.rows)] += self.h * self.row_slope * (by @ terms.J.T)
        return self.law.velocity(self.motion, changes)
