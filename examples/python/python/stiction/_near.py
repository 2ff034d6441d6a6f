"""The equations of a step of MuJoCo's models, at states near the one it was taken from."""

from __future__ import annotations

import copy
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

import mujoco
import numpy as np

from ._types import Array, Mode

if TYPE_CHECKING:
    from .mujoco import Stepper

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
_ROW, _DISABLE, _INTEGRATOR = mujoco.mjtConstraint, mujoco.mjtDisableBit, mujoco.mjtIntegrator
_EQUALITY, _LIMITS = int(_ROW.mjCNSTR_EQUALITY), (int(_ROW.mjCNSTR_LIMIT_JOINT), int(_ROW.mjCNSTR_LIMIT_TENDON))
_D = 6  # rows that a contact may have

# As the compiled side has them, over the model's mean size: gaps up to which contacts are listed, overlaps that count as none, and
# how deep lies what rests.
_BAND, _SLOP, _DEPTH = 1e-6, 1e-7, 3e-9


class Pose(IntEnum):
    """Where a step looks at its contacts: where it begins, where it would end without them, where it ends."""

    START = 0
    FREE = 1
    END = 2


class Touch(NamedTuple):
    """A contact that pushes, and what it is found again by."""

    place: int
    geoms: Array
    dim: int
    #: Where its rows are seen, and where its gap.
    rows: Pose
    gap: Pose
    #: Where it is, at each of these.
    points: dict[Pose, Array]


