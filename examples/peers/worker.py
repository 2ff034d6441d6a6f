"""Serves one library on stdin and stdout, a JSON line a request: a problem, or a solve of it.

Each library runs in a Python of its own, so that a wheel and a distribution's package can race.
A problem is `W`, `q`, `mu` of a spatial scene, rows contact by contact, normal first.
"""
import json
import os
import sys

import numpy as np


def serve(library):
    """`library(W, q, mu)` gives a function `(solver, tolerance) -> (run, result)`.

    `run()` solves from a cold start and returns the seconds that took; `result()` gives
    `(converged, iterations, r)`.
    """
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # the libraries' own chatter
    problem = None
    for line in sys.stdin:
        request = json.loads(line)
        if "W" in request:
            problem = library(*(np.array(request[key], float) for key in ("W", "q", "mu")))
            answer = {}
        else:
            answer = visit(problem, request["solver"], request["tolerance"])
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


def visit(problem, solver, tolerance):
    """Best of some calls within a millisecond, but at least three unless they are slow."""
    best, spent, calls = float("inf"), 0.0, 0
    while calls < 3 or (spent < 1e-3 and calls < 20):
        run, result = problem(solver, tolerance)
        seconds = run()
        best, spent, calls = min(best, seconds), spent + seconds, calls + 1
        if spent > 0.05:
            break
    converged, iterations, impulses = result()
    if not np.isfinite(impulses).all():
        impulses, converged = np.zeros_like(impulses), False
    return {
        "seconds": best,
        "converged": bool(converged),
        "iterations": int(iterations),
        "r": impulses.tolist(),
    }
