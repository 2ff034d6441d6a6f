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

    #: ``(b, n)``
    v: Array
    #: ``(b, c, d)``
    r: Array
    #: ``(b, c, d)``
    u: Array
    #: ``(b, c)``, int8
    modes: NDArray[np.int8]
    #: ``(b, c, d)``
    certificate: Array
    #: ``(b, k)``
    row_impulses: Array
    #: ``(b, k)``
    row_velocities: Array
    #: ``(b, k)``, int8
    row_modes: NDArray[np.int8]
    #: ``(b, k)``
    row_certificate: Array
    #: :class:`Status` of each, ``(b,)``, int8.
    status: NDArray[np.int8]
    #: ``(b,)``
    error: Array
    #: Sweeps, chord steps, Newton steps, searches for a proof: ``(b, 4)``, int32.
    work: NDArray[np.int32]

    def __len__(self) -> int:
        """How many scenes there are."""
        return len(self.status)

    @classmethod
    def empty(cls, b: int, n: int, c: int, d: int = 3, k: int = 0, dtype: DTypeLike = DOUBLE) -> BatchSolution:
        """Make arrays for ``b`` scenes of ``n`` velocities, ``c`` contacts of ``d`` rows and ``k`` joint rows."""
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
    w: ArrayLike,
    mu: ArrayLike,
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

    The arguments are those of :func:`stiction.solve`, each with a leading axis of length ``b``, or 1 if all scenes share it:
    ``M`` ``(b, n, n)``, ``H`` ``(b, c, d, n)``, ``free_impulse`` ``(b, n)``, ``w`` ``(b, c, d)``, ``mu`` ``(b, c)``. The
    interpreter's lock is released; Ctrl-C ends the call.

    Args:
        M: see above, here and below.
        H: .
        free_impulse: .
        w: .
        mu: ., or one number.
        tol: .
        budget: .
        rows: .
        compliance: .
        relaxed: .
        threads: how many, at most; ``None`` takes as many as there are cores for this process, and there are never more.
        out: arrays to write to (an earlier result, or :meth:`BatchSolution.empty`); they are returned.
        dtype: .

    Raises:
        ValueError: as of :func:`stiction.solve`, with the first scene that is refused. ``out`` is then half written.
        KeyboardInterrupt: likewise.
    """
    number = _arrays.number_type(dtype)
    workers = _arrays.threads_of(threads)
    scenes = _arrays.scene((M, H, free_impulse), w, mu, compliance, None, rows, number, lead=1)
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
