"""How a solution moves with its data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays, _stiction
from ._types import Array


@dataclass(frozen=True, eq=False)
class RowChange:
    """Changes of joint rows, or a gradient: as :class:`Rows`, but 0 where nothing is said."""

    #: ``(k, n)``
    jacobian: ArrayLike = 0.0
    #: ``(k,)``, here and below.
    offset: ArrayLike = 0.0
    #: Of the least impulse, where it is the bound of a box.
    lower: ArrayLike = 0.0
    #: Of the largest impulse, likewise.
    upper: ArrayLike = 0.0
    #: Of compliance.
    compliance: ArrayLike = 0.0


@dataclass(frozen=True, eq=False)
class SolutionChange:
    """The change of a solution."""

    #: Of the velocity, ``(n,)``.
    v: Array
    #: Of contact impulses, ``(c, d)``.
    r: Array
    #: Of the impulses of joint rows, ``(k,)``.
    row_impulses: Array
    facts: Facts


@dataclass(frozen=True, eq=False)
class Gradient:
    """The gradient of a weighted sum of a solution with respect to all that went in, each in the shape of what went in."""

    #: ``(n, n)``; it is not symmetric, a symmetric change takes the sum of both halves.
    M: Array
    #: ``(c, d, n)``
    H: Array
    #: ``(n,)``
    free_impulse: Array
    #: ``(c, d)``
    w: Array
    #: ``(c,)``; of coefficients by row that of the larger one of the tangents, which scales the others.
    mu: Array
    #: Of the joint rows.
    rows: RowChange
    facts: Facts


@dataclass(frozen=True, eq=False)
class Facts:
    """Whether there is a derivative, and how near the next change of a mode is; of a batch with a leading axis."""

    #: The least impulse that would change a mode, as a share of the largest; near 0 derivatives are one-sided.
    margin: Array
    #: Are impulses determined by the data? If not, theirs are the least changes.
    has_unique_impulses: Array
    #: Is the velocity?
    has_unique_velocity: Array


class Differentiable:
    """A solution, or those of a batch, that can be differentiated. The arrays that were solved have to be as they were."""

    v: Array
    r: Array
    row_impulses: Array

    def jvp(
        self,
        *,
        M: ArrayLike = 0.0,
        H: ArrayLike = 0.0,
        free_impulse: ArrayLike = 0.0,
        w: ArrayLike = 0.0,
        mu: ArrayLike = 0.0,
        rows: RowChange | None = None,
        threads: int | None = None,
    ) -> SolutionChange:
        """Tell how the solution changes with its data: the Jacobian times a vector.

        Args:
            M: the change of the mass matrix, ``(n, n)``, with the free impulse as it is; nothing said is no change, here and below.
            H: of the contact Jacobians, ``(c, d, n)`` or ``(c·d, n)``.
            free_impulse: of the free impulse, ``(n,)``.
            w: of the offsets, ``(c, d)`` or ``(c·d,)``.
            mu: of the friction coefficients, ``(c,)`` or one number for all; of coefficients by row that of the larger one of the tangents,
                which scales the others.
            rows: of the joint rows.
            threads: as of :func:`solve_batch`.

        Raises:
            ValueError: there is no derivative, an argument has the wrong shape, or the arrays that were solved have changed.
        """
        v, r, impulses = self.v, self.r, self.row_impulses
        rows = RowChange() if rows is None else rows
        lead, (c, d, n, k) = v.shape[:-1], (*r.shape[-2:], v.shape[-1], impulses.shape[-1])
        change_m, change_h = _shaped("M", M, (*lead, n, n)), _shaped("H", H, (*lead, c, d, n))
        change_j = _shaped("rows.jacobian", rows.jacobian, (*lead, k, n))
        pushed = _shaped("free_impulse", free_impulse, (*lead, n)) - np.einsum("...ij,...j->...i", change_m, v)
        pushed = pushed + np.einsum("...cdn,...cd->...n", change_h, r) + np.einsum("...kn,...k->...n", change_j, impulses)
        offsets = _shaped("w", w, (*lead, c, d)) + np.einsum("...cdn,...n->...cd", change_h, v)
        compliance = _shaped("rows.compliance", rows.compliance, (*lead, k))
        row_offsets = _shaped("rows.offset", rows.offset, (*lead, k)) + np.einsum("...kn,...n->...k", change_j, v) + compliance * impulses
        bounds = [_shaped(f"rows.{name}", getattr(rows, name), (*lead, k)) for name in ("lower", "upper")]
        parts = [pushed, offsets, _shaped("mu", mu, (*lead, c)), row_offsets, *bounds]
        (dv, dr, dl), facts = self._derivative(parts, [(n,), (c, d), (k,)], False, threads)
        return SolutionChange(dv, dr, dl, facts)

    def vjp(
        self, *, v: ArrayLike = 0.0, r: ArrayLike = 0.0, row_impulses: ArrayLike = 0.0, threads: int | None = None
    ) -> Gradient:
        """Tell how a sum of the solution changes with all of its data: a vector times the Jacobian.

        Args:
            v: the weight of each velocity in the sum, ``(n,)``; nothing said is 0, here and below.
            r: that of each contact impulse, ``(c, d)``.
            row_impulses: that of each joint row's impulse, ``(k,)``.
            threads: as of :func:`solve_batch`.

        Raises:
            ValueError: as of :meth:`jvp`.
        """
        lead, (c, d, n, k) = self.v.shape[:-1], (*self.r.shape[-2:], self.v.shape[-1], self.row_impulses.shape[-1])
        weights = [
            _shaped("v", v, self.v.shape),
            _shaped("r", r, self.r.shape),
            _shaped("row_impulses", row_impulses, self.row_impulses.shape),
        ]
        shapes = [(n,), (c, d), (c,), (k,), (k,), (k,)]
        (p, offsets, mu, row_offsets, lower, upper), facts = self._derivative(weights, shapes, True, threads)

        def outer(x: Array, y: Array) -> Array:
            return x.reshape(*x.shape, 1) * y.reshape(*lead, *(1,) * (x.ndim - len(lead)), n)

        rows = RowChange(
            jacobian=outer(row_offsets, self.v) + outer(self.row_impulses, p),
            offset=row_offsets,
            lower=lower,
            upper=upper,
            compliance=row_offsets * self.row_impulses,
        )
        return Gradient(-outer(p, self.v), outer(offsets, self.v) + outer(self.r, p), p, offsets, mu, rows, facts)

    def _derivative(
        self, parts: list[Array], shapes: list[tuple[int, ...]], backward: bool, threads: int | None
    ) -> tuple[list[Array], Facts]:
        """Go one way on the compiled side, and cut what comes out into parts of these shapes."""
        scene, settings = vars(self).get("_solved", (None, None))
        if scene is None:
            raise ValueError("solution: its scene is not known")
        lead = self.v.shape[:-1]
        count = int(np.prod(lead))

        def lines(part: Array) -> Array:
            return np.ascontiguousarray(part.reshape(count, int(np.prod(part.shape[len(lead) :]))), np.float64)

        impulses = (lines(self.r), lines(self.row_impulses))
        numbers = np.concatenate([lines(part) for part in parts], axis=1)
        workers = min(_arrays.threads_of(threads), max(count, 1))
        found, facts = _stiction.derivative(scene, settings, len(lead) > 0, impulses, numbers, backward, workers)
        if (facts[:, 3] > 2 * settings[0] + 1e-6).any():
            raise ValueError("solution: the arrays that were solved have changed, or it was not solved")
        ends = np.cumsum([int(np.prod(shape)) for shape in shapes])[:-1]
        cut = [piece.reshape(*lead, *shape) for piece, shape in zip(np.split(found, ends, axis=1), shapes, strict=True)]
        margin, impulses_flag, velocity_flag = (facts[:, i].reshape(lead) for i in range(3))
        return cut, Facts(margin, impulses_flag > 0, velocity_flag > 0)


def _shaped(name: str, given: Any, shape: tuple[int, ...]) -> Array:
    """An array of this shape; a number or what has a shorter leading axis is spread."""
    found = _arrays.array(name, given, _arrays.DOUBLE)
    if found.ndim > 0 and found.size == int(np.prod(shape)):
        return found.reshape(shape)
    try:
        return np.broadcast_to(found, shape)
    except ValueError:
        raise ValueError(f"{name}: shape {list(found.shape)} is not {list(shape)}") from None
