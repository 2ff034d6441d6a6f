"""How a solution moves with its data."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate
from math import prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays, _stiction
from ._types import Array


@dataclass(frozen=True, eq=False)
class RowChange:
    """Changes of joint rows, or a gradient: as :class:`Rows`, but 0 where nothing is said."""

    #: Of the rows over the velocities, ``(k, n)``, 1 or m.
    jacobian: ArrayLike = 0.0
    #: Of what is added to the speed, ``(k,)``, m/s or rad/s.
    offset: ArrayLike = 0.0
    #: Of the least impulse, where it is the bound of a box, ``(k,)``, N·s or N·m·s.
    lower: ArrayLike = 0.0
    #: Of the largest impulse, likewise.
    upper: ArrayLike = 0.0
    #: Of compliance, ``(k,)``, 1/kg or 1/(kg m²).
    compliance: ArrayLike = 0.0


@dataclass(frozen=True, eq=False)
class SolutionChange:
    """The change of a solution."""

    #: Of the velocity, ``(n,)``, m/s and rad/s.
    v: Array
    #: Of contact impulses, ``(c, d)``, N·s, normal first.
    r: Array
    #: Of the impulses of joint rows, ``(k,)``, N·s or N·m·s.
    row_impulses: Array
    #: Whether there is a derivative, and how near the next mode is.
    facts: Facts


@dataclass(frozen=True, eq=False)
class Gradient:
    """The gradient of a weighted sum of a solution with respect to all that went in; its unit is that of the sum over theirs."""

    #: By the mass matrix, ``(n, n)``; it is not symmetric, a symmetric change takes the sum of both halves.
    M: Array
    #: By the contact Jacobians, ``(c, d, n)``.
    H: Array
    #: By the free impulse, ``(n,)``.
    free_impulse: Array
    #: By the offsets, ``(c, d)``.
    w: Array
    #: By the friction coefficients, ``(c,)``; of coefficients by row it is that of the larger one of the tangents, which scales the
    #: others.
    mu: Array
    #: By the joint rows.
    rows: RowChange
    #: Whether there is a derivative, and how near the next mode is.
    facts: Facts


@dataclass(frozen=True, eq=False)
class Facts:
    """Whether there is a derivative, and how near the next change of a mode is; of a batch with a leading axis."""

    #: The least impulse that would change a mode, as a share of the largest, ``()`` or ``(b,)``; near 0 derivatives are one-sided.
    margin: Array
    #: Are impulses determined by the data? If not, theirs are those of ``Solution.least``, while these are inside their cones.
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
        M: ArrayLike | None = None,
        H: ArrayLike | None = None,
        free_impulse: ArrayLike | None = None,
        w: ArrayLike | None = None,
        mu: ArrayLike | None = None,
        rows: RowChange | None = None,
        threads: int | None = None,
    ) -> SolutionChange:
        """Tell how the solution changes with its data: the Jacobian times a vector.

        Args:
            M: the change of the mass matrix, ``(n, n)``, with the free impulse as it is; kg, kg·m, kg·m². ``None`` is no change,
                here and below; those of a batch have a leading axis.
            H: of the contact Jacobians, ``(c, d, n)`` or ``(c·d, n)``; 1 or m.
            free_impulse: of the free impulse, ``(n,)``; N·s, N·m·s.
            w: of the offsets, ``(c, d)`` or ``(c·d,)``; m/s.
            mu: of the friction coefficients, ``(c,)`` or one number, no unit; of coefficients by row that of the larger one of the
                tangents, which scales the others.
            rows: of the joint rows.
            threads: how many, at most, for a batch; ``None`` takes as many as there are cores for this process.

        Raises:
            ValueError: there is no derivative, an argument has the wrong shape, or the arrays that were solved have changed.
        """
        lead, inputs, outputs = self._shapes()
        numbers, (p, offsets, friction, row_offsets, lower, upper) = _parts(lead, inputs)
        (n,), r, impulses = inputs[0], self.r, self.row_impulses
        for name, given, part in (("free_impulse", free_impulse, p), ("w", w, offsets), ("mu", mu, friction)):
            if given is not None:
                part += _shaped(name, given, part.shape)
        if M is not None:
            p -= np.einsum("...ij,...j->...i", _shaped("M", M, (*lead, n, n)), self.v)
        if H is not None:
            change = _shaped("H", H, (*r.shape, n))
            p += np.einsum("...cdn,...cd->...n", change, r)
            offsets += np.einsum("...cdn,...n->...cd", change, self.v)
        if rows is not None:
            change = _shaped("rows.jacobian", rows.jacobian, (*impulses.shape, n))
            p += np.einsum("...kn,...k->...n", change, impulses)
            row_offsets += np.einsum("...kn,...n->...k", change, self.v)
            row_offsets += _shaped("rows.compliance", rows.compliance, impulses.shape) * impulses
            for name, part in (("offset", row_offsets), ("lower", lower), ("upper", upper)):
                part += _shaped(f"rows.{name}", getattr(rows, name), part.shape)
        (v, r, impulses), facts = self._derivative(numbers, outputs, False, threads)
        return SolutionChange(v, r, impulses, facts)

    def vjp(
        self,
        *,
        v: ArrayLike | None = None,
        r: ArrayLike | None = None,
        row_impulses: ArrayLike | None = None,
        threads: int | None = None,
    ) -> Gradient:
        """Tell how a sum of the solution changes with all of its data: a vector times the Jacobian.

        Args:
            v: the weight of each velocity in the sum, ``(n,)``, the unit of the sum over m/s or rad/s; ``None`` is 0, here and
                below; those of a batch have a leading axis.
            r: that of each contact impulse, ``(c, d)``, over N·s.
            row_impulses: that of each joint row's impulse, ``(k,)``, over N·s or N·m·s.
            threads: how many, at most, for a batch; ``None`` takes as many as there are cores for this process.

        Raises:
            ValueError: as of :meth:`jvp`.
        """
        lead, inputs, outputs = self._shapes()
        numbers, parts = _parts(lead, outputs)
        for (name, given), part in zip({"v": v, "r": r, "row_impulses": row_impulses}.items(), parts, strict=True):
            if given is not None:
                part += _shaped(name, given, part.shape)
        (p, offsets, mu, row_offsets, lower, upper), facts = self._derivative(numbers, inputs, True, threads)

        def outer(x: Array, y: Array) -> Array:
            return x[..., None] * y.reshape(*lead, *(1,) * (x.ndim - len(lead)), -1)

        rows = RowChange(
            jacobian=outer(row_offsets, self.v) + outer(self.row_impulses, p),
            offset=row_offsets,
            lower=lower,
            upper=upper,
            compliance=row_offsets * self.row_impulses,
        )
        return Gradient(-outer(p, self.v), outer(offsets, self.v) + outer(self.r, p), p, offsets, mu, rows, facts)

    def _shapes(self) -> tuple[Shape, list[Shape], list[Shape]]:
        """Axes of the batch, and the shapes of the parts of data and of solutions as the compiled side has them."""
        contacts, velocity, rows = self.r.shape[-2:], self.v.shape[-1:], self.row_impulses.shape[-1:]
        return self.v.shape[:-1], [velocity, contacts, contacts[:1], rows, rows, rows], [velocity, contacts, rows]

    def _derivative(self, numbers: Array, shapes: list[Shape], backward: bool, threads: int | None) -> tuple[list[Array], Facts]:
        """Go one way on the compiled side, and cut what comes out into parts of these shapes."""
        scene, settings, fingerprint = vars(self).get("_solved", (None, None, None))
        if scene is None:
            raise ValueError("solution: its scene is not known")
        single = self.r.dtype == np.float32
        if fingerprint not in (None, _stiction.fingerprint(scene, len(self.v.shape) > 1, single)):
            raise ValueError("solution: the arrays that were solved have changed")
        lead, count = self.v.shape[:-1], len(numbers)
        size = prod(self.r.shape[-2:])
        impulses = (
            np.ascontiguousarray(self.r, np.float64).reshape(count, size),
            np.ascontiguousarray(self.row_impulses, np.float64).reshape(count, -1 if self.row_impulses.size else 0),
        )
        workers = min(_arrays.threads_of(threads), max(count, 1))
        n, rows = self.v.shape[-1], size + self.row_impulses.shape[-1]
        reduced = _Reduced(scene, (n, rows), len(lead) > 0) if scene[1] is not None and n > _SMALL and 0 < rows < n else None
        if reduced:
            scene, numbers = reduced.scene, reduced.into(numbers, backward)
        found, facts = _stiction.derivative(scene, settings, len(lead) > 0, impulses, (numbers, backward), workers)
        if reduced:
            found = reduced.out(found, backward)
        if (facts[:, 3] > 2 * settings[0] + 1e-6).any():
            raise ValueError("solution: the arrays that were solved have changed, or it was not solved")
        margin, unique_impulses, unique_velocity = (column.reshape(lead) for column in facts.T[:3])
        return _cut(found, lead, shapes), Facts(margin, unique_impulses > 0, unique_velocity > 0)


Shape = tuple[int, ...]

_SMALL = 36  # velocities that are differentiated as they are: there is a kernel for contacts of any number of rows


class _Reduced:
    """A scene of fewer rows than velocities in as many coordinates as it has rows, in which masses are 1.

    With ``L Lᵀ = M``, the rows ``A = [H; J]`` and ``A L⁻ᵀ = Rᵀ Qᵀ`` impulses are those of rows ``Rᵀ`` and the free impulse
    ``Qᵀ L⁻¹ p``, and ``v = M⁻¹ (p + Aᵀ r)``.
    """

    def __init__(self, scene: _arrays.Scene, sizes: tuple[int, int], is_batch: bool) -> None:
        M, H, p, w, mu, compliance, keys, rows = scene
        n, count = sizes
        self.n, self.L = n, np.linalg.cholesky(np.asarray(M, np.float64).reshape(-1, n, n))
        H, p = np.asarray(H, np.float64), np.asarray(p, np.float64).reshape(-1, n, 1)
        parts = [H.reshape(len(H) if is_batch else 1, -1, n)]
        if rows is not None:
            parts.append(np.asarray(rows[0], np.float64).reshape(-1, len(rows[0][0]) if is_batch else len(rows[0]), n))
        most = max(len(part) for part in (self.L, *parts))
        self.A = np.concatenate([np.broadcast_to(part, (most, *part.shape[1:])) for part in parts], axis=1)
        self.Q, R = np.linalg.qr(np.linalg.solve(self.L, np.swapaxes(self.A, 1, 2)))
        contacts, joint = np.split(np.swapaxes(R, 1, 2), [parts[0].shape[1]], axis=1)
        free = (np.swapaxes(self.Q, 1, 2) @ np.linalg.solve(self.L, p))[..., 0]
        arrays = [np.ascontiguousarray(array if is_batch else array[0]) for array in (np.eye(count)[None], contacts, free, joint)]
        self.scene = (*arrays[:3], w, mu, compliance, keys, None if rows is None else (arrays[3], *rows[1:]))

    def _by_mass(self, lines: Array) -> Array:
        """``M⁻¹`` times each line."""
        half = np.linalg.solve(self.L, lines[..., None])
        return np.asarray(np.linalg.solve(np.swapaxes(self.L, 1, 2), half)[..., 0])

    def into(self, numbers: Array, backward: bool) -> Array:
        """Changes of data, or weights of solutions, in these coordinates."""
        first, rest = np.split(numbers, [self.n], axis=1)
        if backward:
            self.weighted = self._by_mass(first)
            own = rest + np.einsum("...mn,...n->...m", self.A, self.weighted)
            return np.concatenate([np.zeros((len(numbers), self.A.shape[1])), own], axis=1)
        self.first = first
        own = (np.swapaxes(self.Q, 1, 2) @ np.linalg.solve(self.L, first[..., None]))[..., 0]
        return np.concatenate([own, rest], axis=1)

    def out(self, numbers: Array, backward: bool) -> Array:
        """What is told of these coordinates, in those of the scene."""
        first, rest = np.split(numbers, [self.A.shape[1]], axis=1)
        if backward:
            own = self.weighted + np.linalg.solve(np.swapaxes(self.L, 1, 2), self.Q @ first[..., None])[..., 0]
        else:
            own = self._by_mass(self.first + np.einsum("...mn,...m->...n", self.A, rest))
        return np.concatenate([own, rest], axis=1)


def _cut(numbers: Array, lead: Shape, shapes: list[Shape]) -> list[Array]:
    """Parts of lines of numbers, as views."""
    ends = list(accumulate(map(prod, shapes), initial=0))
    return [numbers[:, first:end].reshape(*lead, *shape) for first, end, shape in zip(ends, ends[1:], shapes, strict=False)]


def _parts(lead: Shape, shapes: list[Shape]) -> tuple[Array, list[Array]]:
    """Lines of zeros, one for each scene, and their parts."""
    numbers = np.zeros((prod(lead), sum(map(prod, shapes))))
    return numbers, _cut(numbers, lead, shapes)


def _shaped(name: str, given: Any, shape: Shape) -> Array:
    """A number, or an array of this shape, or of one that is spread to it."""
    found = _arrays.array(name, given, _arrays.DOUBLE)
    if found.ndim > 0 and found.size == prod(shape):
        return found.reshape(shape)
    try:
        return np.broadcast_to(found, shape)
    except ValueError:
        raise ValueError(f"{name}: shape {list(found.shape)} is not {list(shape)}") from None
