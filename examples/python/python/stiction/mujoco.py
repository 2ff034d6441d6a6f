"""MuJoCo's models, kinematics, collision, actuators and sensors, with exact Coulomb friction in its place.

Needs the package ``mujoco``, 3.3 to 4.0.
"""

from __future__ import annotations

import copy
import warnings
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _stiction
from ._softness import Compliance, softness
from ._transition import Derivatives, derivatives
from ._types import Status
from ._versions import flag

__all__ = ["Derivatives", "Rollout", "Stepper", "compat", "patch", "rollout"]

_Number = TypeVar("_Number", int, float)
_STATUS = tuple(Status)
_BLOCK = 1000  # steps between looks at signals
_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
_INTEGRATOR = mujoco.mjtIntegrator
_REFUSED = ("SLEEP", "SPECULATIVE", "OVERRIDE")  # flags; earlier versions lack some


class _Counter(Generic[_Number]):
    """A number that the compiled side keeps under the same name."""

    def __set_name__(self, _: type, name: str) -> None:
        self.name = name

    def __get__(self, stepper: Stepper, _: type) -> _Number:
        number: _Number = stepper._own.tally[self.name]
        return number

    def __set__(self, stepper: Stepper, number: _Number) -> None:
        stepper._own.tally = {**stepper._own.tally, self.name: number}


