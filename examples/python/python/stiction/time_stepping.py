"""From one time step to the next: the free impulse, Jacobians, offsets ``w`` and joint rows of a scene.

The helpers of the Rust library's ``time_stepping``, with its names, fields, defaults and arithmetic. Steps are semi-implicit:
masses, Jacobians and gaps are those at the beginning of a step of length ``h``, contacts and rows act on the velocity at its end.

A number without meaning (NaN, a step of 0, a negative stiffness) raises a ``ValueError`` that begins with its name, when used.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import SupportsIndex

from numpy.typing import ArrayLike

from . import _arrays, _stiction
from ._arrays import DOUBLE
from ._types import Array, Mode, Rows

__all__ = [
    "ClosedLoop",
    "DryFriction",
    "Gap",
    "JointLimit",
    "Motor",
    "Restitution",
    "Spring",
    "StaticFriction",
    "Suction",
    "contact_frame",
    "contact_rows",
    "free_impulse",
    "moving_surface",
]


def _row(row: ArrayLike, numbers: tuple[float, float, float, float], key: int) -> Rows:
    offset, lower, upper, compliance = numbers
    return Rows(_vector("row", row)[None], offset, lower, upper, compliance, key)


@dataclass(frozen=True)
class Gap:
    """The distance of a contact, or of a joint from its stop, which may close within the step, and no further."""

    #: Distance, m or rad: negative in penetration, infinite if nothing is near.
    distance: float = 0.0
    #: Largest speed at which a penetration is pushed out, m/s or rad/s, not negative; with 0 it stays. 0.1 m/s brings it out
    #: gently. Infinity throws the body: 1 mm is out after a step of 1 ms, at 1 m/s, and this velocity lasts.
    recovery: float = 0.0
    #: Largest offset, m/s or rad/s, not negative: the largest closing speed that is expected.
    reach: float = inf

    def offset(self, step: float) -> float:
        """Give the normal offset ``distance / step``, not below ``-recovery`` and not above ``reach``.

        Args:
            step: length of the time step, s, positive.

        Returns:
            The first entry of ``w`` of the contact, m/s.
        """
        return _stiction.gap_offset(self, step)

    def row(self, row: ArrayLike, step: float, key: int = 0) -> Rows:
        """Make the joint row of a stop: ``0 <= λ ⟂ row v + distance / h >= 0``.

        Args:
            row: over the velocities, ``(n,)``: 1 at the joint with ``distance = q - q_min``, or -1 with ``q_max - q``; no unit.
            step: length of the time step, s.
            key: which row it is in all steps, an unsigned integer.
        """
        return _row(row, _stiction.gap_row(self, step), key)


#: Stop of a joint: a :class:`Gap` in rad and rad/s, or m and m/s, with its :meth:`Gap.row`.
JointLimit = Gap


@dataclass(frozen=True)
class DryFriction:
    """Dry friction of a joint: a torque up to a limit holds the joint, or slows it down."""

    #: Largest torque, N·m or N, not negative.
    torque: float

    def row(self, row: ArrayLike, step: float, key: int = 0) -> Rows:
        """Make the joint row.

        Args:
            row: over the velocities, ``(n,)``: 1 at the joint; no unit.
            step: length of the time step, s.
            key: which row it is in all steps, an unsigned integer.
        """
        return _row(row, _stiction.dry_friction_row(self, step), key)


@dataclass(frozen=True)
class Motor:
    """A motor with a position and velocity controller and a torque limit, as one row.

    Its torque is ``-k_p (q + h q̇ - q_d) - k_d (q̇ - v_d) + τ_ff`` within ``± limit``, with the velocity ``q̇`` at the end of the
    step. So stiff gains are stable at any step, and the limit is exact.
    """

    #: Gain ``k_p`` of the position, N·m/rad or N/m, not negative.
    stiffness: float = 0.0
    #: Gain ``k_d`` of the velocity, N·m·s/rad or N·s/m, not negative. At least one of the gains is above 0.
    damping: float = 0.0
    #: Torque ``τ_ff`` added to that of the gains, N·m or N.
    feedforward: float = 0.0
    #: Largest torque, N·m or N, not negative; infinite is none.
    limit: float = inf
    #: Position minus wanted position at the beginning of the step, ``q - q_d``, rad or m.
    ahead: float = 0.0
    #: Wanted velocity ``v_d``, rad/s or m/s.
    target: float = 0.0

    def row(self, row: ArrayLike, step: float, key: int = 0) -> Rows:
        """Make the joint row. Its impulse over the step is the torque of the motor.

        Args:
            row: over the velocities, ``(n,)``: 1 at the joint; no unit.
            step: length of the time step, s.
            key: which row it is in all steps, an unsigned integer.
        """
        return _row(row, _stiction.motor_row(self, step), key)


@dataclass(frozen=True)
class ClosedLoop:
    """One row of a closed loop or of a gear: ``row v + drift / h = 0``. Redundant rows do no harm."""

    #: Position error of the loop, of which the row is the derivative, m or rad.
    drift: float = 0.0
    #: Largest speed at which the drift is removed, m/s or rad/s, not negative.
    recovery: float = inf

    def row(self, row: ArrayLike, step: float, key: int = 0) -> Rows:
        """Make the joint row.

        Args:
            row: over the velocities, ``(n,)``: the constraint Jacobian; 1 or m.
            step: length of the time step, s.
            key: which row it is in all steps, an unsigned integer.
        """
        return _row(row, _stiction.closed_loop_row(self, step), key)


@dataclass(frozen=True)
class Restitution:
    """A contact that bounces, by Newton's law. With friction this law may make energy, without it never does."""

    #: Coefficient of restitution ``e``, 0 to 1.
    coefficient: float
    #: Largest approach speed without a bounce, m/s, not negative.
    threshold: float

    def offset(self, approach: float, gap_offset: float) -> float:
        """Give the normal offset ``e u_N⁻`` if the contact closes within the step, faster than the threshold; else ``gap_offset``.

        Args:
            approach: normal velocity ``u_N⁻`` before the step, m/s, negative in approach.
            gap_offset: result of :meth:`Gap.offset`, m/s.

        Returns:
            The first entry of ``w`` of the contact, m/s.
        """
        return _stiction.restitution_offset(self, approach, gap_offset)


