#!/usr/bin/env python3
"""MuJoCo's solvers and this crate on the question that they share: elliptic cones with compliance, which is our convex relaxation.

    pip install mujoco numpy scipy ./examples/python
    python3 examples/peers/mujoco_solver.py

States of MuJoCo's own simulation, contacts alone (no joint limits, no dry friction). MuJoCo's time is that of `mj_fwdConstraint` from the
acceleration without contacts; ours is that of `solve_batch` on one thread, with filling and factor, over copies of one scene. Each goes down two
tolerances a decade; its time to an error is that of the fastest run whose error, recomputed here for both, is at most that.
"""
import sys
import time
from pathlib import Path

import mujoco
import numpy as np
import stiction

from scene import project

MODELS = Path(__file__).parents[1] / "python/models"
BOX = '<body pos="{x} 0 {z}"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="{mass}" friction="0.5"/></body>'
WORLD = '<mujoco><worldbody><geom type="plane" size="5 5 0.1" friction="0.5"/>{bodies}</worldbody></mujoco>'
TOLERANCES = [10 ** (-k / 2) for k in range(2, 25)]
ERRORS = [1e-3, 1e-6, 1e-9]
COPIES = 64
STATES = 12


def worlds() -> dict[str, mujoco.MjModel]:
    """Models by name."""
    sliding = WORLD.format(bodies=BOX.format(x=0, z=0.1, mass=1))
    stack = WORLD.format(bodies="".join(BOX.format(x=0.01 * k, z=0.1 + 0.2 * k, mass=mass) for k, mass in enumerate((1, 2, 10))))
    models = {"sliding box": sliding, "stack of three boxes": stack}
    found = {name: mujoco.MjModel.from_xml_string(text) for name, text in models.items()}
    found["quadruped"] = mujoco.MjModel.from_xml_path(str(MODELS / "quadruped.xml"))
    for model in found.values():
        model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        for flag in ("FRICTIONLOSS", "LIMIT", "EQUALITY", "WARMSTART"):
            model.opt.disableflags |= getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}")
    return found


def states(model: mujoco.MjModel) -> list[mujoco.MjData]:
    """States of a simulation that is pushed sideways again and again."""
    data, found = mujoco.MjData(model), []
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    for k in range(100 * STATES):
        data.qfrc_applied[:] = 0
        if k // 150 % 2:
            data.qfrc_applied[0] = 0.45 * 9.81 * model.body_mass.sum() * (1 + k % 3) / 3
        mujoco.mj_step(model, data)
        if k % 100 == 99:
            copy = mujoco.MjData(model)
            mujoco.mj_copyData(copy, model, data)
            mujoco.mj_forward(model, copy)
            if copy.ncon:
                found.append(copy)
    return found


class Problem:
    """`M`, `M a0`, `H`, `w`, `mu` and compliance of a state, in MuJoCo's accelerations."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        n, c = model.nv, data.ncon
        self.mass = np.zeros((n, n))
        mujoco.mj_fullM(model, self.mass, data.qM) if hasattr(data, "qM") else mujoco.mj_fullM(model, data, self.mass)
        self.push = self.mass @ data.qacc_smooth
        self.jacobian = data.efc_J.reshape(-1, n)[: 3 * c].reshape(c, 3, n).copy()
        self.offset = -data.efc_aref[: 3 * c].reshape(c, 3).copy()
        self.mu = np.array([data.contact[i].friction[0] for i in range(c)])
        self.compliance = data.efc_R[: 3 * c].reshape(c, 3)[:, :2].copy()
        rows = self.jacobian.reshape(-1, n)
        self.delassus = rows @ np.linalg.solve(self.mass, rows.T) + np.diag(data.efc_R[: 3 * c])
        self.free = rows @ data.qacc_smooth + self.offset.ravel()

    def error(self, force: np.ndarray) -> float:
        """The residual of the natural map of the relaxation, relative to forces (`src/guide/error.md`)."""
        steps = [3 / np.trace(self.delassus[3 * i : 3 * i + 3, 3 * i : 3 * i + 3]) for i in range(len(self.mu))]

        def mapped(u: np.ndarray, r: np.ndarray) -> np.ndarray:
            return np.concatenate([project(r[3 * i : 3 * i + 3] - s * u[3 * i : 3 * i + 3], self.mu[i]) for i, s in enumerate(steps)])

        residual = force - mapped(self.delassus @ force + self.free, force)
        return float(np.linalg.norm(residual) / max(np.linalg.norm(force), np.linalg.norm(mapped(self.free, 0 * force)), 1e-300))


def least(call: object, repeat: int, visits: int = 7) -> float:
    """Least time of a call (s), of some visits."""
    times = []
    for _ in range(visits):
        start = time.perf_counter()
        for _ in range(repeat):
            call()  # type: ignore[operator]
        times.append((time.perf_counter() - start) / repeat)
    return min(times)


def ours(problem: Problem, tolerance: float, budget: int = 1000) -> tuple[float, float]:
    """Time and error."""
    arrays = (problem.mass[None], problem.jacobian[None], np.repeat(problem.push[None], COPIES, 0), problem.offset[None], problem.mu[None])
    how = {"tol": tolerance, "budget": budget, "compliance": problem.compliance[None], "relaxed": True, "threads": 1}
    out = stiction.solve_batch(*arrays, **how)

    def call() -> None:
        stiction.solve_batch(*arrays, **how, out=out)

    seconds = least(call, 2) / COPIES
    return seconds, problem.error(np.asarray(out.r[0]).ravel())


def theirs(model: mujoco.MjModel, data: mujoco.MjData, problem: Problem, solver: int, tolerance: float) -> tuple[float, float]:
    """Time and error."""
    model.opt.solver, model.opt.iterations, model.opt.ls_iterations, model.opt.tolerance = solver, 1000, 100, tolerance
    seconds = least(lambda: mujoco.mj_fwdConstraint(model, data), 20)
    return seconds, problem.error(data.efc_force[: problem.free.size].copy())


def main() -> None:
    """Prints a row for each model, solver and error."""
    solvers = {"this crate": None, "MuJoCo Newton": mujoco.mjtSolver.mjSOL_NEWTON, "MuJoCo CG": mujoco.mjtSolver.mjSOL_CG}
    print(f"MuJoCo {mujoco.__version__}\n\n| model, contacts | solver | to 1e-3: µs | to 1e-6 | to 1e-9 |\n|---|---|---:|---:|---:|")
    for name, model in worlds().items():
        found = [(data, Problem(model, data)) for data in states(model)]
        count = [data.ncon for data, _ in found]
        for solver, kind in solvers.items():
            times: dict[float, list[float]] = {error: [] for error in ERRORS}
            for data, problem in found:
                runs = [ours(problem, t) if kind is None else theirs(model, data, problem, kind, t) for t in TOLERANCES]
                for error in ERRORS:
                    times[error].append(min((seconds for seconds, reached in runs if reached <= error), default=np.inf))
            cells = []
            for error in ERRORS:
                solved = [value for value in times[error] if np.isfinite(value)]
                mean = f"{1e6 * np.exp(np.mean(np.log(solved))):.1f}" if solved else "–"
                cells.append(mean if len(solved) == len(found) else f"{mean} ({len(solved)} of {len(found)})")
            print(f"| {name}, {min(count)} to {max(count)} | {solver} | {' | '.join(cells)} |")
            if kind is None:
                idle = np.exp(np.mean([np.log(ours(problem, 1e-6, 0)[0]) for _, problem in found]))
                print(f"| | filling, factor and one error, without a sweep | {1e6 * idle:.1f} | | |")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
