"""Copies: of a model on threads, of steppers and kernels, of an environment."""

from __future__ import annotations

import copy
import pickle
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import gymnasium
import mujoco
import numpy as np
import pytest

import stiction
from stiction.mujoco import Stepper, patch, rollout

STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
MODELS = Path(__file__).parents[1] / "models"
COPIES, STEPS = 12, 60


def quadruped() -> tuple[mujoco.MjModel, np.ndarray, np.ndarray]:
    """The model, its state on four feet, and controls of some copies."""
    model = mujoco.MjModel.from_xml_path(str(MODELS / "quadruped.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    noise = np.random.default_rng(1).normal(0.0, 0.1, (COPIES, STEPS, model.nu))
    return model, state, data.ctrl + noise


def test_a_rollout_is_what_a_stepper_does_on_any_number_of_threads() -> None:
    model, state, controls = quadruped()
    cone = model.opt.cone
    done = rollout(model, state[None], controls, threads=1, tol=1e-8)
    assert model.opt.cone == cone
    for threads in (2, 1000, None):
        assert all(
            np.array_equal(a, b)
            for a, b in zip(done, rollout(model, state[None], controls, threads=threads, tol=1e-8), strict=True)
        )
    data, last = mujoco.MjData(model), np.empty_like(state)
    stepper = Stepper(model, tol=1e-8)
    for number in (0, COPIES - 1):
        mujoco.mj_resetData(model, data)
        mujoco.mj_setState(model, data, state, STATE)
        stepper.reset()
        for step, control in enumerate(controls[number]):
            data.ctrl[:] = control
            stepper.step(data)
            assert np.array_equal(data.sensordata, done.sensors[number, step])
        mujoco.mj_getState(model, data, last, STATE)
        assert np.array_equal(last, done.states[number, -1])
    assert stepper.unsolved == done.unsolved.sum() == 0


def test_a_rollout_says_what_is_wrong() -> None:
    model, state, controls = quadruped()
    for arguments, word in (
        ((state, controls), "states"),
        ((state[None, 1:], controls), "states"),
        ((state[None], controls[0]), "controls"),
        ((np.tile(state, (3, 1)), controls), "states"),
    ):
        with pytest.raises(ValueError, match=f"^{word}:"):
            rollout(model, *arguments)
    with pytest.raises(ValueError, match="^threads:"):
        rollout(model, state[None], controls, threads=0)
    assert rollout(model, state[None], controls[:, :0]).states.shape == (COPIES, 0, len(state))


def test_an_error_of_mujoco_ends_a_call_and_not_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """A kind of state that there is not."""
    model, state, controls = quadruped()
    size = mujoco.mj_stateSize
    monkeypatch.setattr("stiction.mujoco._STATE", -1)
    monkeypatch.setattr(mujoco, "mj_stateSize", lambda model, _: size(model, STATE))
    with pytest.raises(RuntimeError, match="^MuJoCo: .*state"):
        rollout(model, state[None], controls)


INTERRUPTED = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored in the background
from test_rollout import quadruped, rollout
model, state, controls = quadruped()
print("begun", flush=True)
try:
    rollout(model, state[None], controls[:, :1].repeat(100_000, 1))
except KeyboardInterrupt:
    print("stopped", flush=True)
"""


def test_a_rollout_stops_on_a_signal() -> None:
    """It would take minutes."""
    command, folder = [sys.executable, "-c", INTERRUPTED], Path(__file__).parent
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout and process.stdout.readline() == "begun\n"
        time.sleep(1.0)
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        start = time.monotonic()
        assert process.stdout.readline() == "stopped\n" and time.monotonic() - start < 1.0


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda own: pickle.loads(pickle.dumps(own))])
def test_steppers_and_kernels_are_copied(again: object) -> None:
    model, _, controls = quadruped()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    stepper = Stepper(model, tol=1e-8)
    stepper.step(data, 20)
    other = again(stepper)  # type: ignore[operator]
    ends = []
    for own, model_of in ((stepper, model), (other, other.model)):
        own.reset()
        mine = mujoco.MjData(model_of)
        mujoco.mj_resetDataKeyframe(model_of, mine, 0)
        for control in controls[0]:
            mine.ctrl[:] = control
            own.step(mine)
        ends.append(mine.qpos.copy())
    assert np.array_equal(*ends) and other.steps == stepper.steps == 20 + STEPS
    kernel = stiction.Kernel(6, 4, dtype=np.float32)
    assert again(kernel).size == kernel.size  # type: ignore[operator]
    solved = again(kernel).solve(np.eye(3), np.eye(3)[None], [-1.0, 0, 0], np.zeros((1, 3)), 0.5, tol=1e-4)  # type: ignore[operator]
    assert solved.status is stiction.Status.SOLVED and solved.v.dtype == np.float32


@pytest.mark.parametrize("name", ["Hopper-v5", "Ant-v5", "HalfCheetah-v5"])
def test_an_environment_steps_through_this_law(name: str) -> None:
    runs = []
    for _ in range(2):
        env = gymnasium.make(name)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # RK4
            stepper = patch(env, tol=1e-6)
        for _ in range(2):
            env.action_space.seed(3)
            first, _ = env.reset(seed=3)
            seen = [env.step(env.action_space.sample())[0] for _ in range(20)]
            runs.append(np.array([first, *seen]))
        assert stepper.steps == 2 * 20 * env.unwrapped.frame_skip and stepper.unsolved == stepper.fallbacks == 0  # type: ignore[attr-defined]
    assert all(np.array_equal(run, runs[0]) for run in runs) and np.isfinite(runs[0]).all()
    with pytest.raises(ValueError, match="^env:"):
        patch(object())


class Tray:
    """An environment of ten frames a step, whose tray is moved by 5 mm in each."""

    def __init__(self) -> None:
        boxes = '<geom type="box" size=".2 .2 .01"/></body><body pos="0 0 .06"><freejoint/><geom type="box" size=".05 .05 .05"/>'
        world = f'<worldbody><body mocap="true">{boxes}</body></worldbody>'
        self.model = mujoco.MjModel.from_xml_string(f"<mujoco>{world}</mujoco>")
        self.data = mujoco.MjData(self.model)

    def _step_mujoco_simulation(self, ctrl: np.ndarray, n_frames: int) -> None:
        raise AssertionError("MuJoCo's law")

    def step(self) -> None:
        self.data.mocap_pos[0, 0] += 0.005
        self._step_mujoco_simulation(np.zeros(0), 10)


def test_a_tray_carries_though_its_pose_is_written_each_tenth_step() -> None:
    env = Tray()
    stepper, speeds = patch(env), []
    for _ in range(40):
        env.step()
        speeds.append(env.data.qvel[0])
    assert stepper.steps == 400 and stepper.unsolved == stepper.fallbacks == 0
    assert np.allclose(speeds[5:], 0.25, atol=1e-6) and env.data.qpos[0] > 0.19


def test_threads_are_never_more_than_cores_and_arrays_need_not_be_aligned() -> None:
    H, push, w = np.eye(3)[None, None], np.array([[0, 0, -1.0]]), np.zeros((1, 1, 3))
    assert stiction.solve_batch(np.eye(3)[None], H, push, w, np.full((1, 1), 0.5), threads=2**40).v.shape == (1, 3)
    record = np.zeros(1, dtype=[("id", "u1"), ("M", "f8", (3, 3)), ("keys", "u4", (1,))])
    record["M"][0] = 2 * np.eye(3)
    solved = stiction.solve(record["M"][0], H[0], push[0], w[0], 0.5)
    assert solved.status is stiction.Status.SOLVED
    kernel = stiction.Kernel(3, 1)
    assert kernel.solve(record["M"][0], H[0], push[0], w[0], 0.5, keys=record["keys"][0]).status is stiction.Status.SOLVED
