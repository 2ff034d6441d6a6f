"""``python -m stiction``: scene files, or the bundled ones, solved and measured."""

from __future__ import annotations

import argparse
import sys
import time
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from . import Mode, Solution, Status, load, solve

_MARKS = {Mode.STICK: "=", Mode.SLIP: "~", Mode.OPEN: "o"}


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
    parser = argparse.ArgumentParser(prog="python -m stiction", description="Solve scene files and print a table.")
    parser.add_argument("files", nargs="*", type=Path, help="scene files; without one the bundled ones")
    parser.add_argument("--tolerance", type=float, default=1e-9)
    parser.add_argument("--repeat", type=int, default=100, help="calls of which the fastest counts")
    given = parser.parse_args()
    print(f"{'scene':26} dofs contacts  work    error     time  stick =, slip ~, open o")
    bundled = Path(str(files("stiction"))) / "scenes"
    for path in given.files or sorted(bundled.iterdir()):
        try:
            scene = load(path)
        except (OSError, ValueError) as complaint:
            sys.exit(f"{path}: {complaint}")
        found, seconds = measured(scene, given.tolerance, max(given.repeat, 1))
        contacts = "".join(_MARKS[Mode(mode)] for mode in found.modes)
        ending = contacts if found.solved else found.status.name
        error = "proof" if found.status is Status.INFEASIBLE else f"{found.error:.1e}"
        print(
            f"{path.stem:26} {len(scene['M']):4} {len(scene['mu']):8} {found.work.total:5}"
            f" {error:>8} {1e6 * seconds:5.1f} µs  {ending}"
        )


if __name__ == "__main__":
    main()
