"""What comes out of a solve."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import Scene
from ._derivative import Differentiable
from ._loads import Bearing
from ._types import Array, Modes, RowModes, Status, Work


@dataclass(frozen=True, eq=False)
class Solution(Differentiable, Bearing):
    """A velocity, its impulses, and how far they are from the law."""

    #: Velocity at the end of the step, ``(n,)``, m/s and rad/s; empty after :func:`stiction.solve_delassus`.
    v: Array
    #: Contact impulses, ``(c, d)``, N·s, normal first.
    r: Array
    #: Contact velocities ``H_i v + w_i``, ``(c, d)``, m/s, normal first.
    u: Array
    #: :class:`Mode` of each contact, ``(c,)``: an array of int8, printed by names.
    modes: NDArray[np.int8]
    #: Proof of ``Status.INFEASIBLE`` or ``Status.JAMMED``, otherwise 0: ``d`` in the friction cone of each contact, ``(c, d)``,
    #: normal first, no unit; of an infeasible scene normals alone.
    certificate: Array
    #: How the solve ended.
    status: Status
    #: How far it is from Coulomb's law and the dynamics, relative to the impulses, with a bound on rounding; no unit.
    error: float
    #: What it took, by kind.
    work: Work
    #: Impulses ``λ`` of joint rows, ``(k,)``, N·s or N·m·s.
    row_impulses: Array
    #: Their speeds ``s``, ``(k,)``, m/s or rad/s.
    row_velocities: Array
    #: :class:`RowMode` of each, ``(k,)``, likewise.
    row_modes: NDArray[np.int8]
    #: Their part of the proof, ``(k,)``, no unit.
    row_certificate: Array

    @property
    def solved(self) -> bool:
        """Is the error at most the tolerance?"""
        return self.status is Status.SOLVED

    def is_usable(self, error: float) -> bool:
        """Solved, or ended by the budget or the number type with a small error?

        Args:
            error: largest error that is accepted, relative to the impulses; no unit.
        """
        ended = self.status in (Status.OUT_OF_BUDGET, Status.PRECISION_LIMIT)
        return self.solved or (ended and self.error <= error)

    def forces(self, h: float) -> Array:
        """Give the mean forces of contacts over the step, ``r / h``: ``(c, d)``, N (rows of spin and roll N·m), normal first.

        Args:
            h: length of the time step, s.
        """
        return self.r / h


def solution(parts: tuple[Any, ...], scene: Scene | None, settings: tuple[Any, ...]) -> Solution:
    """Make a solution of what the compiled side returns, for a scene that was solved with these settings."""
    parts, fingerprint = parts
    made = object.__new__(Solution)
    # All fields at once: a frozen class sets them one by one, which takes as long as a solve.
    values = dict(zip(_FIELDS, parts, strict=True))
    values["status"] = _STATUS[values["status"]]
    values["work"] = Work(*values["work"])
    values["modes"], values["row_modes"] = values["modes"].view(Modes), values["row_modes"].view(RowModes)
    values["_solved"] = (scene, settings, fingerprint)
    object.__setattr__(made, "__dict__", values)
    return made


_FIELDS = tuple(field.name for field in fields(Solution))
_STATUS = tuple(Status)
