from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiction
from stiction import BatchSolution, Rows, Status

from judge import read


@pytest.fixture(scope="module")
def scenes(trot: list[dict[str, Any]]) -> tuple[Any, ...]:
    """All steps of the trot with as many contacts as most have."""
    steps = [read(step) for step in trot]
    counts = [len(step[4]) for step in steps]
    most = max(set(counts), key=counts.count)
    chosen = [step for step in steps if len(step[4]) == most] * 20
    return tuple(np.stack(part) for part in zip(*chosen, strict=True))


def bits(found: BatchSolution) -> list[bytes]:
    return [getattr(found, field.name).tobytes() for field in fields(found)]


def test_each_scene_is_that_alone_on_any_number_of_threads(scenes: tuple[Any, ...]) -> None:
    batch = stiction.solve_batch(*scenes, tol=1e-9, threads=1)
    assert len(batch.v) > 200 and (batch.status == Status.SOLVED).all()
    for threads in (2, 3, 7, None):
        assert bits(stiction.solve_batch(*scenes, tol=1e-9, threads=threads)) == bits(batch)
    for i in range(0, len(batch.v), 37):
        alone = stiction.solve(*(part[i] for part in scenes), tol=1e-9)
        assert np.array_equal(batch.v[i], alone.v) and np.array_equal(batch.r[i], alone.r)
        assert batch.work[i].tolist() == list(alone.work) and batch.error[i] == alone.error


def test_singletons_are_broadcast_and_outputs_handed_in(scenes: tuple[Any, ...]) -> None:
    M, H, push, w, _ = scenes
    pushes = push[:1] * np.linspace(0.5, 1.5, 50)[:, None]
    out = BatchSolution.empty(50, 18, H.shape[1])
    found = stiction.solve_batch(M[:1], H[:1], pushes, w[:1], 0.6, out=out)
    assert found is out and out.status.all()
    whole = [np.broadcast_to(part[:1], (50, *part.shape[1:])) for part in (M, H, w)]
    assert bits(stiction.solve_batch(whole[0], whole[1], pushes, whole[2], np.full((50, H.shape[1]), 0.6))) == bits(out)


def test_arrays_without_a_leading_axis_are_those_of_all_scenes(scenes: tuple[Any, ...]) -> None:
    M, H, push, w, mu = (part[0] for part in scenes)
    pushes = push * np.linspace(0.5, 1.5, 50)[:, None]
    rows = Rows(np.eye(18)[6:], lower=-np.linspace(0.1, 0.2, 12), upper=0.2, keys=np.arange(12))
    whole = Rows(np.eye(18)[None, 6:], lower=-np.linspace(0.1, 0.2, 12)[None], upper=0.2, keys=np.arange(12)[None])
    soft = np.linspace(0.001, 0.002, len(mu))
    found = stiction.solve_batch(M, H, pushes, w, mu, rows=rows, compliance=soft)
    led = (M[None], H[None], pushes, w[None], mu[None])
    both = np.stack([soft, soft], axis=1)[None]
    assert bits(found) == bits(stiction.solve_batch(*led, rows=whole, compliance=both)) and len(found.v) == 50
    assert bits(found) == bits(stiction.solve_batch(M.tolist(), H, pushes, w, mu, rows=rows, compliance=both))
    assert not np.array_equal(found.v, stiction.solve_batch(M, H, pushes, w, mu, rows=rows).v)
    one = stiction.solve_batch(M, H, pushes, w, 0.6, compliance=0.001)
    assert bits(one) == bits(stiction.solve_batch(*led[:4], np.full((1, len(mu)), 0.6), compliance=np.full((1, len(mu)), 0.001)))
    assert found.vjp(v=np.ones((50, 18))).M.shape == (50, 18, 18)
    alone = stiction.solve(M, H, pushes[7], w, mu, rows=rows, compliance=soft)
    assert np.array_equal(found.v[7], alone.v)
    single = stiction.solve_batch(M, H, push, w, mu)
    assert len(single.v) == 1


def test_float32_and_rows() -> None:
    rows = Rows(np.eye(2)[None], upper=np.inf, offset=np.zeros((4, 2)))
    pushes = np.array([[1.0, -1.0]]) * np.arange(4)[:, None]
    none = np.zeros((1, 0, 3, 2)), pushes, np.zeros((1, 0, 3)), np.zeros((1, 0))
    found = stiction.solve_batch(np.eye(2)[None], *none, rows=rows, dtype=np.float32, tol=1e-4)
    assert found.row_impulses.dtype == np.float32
    assert np.allclose(found.row_impulses[:, 1], np.arange(4), atol=1e-3) and not found.row_impulses[:, 0].any()


def test_errors_name_argument_and_scene(scenes: tuple[Any, ...]) -> None:
    M, H, push, w, mu = (part.copy() for part in scenes)
    with pytest.raises(ValueError, match="^w: a leading axis of length 3 beside"):
        stiction.solve_batch(M, H, push, w[:3], mu)
    with pytest.raises(ValueError, match="^threads"):
        stiction.solve_batch(M, H, push, w, mu, threads=0)
    with pytest.raises(ValueError, match="^out.v"):
        stiction.solve_batch(M, H, push, w, mu, out=BatchSolution.empty(2, 18, mu.shape[1]))
    mu[[77, 200]] = -1.0
    for threads in (1, 2):
        with pytest.raises(ValueError, match=r"^mu: .*\(scene 77 of the batch\)"):
            stiction.solve_batch(M, H, push, w, mu, threads=threads)
    assert stiction.solve_batch(M[:0], H[:0], push[:0], w[:0], mu[:0]).v.shape == (0, 18)


def test_the_lock_is_released(scenes: tuple[Any, ...]) -> None:
    long = tuple(np.concatenate([part] * 100) for part in scenes)
    done, counted = threading.Event(), 0

    def solve() -> None:
        stiction.solve_batch(*long, tol=1e-9, threads=1)
        done.set()

    thread = threading.Thread(target=solve)
    thread.start()
    while not done.is_set():
        counted += 1
        time.sleep(0.001)
    thread.join()
    assert counted > 10  # this thread ran meanwhile


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_is_heard(tmp_path: Path) -> None:
    program = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored in the background
import numpy as np, stiction
rng = np.random.default_rng(0)
H, push = rng.normal(size=(1, 12, 3, 30)), rng.normal(size=(1_000_000, 30))
print("ready", flush=True)
try:
    stiction.solve_batch(np.eye(30)[None], H, push, np.zeros((1, 12, 3)), 0.7, tol=1e-12, threads=1)
    print("solved")
except KeyboardInterrupt:
    print("interrupted")
"""
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, cwd=tmp_path)
    assert child.stdout is not None and child.stdout.readline() == "ready\n"
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    assert child.communicate(timeout=60)[0] == "interrupted\n"
