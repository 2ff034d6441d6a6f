"""The motion that takes overlaps and open equalities back in a step of MuJoCo's models, and is not kept as a velocity."""

from __future__ import annotations

import numpy as np

from ._law import Bounds, Law, Terms
from ._near import Near
from ._types import Array

# As the compiled side has them: the share of an overlap that is taken back; compliance of contacts and of rows, over what moves
# them, and the least of that, over what moves their bodies when they are free; the fastest recovery, over the model's own speed.
_SHARE, _CONTACT, _ROW, _LEAST, _RECOVERY = 0.8, 1e-4, 0.02, 1e-2, 0.2
# It is solved to little accuracy, and differs from what the step has moved by as much as this, over the largest.
_SAME = 1e-3


class Shift:
    """It is asked for as the step does, and solved again."""

    def __init__(self, near: Near, tol: float) -> None:
        """Solve it at the step."""
        bounds, self.v, self.h = near.bounds, near.last.v, near.h
        #: Friction loss has no part in it.
        self.rows = np.flatnonzero(near.is_limit | np.isinf(bounds.upper))
        terms = near.terms._replace(J=near.terms.J[self.rows], row_gap=near.terms.row_gap[self.rows])
        response, row_response = (
            np.einsum("cn,nc->c", rows, np.linalg.solve(terms.mass, rows.T)) for rows in (terms.H[:, 0], terms.J)
        )
        speed = np.sqrt((np.linalg.norm(near.model.opt.gravity) or 9.81) * near.size)
        most = self.h * _RECOVERY * speed * np.minimum(response / np.maximum(near.mobility, 1e-300), 1.0)
        self.open = terms.gap + self.h * terms.H[:, 0] @ self.v
        old = np.maximum(-self.open - near.curve, 0.0)
        share = np.where((self.open < 0) & (old > 0), np.where(_SHARE * old < most, _SHARE, 1.0), 0.0)
        # Of an overlap the rest is left, and 1 / h of what is asked for is how fast.
        self.offset = np.where(share > 0, self.open + old - np.minimum(_SHARE * old, most), self.open) / self.h
        self.slope = np.where(share == 0, 1.0, np.where(share == 1.0, 0.0, _SHARE)) / self.h
        row_open = terms.row_gap + self.h * terms.J @ self.v
        self.row_slope = np.where(near.is_limit[self.rows] & (row_open < 0), _SHARE, 1.0) / self.h
        soft = _CONTACT * np.maximum(response, _LEAST * near.mobility)
        own = Bounds(
            friction=bounds.friction * (np.arange(bounds.friction.shape[1]) < 2),
            dim=np.minimum(bounds.dim, 3),
            compliance=np.stack([soft, soft], axis=1),
            lower=bounds.lower[self.rows],
            upper=bounds.upper[self.rows],
            row_compliance=_ROW * row_response,
        )
        self.law = Law(self.terms(near.terms), own, np.arange(len(self.open)), tol)
        self.motion = self.law.solved()
        size = np.abs(near.shift).max()
        #: Is it what the step has moved by? Else it is held as it is there.
        self.is_it = bool(size > 0 and np.abs(self.motion.v - near.shift).max() <= _SAME * size)

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
        terms, changes = self.law.terms, changes.copy()
        c, d, nv = terms.H.shape
        changes[:, nv : nv + c * d : d] += self.h * self.slope * (by @ terms.H[:, 0].T)
        changes[:, nv + c * d : nv + c * d + len(self.rows)] += self.h * self.row_slope * (by @ terms.J.T)
        return self.law.velocity(self.motion, changes)
