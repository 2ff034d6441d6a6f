"""One scene: from nothing, or with what the last one left."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from . import _arrays, _stiction
from ._arrays import DOUBLE
from ._solution import Solution, solution
from ._types import Array, Rows


def solve(
    M: ArrayLike,
    H: ArrayLike | None,
    free_impulse: ArrayLike,
    w: ArrayLike | None = None,
    mu: ArrayLike | None = None,
    *,
    tol: float = 1e-6,
    budget: int = 1000,
    rows: Rows | None = None,
    compliance: ArrayLike | None = None,
    relaxed: bool = False,
    dtype: DTypeLike = DOUBLE,
) -> Solution:
    """Solve one time step from nothing.

    Args:
        M: generalised mass matrix, ``(n, n)``; kg, kg·m, kg·m² by the units of the velocities. Positive definite.
        H: contact Jacobians, ``(c, d, n)`` or ``(c·d, n)``, rows with the normal first, pointing out of the obstacle; 1 or m.
            ``None`` for a scene of joint rows alone.
        free_impulse: ``M v_free = M v + h F``, ``(n,)``: momentum at the end of the step without contacts; N·s, N·m·s.
        w: offsets, ``(c, d)`` or ``(c·d,)``: gap over time step, velocity of a moving surface, restitution; m/s. ``None`` is 0: all
            contacts touch, and nothing else moves.
        mu: friction coefficients, ``(c,)`` or one number, no unit; or one for each row behind the normal, ``(c, d - 1)``: two
            tangents, spin (m), two rolls (m), which make the cone elliptic.
        tol: error up to which the scene counts as solved; no unit, relative to the impulses.
        budget: work that the solve may take, in the unit of :attr:`Work.total`.
        rows: joint limits, dry friction, motors, loops: ``k`` of them.
        compliance: of contacts, ``(c,)`` or one number, 1/kg; or along the normal and along the tangents, ``(c, 2)``; ``None`` is
            rigid.
        relaxed: solve the convex relaxation instead (``Model::ConvexRelaxation``), in which a contact that slides lifts off; forces
            are shared out by it.
        dtype: ``float64``, or ``float32`` with the bits of a microcontroller.

    Returns:
        The solution, whatever its status.

    Raises:
        ValueError: an argument has the wrong shape or type, is not finite or makes no sense; its name comes first.
    """
    number = _arrays.number_type(dtype)
    scene = _arrays.scene((M, H, free_impulse), w, mu, compliance, None, rows, number)
    settings = (tol, budget, bool(relaxed))
    return solution(_stiction.solve(scene, settings, number.itemsize == 4), scene, settings)


def solve_delassus(
    W: ArrayLike,
    q: ArrayLike,
    mu: ArrayLike,
    *,
    tol: float = 1e-6,
    budget: int = 1000,
    rows: Rows | None = None,
    relaxed: bool = False,
    dtype: DTypeLike = DOUBLE,
) -> Solution:
    """Solve one time step of which the Delassus operator is given, ``u = W r + q``.

    Args:
        W: ``H M⁻¹ Hᵀ``, ``(m, m)``, 1/kg: ``d`` rows for each contact, then one for each joint row. Symmetric, without compliance;
            it may be singular, and its rank is at most that of the largest ``n`` that is compiled (:data:`SIZES`).
        q: contact velocities without impulses, ``(c, d)`` or ``(c·d,)``, m/s; the ``w`` of complaints.
        mu: friction coefficients, ``(c,)`` or one number, no unit; or one for each row behind the normal, ``(c, d - 1)``.
        tol: error up to which the scene counts as solved; no unit, relative to the impulses.
        budget: work that the solve may take, in the unit of :attr:`Work.total`.
        rows: joint rows; ``offset`` is the velocity without impulses, and ``jacobian`` is not read.
        relaxed: solve the convex relaxation instead (``Model::ConvexRelaxation``).
        dtype: ``float64``, or ``float32`` with the bits of a microcontroller.

    Returns:
        The solution for ``H Hᵀ``, with ``H`` a root of ``W``; its ``v`` is empty, and it has no derivative.

    Raises:
        ValueError: as in :func:`solve`.
    """
    H, q = _root(_arrays.array("W", W, DOUBLE)), _arrays.array("q", q, DOUBLE)
    if rows is not None and isinstance(rows, Rows):
        rows = replace(rows, jacobian=H[q.size :])
    elif len(H) != q.size:
        raise ValueError(f"W: {len(H)} rows are not those of q")
    n = H.shape[1]
    contacts = H[: q.size].reshape(*q.shape, n) if len(H) >= q.size else H
    given = (np.eye(n), contacts, np.zeros(n), q, mu)
    found = solve(*given, tol=tol, budget=budget, rows=rows, relaxed=relaxed, dtype=dtype)
    return replace(found, v=found.v[:0])


def _root(W: Array) -> Array:
    """``H`` with ``H Hᵀ = W`` and as many columns as the rank, by the eigenvalues of ``W`` scaled to a diagonal of 1."""
    if W.ndim != 2 or W.shape[0] != W.shape[1] or not np.isfinite(W).all():
        raise ValueError(f"W: shape {list(W.shape)} is not square, or an entry is not finite")
    own = np.sqrt(np.where(W.diagonal() > 0.0, W.diagonal(), 1.0))
    scaled = W / own[:, None] / own
    values, vectors = np.linalg.eigh(scaled) if len(W) else (np.zeros(0), W)
    rounding = 4 * len(W) * np.finfo(W.dtype).eps
    if np.abs(scaled - scaled.T).max(initial=0.0) > rounding or values.min(initial=0.0) < -rounding * len(W):
        raise ValueError("W: it is not symmetric and positive semidefinite")
    above = values > rounding
    root = own[:, None] * vectors[:, above] * np.sqrt(values[above])
    return root if root.shape[1] else np.zeros((len(W), 1))


class Kernel:
    """A kernel that starts each solve from the last one, by the keys of contacts and rows, and can go on with it.

    Several threads may use one: they wait for each other.
    """

    def __init__(
        self,
        n: int,
        contacts: int,
        *,
        dim: int = 3,
        rows: int = 0,
        surfaces: bool = False,
        dtype: DTypeLike = DOUBLE,
    ) -> None:
        """Make room for a scene.

        Args:
            n: generalised velocities, at most.
            contacts: contacts, at most.
            dim: rows of a contact: 1, 2, 3, 4 or 6.
            rows: joint rows, at most.
            surfaces: will there be coefficients by row, or compliance of contacts?
            dtype: ``float64`` or ``float32``.

        Raises:
            ValueError: no compiled size has so much room (:data:`SIZES`).
        """
        self._number = _arrays.number_type(dtype)
        sizes = {"n": n, "contacts": contacts, "dim": dim, "rows": rows}
        counts = [_arrays.count(name, given) for name, given in sizes.items()]
        self._made = (counts, bool(surfaces), self._number.itemsize == 4)
        self._kernel = _stiction.Kernel(*self._made)
        self._scene: _arrays.Scene | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what is compiled: a copy, also of another process, starts cold."""
        return {name: own for name, own in vars(self).items() if name not in ("_kernel", "_scene")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Make the kernel anew."""
        vars(self).update(state)
        self._kernel = _stiction.Kernel(*self._made)
        self._scene = None

    @property
    def size(self) -> tuple[int, int, int, int, int]:
        """Velocities, rows of a contact, contacts, joint rows, contacts with a surface that there is room for."""
        return self._kernel.size

    def solve(
        self,
        M: ArrayLike,
        H: ArrayLike | None,
        free_impulse: ArrayLike,
        w: ArrayLike | None = None,
        mu: ArrayLike | None = None,
        *,
        keys: ArrayLike | None = None,
        tol: float = 1e-6,
        budget: int = 1000,
        rows: Rows | None = None,
        compliance: ArrayLike | None = None,
        relaxed: bool = False,
    ) -> Solution:
        """Solve one time step, from the impulses of the last one as far as its contacts are still there.

        Args:
            M: generalised mass matrix, ``(n, n)``; kg, kg·m, kg·m² by the units of the velocities.
            H: contact Jacobians, ``(c, d, n)`` or ``(c·d, n)``, rows with the normal first; 1 or m.
            free_impulse: ``M v + h F``, ``(n,)``; N·s, N·m·s.
            w: offsets, ``(c, d)`` or ``(c·d,)``; m/s. ``None`` is 0.
            mu: friction coefficients, ``(c,)`` or one number, no unit; or one for each row behind the normal, ``(c, d - 1)``.
            keys: which contact is which, also in other steps (a foot, a pair of geoms), ``(c,)`` unsigned integers. Of several with
                one key the first follows the first. Without keys they follow each other by their order.
            tol: error up to which the scene counts as solved; no unit, relative to the impulses.
            budget: work that the solve may take, in the unit of :attr:`Work.total`.
            rows: joint limits, dry friction, motors, loops: ``k`` of them, with keys of their own.
            compliance: of contacts, ``(c,)`` or one number, 1/kg; or along the normal and along the tangents, ``(c, 2)``; ``None``
                is rigid.
            relaxed: solve the convex relaxation instead (``Model::ConvexRelaxation``).

        Raises:
            ValueError: as of :func:`solve`, or there is no room.
        """
        scene = _arrays.scene((M, H, free_impulse), w, mu, compliance, keys, rows, self._number)
        settings = (tol, budget, bool(relaxed))
        parts = self._kernel.solve(scene, settings)
        self._scene = scene  # now that it is in the kernel
        return solution(parts, scene, settings)

    def resume(self, *, tol: float = 1e-6, budget: int = 1000, relaxed: bool = False) -> Solution:
        """Go on with a solve that ended as ``Status.OUT_OF_BUDGET``.

        Args:
            tol: error up to which the scene counts as solved, the same as before; no unit.
            budget: further work that it may take, in the unit of :attr:`Work.total`.
            relaxed: is it the convex relaxation? The same as before.

        Raises:
            ValueError: there is no scene.
        """
        settings = (tol, budget, bool(relaxed))
        return solution(self._kernel.resume(settings), self._scene, settings)

    def reset(self) -> None:
        """Forget the last solve: the next one starts cold."""
        self._kernel.reset()

    def presume_rest(self) -> None:
        """Declare that nothing moved before the next solve, which then returns a solution at rest if Coulomb's law has one.

        Call it before the first solve, or after :meth:`reset`: a cold solve of a body at rest may find another solution, in which
        it slides. Later the kernel knows whether its last solution was at rest.
        """
        self._kernel.presume_rest()

    def start_at(self, keys: ArrayLike, r: ArrayLike) -> None:
        """Start the next solve at impulses that are given, instead of those of the last one.

        Args:
            keys: of contacts, ``(c,)`` unsigned integers.
            r: their impulses, ``(c, d)``, N·s, normal first.
        """
        impulses: Any = _arrays.array("r", r, self._number)
        dim = self.size[1]
        if impulses.ndim != 2 or impulses.shape[1] != dim:
            raise ValueError(f"r: shape {list(impulses.shape)} is not (contacts, {dim})")
        self._kernel.start(_arrays.keys_array("keys", keys), impulses)
