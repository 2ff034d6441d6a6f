#!/usr/bin/env python3
"""Our program `solve` against Pinocchio and Siconos on bundled and on random scenes, turn by turn.

See README.md beside this file for what to install.
"""
import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import contestants
import report
from scene import Scene

ROOT = Path(__file__).parent.parent.parent
# Two a decade. Below 1e-12, and above 1e-1 for peers, because some of their tolerances are absolute.
TOLERANCES = [10 ** (-k / 2) for k in range(2, 31)]
LOOSER = [10 ** (-k / 2) for k in range(-4, 2)]
# The random field of `examples/speed_vs_error`, whose every sixth scene is generic.
SEED, DRAWN = 2, 144


def race(scene, entries, visits):
    """`{name: [(error, seconds, iterations)]}` down the tolerances, what preparing takes, and what
    our solve takes that is given its own solution.

    A ladder ends after the first rung that its solver does not finish.
    """
    rungs, prepare = {entry.name: [] for entry in entries}, {}
    ladders = {e.name: TOLERANCES if e.ours else LOOSER + TOLERANCES for e in entries}

    def visit(entry, tolerance):
        answer = entry.visit(tolerance)
        if "prepare" in answer:
            prepare[entry.name] = min(prepare.get(entry.name, float("inf")), answer["prepare"])
        return answer

    for entry in entries:
        entry.open(scene)
        for tolerance in ladders[entry.name]:
            answer = visit(entry, tolerance)
            error = scene.error(answer["v"], answer["r"])
            if entry.ours and abs(error - answer["error"]) > 1e-2 * error + 1e-13:
                raise RuntimeError(f"{scene.name}: error {error}, but `solve` says {answer['error']}")
            rungs[entry.name].append([error, answer["seconds"], answer["iterations"]])
            if not answer["converged"]:
                break
    for _ in range(1, visits):
        for entry in entries:
            entry.open(scene)
            for rung, tolerance in zip(rungs[entry.name], ladders[entry.name]):
                if rung[1] <= 0.02:  # slower ones do not matter by a few percent
                    rung[1] = min(rung[1], visit(entry, tolerance)["seconds"])
    return {
        "rungs": rungs,
        "prepare": prepare,
        "delassus": scene.seconds_for_delassus(),
        "given": {level: entries[0].given(level, visits) for level in report.LEVELS},
    }


def draw(program, folder):
    command = [program, "--scenes", folder, "--seed", str(SEED), "--drawn", str(DRAWN)]
    subprocess.run(command, check=True)


def read(folder):
    """The spatial scenes that have a solution."""
    scenes = [Scene(path) for path in sorted(folder.glob("*.json"))]
    return [s for s in scenes if s.dim == 3 and not s.name.startswith(("infeasible", "Generic"))]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pinocchio-python", default=sys.executable)
    parser.add_argument("--siconos-python", default=sys.executable)
    parser.add_argument("--visits", type=int, default=5, help="turns of each solver")
    parser.add_argument("--output", type=Path, default=Path(__file__).parent / "report")
    parser.add_argument("scenes", nargs="*", help="names [default: all]")
    options = parser.parse_args()

    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    solve = built / "solve"
    ours = [contestants.Ours(solve, precision) for precision in ("f64", "f32")]
    peers = contestants.peers(options.pinocchio_python, options.siconos_python)
    fields = []
    with tempfile.TemporaryDirectory() as folder:
        draw(built / "speed_vs_error", folder)
        for name, files in (("bundled", ROOT / "tests" / "scenes"), ("random", Path(folder))):
            scenes = read(files)
            if options.scenes:
                scenes = [scene for scene in scenes if scene.name in options.scenes]
            races = {}
            for done, scene in enumerate(scenes, 1):
                print(f"{name} {done}/{len(scenes)}: {scene.name}", file=sys.stderr, flush=True)
                races[scene.name] = race(scene, ours + peers, options.visits)
            fields.append((name, races))
    report.write(options.output, fields, [e.name for e in ours], [e.name for e in peers])


if __name__ == "__main__":
    main()
