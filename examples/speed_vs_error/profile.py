#!/usr/bin/env python3
"""Counts instructions a solve by function and by kind, with valgrind's callgrind and objdump, and writes
`report/callgrind.md`, and those of the default method on all scenes to `report/instructions.txt`.

Run by hand after `cargo build --release -p speed_vs_error`; the report of the next race includes both.
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
RACE = TARGET / "release" / "speed_vs_error"
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
# What an instruction of x86-64 is, by its name and its operands as objdump writes them; the first that fits.
KINDS = (
    ("floating-point arithmetic", re.compile(r"(add|sub|mul|div|sqrt)[sp]d ")),
    ("comparisons, signs, choices", re.compile(r"(u?comisd|(min|max|cmp\w*)[sp]d|(andn?|x?or)p[sd]) ")),
    ("loads and stores of numbers", re.compile(r"mov([au]p[sd]|[lh]p[sd]|sd|q|dq[au]) (?=.*%xmm).*\(")),
    ("moves between registers", re.compile(r"(mov([au]p[sd]|hlps|lhps|ddup|sd|q|dq[au])|unpck\w+|p?shuf\w+) .*%xmm")),
    ("jumps and calls", re.compile(r"(j\w+|callq?|retq?) ")),
)
COPIES, REST = "copies by the C library", "rest"
COSTS = re.compile(r"^(0x[0-9a-f]+) \d+ (\d+)$")


@functools.cache
def names():
    """Name and operands of every instruction of the race, by its address."""
    command = ["objdump", "--disassemble", "--no-show-raw-insn", RACE]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    lines = re.finditer(r"^ *([0-9a-f]+):\t(\S+) *(.*)$", text, re.MULTILINE)
    return {int(line[1], 16): f"{line[2]} {line[3]}" for line in lines}


def kinds(lines):
    """Executions by kind, and those of each name, from what callgrind wrote."""
    found, executed, ours, inclusive = collections.Counter(), collections.Counter(), True, False
    for line in lines:
        if line.startswith("ob="):
            ours = line.rstrip().endswith(RACE.name)
        if line.startswith("calls="):
            inclusive = True  # the next line is of what is called
        elif match := COSTS.match(line):
            if not inclusive:
                name, number = names()[int(match[1], 16)] if ours else "", int(match[2])
                kind = next((kind for kind, form in KINDS if form.match(name)), REST)
                found[kind if ours else COPIES] += number
                executed[name.split(" ")[0]] += number
            inclusive = False
    return found, executed


@functools.cache
def count(scene, solver):
    """Instructions a solve, the same by function and by kind, and iterations and Newton steps."""
    with tempfile.NamedTemporaryFile() as out:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out.name}"]
        command += ["--dump-instr=yes", "--compress-pos=no", "--compress-strings=no"]
        command += ["--toggle-collect=*Contestant*solve*", RACE]
        command += ["--profile", f"{scene}:{solver}:{TOLERANCE}:{CALLS}"]
        run = subprocess.run(command, capture_output=True, text=True, check=True)
        annotate = ["callgrind_annotate", "--threshold=100", "--auto=no", out.name]
        lines = subprocess.run(annotate, capture_output=True, text=True, check=True).stdout
        with open(out.name) as written:
            by_kind = kinds(written)
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
    if sum(by_kind[0].values()) != total:
        raise RuntimeError(f"{scene}: the kinds do not add up to {total}")
    return total / CALLS, functions, by_kind, run.stdout.split()


def columns(scene, total, found, executed):
    """A row of the table of kinds."""
    lanes = {"sd": 1, "pd": 2}

    def operations(*heads):
        return sum(executed[f"{head}{end}"] * n for head in heads for end, n in lanes.items()) / CALLS

    row = [scene, f"{total:,.0f}", f"{operations('mul'):,.0f}", f"{operations('add', 'sub'):,.0f}"]
    row.append(f"{operations('div', 'sqrt'):,.0f}")
    for kind in (*(kind for kind, _ in KINDS), REST, COPIES):
        row.append(f"{found[kind] / CALLS / total:.0%}")
    return row


def table(head, rows):
    """A table of Markdown, the first column to the left."""
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def main():
    rows, shares, of_kind = [], [], []
    for scene in SCENES:
        row = [scene]
        for solver in SOLVERS:
            print(f"{scene}, {solver}", file=sys.stderr)
            total, functions, by_kind, (iterations, steps) = count(scene, solver)
            row.append(f"{total:,.0f} ({iterations} + {steps})")
            if solver == SOLVERS[0]:
                listed = functions.most_common(8)
                share = (f"`{name}` {value / CALLS / total:.0%}" for name, value in listed)
                shares.append(f"- {scene}: {', '.join(share)}")
                of_kind.append(columns(scene, total, *by_kind))
        rows.append(row)
    operations = ("instructions", "products", "sums", "quotients and roots")
    text = f"""Instructions a solve to {TOLERANCE:.0e} (iterations or sweeps + Newton steps), counted by callgrind on
x86-64, {datetime.date.today()}, `examples/speed_vs_error/profile.py`:

{table(["scene", *SOLVERS], rows)}
What the default method's in f64 are: products, sums and differences, quotients and roots of doubles executed (a vector of doubles is
two, whether both are used or not), and the share of all instructions that is of each kind. A load that is part of an arithmetic
instruction counts as arithmetic; the rest is addresses, counters, masks, integers in memory and exponents.

{table(["scene", *operations, *(kind for kind, _ in KINDS), REST, COPIES], of_kind)}
Where the default method's in f64 go, inlined code counted where it is inlined:

{chr(10).join(shares)}
"""
    (HERE / "report" / "callgrind.md").write_text(text)
    lines = []
    for path in sorted((HERE.parent.parent / "tests" / "scenes").glob("*.json")):
        print(f"{path.stem}, {SOLVERS[0]}", file=sys.stderr)
        try:
            total, *_, efforts = count(path.stem, SOLVERS[0])
        except subprocess.CalledProcessError as error:
            if "no such scene" not in error.stderr:
                raise
            continue  # infeasible scenes take no part in the race
        lines.append(f"{path.stem} {' '.join(efforts)} {total:.0f}\n")
    (HERE / "report" / "instructions.txt").write_text("".join(lines))


main()
