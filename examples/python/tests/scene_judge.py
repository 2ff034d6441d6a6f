"""A judge of MuJoCo's steps, written apart from the stepper.

Contacts and momentum are measured as the guide's `error.md` says, joint rows as `src/sets/energy.rs` does: relative to an energy.
It reads MuJoCo's model, positions and forces. It makes its own Jacobians by `mj_jac`, at a model of its own, and uses none of
MuJoCo's constraint rows. Impulses in N·s, lengths in m.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from judge import project

Array = NDArray[np.float64]
ROWS = mujoco.mjtConstraint


class Judge:
    """Recomputes what a step should be, on a model that no stepper has changed."""

    def __init__(self, model: mujoco.MjModel, recovery: float = 0.1) -> None:
        """Judge steps of this model, or of one with the same numbers."""
        self.model, self.data, self.recovery = model, mujoco.MjData(model), recovery
        self.momentum = self.law = 0.0  # the parts of the guide's error, the worst of all steps
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

    def judge(self, after: mujoco.MjData) -> None:
        """Compare with the state after it, and the forces that are said to have acted."""
        model, mine, h = self.model, self.data, self.model.opt.timestep
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, mine, mass)
        mass += h * np.diag(model.dof_damping)
        push = h * mine.qfrc_smooth
        change = mass @ (after.qvel - mine.qvel) - push
        size = max(float(np.linalg.norm(mass @ mine.qvel + push)), float(np.linalg.norm(mass @ after.qvel)))
        inverse = np.linalg.inv(mass)
        free = mine.qvel + inverse @ push
        fed = 0.5 * float(change @ (2 * after.qvel - inverse @ change))  # against the velocity that forces alone would give
        gaps, impulses, alone, stops = [0.0], [0.0], [0.0], [0.0]  # of contacts
        work, works = 0.0, [1e-4 * float(free @ mass @ free), float(change @ inverse @ change)]  # of rows
        for contact in after.contact:
            if contact.efc_address < 0:
                continue
            jacobian = contact.frame.reshape(3, 3) @ (self.point(contact, 1) - self.point(contact, 0))
            rows = slice(contact.efc_address, contact.efc_address + 3)
            impulse, mu = h * after.efc_force[rows], float(model.geom_friction[contact.geom, 0].max())
            change -= jacobian.T @ impulse
            speed, unsolved = jacobian @ after.qvel, jacobian @ free
            slip = float(np.linalg.norm(speed[1:]))
            self.modes["open" if impulse[0] < 1e-9 else "slip" if slip > 1e-5 else "stick"] += 1
            offset = max(contact.dist / h, -self.recovery)
            fed += impulse[0] * offset
            speed[0] += offset + mu * slip
            unsolved[0] += offset + mu * float(np.linalg.norm(unsolved[1:]))
            alpha = 3 / np.trace(jacobian @ inverse @ jacobian.T)
            gaps.extend(impulse - project(impulse - alpha * speed, mu))
            impulses.extend(impulse)
            alone.extend(project(-alpha * unsolved, mu))
            stops.extend(alpha * (np.abs(jacobian) @ np.abs(free) + [max(-offset, 0.0), 0.0, 0.0]))
        for row in np.flatnonzero(after.efc_type < int(ROWS.mjCNSTR_CONTACT_FRICTIONLESS)):
            jacobian, offset, bound = self.row(after, int(row))
            impulse = h * after.efc_force[row]
            change -= jacobian * impulse
            fed += impulse * offset
            mobility = float(jacobian @ inverse @ jacobian)
            if mobility == 0.0:  # no motion can open it: the axis of a loop in the plane
                assert abs(offset) < 1e-9
                continue
            work += mobility * (impulse - np.clip(impulse - (jacobian @ after.qvel + offset) / mobility, *bound)) ** 2
            works.append(mobility * np.clip(-(jacobian @ free + offset) / mobility, *bound) ** 2)
        self.momentum = max(self.momentum, float(np.linalg.norm(change)) / size)
        references = [float(np.linalg.norm(part)) for part in (impulses, alone, stops)]
        reference = max(*references[:2], 0.01 * references[2], 1e-300)
        self.law = max(self.law, float(np.linalg.norm(gaps)) / reference, float(np.sqrt(work / max(works))))
        self.fed = max(self.fed, fed)
        self.balance(after)

    def point(self, contact: mujoco.MjContact, side: int) -> Array:
        """Jacobian of a contact's point, on one of its two bodies; rows along the world's axes."""
        jacobian = np.zeros((3, self.model.nv))
        mujoco.mj_jac(self.model, self.data, jacobian, None, contact.pos, self.model.geom_bodyid[contact.geom[side]])
        return jacobian

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
            return jacobian, max(distance / h, -self.recovery), (0.0, np.inf)
        assert model.eq_type[index] == int(mujoco.mjtEq.mjEQ_CONNECT)
        ends, jacobians = [], []
        for body, anchor in ((model.eq_obj1id[index], 0), (model.eq_obj2id[index], 3)):
            local = model.eq_data[index, anchor : anchor + 3]
            ends.append(self.data.xpos[body] + self.data.xmat[body].reshape(3, 3) @ local)
            jacobians.append(np.zeros((3, model.nv)))
            mujoco.mj_jac(model, self.data, jacobians[-1], None, ends[-1], body)
        axis = row - int(np.flatnonzero(after.efc_id[: row + 1] == index)[0])
        return (jacobians[0] - jacobians[1])[axis], (ends[0] - ends[1])[axis] / h, (-np.inf, np.inf)

    def balance(self, after: mujoco.MjData) -> None:
        """Energy after the step, less the work of motors, hands and dampers."""
        model, mine, h = self.model, self.data, self.model.opt.timestep
        mean = 0.5 * (mine.qvel + after.qvel)
        self.work += h * float((mine.qfrc_actuator + mine.qfrc_applied) @ mean)
        mine.qpos[:], mine.qvel[:] = after.qpos, after.qvel
        mujoco.mj_fwdPosition(model, mine)
        mujoco.mj_energyPos(model, mine)
        mujoco.mj_energyVel(model, mine)
        self.energies.append(float(mine.energy.sum()) - self.work)

    def growth(self) -> float:
        """By how much it has grown at most, since any earlier time (J)."""
        energies = np.array(self.energies)
        return float((energies - np.minimum.accumulate(energies)).max())
