"""Rollouts of a quadruped on a cluster: the example starts one on this machine; ``Client("host:8786")`` takes yours.

``pip install '.[cluster]'``, then ``python cluster.py``. The model is sent to each worker once. On this machine workers are
threads: rollouts run without the interpreter's lock.
"""

from __future__ import annotations

import time
from pathlib import Path

import mujoco
import numpy as np
from dask.distributed import Client
from numpy.typing import NDArray

from stiction.mujoco import rollout

STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
TASKS, COPIES, STEPS = 8, 32, 200


def heights(model: mujoco.MjModel, state: NDArray[np.float64], control: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
    """Step some copies with legs pulled by other amounts, and tell how high the trunk of each is at the end (m)."""
    pulled = control + np.random.default_rng(seed).normal(0.0, 0.1, (COPIES, 1, len(control)))
    done = rollout(model, state[None], np.tile(pulled, (1, STEPS, 1)), threads=1)
    return done.states[:, -1, 3]  # behind the time x, y, z


def main() -> None:
    """Send the tasks, and gather what they say."""
    model = mujoco.MjModel.from_xml_path(str(Path(__file__).parent / "models" / "quadruped.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    with Client(n_workers=2, threads_per_worker=1, processes=False, dashboard_address=":0") as client:
        sent, start = client.scatter(model, broadcast=True), time.perf_counter()
        ends = np.concatenate(client.gather([client.submit(heights, sent, state, data.ctrl, seed) for seed in range(TASKS)]))
        rate = TASKS * COPIES * STEPS / (time.perf_counter() - start)
    print(f"{len(ends)} copies, {rate:,.0f} steps a second; trunks from {ends.min():.3f} to {ends.max():.3f} m high")


if __name__ == "__main__":
    main()
