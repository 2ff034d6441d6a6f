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

    OPEN = 0
    AT_LIMIT = 1
    AT_LOWER = 2
    AT_UPPER = 3
    HOLDING = 4


class Work(NamedTuple):
    """The work of a solve, by kind."""

    sweeps: int
    chord_steps: int
    newton_steps: int
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

    #: ``(k, n)``; anything (``None``) beside a ``W``.
    jacobian: ArrayLike | None
    #: ``(k,)``, m/s or rad/s; a number stands for ``k`` of them, here and below.
    offset: ArrayLike = 0.0
    #: The least impulse, ``(k,)``, N·s or N·m·s.
    lower: ArrayLike = 0.0
    #: The largest impulse, ``(k,)``.
    upper: ArrayLike = np.inf
    #: ``(k,)``, the unit of ``s`` over that of ``λ``; 0 is rigid.
    compliance: ArrayLike = 0.0
    #: Which row is which, for a warm start, ``(k,)`` unsigned integers.
    keys: ArrayLike = 0