@dataclass(frozen=True)
class Spring:
    """A spring with a damper in a contact or a joint row, implicit over the step: compliance and offset belong together."""

    #: Stiffness ``k``, N/m or N·m/rad, positive; infinite is rigid.
    stiffness: float
    #: Relaxation time ``τ``, s, not negative. The damper is ``k τ``.
    relaxation: float

    def compliance(self, step: float) -> float:
        """Give the compliance ``1 / (h (h + τ) k)``, 1/kg or 1/(kg m²).

        Args:
            step: length of the time step ``h``, s.
        """
        return _stiction.spring_compliance(self, step)

    def offset(self, gap: Gap, step: float) -> float:
        """Give the normal offset ``distance / (h + τ)``, m/s or rad/s, at most ``reach``.

        Args:
            gap: distance at the beginning of the step; its ``recovery`` has no effect.
            step: length of the time step ``h``, s.
        """
        if not isinstance(gap, Gap):
            raise ValueError(f"gap: {type(gap).__name__} is not Gap")
        return _stiction.spring_offset(self, gap, step)


@dataclass(frozen=True)
class Suction:
    """A contact that pulls while it touches: a suction cup, a magnet.

    Take the pull from the free impulse before the solve, and from the solved impulse after it.
    """

    #: Largest pull, N, not negative.
    force: float
    #: Does the contact touch at the beginning of the step? Across a gap it does not pull.
    touches: bool

    def push_back(self, jacobian: ArrayLike, step: float, free_impulse: ArrayLike) -> Array:
        """Give the free impulse without the pull, for the solve.

        Args:
            jacobian: of the contact, ``(d, n)``, the normal row first; 1 or m.
            step: length of the time step, s.
            free_impulse: ``(n,)``, N·s and N·m·s; it stays as it is.
        """
        rows = _matrix("jacobian", jacobian)
        if not len(rows):
            raise ValueError("jacobian: there are no rows")
        return _stiction.suction_push_back(self, rows[0], step, _vector("free_impulse", free_impulse, rows.shape[1]))

    def impulse(self, solved: ArrayLike, step: float) -> Array:
        """Give the impulse of the contact, which may pull, N·s.

        Args:
            solved: its impulse in the solution, ``(d,)``, N·s, normal first.
            step: length of the time step, s.
        """
        impulse = _vector("solved", solved).copy()
        if not len(impulse):
            raise ValueError("solved: there are no rows")
        impulse[0] = _stiction.suction_impulse(self, impulse[0], step)
        return impulse


