"""What the contact law is asked about in a step of MuJoCo's models, at states near the one where the step begins."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, NamedTuple

import mujoco
import numpy as np

from ._law import Bounds, Motion, Terms
from ._types import Array, Mode
from ._versions import MARGINS_ADD, is_damped, mass_matrix, solve_as_one, surface_velocities, velocity_derivative

if TYPE_CHECKING:
    from .mujoco import Stepper

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
_ROW, _INTEGRATOR = mujoco.mjtConstraint, mujoco.mjtIntegrator
_EQUALITY, _OF_DOF = int(_ROW.mjCNSTR_EQUALITY), int(_ROW.mjCNSTR_FRICTION_DOF)
_LIMITS = (int(_ROW.mjCNSTR_LIMIT_JOINT), int(_ROW.mjCNSTR_LIMIT_TENDON))
_D = 6  # rows that a contact may have

# As the compiled side has them, over the model's mean size: gaps up to which contacts are listed, overlaps that count as none, and
# how deep lies what rests.
_BAND, _SLOP, _DEPTH = 1e-6, 1e-7, 3e-9
_NO_LEVER = 1e-4  # a row that has no force and moves less than this beside its equality's others
_LEVER = 1e-5  # a normal is held by this share of what moves its bodies when they are free


class Touch(NamedTuple):
    """A contact that pushes, or overlaps at the end, and what it is found again by."""

    place: int
    geoms: Array
    dim: int
    point: Array
    #: Is it seen where a try has led, and not where the step begins?
    is_new: bool


class Near:
    """A step that was taken, and its terms at states near by."""

    def __init__(self, stepper: Stepper, data: mujoco.MjData, eps: float) -> None:
        """Take the step of a copy of the data."""
        self.start, self.end, self.eps, self.h = data, copy.copy(data), eps, stepper.model.opt.timestep
        self.size, self.extent = stepper.model.stat.meansize, max(stepper.model.stat.extent, 1.0)
        stepper.step1(self.end)
        listed = self.end.contact.dist - self.end.contact.includemargin + _BAND * self.size
        stepper.step2(self.end)
        self.model, self.grown = self._model(stepper.model)
        self.limit_margins = stepper.model.jnt_margin, stepper.model.tendon_margin
        self.scratch, self.late = mujoco.MjData(self.model), mujoco.MjData(self.model)
        self.state = np.empty(mujoco.mj_stateSize(self.model, _STATE))
        mujoco.mj_getState(stepper.model, data, self.state, _STATE)
        self.is_damped = False
        if self.model.opt.integrator != _INTEGRATOR.mjINT_EULER:
            self.is_damped = bool(np.linalg.eigvalsh(self._smooth()[0])[0] <= 0)
        modes = np.array(stepper.modes, int)
        taken = np.flatnonzero(modes >= 0)
        self._take(taken)
        #: What the position moves by beside the velocity, to take overlaps back.
        self.shift = np.zeros(self.model.nv)
        mujoco.mj_differentiatePos(self.model, self.shift, self.h, self.integrated(data.qpos, self.last.v), self.end.qpos)
        contact, after = self.end.contact, self.gap + self.h * self.terms.H[:, 0] @ self.last.v
        self.touches = [
            Touch(i, contact.geom[place].copy(), int(contact.dim[place]), contact.pos[place].copy(), bool(place >= len(listed)))
            for i, place in enumerate(taken)
            if modes[place] != Mode.OPEN or after[i] < 0
        ]
        before = np.append(listed + _DEPTH * self.size, np.full(self.end.ncon - len(listed), 0.0))[taken]
        self.is_new: Array = taken >= len(listed)
        #: How much of an overlap is not from the start of the step, but what its path has of a curve (m).
        self.curve: Array = np.where(taken < len(listed), before - self.gap, np.maximum(-self.gap, 0.0))
        self.overlaps = [i for i, place in enumerate(taken) if place < len(listed) and listed[place] < -_SLOP * self.size]
        self.error: float = stepper.error

    def _model(self, given: mujoco.MjModel) -> tuple[mujoco.MjModel, float]:
        """A model that lists what is near as well, with the Stepper's options; by how much more (m)."""
        model = copy.copy(given)
        solve_as_one(model)
        model.opt.ccd_tolerance, model.opt.ccd_iterations = 1e-12 * self.size, 200
        if model.opt.integrator != _INTEGRATOR.mjINT_EULER:
            model.opt.integrator = _INTEGRATOR.mjINT_IMPLICITFAST
        grown = _BAND * self.size + 10 * self.eps * self.extent
        of_each = grown / 2 if MARGINS_ADD else grown
        model.geom_margin[:] += of_each
        model.body_margin[:] += of_each
        model.pair_margin[:] += grown
        far = self.end.efc_pos[np.isin(self.end.efc_type, _LIMITS)].max(initial=0.0) + grown
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
        model, data = self.model, self.scratch
        mujoco.mj_setState(model, data, self.state, _STATE)
        for name, numbers in changed.items():
            getattr(data, name)[:] = numbers
        mujoco.mj_step1(model, data)
        mujoco.mj_fwdActuation(model, data)
        mujoco.mj_fwdAcceleration(model, data)
        mass, force, velocity = mass_matrix(model, data), data.qfrc_smooth.copy(), data.qvel.copy()
        is_implicit = model.opt.integrator != _INTEGRATOR.mjINT_EULER
        (mujoco.mj_implicit if is_implicit else mujoco.mj_Euler)(model, data)  # for activations and qDeriv; contacts stay
        if is_implicit and not self.is_damped:
            D = velocity_derivative(model, data)
            mass -= self.h / 2 * (D + D.T)
        elif is_damped(model):
            mass += self.h * np.diag(model.dof_damping)
        return mass, mass @ velocity + self.h * force, data.act.copy()

    def _take(self, taken: Array) -> None:
        """Take contacts, joint rows and motion from the end of the step."""
        end, contact, h = self.end, self.end.contact, self.h
        (mass, impulse, act), J = self._smooth(), self._constraints(end)
        H, w, r = np.zeros((len(taken), _D, self.model.nv)), np.zeros((len(taken), _D)), np.zeros((len(taken), _D))
        friction, dims, self.gap = np.zeros((len(taken), _D - 1)), contact.dim[taken], contact.dist[taken]
        for i, place in enumerate(taken):
            dim, first = dims[i], contact.efc_address[place]
            H[i, :dim], r[i, :dim] = J[first : first + dim], h * end.efc_force[first : first + dim]
            friction[i, : dim - 1] = contact.friction[place, : dim - 1]
            w[i, 1 : min(dim, 4)] = surface_velocities(end)[place, : min(dim, 4) - 1]
        w[:, 0] = np.maximum(self.gap, 0.0) / h
        kind, gap = end.efc_type, self._limit_gaps(end)
        fastest = np.min([J @ v for v in (end.qvel, self.start.qvel, np.linalg.solve(mass, impulse))], axis=0)
        limits = np.isin(kind, _LIMITS)
        kept = (kind < _LIMITS[0]) | limits & ((gap <= 0) | (gap + h * fastest < 0))
        rows, forces = self._names(end)[:, :2], end.efc_force
        moves = np.einsum("jn,nj->j", J, np.linalg.solve(mass, J.T))
        for idle in np.flatnonzero((kind == _EQUALITY) & (forces == 0)):  # what has no lever takes no part
            kept[idle] = moves[idle] > _NO_LEVER * moves[(rows == rows[idle]).all(axis=1)].max()
        self.names, self.is_limit, self.row_gap = self._names(end)[kept], limits[kept], gap[kept]
        most = np.where(kind == _EQUALITY, np.inf, h * end.efc_frictionloss)[kept]
        bounds = np.where(self.is_limit, 0.0, -most), np.where(self.is_limit, np.inf, most)
        mobility = self.model.body_invweight0[self.model.geom_bodyid[contact.geom[taken]], 0].sum(axis=1)
        response = np.einsum("cn,nc->c", H[:, 0], np.linalg.solve(mass, H[:, 0].T))
        #: How much the bodies of contacts move when they are free.
        self.mobility = mobility
        lever = np.maximum(_LEVER * mobility - response, 0.0)
        self.bounds = Bounds(friction, dims, np.stack([lever, 0 * lever], axis=1), *bounds, np.zeros(len(J[kept])))
        offset = np.where(self.is_limit, np.maximum(self.row_gap, 0.0) / h, 0.0)
        self.terms = Terms(mass, impulse, H, w, J[kept], offset, self.gap, self.row_gap, act)
        self.last = Motion(end.qvel.copy(), r, h * end.efc_force[kept])

    def _constraints(self, data: mujoco.MjData) -> Array:
        rows: Array = data.efc_J.reshape(-1, self.model.nv)
        return rows

    def _limit_gaps(self, data: mujoco.MjData) -> Array:
        """What is left up to limits (m, rad), beside numbers of other constraints."""
        gaps: Array = data.efc_pos.copy()
        for kind, margin in zip(_LIMITS, self.limit_margins, strict=True):
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
        side = self._constraints(data).sum(axis=1) > 0
        return np.stack([kind, own, np.where(np.isin(kind, _LIMITS), side, number)], axis=1)

    def lead(self, positions: Array, velocity: Array) -> None:
        """Look at the pose that a velocity leads to."""
        late = self.late
        late.qpos[:] = self.integrated(positions, velocity)
        late.mocap_pos[:], late.mocap_quat[:] = self.start.mocap_pos, self.start.mocap_quat
        mujoco.mj_kinematics(self.model, late)
        mujoco.mj_comPos(self.model, late)
        mujoco.mj_collision(self.model, late)

    def seen(self, touches: list[Touch], way: Array | None, **changed: Array) -> Terms:
        """The terms of a state of which this is changed: ``qpos``, ``qvel``, ``act``, ``ctrl``.

        Of contacts these are looked at, new ones where the velocity ``way`` leads to.
        """
        mass, impulse, act = self._smooth(**changed)
        terms = self.terms._replace(mass=mass, impulse=impulse, act=act)
        if "qpos" not in changed:
            return terms
        if way is not None:
            self.lead(changed["qpos"], way)
        return self._rows_of(terms, touches, way)

    def _rows_of(self, terms: Terms, touches: list[Touch], way: Array | None) -> Terms:
        """Terms with rows and offsets as they are at the poses."""
        terms = terms._replace(**{name: getattr(terms, name).copy() for name in ("H", "w", "J", "offset", "gap", "row_gap")})
        for touch in touches:
            i, dim, contact = touch.place, touch.dim, self._data(touch).contact
            place = self.again(touch, 1e-5 * self.size + 20 * self.eps * self.extent)
            terms.H[i, :dim] = self._rows(touch, place)
            terms.w[i, 1 : min(dim, 4)] = surface_velocities(self._data(touch))[place, : min(dim, 4) - 1]
            gap = contact.dist[place] - contact.includemargin[place] + self.grown + _DEPTH * self.size
            if touch.is_new:
                gap -= self.h * float(terms.H[i, 0] @ way)
            terms.gap[i], terms.w[i, 0] = gap - (0.0 if touch.is_new else self.curve[i]), self._closing(gap, self.gap[i])
        moving = np.flatnonzero(np.where(self.is_limit, self.last.row_impulses != 0, self.names[:, 0] != _OF_DOF))
        if len(moving):
            data = self.scratch
            names, gaps, rows = self._names(data), self._limit_gaps(data), self._constraints(data)
        for j in moving:
            found = np.flatnonzero((names == self.names[j]).all(axis=1))
            if not len(found):
                raise lost("a limit or an equality")
            terms.J[j], terms.row_gap[j] = rows[found[0]], gaps[found[0]]
            if self.is_limit[j]:
                terms.offset[j] = self._closing(gaps[found[0]], self.row_gap[j])
        return terms

    def _rows(self, touch: Touch, place: int) -> Array:
        """The Jacobian of a contact, along and about the axes of its frame."""
        data, nv, sides = self._data(touch), self.model.nv, []
        frame, point = data.contact.frame[place].reshape(3, 3), data.contact.pos[place]
        for body in self.model.geom_bodyid[touch.geoms]:
            along, about = np.zeros((3, nv)), np.zeros((3, nv))
            mujoco.mj_jac(self.model, data, along, about, point, body)
            sides.append(np.concatenate([frame @ along, frame @ about]))
        rows: Array = (sides[1] - sides[0])[: touch.dim]
        return rows

    def _data(self, touch: Touch) -> mujoco.MjData:
        return self.late if touch.is_new else self.scratch

    def again(self, touch: Touch, reach: float) -> int:
        """The place of a contact in the list where it is seen."""
        contact = self._data(touch).contact
        same = np.flatnonzero((contact.geom == touch.geoms).all(axis=1))
        away = np.linalg.norm(contact.pos[same] - touch.point, axis=1)
        if not away.min(initial=np.inf) <= reach:
            one, other = (repr(self.model.geom(geom).name or int(geom)) for geom in touch.geoms)
            raise lost(f"the contact of geoms {one} and {other}")
        return int(same[away.argmin()])

    def _closing(self, gap: float, now: float) -> float:
        """The velocity that closes a gap in the step: of an overlap none. What rests is at the end of its gap."""
        return gap / self.h if now >= -_SLOP * self.size else 0.0


def lost(what: str) -> ValueError:
    """Make an error of what differences cannot follow."""
    return ValueError(f"data: {what} cannot be found again, or end as things move by eps")
