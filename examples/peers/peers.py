#!/usr/bin/env python3
"""Our `solve` example against Pinocchio and Siconos on the bundled scenes, turn by turn.

See README.md beside this file for what to install.
"""
import argparse
import os
import sys
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import contestants
import report
from scene import Scene

ROOT = Path(__file__).parent.parent.parent
# Two a decade; below 1e-12 for those whose tolerances are absolute, on scenes of small impulses.
TOLERANCES = [10 ** (-k / 2) for k in range(2, 31)]


def race(scene, entries, visits):
    """`{name: [(error, seconds, iterations)]}` down the tolerances, what preparing takes, and what
    our solve takes that is given its own solution.

    A ladder ends after the first rung that its solver does not finish.
    """
    rungs, prepare = {entry.name: [] for entry in entries}, {}
    for entry in entries:
        entry.open(scene)
        for tolerance in TOLERANCES:
            answer = entry.visit(tolerance)
            error = scene.error(answer["v"], answer["r"])
            rungs[entry.name].append([error, answer["seconds"], answer["iterations"]])
            if not answer["converged"]:
                break
    for _ in range(1, visits):
        for entry in entries:
            entry.open(scene)
            for rung, tolerance in zip(rungs[entry.name], TOLERANCES):
                if rung[1] > 0.02:  # too slow to matter by a few percent
                    continue
                answer = entry.visit(tolerance)
                rung[1] = min(rung[1], answer["seconds"])
                if "prepare" in answer:
                    best = min(prepare.get(entry.name, float("inf")), answer["prepare"])
                    prepare[entry.name] = best
    return {
        "rungs": rungs,
        "prepare": prepare,
        "delassus": scene.seconds_for_delassus(),
        "given": {level: entries[0].given(level, visits) for level in report.LEVELS},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--solve", default=None, help="the built `solve` example")
    parser.add_argument("--pinocchio-python", default=sys.executable)
    parser.add_argument("--siconos-python", default=sys.executable)
    parser.add_argument("--visits", type=int, default=5, help="turns of each solver")
    parser.add_argument("--output", type=Path, default=Path(__file__).parent / "report")
    parser.add_argument("scenes", nargs="*", help="names [default: the feasible spatial ones]")
    options = parser.parse_args()

    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    solve = options.solve or target / "release" / "examples" / "solve"
    ours = [contestants.Ours(solve, precision) for precision in ("f64", "f32")]
    peers = contestants.peers(options.pinocchio_python, options.siconos_python)
    scenes = [Scene(path) for path in sorted((ROOT / "tests" / "scenes").glob("*.json"))]
    scenes = [s for s in scenes if s.dim == 3 and not s.name.startswith("infeasible")]
    if options.scenes:
        scenes = [scene for scene in scenes if scene.name in options.scenes]
    races = {}
    for done, scene in enumerate(scenes, 1):
        print(f"scene {done:>2}/{len(scenes)}: {scene.name}", file=sys.stderr, flush=True)
        races[scene.name] = race(scene, ours + peers, options.visits)
    report.write(options.output, races, [e.name for e in ours], [e.name for e in peers])


if __name__ == "__main__":
    main()
