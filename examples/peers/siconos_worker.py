"""Siconos' NSGS, Alart-Curnier Newton and ADMM (Debian: `python3-siconos`)."""
import os
import time

import numpy as np
import siconos.numerics as sn

from worker import serve

SOLVERS = {
    "NSGS": (sn.SICONOS_FRICTION_3D_NSGS, 20_000),
    "Newton": (sn.SICONOS_FRICTION_3D_NSN_AC, 200),
    "ADMM": (sn.SICONOS_FRICTION_3D_ADMM, 10_000),
}


def problem(W, q, mu):
    contacts = sn.FrictionContactProblem(3, len(mu), np.asfortranarray(W), q.copy(), mu)

    def prepare(solver, tolerance):
        name, iterations = SOLVERS[solver]
        options = sn.SolverOptions(name)
        options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = iterations
        options.dparam[sn.SICONOS_DPARAM_TOL] = tolerance
        impulses, velocities, answer = np.zeros(len(q)), np.zeros(len(q)), {}

        def run():
            start = time.perf_counter()
            answer["info"] = sn.fc3d_driver(contacts, impulses, velocities, options)
            return max(time.perf_counter() - start - CALL, 0.1 * CALL)

        def result():
            done = options.iparam[sn.SICONOS_IPARAM_ITER_DONE]
            return answer["info"] == 0, done, impulses.copy()

        return run, result

    return prepare


def call():
    """What a call from Python costs by itself: one open contact, nothing to solve."""
    prepare = problem(np.eye(3), np.array([1.0, 0.0, 0.0]), np.array([0.5]))
    return min(prepare("NSGS", 1e-3)[0]() for _ in range(1000))


sn.numerics_set_verbose(0)
os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # a singular factor is not our concern
CALL = 0.0
CALL = call()
serve(problem)
