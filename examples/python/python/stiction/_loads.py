"""What a solution bears: least impulses, and how near to slipping it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays, _stiction
from ._types import Array, Rows


@dataclass(frozen=True, eq=False)
class LeastImpulses:
    """Of all impulses that obey the law with a velocity, those of springs of equal stiffness."""

    #: Of contacts, ``(c, d)``, N·s, normal first.
    r: Array
    #: Of joint rows, ``(k,)``, N·s or N·m·s.
    row_impulses: Array
    #: The share of its friction that each contact uses, ``(c,)``: ``|r_T| / (mu r_N)``, or 0. 1 is no warning.
    use: Array
    #: The share of the momentum of the solution's impulses that they miss; no unit.
    momentum_error: float


class Bearing:
    """A solution of one scene, and what it bears. The arrays that were solved have to be as they were."""

    v: Array
    r: Array
    row_impulses: Array

    def least(self, *, still: float = 0.0) -> LeastImpulses:
        """Share loads as springs of equal stiffness do: unique, and the same whatever came before.

        Args:
            still: speed up to which a contact that slips or opens counts as one that sticks, m/s.

        Raises:
            ValueError: the scene was not solved, or its arrays have changed.
        """
        found = self._told("least", still)
        r, rows = np.split(found[1:], [self.r.size])
        scene: _arrays.Scene = vars(self)["_solved"][0]
        return LeastImpulses(r.reshape(self.r.shape), rows, _use(r.reshape(self.r.shape), scene[4]), float(found[0]))

    def slip_reserve(self, *, accuracy: float = 1e-4, still: float = 0.0) -> float:
        """Tell the least share of the friction of all that sticks with which it still sticks: 0.8, and a fifth may go.

        It is 0 where nothing sticks: where all slips or is in the air. :func:`rest_reserve` goes on above 1 there.

        Args:
            accuracy: of the share, relative; no unit.
            still: speed up to which a contact that slips or opens counts as one that sticks, m/s.

        Raises:
            ValueError: as of :meth:`least`.
        """
        return float(self._told("slip", still, accuracy)[0])

    def load_reserve(self, load: ArrayLike, *, accuracy: float = 1e-4, still: float = 0.0) -> float:
        """Tell the largest factor on a further impulse ``load`` ``(n,)`` with which all that sticks still sticks.

        It is that of the convex relaxation: Coulomb's law may let go earlier.

        Args:
            load: over the velocities, ``(n,)``; N·s, N·m·s.
            accuracy: of the factor, relative; no unit.
            still: speed up to which a contact that slips or opens counts as one that sticks, m/s.

        Raises:
            ValueError: as of :meth:`least`; the load has the wrong shape, or is not finite.
        """
        return float(self._told("load", still, accuracy, _arrays.array("load", load, _arrays.DOUBLE))[0])

    def _told(self, name: str, still: float, accuracy: float = 0.0, load: Array | None = None) -> Array:
        scene, settings, fingerprint = vars(self).get("_solved", (None, None, None))
        if scene is None:
            raise ValueError("solution: its scene is not known")
        if fingerprint not in (None, _stiction.fingerprint(scene, False, self.r.dtype == np.float32)):
            raise ValueError("solution: the arrays that were solved have changed")
        impulses = (np.ravel(np.asarray(self.r, np.float64)), np.asarray(self.row_impulses, np.float64))
        further = np.zeros(0) if load is None else load
        return _stiction.bear(scene, settings, impulses, (name, float(still), float(accuracy), further))


def _use(r: Array, mu: Any) -> Array:
    """The share of friction that contacts use; coefficients by row make the cone elliptic."""
    tangents, own = r[:, 1:], np.asarray(mu, np.float64)
    own = own[:, None] if own.ndim == 1 else own
    with np.errstate(divide="ignore", invalid="ignore"):
        rub: Array = np.linalg.norm(np.where(tangents == 0.0, 0.0, tangents / own), axis=1)
        used: Array = np.where(rub == 0.0, 0.0, rub / r[:, 0])
    return used


def rest_reserve(
    M: ArrayLike, H: ArrayLike, free_impulse: ArrayLike, mu: ArrayLike, *, accuracy: float = 1e-4, rows: Rows | None = None
) -> float:
    """Tell the least share of friction with which all could stay at rest, if all contacts bear.

    Above 1 something slides; it is infinite if something tips or falls whatever the friction. Joint rows hold within their bounds.

    Args:
        M: generalised mass matrix, ``(n, n)``; kg, kg·m, kg·m² by the units of the velocities.
        H: contact Jacobians, ``(c, d, n)``, rows with the normal first; 1 or m.
        free_impulse: ``M v + h F``, ``(n,)``; N·s, N·m·s.
        mu: friction coefficients, ``(c,)`` or one number, no unit; or one for each row behind the normal, ``(c, d - 1)``.
        accuracy: of the share, relative; no unit.
        rows: joint rows, ``k`` of them.

    Raises:
        ValueError: as of :func:`stiction.solve`.
    """
    contacts = _arrays.jacobians(H)
    scene = _arrays.scene((M, contacts, free_impulse), np.zeros(contacts.shape[:2]), mu, None, None, rows, _arrays.DOUBLE)
    asked = ("rest", 0.0, float(accuracy), np.zeros(0))
    return float(_stiction.bear(scene, (1e-6, 1000, False), (np.zeros(0), np.zeros(0)), asked)[0])
