"""Scenes and steps per second, beside Pinocchio and MuJoCo: prints the tables of the guide.

``pip install . pin mujoco``, then ``python speed.py`` on a machine that does nothing else. Pinocchio is left out where it is not
installed.
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
from stiction import BatchSolution
from stiction.mujoco import Stepper

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "tests"))

from judge import error, read  # noqa: E402

TOLERANCE = 1e-6
SCENES = ("box_slide_spin", "go2_trot_mixed", "talos_stand_boxfeet", "stack3_push")
COUNT = 20_000
TURNS = 7


def least(call: Callable[[], Any], number: int = 1) -> float:
    """Time a call (s): the least of some turns of ``number`` calls."""
    best = np.inf
    for _ in range(TURNS):
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


def steps() -> None:
    """Print steps per second of a quadruped that stands, from an MJCF."""
    print("\n| step of a standing quadruped, 2 ms | µs a step | steps/s |")
    print("|---|--:|--:|")
    print_ = lambda name, seconds: print(f"| {name} | {1e6 * seconds:.1f} | {1 / seconds:,.0f} |")  # noqa: E731

    def load(**options: Any) -> tuple[mujoco.MjModel, mujoco.MjData]:
        model = mujoco.MjModel.from_xml_path(str(HERE / "models/quadruped.xml"))
        model.opt.timestep = 0.002
        for option, value in options.items():
            setattr(model.opt, option, value)
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        mujoco.mj_step(model, data, 500)
        return model, data

    model, data = load()
    stepper = Stepper(model, tol=TOLERANCE)
    stepper.step(data, 500)

    def own() -> None:
        mujoco.mj_step1(model, data)
        mujoco.mj_fwdActuation(model, data)
        mujoco.mj_fwdAcceleration(model, data)
        mujoco.mj_sensorAcc(model, data)
        mujoco.mj_Euler(model, data)

    print_("`Stepper.step`", least(lambda: stepper.step(data), 2000))
    assert stepper.unsolved == 0
    data.qacc[:] = 0.0
    print_("of it MuJoCo's kinematics, collision, actuation, sensors, Euler", least(own, 2000))
    kinds = {"pyramids (default)": {}, "elliptic, impratio 100": {"cone": 1, "impratio": 100.0}}
    kinds["elliptic, impratio 100, noslip 10"] = {**kinds["elliptic, impratio 100"], "noslip_iterations": 10}
    for name, options in kinds.items():
        model, data = load(**options)
        print_(f"`mj_step`, {name}", least(lambda model=model, data=data: mujoco.mj_step(model, data), 2000))  # type: ignore[misc]
    model, data = load()
    state = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    state = np.tile(state, (2, 1))
    control = np.broadcast_to(data.ctrl, (2, 1000, model.nu)).copy()
    for threads in (1, 2):
        datas = [mujoco.MjData(model) for _ in range(threads)]
        with rollout.Rollout(nthread=threads) as run:
            seconds = least(lambda run=run, datas=datas: run.rollout(model, datas, state, control))  # type: ignore[misc]
        print_(f"`mujoco.rollout`, {threads} threads", seconds / 2000)


if __name__ == "__main__":
    scenes()
    steps()
