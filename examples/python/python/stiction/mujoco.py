"""MuJoCo's models, kinematics, collision, actuators and sensors, with exact Coulomb friction in its place.

Needs the package ``mujoco``, 4.0 or later.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from ._stiction import Gather, LookAhead
from ._types import Status

__all__ = ["Stepper"]

_MARGINS = ("geom_margin", "body_margin", "pair_margin", "jnt_margin", "tendon_margin")
# As numbers: MuJoCo's enumerations take a microsecond to compare.
_IMPLICITFAST = int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
_EULERDAMP = int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
_DAMPER = int(mujoco.mjtDisableBit.mjDSBL_DAMPER)
_STATUS = tuple(Status)
_ENABLE = mujoco.mjtEnableBit


class Stepper:
    """Steps a model as ``mujoco.mj_step`` does, but for its constraints: these are rigid, and friction is Coulomb's.

    Contacts (condim 1, 3, 4 and 6, friction of geoms and pairs, moving surfaces), limits of joints and tendons, friction loss and
    equality constraints are solved together, to a tolerance, at the end of the step. Contacts and limits may close their gap
    within the step and no further, so nothing sinks in. Damping of joints is implicit as with MuJoCo's Euler; with
    ``implicitfast`` so are that of tendons and the velocity gains of actuators. ``efc_force``, ``qfrc_constraint`` and ``qacc`` are
    written, so ``mj_contactForce`` and force sensors read what acts.

    What has no meaning here and is not read: ``solref``, ``solimp``, ``impratio``, solver and iterations.

    The stepper changes the model: cones become elliptic, Jacobians dense, and in each step margins of geoms, pairs, joints and
    tendons grow by how far things may move in a step (MuJoCo lists contacts by their margin). For its own ``mj_step`` load another.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        *,
        tol: float = 1e-6,
        budget: int = 1000,
        recovery: float = 0.1,
        closing: float = 1.0,
        look_ahead: float | None = None,
    ) -> None:
        """Take a model over.

        Args:
            model: it is changed, see above.
            tol: error up to which a step counts as solved.
            budget: work that a step may take.
            recovery: the fastest at which a penetration or a joint beyond its limit is pushed out; m/s, rad/s.
            closing: the fastest at which an equality that is open is closed; m/s, rad/s. A body that is welded to one of motion
                capture follows it at this speed.
            look_ahead: contacts nearer than this are in the scene (m); ``None`` takes twice what its geoms move in a step.

        Raises:
            ValueError: the model asks for what does not map.
        """
        _check(model)
        self.model = model
        self._settings = (float(tol), int(budget))
        self._recovery, self._closing = float(recovery), float(closing)
        if not (self._recovery >= 0 and self._closing >= 0):
            raise ValueError(f"recovery, closing: {recovery!r} and {closing!r} are not speeds")
        self._fixed = None if look_ahead is None else float(look_ahead)
        #: Steps taken.
        self.steps = 0
        #: Steps whose error is above the tolerance. They were taken all the same, with the best that was found.
        self.unsolved = 0
        #: The largest error of a step that was not solved; 0 if all were.
        self.worst_error = 0.0
        #: Steps in which penetrations contradicted each other (an object between walls that overlap it), and were left as they are.
        self.contradictions = 0
        #: Steps in which more contacts were reached than there is room for, so that some sink in. They are not solved, with an
        #: infinite error.
        self.crowded = 0
        #: How the last step ended.
        self.status = Status.UNSOLVED
        #: Its error.
        self.error = 0.0
        #: Its work.
        self.work = 0
        model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self._margins = [getattr(model, name) for name in _MARGINS]
        margins = [margin.tolist() for margin in self._margins]
        radius = np.where(model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE, 0.0, model.geom_rbound)
        roots = model.body_rootid[model.geom_bodyid]
        geoms = list(zip(model.geom_bodyid.tolist(), roots.tolist(), radius.tolist(), strict=True))
        pairs = list(zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True))
        self._look_ahead = LookAhead(margins, geoms, pairs, 1e-3 * model.stat.meansize)
        self._gather = Gather(model.nv, margins[3], margins[4])
        self._metric = np.zeros((model.nv, model.nv))
        self._no_damping = np.zeros(model.nv)
        self._data: mujoco.MjData | None = None

    @property
    def modes(self) -> list[int]:
        """:class:`stiction.Mode` of each contact of ``data.contact`` in the last step; -1 of one that took no part."""
        return self._gather.modes

    def reset(self) -> None:
        """Forget the last step, as after ``mj_resetData``: the next one starts cold."""
        self._gather.reset()

    def step(self, data: mujoco.MjData, nstep: int = 1) -> None:
        """Advance ``data`` by one step, or several; ``step1`` and ``step2`` in one.

        Raises:
            ValueError: more joint rows than are compiled, or the mass matrix is not positive definite.
        """
        for _ in range(nstep):
            self.step1(data)
            self.step2(data)

    def step1(self, data: mujoco.MjData) -> None:
        """Do what comes before controls are set: positions, collision, velocities, sensors of both."""
        if data is not self._data:
            self._bind(data)
        self._look(data)
        mujoco.mj_step1(self.model, data)

    def step2(self, data: mujoco.MjData) -> None:
        """Do what comes after controls are set: actuation, the solve, the sensors of forces, and the step."""
        model, step = self.model, self.model.opt.timestep
        mujoco.mj_fwdActuation(model, data)
        mujoco.mj_fwdAcceleration(model, data)
        mujoco.mj_fullM(model, data, self._metric)
        contact = data.contact
        status, self.error, self.work, contradicts, left_out = self._gather.step(
            self._implicit(data).reshape(-1),
            self._state,
            (data.efc_J, data.efc_type, data.efc_id, data.efc_pos, data.efc_frictionloss),
            (
                contact.dist,
                contact.includemargin,
                contact.dim,
                contact.efc_address,
                contact.geom,
                contact.friction,
                contact.surfacevel,
            ),
            (data.qacc, data.qfrc_constraint, data.efc_force),
            self._look_ahead,
            (step, self._recovery, self._closing),
            self._settings,
        )
        self.status = _STATUS[status]
        self.steps += 1
        self.contradictions += contradicts
        self.crowded += left_out > 0
        if self.status is not Status.SOLVED or left_out:
            self.unsolved += 1
            self.worst_error = max(self.worst_error, math.inf if left_out else self.error)
        mujoco.mj_sensorAcc(model, data)
        # The velocity at the end of the step is the solver's: damping is in it.
        disabled = model.opt.disableflags
        model.opt.disableflags = disabled | _EULERDAMP
        mujoco.mj_Euler(model, data)
        model.opt.disableflags = disabled
        self._look_ahead.keep(data.qvel)

    def _bind(self, data: mujoco.MjData) -> None:
        """Keep what stays the same from step to step."""
        self._data = data
        implicit = not self.model.opt.disableflags & (_EULERDAMP | _DAMPER)
        damping = self.model.dof_damping if implicit else self._no_damping
        self._state = (data.qvel, data.qfrc_smooth, damping)
        self._motion = (data.cvel, data.subtree_com, data.geom_xpos, data.qvel, data.ten_velocity)

    def _look(self, data: mujoco.MjData) -> None:
        """Set the margins that this step needs."""
        model = self.model
        if self._look_ahead.is_pushed(data.qvel):  # by somebody else, or it is the first step
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            mujoco.mj_tendon(model, data)
        option = model.opt
        self._look_ahead.set(self._motion, self._margins, option.timestep, option.gravity, self._fixed)

    def _implicit(self, data: mujoco.MjData) -> NDArray[np.float64]:
        """Add to the mass matrix what ``implicitfast`` takes implicitly beside damping of joints."""
        model, step = self.model, self.model.opt.timestep
        if model.opt.integrator != _IMPLICITFAST:
            return self._metric
        if model.ntendon and np.any(model.tendon_damping):
            jacobian = np.zeros((model.ntendon, model.nv))
            mujoco.mju_sparse2dense(jacobian, data.ten_J.reshape(-1), model.ten_J_rownnz, model.ten_J_rowadr, model.ten_J_colind)
            self._metric += step * jacobian.T @ (model.tendon_damping[:, None] * jacobian)
        gain = -model.actuator_biasprm[:, 2] * (model.actuator_biastype == mujoco.mjtBias.mjBIAS_AFFINE)
        if np.any(gain):
            limited = model.actuator_forcelimited.astype(bool)
            force, bounds = data.actuator_force, model.actuator_forcerange
            gain[limited & ((force <= bounds[:, 0]) | (force >= bounds[:, 1]))] = 0.0
            moment = np.zeros((model.nu, model.nv))
            mujoco.mju_sparse2dense(moment, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind)
            self._metric += step * moment.T @ (gain[:, None] * moment)
        return self._metric


def _check(model: mujoco.MjModel) -> None:
    """Refuse what does not map."""
    integrators = (mujoco.mjtIntegrator.mjINT_EULER, mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    refused = {
        "option integrator: Euler and implicitfast map; RK4, implicit and discrete do not": (
            model.opt.integrator not in integrators
        ),
        "flag sleep: bodies that sleep have no contacts here; disable it": model.opt.enableflags & _ENABLE.mjENBL_SLEEP,
        "flag speculative: its distances are made for soft contacts; disable it, a Stepper looks ahead by itself": (
            model.opt.enableflags & _ENABLE.mjENBL_SPECULATIVE
        ),
        "flag override: margins belong to the Stepper; disable it": model.opt.enableflags & _ENABLE.mjENBL_OVERRIDE,
        "flex: deformable bodies have more contacts than are solved here": model.nflex > 0,
        "it has no velocities": model.nv == 0,
    }
    for reason, holds in refused.items():
        if holds:
            raise ValueError(f"model: {reason}")
