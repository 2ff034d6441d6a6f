"""What goes in beside plain arrays, and the words for what comes out."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]


class Status(IntEnum):
    """How a solve ended."""

    #: There was none, or it was interrupted.
    UNSOLVED = 0
    #: The error is at most the tolerance.
    SOLVED = 1
    #: The error is above the tolerance, but near what rounding in this number type allows.
    PRECISION_LIMIT = 2
    #: No velocity satisfies all contacts and joint rows; the certificate proves it.
    INFEASIBLE = 3
    #: The budget was used up; the solution is the best so far.
    OUT_OF_BUDGET = 4
    #: No solution was found, and friction locks what is to be pushed apart; the certificate proves it.
    JAMMED = 5


class Mode(IntEnum):
    """What a contact does."""

    #: It has no impulse.
    OPEN = 0
    #: It has one, and does not move along its tangents by more than the tolerance allows.
    STICK = 1
    #: It moves along its tangents.
    SLIP = 2


class RowMode(IntEnum):
    """What a joint row does."""

    #: Of a limit: not reached, without an impulse.
    OPEN = 0
    #: Of a limit: reached, and it pushes.
    AT_LIMIT = 1
    #: Of a box: the impulse is its least one; a motor is saturated, dry friction gives way.
    AT_LOWER = 2
    #: Of a box: the impulse is its largest one.
    AT_UPPER = 3
    #: Of an equality or a box: it does not move.
    HOLDING = 4


class Names(np.ndarray[Any, np.dtype[np.int8]]):
    """Integers that are printed by the names of an enumeration; what is computed from them is a plain array."""

    kind: type[IntEnum]

    def __repr__(self) -> str:
        """Such as ``[Mode.STICK, Mode.SLIP]``."""
        names = (f"{self.kind.__name__}.{self.kind(int(code)).name}" for code in np.asarray(self).ravel())
        return f"[{', '.join(names)}]"

    __str__ = __repr__

    def __array_wrap__(self, array: Any, *_: Any) -> Any:
        """Make a result a plain array, or a number."""
        return np.asarray(array)[()]


class Modes(Names):
    """Integers of :class:`Mode`."""

    kind = Mode


class RowModes(Names):
    """Integers of :class:`RowMode`."""

    kind = RowMode


class Work(NamedTuple):
    """The work of a solve, by kind."""

    #: Gauss-Seidel sweeps.
    sweeps: int
    #: Newton steps with the Jacobian of an earlier step.
    chord_steps: int
    #: Newton steps with a new Jacobian, and steps along the central path.
    newton_steps: int
    #: Searches for a proof that a scene is infeasible, at most one in a solve.
    proof_searches: int

    @property
    def total(self) -> int:
        """In the unit of a budget: 2 for a sweep or a chord step, 10 for the others."""
        return 2 * (self.sweeps + self.chord_steps) + 10 * (self.newton_steps + self.proof_searches)


@dataclass(frozen=True, eq=False)
class Rows:
    """Joint rows beside the contacts: ``s = jacobian v + offset + compliance λ``, with ``λ`` from ``lower`` to ``upper``.

    ``λ`` is ``lower`` while ``s > 0`` and ``upper`` while ``s < 0``. So ``(0, inf)`` is a stop, ``(-inf, inf)`` an equality
    (a loop that is closed), ``(-h τ, h τ)`` dry friction of a torque ``τ`` or a motor that it limits.
    """

    #: Over the velocities, ``(k, n)``, 1 or m; anything (``None``) beside a ``W``.
    jacobian: ArrayLike | None
    #: Added to the speed, ``(k,)``, m/s or rad/s; a number stands for ``k`` of them, here and below.
    offset: ArrayLike = 0.0
    #: The least impulse, ``(k,)``, N·s or N·m·s.
    lower: ArrayLike = 0.0
    #: The largest impulse, ``(k,)``, N·s or N·m·s.
    upper: ArrayLike = np.inf
    #: Speed for an impulse, ``(k,)``, 1/kg or 1/(kg m²); 0 is rigid.
    compliance: ArrayLike = 0.0
    #: Which row is which, for a warm start, ``(k,)`` unsigned integers.
    keys: ArrayLike = 0

    @classmethod
    def of(cls, *parts: Rows) -> Rows:
        """Join rows, as the helpers of :mod:`stiction.time_stepping` make them, one after the other.

        Args:
            parts: rows over the same velocities, any number of each.
        """
        jacobians = [np.asarray(part.jacobian) for part in parts]
        if len({found.shape[1:] for found in jacobians}) != 1 or jacobians[0].ndim != 2:
            raise ValueError(f"parts: jacobians of shapes {[list(found.shape) for found in jacobians]} do not join")
        names = ("offset", "lower", "upper", "compliance", "keys")
        counted = [(part, len(found)) for part, found in zip(parts, jacobians, strict=True)]
        joined = {name: np.concatenate([np.broadcast_to(getattr(part, name), count) for part, count in counted]) for name in names}
        return cls(np.concatenate(jacobians), **joined)