@dataclass(frozen=True)
class StaticFriction:
    """Static and kinetic friction: a contact that slipped in the last step has the lower coefficient in this one."""

    #: Coefficient of a contact that sticks, opens or is new.
    at_rest: float
    #: Coefficient of a contact that slips.
    sliding: float

    def mu(self, last: SupportsIndex | None) -> float:
        """Give the coefficient for the next step.

        Args:
            last: :class:`stiction.Mode` of the contact in the last step, ``None`` if it is new.
        """
        return self.sliding if last == Mode.SLIP else self.at_rest


def contact_frame(normal: ArrayLike) -> Array:
    """Give the frame of a contact, ``(k, k)``: its rows are the normal and the tangents.

    An impulse ``r`` of the contact is the vector ``r @ frame``.

    Args:
        normal: of length 1, out of the obstacle, ``(k,)`` with ``k`` = 2 or 3 coordinates, the last of them upwards; no unit.
    """
    axes = _vector("normal", normal)
    return _stiction.contact_frame(axes).reshape(len(axes), len(axes))


def contact_rows(normal: ArrayLike, velocity: ArrayLike) -> Array:
    """Give the Jacobian of a contact, ``(k, n)``, rows with the normal first: ``H[i]`` of a scene.

    Args:
        normal: as of :func:`contact_frame`, ``(k,)``.
        velocity: Jacobian of the point that touches, in the coordinates of the normal, ``(k, n)``; 1 or m. Of two bodies it is
            that of the first minus that of the second, out of which the normal points.
    """
    frame = contact_frame(normal)
    matrix = _matrix("velocity", velocity)
    if len(matrix) != len(frame):
        raise ValueError(f"velocity: {len(matrix)} rows are not those of the normal")
    rows: Array = frame @ matrix
    return rows


def free_impulse(mass: ArrayLike, velocity: ArrayLike, force: ArrayLike, step: float) -> Array:
    """Give the momentum at the end of the step without contacts, ``M v⁻ + h F``: ``(n,)``, N·s and N·m·s.

    Args:
        mass: generalised mass matrix ``M``, ``(n, n)``; kg, kg·m, kg·m² by the units of the velocities.
        velocity: before the step, ``v⁻``, ``(n,)``, m/s and rad/s.
        force: sum of all forces but those of contacts: weight, motors, ``-C(q, v⁻) v⁻``; ``(n,)``, N and N·m.
        step: length of the time step ``h``, s.
    """
    matrix = _matrix("mass", mass)
    momentum: Array = matrix @ _vector("velocity", velocity, matrix.shape[1]) + _vector("force", force, len(matrix)) * step
    return momentum


def moving_surface(frame: ArrayLike, velocity: ArrayLike) -> Array:
    """Give the offset of a contact with a moving surface, ``-R v_s``: ``(d,)``, m/s. Add it to the other offsets.

    Args:
        frame: normal and tangents of the contact in the coordinates of the velocity, ``(d, k)``, no unit; or a contact's Jacobian.
        velocity: of the surface at the contact, ``(k,)``, m/s; with a Jacobian that of the whole system, ``(n,)``, m/s and rad/s.
    """
    matrix = _matrix("frame", frame)
    offset: Array = -(matrix @ _vector("velocity", velocity, matrix.shape[1]))
    return offset


def _matrix(name: str, given: ArrayLike) -> Array:
    matrix = _arrays.array(name, given, DOUBLE)
    if matrix.ndim != 2:
        raise ValueError(f"{name}: shape {list(matrix.shape)} is not that of a matrix")
    return matrix


def _vector(name: str, given: ArrayLike, length: int | None = None) -> Array:
    vector = _arrays.array(name, given, DOUBLE)
    if vector.ndim != 1 or length not in (None, len(vector)):
        raise ValueError(f"{name}: shape {list(vector.shape)} is not {'flat' if length is None else [length]}")
    return vector
