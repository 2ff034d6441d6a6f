"""All that solves, in threads whose stack is as small as musl's: 128 KB."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

START = """
import sys, threading
from collections.abc import Callable
from pathlib import Path
import numpy as np
import stiction

def done(work: Callable[[], None]) -> None:
    threading.stack_size(128 << 10)
    thread = threading.Thread(target=lambda: (work(), print("done", flush=True)))
    thread.start()
    thread.join()
"""

KERNELS = """
def each(dim, number):
    random = np.random.default_rng(0)
    for n, dim_of, contacts, rows, _ in stiction.SIZES:
        if dim_of != dim:
            continue
        H, push = random.normal(size=(contacts, dim, n)), random.normal(size=n)
        mu = np.full((contacts, dim - 1) if dim > 3 else contacts, 0.5)
        scene = tuple(part.astype(number) for part in (np.eye(n), H, push, np.zeros((contacts, dim)), mu))
        kernel = stiction.Kernel(n, contacts, dim=dim, rows=rows, dtype=number)
        solution = kernel.solve(*scene, budget=50, tol=1e-3)
        stiction.solve(*scene, budget=50, tol=1e-3)
        few = np.full_like(mu, 0.5)[:1]
        solved = stiction.solve(np.eye(n), H[:1], push, np.zeros((1, dim)), few, tol=1e-6)
        for ask in (
            lambda: solved.vjp(v=np.ones(n)), lambda: solved.jvp(mu=0.1), solved.least, solved.slip_reserve,
            lambda: solved.load_reserve(np.ones(n)), lambda: stiction.rest_reserve(*scene[:3], scene[4]),
        ):
            try:
                ask()
            except ValueError as error:  # too large, without friction, with more rows
                print(error)

def work():
    for dim in (3, 1, 2, 4, 6):
        for number in (np.float64, np.float32):
            each(dim, number)
"""

MODELS = """
import mujoco
from stiction.mujoco import Stepper, rollout

def work():
    for name in ("quadruped", "gripper"):
        model = mujoco.MjModel.from_xml_path(str(Path(sys.argv[1]) / f"{name}.xml"))
        data = mujoco.MjData(model)
        stepper = Stepper(model)
        stepper.step(data, 300)
        state = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        rollout(model, state[None], np.zeros((2, 5, model.nu)))
        assert stepper.unsolved == 0
"""


@pytest.mark.parametrize("code", [KERNELS, MODELS], ids=["kernels", "models"])
def test_small_stacks_are_enough(code: str) -> None:
    """Numpy's ``linalg.solve``, of derivatives of more than 60 velocities, needs more if OpenBLAS has several threads."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-c", START + code + "\ndone(work)\n", str(Path(__file__).parents[1] / "models")]
    process = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert process.returncode == 0 and process.stdout.endswith("done\n"), process.stdout + process.stderr