class Stepper:
    """Steps a model as ``mujoco.mj_step`` does, but for its constraints: these are rigid, and friction is Coulomb's.

    Contacts (condim 1, 3, 4 and 6, friction of geoms and pairs, moving surfaces), limits of joints and tendons, friction loss and
    equality constraints are solved together, to a tolerance, at the end of the step. What would overlap after the step is found
    there and the step solved again, so nothing sinks in. Overlaps and open equalities are taken back by a motion that is not kept
    as a velocity. Damping of joints is implicit as with MuJoCo's Euler; all other integrators are stepped as ``implicitfast``, with
    MuJoCo's own velocity derivatives. ``efc_force``, ``qfrc_constraint`` and ``qacc`` are written, so ``mj_contactForce`` and
    force sensors read what acts.

    What has no meaning here and is not read: ``impratio``, solver, iterations, ``solimp`` and, but of what is soft, ``solref``.
    An exception are equalities with a body of motion capture: these are rigid while what they lead can follow; where it is blocked
    they pull as MuJoCo has them.

    Contacts and equalities are soft where ``compliance`` or ``soft`` asks for it: springs of a stiffness ``k`` with a damper
    ``d``, implicit over the step ``h``, which alone damps as ``d = h k`` would. An overlap, or what is open, loads its spring,
    also as the simulation begins, and is not taken back. A contact is soft along its normal, and what sticks does not creep;
    while something tilts, its corners may rub against each other with all their friction. Each point of ``data.contact`` has a
    spring of its own: a box on four corners is four times as stiff as on one. (Of an island of more than 64 points those inside
    of a face are left out.) With ``soft`` a ``solref`` of a negative number and another that is not positive is ``(-k, -d)`` in
    N/m and N·s/m as it stands, where MuJoCo scales it by mass and impedance. Each row of an equality has one in its own unit:
    N·m/rad between hinges; a rotation of a weld by an angle ``a`` counts as ``torquescale * sin(a / 2)`` (m). A soft equality
    with a body of motion capture has no other law. Limits and friction loss stay rigid.

    Of the model two options are changed: cones become elliptic, Jacobians dense. Several steppers, also of several threads, may
    share a model.
    """

    #: Steps taken.
    steps = _Counter[int]()
    #: Steps whose error is above the tolerance.
    unsolved = _Counter[int]()
    #: The largest error of a step that was not solved; 0 if all were.
    worst_unsolved = _Counter[float]()
    #: The largest error of all steps.
    max_error = _Counter[float]()
    #: Steps in which what is moved from outside contradicts what holds, so that it gave way.
    contradictions = _Counter[int]()
    #: Steps in which the exact law had no usable answer and all contacts gave way a little.
    fallbacks = _Counter[int]()
    #: Steps in which no compiled size held the contacts, velocities and joint rows of an island, so that all contacts gave way a
    #: little. They are not solved, with an infinite error.
    crowded = _Counter[int]()
    #: Steps in which something moved farther than contacts are looked for on its way.
    blind = _Counter[int]()
    #: Error of the last step.
    error = _Counter[float]()
    #: Work of the last step.
    work = _Counter[int]()

    def __init__(
        self, model: mujoco.MjModel, *, tol: float = 1e-6, budget: int = 1000, compliance: Compliance = 0.0, soft: bool = False
    ) -> None:
        """Take a model over.

        Args:
            model: see above for what is changed.
            tol: error up to which a step counts as solved, relative to the impulses; no unit.
            budget: work that a solve may take, in the unit of :attr:`stiction.Work.total`.
            compliance: displacement per force of contacts and equalities (m/N, between hinges rad/(N·m)); 0 is rigid. One number is
                that of all; a mapping has it of pairs of geoms, ``("sole", "floor")`` in either order, each a name or a number, and
                of equalities, ``"strap"``, and all else is rigid.
            soft: whether ``solref`` in MuJoCo's direct form is read, unless ``compliance`` names the pair or equality.

        Raises:
            ValueError: the model asks for what does not map, has nothing of a name, or a compliance is negative or not finite.
            ImportError: this version of MuJoCo is not known; it says which are.
        """
        _check(model)
        _check_settings(tol, budget)
        self._model = model
        self._settings = (float(tol), int(budget))
        self._softness = softness(model, compliance, soft)
        model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self._own = _stiction.Stepper(_library(), model._address, self._softness)

    def __getstate__(self) -> dict[str, Any]:
        """Take along what :meth:`state` has: with its data, or a copy of that, a copy goes on as this one does."""
        return {**{name: own for name, own in vars(self).items() if name != "_own"}, "_state": (self._own.state(), self._own.tally)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take the model over anew."""
        words, tally = state.pop("_state")
        vars(self).update(state)
        self._own = _stiction.Stepper(_library(), self._model._address, self._softness)
        self._own.set_state(None, words)
        self._own.tally = tally

    @property
    def status(self) -> Status:
        """How the last step ended."""
        status: int = self._own.tally["status"]
        return _STATUS[status]

    @property
    def model(self) -> mujoco.MjModel:
        """The model that is stepped."""
        return self._model

    @property
    def modes(self) -> list[int]:
        """:class:`stiction.Mode` of each contact of ``data.contact`` in the last step; -1 of one that took no part."""
        return self._own.modes

    def reset(self) -> None:
        """Forget the last step, as after ``mj_resetData``: the next one starts cold."""
        self._own.reset()

    def state(self) -> NDArray[np.uint64]:
        """What the next step takes from those before it, beside MuJoCo's ``mjSTATE_INTEGRATION``: for :meth:`set_state`.

        From here on this stepper goes on as one that is given the state, bit by bit: a matrix that it kept is computed anew.
        """
        return np.array(self._own.state(), np.uint64)

    def set_state(self, data: mujoco.MjData, state: ArrayLike) -> None:
        """Go on as after :meth:`state`.

        Args:
            data: has the ``mjSTATE_INTEGRATION`` of then; copies of it are recognised.
            state: of a stepper of this model, also of another process: ``(words,)`` unsigned integers, as :meth:`state` gives them.

        Raises:
            ValueError: the state is that of another model.
        """
        self._own.set_state(data._address, np.asarray(state, np.uint64).tolist())

    def step(self, data: mujoco.MjData, nstep: int = 1) -> None:
        """Advance by one step, or several; ``step1`` and ``step2`` in one.

        Args:
            data: of the model.
            nstep: how many steps of ``model.opt.timestep``.

        Raises:
            ValueError: the data belongs to another model, the mass matrix is not positive definite, or ``nstep`` is negative.
        """
        if nstep < 0:
            raise ValueError(f"nstep: {nstep!r} is no number of steps")
        for first in range(0, nstep, _BLOCK):
            self._own.step(data._address, min(_BLOCK, nstep - first), self._settings)

    def step1(self, data: mujoco.MjData) -> None:
        """Do what comes before controls are set: positions, collision, velocities, sensors of both.

        Args:
            data: of the model.
        """
        self._own.step1(data._address)

    def step2(self, data: mujoco.MjData) -> None:
        """Do what comes after controls are set: actuation, the solve, the sensors of forces, and the step.

        Args:
            data: of the model, after :meth:`step1`.
        """
        self._own.step2(data._address, self._settings)

    def derivatives(self, data: mujoco.MjData, *, eps: float = 1e-6) -> Derivatives:
        """Tell how the state after a step moves with the state and the controls before it; both ``data`` and this stay as they are.

        The contact law is differentiated in its modes; what it is asked about, as forces, masses, Jacobians and gaps, is
        differenced without solving again. It is the derivative of a step that begins cold, in which bodies of motion capture stand
        still. Of a contact or limit at rest it is that of the side on which it opens. Held is by how much the path of what rolls or
        rocks is off a line, of which positions feel a few percent of ``h`` times a velocity.

        Args:
            data: where the step would begin, with its controls.
            eps: by how much positions, velocities, activations and controls are moved for differences, each in its unit.

        Raises:
            ValueError: there is no derivative; it says why.
        """
        cold = copy.copy(self)
        cold.reset()
        cold._settings = (min(self._settings[0], 1e-10), self._settings[1])
        cold._own.keep_impulses()
        return derivatives(cold, data, eps, self._settings[0])


class Rollout(NamedTuple):
    """What copies of a model have done."""

    #: State of each copy after each step, as ``mujoco.mj_getState`` has it of ``mjSTATE_FULLPHYSICS``: ``(copies, steps, state)``.
    states: NDArray[np.float64]
    #: Readings of sensors in each step: ``(copies, steps, nsensordata)``.
    sensors: NDArray[np.float64]
    #: Steps of each copy that were not solved: ``(copies,)``.
    unsolved: NDArray[np.int64]


def rollout(
    model: mujoco.MjModel,
    states: ArrayLike,
    controls: ArrayLike,
    *,
    threads: int | None = None,
    tol: float = 1e-6,
    budget: int = 1000,
    compliance: Compliance = 0.0,
    soft: bool = False,
) -> Rollout:
    """Step copies of a model, each from its state through its controls, as ``mujoco.rollout`` does.

    The threads share the model, and run without the interpreter's lock. Each copy starts cold, so its result does not depend on
    the others, nor on the number of threads.

    Args:
        model: is not changed.
        states: where copies start, ``(copies, state)`` of ``mjSTATE_FULLPHYSICS``, in MuJoCo's units; one, ``(1, state)``, is the
            start of all.
        controls: of each copy in each step, ``(copies, steps, nu)``, each in the unit of its actuator; ``(1, steps, nu)`` are those
            of all.
        threads: how many, at most; ``None`` takes as many as there are cores for this process, and there are never more.
        tol: error up to which a step counts as solved, relative to the impulses; no unit.
        budget: work that a solve may take, in the unit of :attr:`stiction.Work.total`.
        compliance: what is soft, as a :class:`Stepper` takes it.
        soft: whether ``solref`` in MuJoCo's direct form is read.

    Raises:
        ValueError: as of a :class:`Stepper`, or the shape of an array is none of these.
        RuntimeError: MuJoCo gave up.
    """
    _check(model)
    _check_settings(tol, budget)
    springs = softness(model, compliance, soft)
    size = mujoco.mj_stateSize(model, _STATE)
    first, given = _arrays.array("states", states, _arrays.DOUBLE), _arrays.array("controls", controls, _arrays.DOUBLE)
    if first.ndim != 2 or first.shape[1] != size:
        raise ValueError(f"states: shape {list(first.shape)} is not (copies, {size})")
    if given.ndim != 3 or given.shape[2] != model.nu:
        raise ValueError(f"controls: shape {list(given.shape)} is not (copies, steps, {model.nu})")
    copies, steps = max(len(first), len(given)), given.shape[1]
    for name, found in (("states", first), ("controls", given)):
        if len(found) not in (1, copies):
            raise ValueError(f"{name}: there are {len(found)} for {copies} copies")
    done = Rollout(np.empty((copies, steps, size)), np.empty((copies, steps, model.nsensordata)), np.zeros(copies, np.int64))
    start = np.ascontiguousarray(np.broadcast_to(first, (copies, size)))
    control = np.ascontiguousarray(np.broadcast_to(given, (copies, steps, model.nu)))
    settings, workers = (float(tol), int(budget)), _arrays.threads_of(threads)
    _stiction.rollout(_library(), model._address, int(_STATE), (start, control), tuple(done), settings, workers, springs)
    return done


def patch(env: Any, *, tol: float = 1e-6, budget: int = 1000, compliance: Compliance = 0.0, soft: bool = False) -> Stepper:
    """Make an environment step through this law; wrappers may be around it.

    It is one of gymnasium, gymnasium-robotics, metaworld, dm_control (suite, composer) or robosuite. Bodies of motion capture move
    evenly over the frames of a step, where MuJoCo has them jump. A copy of the environment, by ``copy.deepcopy`` or ``pickle``,
    steps through this law as well, by a stepper of its own. Packages that need another MuJoCo than the one that is installed may
    work after :func:`compat`.

    Args:
        env: the environment, with or without wrappers.
        tol: error up to which a step counts as solved, relative to the impulses; no unit.
        budget: work that a solve may take, in the unit of :attr:`stiction.Work.total`.
        compliance: what is soft, as a :class:`Stepper` takes it; names are looked up anew in models that are built anew.
        soft: whether ``solref`` in MuJoCo's direct form is read.

    Returns:
        The stepper, which counts what is not solved. A reset of the environment is noticed, and models that it builds anew.

    Raises:
        ValueError: it has no model of MuJoCo that it steps as these do, or one that a :class:`Stepper` refuses.
    """
    from ._patch import patch_bare

    settings = {"tol": tol, "budget": budget, "compliance": compliance, "soft": soft}
    return patch_bare(getattr(env, "unwrapped", env), settings)


def compat() -> list[str]:
    """Mend in memory what packages get wrong with the MuJoCo that is installed, before their environments are made.

    These are dm_control 1.0.50, gymnasium-robotics 1.4.2, metaworld 3.1.1 and robosuite 1.5.2, as far as they are installed.

    Returns:
        What was changed, a line each.
    """
    from ._compat import mend

    return mend()


def _library() -> Path:
    """MuJoCo's library, as the package ``mujoco`` has loaded it."""
    folder = Path(mujoco.__file__).parent
    names = ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")
    return next(path for name in names for path in folder.glob(name))


def _check_settings(tol: float, budget: int) -> None:
    if not tol >= 0:
        raise ValueError(f"tol: {tol!r} is no error")
    if not budget >= 0:
        raise ValueError(f"budget: {budget!r} is no amount of work")


def _check(model: mujoco.MjModel) -> None:
    """Refuse what does not map."""
    if not isinstance(model, mujoco.MjModel):
        raise TypeError(f"model: a mujoco.MjModel is wanted, as mujoco.MjModel.from_xml_path gives one, not {type(model).__name__}")
    _stiction.check_version(_library())  # others lack some of the names below
    enabled = [bool(model.opt.enableflags & flag(mujoco.mjtEnableBit, f"mjENBL_{name}")) for name in _REFUSED]
    sleeps, speculates, overrides = enabled
    refused = {
        "option integrator: discrete does not map": model.opt.integrator == getattr(_INTEGRATOR, "mjINT_DISCRETE", None),
        "flag sleep: bodies that sleep have no contacts here; disable it": sleeps,
        "flag speculative: its distances are made for soft contacts; disable it, a Stepper looks ahead by itself": speculates,
        "flag override: margins belong to the Stepper; disable it": overrides,
        "geom surfacevel: contacts know it from MuJoCo 4.0 on": (
            not hasattr(mujoco.MjContact, "surfacevel") and np.any(getattr(model, "geom_surfacevel", 0.0))
        ),
        "flex: deformable bodies have more contacts than are solved here": model.nflex > 0,
        "it has no velocities": model.nv == 0,
    }
    for reason, holds in refused.items():
        if holds:
            raise ValueError(f"model: {reason}")
    if model.opt.integrator in (_INTEGRATOR.mjINT_RK4, _INTEGRATOR.mjINT_IMPLICIT):
        warnings.warn("the model's integrator, RK4 or implicit, is stepped as implicitfast", stacklevel=3)
