"""Many scenes at once."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _arrays, _stiction
from ._arrays import DOUBLE
from ._derivative import Differentiable
from ._types import Array, Rows


@dataclass(frozen=True, eq=False)
class BatchSolution(Differentiable):
    """The solutions of a batch of ``b`` scenes: as :class:`Solution`, with a leading axis."""

    #: Velocities at the ends of the steps, ``(b, n)``, m/s and rad/s.
    v: Array
    #: Contact impulses, ``(b, c, d)``, N·s, normal first.
    r: Array
    #: Contact velocities ``H_i v + w_i``, ``(b, c, d)``, m/s, normal first.
    u: Array
    #: :class:`Mode` of each contact, ``(b, c)``, int8.
    modes: NDArray[np.int8]
    #: Proofs of ``Status.INFEASIBLE`` or ``Status.JAMMED``, otherwise 0; ``(b, c, d)``, no unit.
    certificate: Array
    #: Impulses ``λ`` of joint rows, ``(b, k)``, N·s or N·m·s.
    row_impulses: Array
    #: Their speeds ``s``, ``(b, k)``, m/s or rad/s.
    row_velocities: Array
    #: :class:`RowMode` of each, ``(b, k)``, int8.
    row_modes: NDArray[np.int8]
    #: Their part of the proofs, ``(b, k)``, no unit.
    row_certificate: Array
    #: :class:`Status` of each, ``(b,)``, int8.
    status: NDArray[np.int8]
    #: How far each is from the law, relative to its impulses, ``(b,)``, no unit.
    error: Array
    #: Sweeps, chord steps, Newton steps, searches for a proof: ``(b, 4)``, int32.
    work: NDArray[np.int32]

    def __len__(self) -> int:
        """How many scenes there are."""
        return len(self.status)

    @classmethod
    def empty(cls, b: int, n: int, c: int, d: int = 3, k: int = 0, dtype: DTypeLike = DOUBLE) -> BatchSolution:
        """Make arrays for a batch, of zeros.

        Args:
            b: number of scenes.
            n: velocities of each.
            c: contacts of each.
            d: rows of a contact.
            k: joint rows of each.
            dtype: ``float64`` or ``float32``, that of the solve.
        """
        shapes = _shapes(b, n, c, d, k, _arrays.number_type(dtype))
        return cls(**{name: np.zeros(shape, number) for name, (shape, number) in shapes.items()})


def _shapes(b: int, n: int, c: int, d: int, k: int, number: np.dtype[Any]) -> dict[str, tuple[tuple[int, ...], Any]]:
    return {
        "v": ((b, n), number),
        "r": ((b, c, d), number),
        "u": ((b, c, d), number),
        "modes": ((b, c), np.int8),
        "certificate": ((b, c, d), number),
        "row_impulses": ((b, k), number),
        "row_velocities": ((b, k), number),
        "row_modes": ((b, k), np.int8),
        "row_certificate": ((b, k), number),
        "status": ((b,), np.int8),
        "error": ((b,), number),
        "work": ((b, 4), np.int32),
    }


def solve_batch(
    M: ArrayLike,
    H: ArrayLike,
    free_impulse: ArrayLike,
    w: ArrayLike | None = None,
    mu: ArrayLike | None = None,
    *,
    tol: float = 1e-6,
    budget: int = 1000,
    rows: Rows | None = None,
    compliance: ArrayLike | None = None,
    relaxed: bool = False,
    threads: int | None = None,
    out: BatchSolution | None = None,
    dtype: DTypeLike = DOUBLE,
) -> BatchSolution:
    """Solve ``b`` scenes of one size, each from nothing: the same bits on any number of threads.

    An array has the shape that it has for :func:`stiction.solve` behind a leading axis of length ``b``, or 1 if all scenes share
    it. Where all share it, the axis may be left out as well: ``M`` ``(n, n)`` beside ``free_impulse`` ``(b, n)``. Nothing is copied
    for that. The interpreter's lock is released; Ctrl-C ends the call.

    Args:
        M: generalised mass matrices, ``(b, n, n)`` or ``(n, n)``; kg, kg·m, kg·m² by the units of the velocities.
        H: contact Jacobians, ``(b, c, d, n)`` or ``(c, d, n)``, rows with the normal first; 1 or m.
        free_impulse: ``M v + h F``, ``(b, n)`` or ``(n,)``; N·s, N·m·s.
        w: offsets, ``(b, c, d)`` or ``(c, d)``; m/s. ``None`` is 0.
        mu: friction coefficients, ``(b, c)``, ``(c,)`` or one number; or one for each row behind the normal, ``(b, c, d - 1)`` or
            ``(1, c, d - 1)``; no unit, of spin and roll m.
        tol: error up to which a scene counts as solved; no unit, relative to the impulses.
        budget: work that the solve of a scene may take, in the unit of :attr:`Work.total`.
        rows: joint rows, as many in all scenes; each array ``(b, k, n)`` or ``(b, k)``, or without the leading axis.
        compliance: of contacts, ``(b, c)``, ``(c,)`` or one number, 1/kg; or along the normal and along the tangents,
            ``(b, c, 2)`` or ``(1, c, 2)``; ``None`` is rigid.
        relaxed: solve the convex relaxation instead, ``Model::ConvexRelaxation``.
        threads: how many, at most; ``None`` takes as many as there are cores for this process, and there are never more.
        out: arrays to write to (an earlier result, or :meth:`BatchSolution.empty`); they are returned.
        dtype: ``float64``, or ``float32`` with the bits of a microcontroller.

    Returns:
        The solutions, whatever their status.

    Raises:
        ValueError: as of :func:`stiction.solve`, with the first scene that is refused. ``out`` is then half written.
        KeyboardInterrupt: likewise.
    """
    number = _arrays.number_type(dtype)
    workers = _arrays.threads_of(threads)
    dynamics = tuple(_arrays.led(*own, number) for own in (("M", M, 2), ("H", H, 3), ("free_impulse", free_impulse, 1)))
    w, mu, compliance = (
        None if given is None else _arrays.led(name, given, own, number)
        for name, given, own in (("w", w, 2), ("mu", mu, 1), ("compliance", compliance, 1))
    )
    scenes = _arrays.scene(dynamics, w, mu, compliance, None, rows, number, lead=1)
    shapes = _shapes(*_stiction.batch_shape(scenes, number.itemsize == 4), number)
    if out is None:
        out = BatchSolution(**{name: np.zeros(shape, kind) for name, (shape, kind) in shapes.items()})
    elif not isinstance(out, BatchSolution):
        raise ValueError(f"out: {type(out).__name__} is not BatchSolution")
    places = tuple(getattr(out, field.name) for field in fields(out))
    for place, (name, (shape, kind)) in zip(places, shapes.items(), strict=True):
        if place.shape != shape or place.dtype != kind or not place.flags.c_contiguous or not place.flags.writeable:
            raise ValueError(f"out.{name}: not a contiguous array of shape {list(shape)} and type {np.dtype(kind)}")
    settings = (tol, budget, bool(relaxed))
    fingerprint = _stiction.solve_batch(scenes, settings, workers, places, number.itemsize == 4)
    object.__setattr__(out, "_solved", (scenes, settings, fingerprint))
    return out
