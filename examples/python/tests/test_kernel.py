from __future__ import annotations

import json
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiction
from stiction import Status
from stiction.time_stepping import contact_rows

from conftest import REPOSITORY
from judge import read
from test_solve import EYE, MU, PUSH, H, W

N, D = 18, 3


def records() -> list[dict[str, Any]]:
    """The steps of ``examples/firmware/trot.bin``, as ``examples/embedded/records.rs`` describes them."""
    data = memoryview((REPOSITORY / "examples/firmware/trot.bin").read_bytes())
    place, steps = 0, []

    def numbers(count: int) -> np.ndarray[Any, np.dtype[np.float32]]:
        nonlocal place
        place += 4 * count
        return np.frombuffer(data[place - 4 * count : place], "<f4").astype(np.float32)

    def word() -> int:
        return int(struct.unpack("<I", numbers(1).tobytes())[0])

    while place < len(data):
        contacts = word()
        M = np.zeros((N, N), np.float32)
        M[np.tril_indices(N)] = numbers(N * (N + 1) // 2)
        M = np.where(M != 0, M, M.T)
        step: dict[str, Any] = {"M": M, "free_impulse": -numbers(N), "keys": [], "mu": [], "w": [], "H": []}
        for _ in range(contacts):
            step["keys"].append(word())
            step["mu"].append(numbers(1)[0])
            step["w"].append(numbers(D))
            step["H"].append(numbers(D * N).reshape(D, N))
        steps.append({name: np.array(value) for name, value in step.items()})
    return steps


def fastest(kernel: stiction.Kernel, body: dict[str, Any], steps: int) -> float:
    """The largest speed of a contact (m/s) of a body of ``tests/rest_kept.json``, near the largest load that friction can hold."""
    M, force, H = np.diag(body["masses"]), 0.99 * np.array(body["load"]), []
    force[: len(body["weight"])] += body["weight"]
    for (x, y, z), normal, _ in body["feet"]:
        velocity = np.hstack([np.eye(3), [[0, z, -y], [-z, 0, x], [y, -x, 0]]])
        H.append(contact_rows(normal / np.linalg.norm(normal), velocity))
    v, speed = np.zeros(6), 0.0
    for _ in range(steps):
        found = kernel.solve(M, H, M @ v + 2e-3 * force, mu=[mu for _, _, mu in body["feet"]], tol=1e-9)
        assert found.solved
        v, speed = found.v, max(speed, np.abs(found.u).max())
    return speed


def test_a_body_that_rests_stays_if_that_is_said() -> None:
    bodies = json.loads((REPOSITORY / "tests/rest_kept.json").read_text())
    slide, kernel = 0, stiction.Kernel(6, 8)
    for body in (body for body in bodies if len(body["masses"]) == 6):
        kernel.reset()
        slide += fastest(kernel, body, 1) > 1e-3
        kernel.reset()
        kernel.presume_rest()
        assert fastest(kernel, body, 20) < 1e-8
    assert slide >= 8


def test_float32_has_the_bits_of_the_microcontroller() -> None:
    kernel, lines = stiction.Kernel(N, 5, dtype=np.float32), []
    assert kernel.size[0] == N  # not padded
    for count, step in enumerate(records(), 1):
        found = kernel.solve(**step, tol=1e-4, budget=100)
        assert found.solved and found.r.dtype == np.float32
        line = f"{count:2}"
        for key, impulse in zip(step["keys"], found.r, strict=True):
            line += f"  {key}: " + " ".join(f"{bits:08x}" for bits in impulse.view(np.uint32))
        lines.append(line)
    assert lines == (Path(__file__).parent / "trot.txt").read_text().splitlines()


def test_warm_starts_take_less_work(trot: list[dict[str, Any]]) -> None:
    names = sorted({name for step in trot for name in step["contact_names"]})
    kernel, warm, cold = stiction.Kernel(N, 5), 0, 0
    for step in trot:
        keys = [names.index(name) for name in step["contact_names"]]
        found = kernel.solve(*read(step), keys=keys, tol=1e-9)
        again = stiction.solve(*read(step), tol=1e-9)
        assert found.solved and again.solved
        assert np.allclose(found.v, again.v, atol=1e-7)
        warm, cold = warm + found.work.total, cold + again.work.total
    assert warm < 0.9 * cold


def test_a_budget_ends_and_resume_goes_on() -> None:
    rng = np.random.default_rng(3)
    J, push, mu = rng.normal(size=(5, 3, 9)), rng.normal(size=9), np.full(5, 0.6)
    whole = stiction.solve(np.eye(9), J, push, np.zeros((5, 3)), mu, tol=1e-10)
    kernel, calls = stiction.Kernel(9, 5), 1
    part = kernel.solve(np.eye(9), J, push, np.zeros((5, 3)), mu, tol=1e-10, budget=2)
    assert part.status is Status.OUT_OF_BUDGET
    while part.status is Status.OUT_OF_BUDGET:
        part, calls = kernel.resume(tol=1e-10, budget=2), calls + 1
    assert calls > 2 and part.solved
    assert np.array_equal(part.r, whole.r) and part.work == whole.work


def test_reset_start_and_refusal() -> None:
    kernel = stiction.Kernel(3, 1)
    with pytest.raises(ValueError, match="no scene"):
        kernel.resume()
    first = kernel.solve(EYE, H, PUSH, W, MU, keys=[7], tol=1e-9)
    assert first.work.total > 0
    assert kernel.solve(EYE, H, PUSH, W, MU, keys=[7], tol=1e-9).work.total == 0
    kernel.reset()
    assert kernel.solve(EYE, H, PUSH, W, MU, keys=[7], tol=1e-9).work == first.work
    kernel.reset()
    kernel.start_at([7], first.r)
    assert kernel.solve(EYE, H, PUSH, W, MU, keys=[7], tol=1e-9).work.total == 0
    with pytest.raises(ValueError, match="^M"):
        kernel.solve(-EYE, H, PUSH, W, MU)
    with pytest.raises(ValueError, match="no scene"):
        kernel.resume()
    for keys in ([-1], [2**32], [0.5]):
        with pytest.raises(ValueError, match="^keys"):
            kernel.solve(EYE, H, PUSH, W, MU, keys=keys)
    with pytest.raises(ValueError, match="^r"):
        kernel.start_at([7], [1.0])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_large_scene_is_solved_again_after_a_fork() -> None:
    """Large kernels run on a thread that is kept, and a fork leaves threads behind."""
    H = np.zeros((1, 3, 130))
    H[0, [0, 1, 2], [2, 0, 1]] = 1.0
    push = np.concatenate([[0.03, 0.0, -0.02], np.zeros(127)])

    def is_solved() -> bool:
        return stiction.solve(np.eye(130), H, push, W, MU).solved

    assert is_solved()
    child = os.fork()
    if child == 0:
        os._exit(0 if is_solved() else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
