"""``python -m stiction``: the bundled scenes, solved and measured."""

from __future__ import annotations

import argparse
import json
import time
from importlib.resources import files
from typing import Any

import numpy as np

from . import Mode, Solution, Status, solve

_MARKS = {Mode.STICK: "=", Mode.SLIP: "~", Mode.OPEN: "o"}


def read(text: str) -> dict[str, Any]:
    """Read a scene file: arguments of :func:`stiction.solve`."""
    scene = json.loads(text)
    shape = (scene["n_contacts"], scene["dim"])
    return {
        "M": np.array(scene["M"], float),
        "H": np.array(scene["H"], float).reshape(*shape, scene["n_dof"]),
        "free_impulse": -np.array(scene["f"], float),
        "w": np.array(scene["w"], float).reshape(shape),
        "mu": np.array(scene["mu"], float),
    }


def measured(scene: dict[str, Any], tol: float, repeat: int) -> tuple[Solution, float]:
    """Solve a scene so many times; the solution, and the least time of a call (s)."""
    best = np.inf
    for _ in range(repeat):
        start = time.perf_counter()
        found = solve(**scene, tol=tol)
        best = min(best, time.perf_counter() - start)
    return found, best


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m stiction", description="Solve the bundled scenes.")
    parser.add_argument("--tolerance", type=float, default=1e-9)
    parser.add_argument("--repeat", type=int, default=100, help="calls of which the fastest counts")
    given = parser.parse_args()
    print(f"{'scene':26} dofs contacts  work    error     time  stick =, slip ~, open o")
    for path in sorted(files("stiction").joinpath("scenes").iterdir(), key=lambda path: path.name):
        scene = read(path.read_text())
        found, seconds = measured(scene, given.tolerance, max(given.repeat, 1))
        contacts = "".join(_MARKS[Mode(mode)] for mode in found.modes)
        ending = contacts if found.solved else found.status.name.lower().replace("_", " ")
        error = "proof" if found.status is Status.INFEASIBLE else f"{found.error:.1e}"
        print(
            f"{path.name.removesuffix('.json'):26} {len(scene['M']):4} {len(scene['mu']):8} {found.work.total:5}"
            f" {error:>8} {1e6 * seconds:5.1f} µs  {ending}"
        )


if __name__ == "__main__":
    main()
