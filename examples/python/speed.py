"""Scenes and steps per second, beside Pinocchio and MuJoCo: prints the tables of `src/guide/reports/python.md`.

``pip install . pin mujoco``, then ``python speed.py`` on a machine that does nothing else. Pinocchio is left out where it is not
installed. ``python speed.py steps copies`` prints these tables alone.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout

import stiction
import stiction.mujoco
from stiction import BatchSolution
from stiction.mujoco import Stepper

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "tests"))

from test_mujoco_scenes import trot  # noqa: E402

from judge import Array, error, read  # noqa: E402

STATE = mujoco.mjtState.mjSTATE_INTEGRATION

TOLERANCE = 1e-6
SCENES = ("box_slide_spin", "go2_trot_mixed", "talos_stand_boxfeet", "stack3_push")
COUNT = 20_000
TURNS = 7


def least(call: Callable[[], Any], number: int = 1, turns: int = TURNS) -> float:
    """Time a call (s): the least of some turns of ``number`` calls."""
    best = np.inf
    for _ in range(turns):
        start = time.perf_counter()
        for _ in range(number):
            call()
        best = min(best, (time.perf_counter() - start) / number)
    return float(best)


def pinocchio(scene: tuple[Any, ...]) -> dict[str, float]:
    """Time Pinocchio's solvers (s), by their own clock without Python, at the loosest tolerance that reaches ours."""
    try:
        import pinocchio as pin
    except ImportError:
        return {}
    M, H, push, w, mu = scene
    rows = H.reshape(-1, len(M))
    order = np.arange(len(rows)).reshape(-1, 3)[:, [1, 2, 0]].ravel()  # its rows are two tangents, then the normal
    W = np.asfortranarray((rows @ np.linalg.solve(M, rows.T))[np.ix_(order, order)])
    q = (rows @ np.linalg.solve(M, push) + w.ravel())[order]
    model = pin.Model()
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    model.appendBodyToJoint(1, pin.Inertia.Random(), pin.SE3.Identity())
    models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    for friction in mu:
        contact = pin.PointContactConstraintModel(model, 0, pin.SE3.Identity(), 1, pin.SE3.Identity())
        contact.setFriction(float(friction))
        models.append(pin.ConstraintModel(contact))
        datas.append(models[-1].createData())
    times = {}
    for name in ("ADMM", "PGS"):
        for exponent in range(3, 13):
            settings, outcome = getattr(pin, f"{name}SolverSettings")(), getattr(pin, f"{name}SolverResult")()
            settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = 10.0**-exponent
            settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0.0
            settings.max_iterations, settings.measure_timings = 10_000, True
            clocks = []
            for _ in range(50):
                method = pin.ADMMConstraintSolver(len(q)) if name == "ADMM" else pin.PGSConstraintSolver()
                method.solve(pin.DelassusOperatorDense(W), q, models, datas, settings, outcome)
                clocks.append(method.getElapsedTime() * 1e-6)
            r = np.zeros(len(q))
            r[order] = outcome.retrieveConstraintImpulses()
            v = np.linalg.solve(M, push + rows.T @ r)
            if error(M, H, push, w, mu, v, r.reshape(H.shape[:2])) <= TOLERANCE:
                times[name] = min(clocks)
                break
    return times


