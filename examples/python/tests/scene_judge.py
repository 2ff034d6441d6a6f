"""A judge of MuJoCo's steps, written apart from the stepper.

Contacts and momentum are measured as the guide's `error.md` says, joint rows as `src/sets/energy.rs` does: relative to an energy.
It reads MuJoCo's model, positions and forces. It makes its own Jacobians by `mj_jac`, at a model of its own, and uses none of
MuJoCo's constraint rows. Impulses in N·s, lengths in m.

Contacts that are listed when a step begins are judged to rounding. Those that were found at its end have the row of a pose near
the end, that of a try before the last; at worst the pose that forces alone lead to. How much their row changes from there to the
end is what may be said against it, and no more.
"""

from __future__ import annotations

import copy

import mujoco
import numpy as np
from numpy.typing import NDArray

from judge import project

Array = NDArray[np.float64]
ROWS = mujoco.mjtConstraint


class Ends:
    """Where a step leads to, and where it would without constraints: what rows found at its end are made from."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Make room for both, on a model that lists what is near as well."""
        self.model = copy.deepcopy(model)
        self.model.geom_margin[:] += 1e-3 * model.stat.meansize
        self.poses = mujoco.MjData(self.model), mujoco.MjData(self.model)

    def lead(self, before: Array, after: Array, free: Array) -> None:
        """Move from these positions with both velocities."""
        for pose, velocity in zip(self.poses, (after, free), strict=True):
            pose.qpos[:] = before
            mujoco.mj_integratePos(self.model, pose.qpos, velocity, self.model.opt.timestep)
            mujoco.mj_kinematics(self.model, pose)
            mujoco.mj_comPos(self.model, pose)
        mujoco.mj_collision(self.model, self.poses[0])

    def rows(self, contact: mujoco.MjContact) -> tuple[Array, list[Array]]:
        """The Jacobian of a contact at the end, and how much it may be off: at the other pose, and with a point that came along."""
        end, free = (jacobian(self.model, pose, contact, contact.pos) for pose in self.poses)
        off = [free - end]
        for body in self.model.geom_bodyid[contact.geom]:
            (p, turned), (q, before) = ((pose.xpos[body], pose.xmat[body].reshape(3, 3)) for pose in self.poses)
            off.append(jacobian(self.model, self.poses[0], contact, p + turned @ before.T @ (contact.pos - q)) - end)
        near = [other for other in self.poses[0].contact if np.array_equal(other.geom, contact.geom)]
        for other in sorted(near, key=lambda other: float(np.linalg.norm(other.pos - contact.pos)))[:1]:
            off.append(jacobian(self.model, self.poses[0], other, other.pos) - end)
        return end, off


def jacobian(model: mujoco.MjModel, data: mujoco.MjData, contact: mujoco.MjContact, point: Array) -> Array:
    """Jacobian of a contact as if at this point, at the pose of the data; along and about the axes of its frame."""
    sides = []
    for geom in contact.geom:
        along, about = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, along, about, point, model.geom_bodyid[geom])
        sides.append(np.concatenate([contact.frame.reshape(3, 3) @ part for part in (along, about)]))
    rows: Array = (sides[1] - sides[0])[: contact.dim]
    return rows


