"""The tries of a step of MuJoCo's models, which is solved again with what it has found where the last try led to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._law import Law, Motion, Terms
from ._near import Near, Touch, lost
from ._shift import Shift
from ._types import Array

_TRIES = 5  # after which a step takes no contact anew
_SAME = 1e-6  # up to which terms are those of the step


class Try(NamedTuple):
    """A solve of a step."""

    law: Law
    motion: Motion
    shift: Shift
    touches: list[Touch]
    #: The velocity that leads to where the new ones are seen; ``None`` of the first try, which has none.
    way: Array | None

    def equations(self, terms: Terms) -> Array:
        """The equations of motion and shift."""
        return np.concatenate([self.motion.equations(terms), self.shift.equations(terms)])

    def velocities(self, changes: Array) -> Array:
        """How velocity and shift move where these move by lines: ``(2, lines, nv)``."""
        size = changes.shape[1] - self.shift.size
        by = self.law.velocity(self.motion, changes[:, :size])
        return np.stack([by, self.shift.velocity(changes[:, size:], by)])


def tries(near: Near) -> list[Try]:
    """Try as the step has; the last is the step itself.

    Raises:
        ValueError: its contacts are not found again, as of a body that moves farther than it is thick.
    """
    # What overlaps and does not push may have been found elsewhere than what does: it is then held.
    for touches in (near.touches, [touch for touch in near.touches if near.last.r[touch.place].any()]):
        found = _tried(near, touches)
        if found:
            return found
    raise lost("contacts of the step")


def _tried(near: Near, touches: list[Touch]) -> list[Try]:
    """Try with these contacts; nothing if that does not lead to the step."""
    found: list[Try] = []
    way, everything = None, np.arange(len(near.gap))

    def add(terms: Terms, contacts: Array, touches: list[Touch], known: Motion | None = None) -> None:
        law = Law(terms, near.bounds, contacts, near.error)
        motion = known or law.solved()
        found.append(Try(law, motion, Shift(near, terms, motion, contacts), touches, way))

    if near.is_new.any():
        add(near.terms, np.array(near.overlaps, int), [touch for touch in touches if not touch.is_new])
    while len(found) <= _TRIES:
        if found:
            way = found[-1].motion.v + found[-1].shift.motion.v
            near.lead(near.start.qpos, way)
            touches = [_nearest(near, touch) if touch.is_new else touch for touch in touches]
        terms = near.seen(touches, way, qpos=near.start.qpos)
        if _is_it(near, terms):
            add(near.terms, everything, touches, near.last)
            found[-1].shift.hold(near)
            return found
        if not found:
            break
        add(terms, everything, touches)
    return []


def _nearest(near: Near, touch: Touch) -> Touch:
    """A new contact where it is now."""
    place = near.again(touch, 0.05 * near.size)
    return touch._replace(point=near.late.contact.pos[place].copy())


def _is_it(near: Near, terms: Terms) -> bool:
    """Are these the terms of the step?"""
    nv, last, known_terms = near.model.nv, near.last, near.terms
    found, known = last.equations(terms), last.equations(known_terms)
    known[:nv] = 0.0
    pushes = np.einsum("cdn,cd->n", np.abs(known_terms.H), np.abs(last.r)) + np.abs(last.row_impulses) @ np.abs(known_terms.J)
    impulse = max(float((np.abs(known_terms.impulse) + pushes).max()), 1e-300)
    speed = float((np.abs(known_terms.H) @ np.abs(last.v)).max(initial=0.0))
    momentum, speeds = np.split(np.abs(found - known), [nv])
    fits = speeds.max(initial=0.0) <= _SAME * (speed + near.size / near.h)
    return bool(fits and momentum.max() <= (_SAME + near.error) * impulse)