def scenes() -> None:
    """Print scenes per second."""
    print("| scene | n | contacts | `solve` | batch, one core | two cores | Pinocchio ADMM | Pinocchio PGS |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for name in SCENES:
        scene = read(json.loads((HERE / f"../../tests/scenes/{name}.json").read_text()))
        alone = least(lambda scene=scene: stiction.solve(*scene, tol=TOLERANCE), 2000)  # type: ignore[misc]
        # Each has its own arrays, and a push of its own.
        scale = np.random.default_rng(1).uniform(0.9, 1.1, (COUNT, 1))
        batch = [np.repeat(part[None], COUNT, 0) for part in scene]
        batch[2] = batch[2] * scale
        out: BatchSolution = stiction.solve_batch(*batch, tol=TOLERANCE)
        assert (out.status == stiction.Status.SOLVED).all()
        seconds = [alone] + [
            least(lambda k=k, batch=batch, out=out: stiction.solve_batch(*batch, tol=TOLERANCE, threads=k, out=out)) / COUNT  # type: ignore[misc]
            for k in (1, 2)
        ]
        peers = pinocchio(scene)
        seconds += [peers.get("ADMM", np.nan), peers.get("PGS", np.nan)]
        cells = [f"{1 / each:,.0f}" if np.isfinite(each) else "not reached" for each in seconds]
        print(f"| {name} | {len(scene[0])} | {len(scene[4])} | " + " | ".join(cells) + " |")


def moving(name: str, count: int) -> tuple[mujoco.MjModel, list[Array]]:
    """A model of the folder, and states on its way in which `count` contacts touch."""
    model, states = bare(name), []
    data, stepper = mujoco.MjData(model), Stepper(bare(name), tol=1e-9)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    for step in range(500):
        if name == "quadruped":
            trot(data, 0.5 + data.time)
        if name == "humanoid":
            data.qfrc_applied[0] = 60.0 if 50 <= step < 100 else 0.0
        stepper.step(data)
        state = np.zeros(mujoco.mj_stateSize(model, STATE))
        mujoco.mj_getState(model, data, state, STATE)
        state[1 + (2 if model.nq > 7 or name == "cube" else 0)] -= 1e-7  # what touches is listed, without a margin
        mujoco.mj_setState(model, probe := mujoco.MjData(model), state, STATE)
        mujoco.mj_forward(model, probe)
        if probe.ncon == count and probe.nefc == 3 * count:
            states.append(state)
    return model, states


def bare(name: str, **options: float) -> mujoco.MjModel:
    """A model without friction in its joints: contacts alone."""
    model = mujoco.MjModel.from_xml_path(str(HERE / f"models/{name}.xml"))
    model.opt.timestep, model.dof_frictionloss[:] = 0.002, 0.0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_WARMSTART  # each from nothing
    model.opt.cone, model.opt.jacobian = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtJacobian.mjJAC_DENSE
    for option, value in options.items():
        setattr(model.opt, option, value)
    return model


def beside_mujoco() -> None:
    """Print scenes per second of MuJoCo's solver alone and of a batch, on one core, for the same states, and errors."""
    best = {"cone": 1, "impratio": 100.0, "tolerance": 1e-10}
    kinds = {"default": {"cone": 0}, "elliptic, `impratio` 100, tolerance 1e-10": best}
    heads = " | ".join(f"MuJoCo, {kind} | error: median, worst" for kind in kinds)
    print(f"\n| states | n | contacts | batch | its worst error | {heads} |")
    print("|---|" + "--:|" * 8)
    for name, count in (("cube", 4), ("quadruped", 4), ("quadruped", 2), ("humanoid", 8)):
        model, states = moving(name, count)
        batch, cells = [], []
        for state in states:
            mujoco.mj_setState(model, data := mujoco.MjData(model), state, STATE)
            mujoco.mj_forward(model, data)
            mass = np.zeros((model.nv, model.nv))
            mujoco.mj_fullM(model, data, mass)
            push = mass @ data.qvel + model.opt.timestep * data.qfrc_smooth
            rows = data.efc_J.reshape(count, 3, model.nv).copy()
            batch.append((mass, rows, push, np.zeros((count, 3)), data.contact.friction[:, 0].copy()))
        arrays = [np.array(part) for part in zip(*batch, strict=True)]
        out = stiction.solve_batch(*arrays, tol=TOLERANCE)
        worst = max(error(*scene, v, r) for scene, v, r in zip(batch, out.v, out.r, strict=True))
        many = [np.concatenate([part] * 20) for part in arrays]
        seconds = least(lambda many=many: stiction.solve_batch(*many, tol=TOLERANCE, threads=1)) / len(many[0])  # type: ignore[misc]
        for options in kinds.values():
            other, datas, errors, force = bare(name, **options), [], [], np.zeros(6)
            for scene, state in zip(batch, states, strict=True):
                mujoco.mj_setState(other, data := mujoco.MjData(other), state, STATE)
                mujoco.mj_forward(other, data)
                impulses = np.zeros((count, 3))
                for i in range(count):
                    mujoco.mj_contactForce(other, data, i, force)
                    impulses[i] = other.opt.timestep * force[:3]
                errors.append(error(*scene, data.qvel + other.opt.timestep * data.qacc, impulses))
                datas.append(data)

            def solver(other: mujoco.MjModel = other, datas: list[mujoco.MjData] = datas) -> None:
                for data in datas:
                    mujoco.mj_fwdConstraint(other, data)

            cells.append(f"{len(datas) / least(solver):,.0f} | {np.median(errors):.1e}, {max(errors):.1e}")
        print(f"| {len(states)} of {name} | {model.nv} | {count} | {1 / seconds:,.0f} | {worst:.1e} | " + " | ".join(cells) + " |")


def standing(name: str, advance: Callable[[mujoco.MjModel], Any], **options: float) -> tuple[mujoco.MjModel, mujoco.MjData, Any]:
    """A model that has stood for a second, its data, and what advances them."""
    model = mujoco.MjModel.from_xml_path(str(HERE / f"models/{name}.xml"))
    model.opt.timestep = 0.002
    for option, value in options.items():
        setattr(model.opt, option, value)
    data, step = mujoco.MjData(model), advance(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    step(data, 500)
    return model, data, step


def exact(model: mujoco.MjModel) -> Callable[..., None]:
    """Steps of this package."""
    return Stepper(model, tol=TOLERANCE).step


def soft(model: mujoco.MjModel) -> Callable[..., None]:
    """Steps of MuJoCo."""
    return lambda data, count=1: mujoco.mj_step(model, data, count)


def shared(model: mujoco.MjModel) -> Callable[..., None]:
    """What such steps have of MuJoCo: kinematics, collision, actuation, sensors, Euler. Nothing pushes, so it falls."""
    stages = (mujoco.mj_step1, mujoco.mj_fwdActuation, mujoco.mj_fwdAcceleration, mujoco.mj_sensorAcc, mujoco.mj_Euler)

    def step(data: mujoco.MjData, count: int = 1) -> None:
        for _ in range(count):
            for stage in stages:
                stage(model, data)

    return step


def steps() -> None:
    """Print how long a step takes of models that stand."""
    print("\n| step of 2 ms, µs | quadruped | humanoid |\n|---|--:|--:|")
    best = {"cone": 1, "impratio": 100.0}
    kinds: dict[str, tuple[Any, dict[str, float]]] = {
        "`Stepper.step`": (exact, {}),
        "of it MuJoCo's parts": (shared, {}),
        "`mj_step`, pyramids (default)": (soft, {}),
        "`mj_step`, elliptic, `impratio` 100": (soft, best),
        "`mj_step`, elliptic, `impratio` 100, `noslip` 10": (soft, {**best, "noslip_iterations": 10}),
    }
    for kind, (advance, options) in kinds.items():
        cells = []
        for name in ("quadruped", "humanoid"):
            _, data, step = standing(name, advance, **options)
            cells.append(f"{1e6 * least(lambda data=data, step=step: step(data), 2000):.1f}")  # type: ignore[misc]
        print(f"| {kind} | " + " | ".join(cells) + " |")


def copies(count: int = 4096, length: int = 50) -> None:
    """Print steps per second of copies of the quadruped, by turns with MuJoCo's, on two cores: targets of joints shake."""
    print(f"\n| {count} copies, {length} steps each; targets shake by, rad | `rollout` | MuJoCo's, elliptic, `impratio` 100 |")
    print("|--:|--:|--:|")
    model, own, _ = standing("quadruped", exact)
    other, theirs, _ = standing("quadruped", soft, cone=1, impratio=100.0)
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    states = np.zeros((2, 1, mujoco.mj_stateSize(model, kind)))
    mujoco.mj_getState(model, own, states[0, 0], kind)
    mujoco.mj_getState(other, theirs, states[1, 0], kind)
    shape, datas = (count, length), [mujoco.MjData(other) for _ in range(2)]
    out = {"state": np.zeros((*shape, states.shape[2])), "sensordata": np.zeros((*shape, other.nsensordata))}
    with rollout.Rollout(nthread=2) as run:
        for shake in (0.05, 0.5):
            controls = own.ctrl + np.random.default_rng(0).normal(0.0, shake, (*shape, model.nu))
            both: list[Callable[[], Any]] = [
                lambda controls=controls: stiction.mujoco.rollout(model, states[0], controls, threads=2, tol=TOLERANCE),  # type: ignore[misc]
                lambda controls=controls: run.rollout(other, datas, np.tile(states[1], (count, 1)), controls, **out),  # type: ignore[misc]
            ]
            seconds = np.min([[least(call, turns=1) for call in both] for _ in range(TURNS)], axis=0)
            print(f"| {shake} | " + " | ".join(f"{count * length / each:,.0f}" for each in seconds) + " |")


if __name__ == "__main__":
    for table in (scenes, beside_mujoco, steps, copies):
        if not sys.argv[1:] or table.__name__ in sys.argv[1:]:
            table()