def mass_of(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """The mass matrix; before 3.10 MuJoCo takes it by another call."""
    mass = np.zeros((model.nv, model.nv))
    if mujoco.mj_version() < 3_010_000:
        mujoco.mj_fullM(model, mass, data.qM)
    else:
        mujoco.mj_fullM(model, data, mass)
    return mass


def less(x: Array, doubt: Array | float) -> Array:
    """A vector shorter, entry by entry, by what may be said against it."""
    rest: Array = np.sign(x) * np.maximum(np.abs(x) - doubt, 0.0)
    return rest


class Judge:
    """Recomputes what a step should be, on a model that no stepper has changed."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Judge steps of this model, or of one with the same numbers."""
        self.model, self.data, self.ends = model, mujoco.MjData(model), Ends(model)
        self.momentum = self.law = 0.0  # the parts of the guide's error, the worst of all steps
        self.deepest = self.opened = 0.0  # overlap and opening of equalities after a step, the worst of all (m)
        self.added = 0  # contacts found at the end of a step
        self.fed = 0.0  # the most that constraints have added to kinetic energy in a step, other than by closing gaps (J)
        self.energies: list[float] = []  # after each step, less what motors and hands have put in
        self.work = 0.0
        self.modes = {"open": 0, "stick": 0, "slip": 0}

    def set_out(self, data: mujoco.MjData) -> None:
        """Note the state before a step, and compute forces without constraints."""
        mine = self.data
        mine.qpos[:], mine.qvel[:], mine.ctrl[:] = data.qpos, data.qvel, data.ctrl
        mine.qfrc_applied[:] = data.qfrc_applied
        mujoco.mj_fwdPosition(self.model, mine)
        mujoco.mj_fwdVelocity(self.model, mine)
        mujoco.mj_fwdActuation(self.model, mine)
        mujoco.mj_fwdAcceleration(self.model, mine)

    def judge(self, after: mujoco.MjData, modes: list[int], listed: int) -> None:
        """Compare with the state after it, and the forces that are said to have acted; so many contacts were listed before."""
        model, mine, h = self.model, self.data, self.model.opt.timestep
        mass = mass_of(model, mine)
        mass += h * np.diag(model.dof_damping)
        push = h * mine.qfrc_smooth
        change = mass @ (after.qvel - mine.qvel) - push
        size = max(float(np.linalg.norm(mass @ mine.qvel + push)), float(np.linalg.norm(mass @ after.qvel)))
        self.momentum = max(self.momentum, float(np.linalg.norm(change - h * after.qfrc_constraint)) / size)
        inverse = np.linalg.inv(mass)
        free = mine.qvel + inverse @ push
        fed = 0.5 * float(change @ (2 * after.qvel - inverse @ change))  # against the velocity that forces alone would give
        self.ends.lead(mine.qpos, after.qvel, free)
        gaps, impulses, alone, stops = [0.0], [0.0], [0.0], [0.0]  # of contacts
        work, works = 0.0, [1e-4 * float(free @ mass @ free), float(change @ inverse @ change)]  # of rows
        for index, contact in enumerate(after.contact):
            if contact.efc_address < 0 or modes[index] < 0:
                assert contact.efc_address < 0 or not after.efc_force[contact.efc_address : contact.efc_address + contact.dim].any()
                continue
            if index < listed:
                rows, off = jacobian(model, mine, contact, contact.pos), [np.zeros((3, model.nv))]
            else:
                _, off = self.ends.rows(contact)
                rows = after.efc_J.reshape(-1, model.nv)[contact.efc_address : contact.efc_address + 3]
                self.added += 1
            span = slice(contact.efc_address, contact.efc_address + 3)
            impulse, mu = h * after.efc_force[span], float(model.geom_friction[contact.geom, 0].max())
            change -= rows.T @ impulse
            speed, unsolved = rows @ after.qvel, rows @ free
            slip = float(np.linalg.norm(speed[1:]))
            self.modes["open" if impulse[0] < 1e-9 else "slip" if slip > 1e-5 else "stick"] += 1
            offset = max(contact.dist / h, 0.0)
            fed += impulse[0] * offset
            speed[0] += offset + mu * slip
            unsolved[0] += offset + mu * float(np.linalg.norm(unsolved[1:]))
            alpha = 3 / np.trace(rows @ inverse @ rows.T)
            known = alpha * (1 + mu) * sum(float(np.linalg.norm(part @ after.qvel)) for part in off)
            gaps.extend(less(impulse - project(impulse - alpha * speed, mu), known))
            gaps.extend(impulse - project(impulse, mu))
            impulses.extend(impulse)
            alone.extend(project(-alpha * unsolved, mu))
            stops.extend(alpha * (np.abs(rows) @ np.abs(free)))
        for row in np.flatnonzero(after.efc_type < int(ROWS.mjCNSTR_CONTACT_FRICTIONLESS)):
            lever, offset, bound = self.row(after, int(row))
            impulse = h * after.efc_force[row]
            change -= lever * impulse
            fed += impulse * offset
            mobility = float(lever @ inverse @ lever)
            if mobility == 0.0:  # no motion can open it: the axis of a loop in the plane
                continue
            work += mobility * (impulse - np.clip(impulse - (lever @ after.qvel + offset) / mobility, *bound)) ** 2
            works.append(mobility * np.clip(-(lever @ free + offset) / mobility, *bound) ** 2)
        self.momentum = max(self.momentum, float(np.linalg.norm(change)) / size)
        references = [float(np.linalg.norm(part)) for part in (impulses, alone, stops)]
        reference = max(*references[:2], 0.01 * references[2], 1e-300)
        self.law = max(self.law, float(np.linalg.norm(gaps)) / reference, float(np.sqrt(work / max(works))))
        self.fed = max(self.fed, fed)
        self.balance(after)

    def row(self, after: mujoco.MjData, row: int) -> tuple[Array, float, tuple[float, float]]:
        """Jacobian, offset (m/s, rad/s) and bounds of the impulse, of one joint row."""
        model, h, index = self.model, self.model.opt.timestep, after.efc_id[row]
        jacobian = np.zeros(model.nv)
        if after.efc_type[row] == int(ROWS.mjCNSTR_FRICTION_DOF):
            jacobian[index] = 1
            return jacobian, 0.0, (-h * model.dof_frictionloss[index], h * model.dof_frictionloss[index])
        if after.efc_type[row] == int(ROWS.mjCNSTR_LIMIT_JOINT):
            angle, (low, high) = self.data.qpos[model.jnt_qposadr[index]], model.jnt_range[index]
            side = 1.0 if angle - low < high - angle else -1.0
            jacobian[model.jnt_dofadr[index]] = side
            distance = min(angle - low, high - angle)
            return jacobian, max(distance / h, 0.0), (0.0, np.inf)
        assert model.eq_type[index] == int(mujoco.mjtEq.mjEQ_CONNECT)
        jacobians = []
        for body, end in zip((model.eq_obj1id[index], model.eq_obj2id[index]), self.pins(index), strict=True):
            jacobians.append(np.zeros((3, model.nv)))
            mujoco.mj_jac(model, self.data, jacobians[-1], None, end, body)
        axis = row - int(np.flatnonzero(after.efc_id[: row + 1] == index)[0])
        return (jacobians[0] - jacobians[1])[axis], 0.0, (-np.inf, np.inf)

    def pins(self, index: int) -> list[Array]:
        """Where both bodies have the point that an equality connects."""
        model, mine = self.model, self.data
        bodies = ((model.eq_obj1id[index], 0), (model.eq_obj2id[index], 3))
        return [mine.xpos[b] + mine.xmat[b].reshape(3, 3) @ model.eq_data[index, at : at + 3] for b, at in bodies]

    def look(self) -> None:
        """Note how deep things overlap, how far joints are beyond their stops, and how far equalities are open."""
        model, mine = self.model, self.data
        self.deepest = max(self.deepest, -float(mine.contact.dist.min(initial=0.0)))
        for joint in np.flatnonzero(model.jnt_limited):
            low, high = model.jnt_range[joint] - mine.qpos[model.jnt_qposadr[joint]]
            self.deepest = max(self.deepest, low, -high)
        self.opened = max([self.opened, *(float(np.linalg.norm(np.subtract(*self.pins(i)))) for i in range(model.neq))])

    def balance(self, after: mujoco.MjData) -> None:
        """Energy after the step, less the work of motors, hands and dampers."""
        model, mine, h = self.model, self.data, self.model.opt.timestep
        mean = 0.5 * (mine.qvel + after.qvel)
        self.work += h * float((mine.qfrc_actuator + mine.qfrc_applied) @ mean)
        mine.qpos[:], mine.qvel[:] = after.qpos, after.qvel
        mujoco.mj_fwdPosition(model, mine)
        self.look()
        mujoco.mj_energyPos(model, mine)
        mujoco.mj_energyVel(model, mine)
        self.energies.append(float(mine.energy.sum()) - self.work)

    def growth(self) -> float:
        """By how much it has grown at most, since any earlier time (J)."""
        energies = np.array(self.energies)
        return float((energies - np.minimum.accumulate(energies)).max())
