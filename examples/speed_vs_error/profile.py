#!/usr/bin/env python3
"""Counts instructions a solve by function, with valgrind's callgrind, and writes `report/callgrind.md`,
and those of the default method on all scenes to `report/instructions.txt`.

Run by hand after `cargo build --release --example speed_vs_error`; the report of the next run of
the example includes both.
"""
import collections
import datetime
import functools
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", HERE.parent.parent / "target"))
EXAMPLE = TARGET / "release" / "examples" / "speed_vs_error"
SCENES = ("box_slide_spin", "go2_trot_mixed", "allegro_heavy_box", "stack3_1_10_100")
SOLVERS = (
    "default method, f64",
    "default method, f32",
    "Gauss-Seidel, f64",
    "Alart-Curnier Newton, f64",
)
TOLERANCE = 1e-3
CALLS = 20
LINE = re.compile(r"^\s*([\d,]+) \([^)]*\)\s+(.*)$")


@functools.cache
def count(scene, solver):
    """Instructions a solve, the same by function, and iterations and Newton steps."""
    with tempfile.NamedTemporaryFile() as out:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out.name}"]
        command += ["--toggle-collect=*Contestant*solve*", EXAMPLE]
        command += ["--profile", f"{scene}:{solver}:{TOLERANCE}:{CALLS}"]
        run = subprocess.run(command, capture_output=True, text=True, check=True)
        annotate = ["callgrind_annotate", "--threshold=100", "--auto=no", out.name]
        lines = subprocess.run(annotate, capture_output=True, text=True, check=True).stdout
    functions, total = collections.Counter(), 0
    for line in lines.splitlines():
        if not (match := LINE.match(line)):
            continue
        instructions, what = int(match[1].replace(",", "")), match[2]
        if what.startswith("PROGRAM TOTALS"):
            total = instructions
        elif ":" in what:
            # "file:function [binary]": inlined code counts for the function around it.
            name = re.sub(r"\s*\[[^]]*\]$", "", what.split(":", 1)[1]).split("'")[0]
            name = re.sub(r"<T[^>]*>", "", name.removeprefix("stiction::"))
            functions["solve itself" if "Contestant" in name else name] += instructions
    return total / CALLS, functions, run.stdout.split()


def main():
    rows, shares = [], []
    for scene in SCENES:
        row = [scene]
        for solver in SOLVERS:
            print(f"{scene}, {solver}", file=sys.stderr)
            total, functions, (iterations, steps) = count(scene, solver)
            row.append(f"{total:,.0f} ({iterations} + {steps})")
            if solver == SOLVERS[0]:
                listed = functions.most_common(8)
                share = (f"`{name}` {value / CALLS / total:.0%}" for name, value in listed)
                shares.append(f"- {scene}: {', '.join(share)}")
        rows.append(row)
    table = [["scene", *SOLVERS], ["---"] + ["---:"] * len(SOLVERS), *rows]
    text = f"""Instructions a solve to {TOLERANCE:.0e} (iterations or sweeps + Newton steps), counted by callgrind on
x86-64, {datetime.date.today()}, `examples/speed_vs_error/profile.py`:

{"".join("| " + " | ".join(line) + " |" + chr(10) for line in table)}
Where the default method's in f64 go, inlined code counted where it is inlined:

{chr(10).join(shares)}
"""
    (HERE / "report" / "callgrind.md").write_text(text)
    lines = []
    for path in sorted((HERE.parent.parent / "tests" / "scenes").glob("*.json")):
        print(f"{path.stem}, {SOLVERS[0]}", file=sys.stderr)
        try:
            total, _, efforts = count(path.stem, SOLVERS[0])
        except subprocess.CalledProcessError as error:
            if "no such scene" not in error.stderr:
                raise
            continue  # infeasible scenes take no part in the race
        lines.append(f"{path.stem} {' '.join(efforts)} {total:.0f}\n")
    (HERE / "report" / "instructions.txt").write_text("".join(lines))


main()