class Near:
    """A step that was taken, with its velocity, contacts and joint rows, and what these are at states near by."""

    def __init__(self, stepper: Stepper, data: mujoco.MjData, eps: float) -> None:
        """Take the step of a copy of the data."""
        self.start, self.end, self.eps, self.h = data, copy.copy(data), eps, stepper.model.opt.timestep
        self.size, self.extent = stepper.model.stat.meansize, max(stepper.model.stat.extent, 1.0)
        stepper.step1(self.end)
        contact = self.end.contact
        listed = contact.dist - contact.includemargin + (_BAND + _DEPTH) * self.size
        stepper.step2(self.end)
        self.model, self.grown = self._model(stepper.model)
        self.jnt_margin, self.tendon_margin = stepper.model.jnt_margin, stepper.model.tendon_margin
        self.scratch, *poses = (mujoco.MjData(self.model) for _ in Pose)
        self.poses = {Pose.START: self.scratch, Pose.FREE: poses[0], Pose.END: poses[1]}
        self.state = np.empty(mujoco.mj_stateSize(self.model, STATE))
        mujoco.mj_getState(stepper.model, data, self.state, STATE)
        self.is_damped = False
        self.mass, self.impulse, self.act = self._smooth()
        if self.model.opt.integrator != _INTEGRATOR.mjINT_EULER and np.linalg.eigvalsh(self.mass)[0] <= 0:
            self.is_damped = True  # the Stepper then takes the damping of joints alone
            self.mass, self.impulse, self.act = self._smooth()
        self.v, self.shift = self.end.qvel.copy(), np.zeros(self.model.nv)
        middle = self.integrated(data.qpos, self.v)
        mujoco.mj_differentiatePos(self.model, self.shift, self.h, middle, self.end.qpos)
        self.motion = self.v + self.shift
        self._take_contacts(listed, np.array(stepper.modes, int))
        self._take_rows()
        self._check(stepper.error)

    def _model(self, given: mujoco.MjModel) -> tuple[mujoco.MjModel, float]:
        """A model that lists what is near as well, with the Stepper's options; by how much more (m)."""
        model = copy.copy(given)
        model.opt.disableflags |= _DISABLE.mjDSBL_ISLAND
        model.opt.ccd_tolerance, model.opt.ccd_iterations = 1e-12 * self.size, 200
        if model.opt.integrator != _INTEGRATOR.mjINT_EULER:
            model.opt.integrator = _INTEGRATOR.mjINT_IMPLICITFAST
        grown = _BAND * self.size + 10 * self.eps * self.extent
        model.geom_margin[:] += grown / 2
        model.body_margin[:] += grown / 2
        model.pair_margin[:] += grown
        limits = np.isin(self.end.efc_type, _LIMITS)
        far = self.end.efc_pos[limits].max(initial=0.0) + grown
        model.jnt_margin[:] += far
        model.tendon_margin[:] += far
        return model, grown

    def integrated(self, positions: Array, velocity: Array, time: float | None = None) -> Array:
        """Positions after a time step, or another time, at a velocity."""
        moved: Array = positions.copy()
        mujoco.mj_integratePos(self.model, moved, velocity, self.h if time is None else time)
        return moved

    def _smooth(self, **changed: Array) -> tuple[Array, Array, Array]:
        """The mass matrix with what is implicit in it, the free impulse, and the next activations, of a changed state."""
        model, data, nv = self.model, self.scratch, self.model.nv
        mujoco.mj_setState(model, data, self.state, STATE)
        for name, numbers in changed.items():
            getattr(data, name)[:] = numbers
        mujoco.mj_step1(model, data)
        mujoco.mj_fwdActuation(model, data)
        mujoco.mj_fwdAcceleration(model, data)
        mass, force, velocity = np.zeros((nv, nv)), data.qfrc_smooth.copy(), data.qvel.copy()
        mujoco.mj_fullM(model, data, mass)
        self.positions = data.qpos.copy()
        is_implicit = model.opt.integrator != _INTEGRATOR.mjINT_EULER
        (mujoco.mj_implicit if is_implicit else mujoco.mj_Euler)(model, data)  # activations, and qDeriv
        if is_implicit and not self.is_damped:
            D = np.zeros((nv, nv))
            D[np.repeat(np.arange(nv), model.D_rownnz), model.D_colind] = data.qDeriv
            mass -= self.h / 2 * (D + D.T)
        elif not model.opt.disableflags & (_DISABLE.mjDSBL_EULERDAMP | _DISABLE.mjDSBL_DAMPER):
            mass += self.h * np.diag(model.dof_damping)
        return mass, mass @ velocity + self.h * force, data.act.copy()

    def _take_contacts(self, listed: Array, modes: Array) -> None:
        """Take the contacts of the step, with the gaps that they had as it began."""
        end, contact, nv = self.end, self.end.contact, self.model.nv
        part = np.flatnonzero(modes >= 0)
        c = len(part)
        self.H, self.w, self.r = np.zeros((c, _D, nv)), np.zeros((c, _D)), np.zeros((c, _D))
        self.friction, self.dim, self.gap = np.zeros((c, _D - 1)), contact.dim[part], contact.dist[part]
        self.mobility = self.model.body_invweight0[self.model.geom_bodyid[contact.geom[part]], 0].sum(axis=1)
        self.touches: list[Touch] = []
        self._lead(Pose.FREE, np.linalg.solve(self.mass, self.impulse))
        self._lead(Pose.END, self.motion)
        for i, place in enumerate(part):
            dim, rows = self.dim[i], slice(contact.efc_address[place], contact.efc_address[place] + self.dim[i])
            self.H[i, :dim], self.r[i, :dim] = end.efc_J.reshape(-1, nv)[rows], self.h * end.efc_force[rows]
            self.friction[i, : dim - 1] = contact.friction[place, : dim - 1]
            self.w[i, 1 : min(dim, 4)] = contact.surfacevel[place, : min(dim, 4) - 1]
            self.w[i, 0] = max(self.gap[i], 0.0) / self.h
            if modes[place] != Mode.OPEN:
                is_curved = place < len(listed) and abs(self.gap[i] - listed[place]) > 1e-9 * self.size
                self.touches.append(self._touch(i, int(place), place >= len(listed), is_curved))

    def _touch(self, i: int, place: int, is_new: bool, is_curved: bool) -> Touch:
        """See where a contact of the list is, and where its row and its gap are from."""
        geoms, point = self.end.contact.geom[place].copy(), self.end.contact.pos[place].copy()
        touch = Touch(i, geoms, int(self.dim[i]), Pose.START, Pose.START, {Pose.START: point})
        if not is_new and not is_curved:
            return touch
        reach = 0.05 * self.size + (self.h * float(np.abs(self.v).max()) * self.extent if is_curved else 0.0)
        near = {}
        for pose in (Pose.FREE, Pose.END):
            found = self._again(pose, touch._replace(points={pose: point}), reach)
            if found is not None:
                near[pose] = self.poses[pose].contact.pos[found].copy()
        if is_curved:
            near.pop(Pose.FREE, None)
        if not near:
            raise _lost(self.model, touch)
        last = min(near, key=lambda pose: float(np.linalg.norm(near[pose] - point)))
        return touch._replace(rows=last if is_new else Pose.START, gap=last, points={Pose.START: point, last: near[last]})

    def _take_rows(self) -> None:
        """Take the joint rows of the step, of limits those that it may reach."""
        end, h = self.end, self.h
        J, kind, gap = end.efc_J.reshape(-1, self.model.nv), end.efc_type, self._gaps(end)
        fastest = np.min([J @ v for v in (self.v, self.start.qvel, np.linalg.solve(self.mass, self.impulse))], axis=0)
        is_limit = np.isin(kind, _LIMITS)
        kept = (kind < _LIMITS[0]) | is_limit & ((gap <= 0) | (gap + h * fastest < 0))
        self.J, self.names, self.row_impulses = J[kept], self._names(end)[kept], h * end.efc_force[kept]
        self.is_limit, self.row_gap = is_limit[kept], gap[kept]
        most = np.where(kind == _EQUALITY, np.inf, h * end.efc_frictionloss)[kept]
        self.lower, self.upper = np.where(self.is_limit, 0.0, -most), np.where(self.is_limit, np.inf, most)
        self.offset = np.where(self.is_limit, np.maximum(self.row_gap, 0.0) / h, 0.0)

    def _gaps(self, data: mujoco.MjData) -> Array:
        """What is left up to limits (m, rad), beside numbers of other constraints."""
        gaps = data.efc_pos.copy()
        for kind, margin in zip(_LIMITS, (self.jnt_margin, self.tendon_margin), strict=True):
            own = data.efc_type == kind
            gaps[own] -= margin[data.efc_id[own]]
        return gaps

    def _names(self, data: mujoco.MjData) -> Array:
        """What constraints are found again by: their kind, what they are of, and which of its rows; of a limit its side."""
        kind, own = data.efc_type, data.efc_id
        number = np.zeros_like(own)
        for i in range(1, data.nefc):
            if kind[i] == kind[i - 1] and own[i] == own[i - 1]:
                number[i] = number[i - 1] + 1
        side = data.efc_J.reshape(-1, self.model.nv).sum(axis=1) > 0
        return np.stack([kind, own, np.where(np.isin(kind, _LIMITS), side, number)], axis=1)

    def _check(self, error: float) -> None:
        """See whether the equations of the step are found again.

        Raises:
            ValueError: they are not.
        """
        found = self.equations(self.motion)
        known = np.concatenate([np.zeros(self.model.nv), (self.H @ self.v + self.w).ravel(), self.J @ self.v + self.offset])
        pushes = np.einsum("cdn,cd->cn", np.abs(self.H), np.abs(self.r)).sum(axis=0) + np.abs(self.row_impulses) @ np.abs(self.J)
        impulse = max(float((np.abs(self.impulse) + pushes).max()), 1e-300)
        speed = float((np.abs(self.H) @ np.abs(self.v)).max(initial=0.0))
        off, nv = np.abs(found[: len(known)] - known), self.model.nv
        if off[:nv].max() > (1e-5 + error) * impulse or off[nv:].max(initial=0.0) > 1e-5 * speed + 2 * _SLOP * self.size / self.h:
            raise ValueError("data: the step is not found again, as of a body that moves farther in it than it is thick")

    def _again(self, pose: Pose, touch: Touch, reach: float) -> int | None:
        """The place of a contact in the list of a pose, if it is there."""
        contact = self.poses[pose].contact
        same = np.flatnonzero((contact.geom == touch.geoms).all(axis=1))
        away = np.linalg.norm(contact.pos[same] - touch.points[pose], axis=1)
        return int(same[away.argmin()]) if away.min(initial=np.inf) <= reach else None

    def _lead(self, to: Pose, motion: Array) -> None:
        """Look at the pose at the end of a motion."""
        pose = self.poses[to]
        pose.qpos[:] = self.integrated(self.positions, motion)
        pose.mocap_pos[:], pose.mocap_quat[:] = self.start.mocap_pos, self.start.mocap_quat
        mujoco.mj_kinematics(self.model, pose)
        mujoco.mj_comPos(self.model, pose)
        mujoco.mj_collision(self.model, pose)

    def equations(self, motion: Array | None = None, **changed: Array) -> Array:
        """Momentum, velocities of contacts and of joint rows, and next activations, with the velocity and the impulses of the step.

        Args:
            motion: where to look for contacts that are told at the end, if not where the step leads.
            changed: what of the state is not as it was: ``qpos``, ``qvel``, ``act``, ``ctrl``.
        """
        mass, impulse, act = self._smooth(**changed)
        H, w, J, offset = self.H, self.w, self.J, self.offset
        if motion is not None or "qpos" in changed or self.sees(Pose.FREE):
            H, w, J, offset = H.copy(), w.copy(), J.copy(), offset.copy()
            motions = {Pose.START: np.zeros_like(self.v)}
            motions[Pose.FREE] = np.linalg.solve(mass, impulse) if self.sees(Pose.FREE) else self.v
            motions[Pose.END] = self.motion if motion is None else motion
            self._look(H, w, motions)
            self._look_at_rows(J, offset)
        momentum = impulse - mass @ self.v + np.einsum("cdn,cd->n", H, self.r) + self.row_impulses @ J
        return np.concatenate([momentum, (H @ self.v + w).ravel(), J @ self.v + offset, act])

    def sees(self, pose: Pose) -> bool:
        """Is a contact seen there?"""
        return any(touch.gap == pose for touch in self.touches)

    def _look(self, H: Array, w: Array, motions: dict[Pose, Array]) -> None:
        """See rows and velocities of contacts that push."""
        for pose in (Pose.FREE, Pose.END):
            if self.sees(pose):
                self._lead(pose, motions[pose])
        for touch in self.touches:
            i, dim, contact = touch.place, touch.dim, self.poses[touch.rows].contact
            places = [self._again(pose, touch, 1e-5 * self.size + 20 * self.eps * self.extent) for pose in (touch.rows, touch.gap)]
            if places[0] is None or places[1] is None:
                raise _lost(self.model, touch)
            H[i, :dim] = self._rows(touch, places[0])
            w[i, 1 : min(dim, 4)] = contact.surfacevel[places[0], : min(dim, 4) - 1]
            contact = self.poses[touch.gap].contact
            gap = contact.dist[places[1]] - contact.includemargin[places[1]] + self.grown + _DEPTH * self.size
            w[i, 0] = self._closing(gap - self.h * H[i, 0] @ motions[touch.gap], self.gap[i])

    def _look_at_rows(self, J: Array, offset: Array) -> None:
        """See joint rows that may push."""
        names, gaps, rows = self._names(self.scratch), self._gaps(self.scratch), self.scratch.efc_J.reshape(-1, self.model.nv)
        for j, name in enumerate(self.names):
            if self.is_limit[j] and self.row_impulses[j] == 0.0:
                continue
            found = np.flatnonzero((names == name).all(axis=1))
            if not len(found):
                raise ValueError("data: a limit or an equality ends as things move by eps")
            J[j] = rows[found[0]]
            if self.is_limit[j]:
                offset[j] = self._closing(gaps[found[0]], self.row_gap[j])

    def _rows(self, touch: Touch, place: int) -> Array:
        """The Jacobian of a contact, along and about the axes of its frame."""
        data, nv, sides = self.poses[touch.rows], self.model.nv, []
        frame, point = data.contact.frame[place].reshape(3, 3), data.contact.pos[place]
        for body in self.model.geom_bodyid[touch.geoms]:
            along, about = np.zeros((3, nv)), np.zeros((3, nv))
            mujoco.mj_jac(self.model, data, along, about, point, body)
            sides.append(np.concatenate([frame @ along, frame @ about]))
        rows: Array = (sides[1] - sides[0])[: touch.dim]
        return rows

    def _closing(self, gap: float, now: float) -> float:
        """The velocity that closes a gap in the step: of an overlap none. What rests is at the end of its gap."""
        return gap / self.h if now >= -_SLOP * self.size else 0.0


def _lost(model: mujoco.MjModel, touch: Touch) -> ValueError:
    pair = " and ".join(repr(model.geom(geom).name or int(geom)) for geom in touch.geoms)
    return ValueError(f"data: the contact of geoms {pair} jumps, or ends, as things move by eps")
