#!/usr/bin/env python3
"""Prints the measurements of `.ci/firmware` as a table and compares them with the baseline.

Usage: firmware_table.py MEASURED BASELINE COMPILER. A line of a file is `machine scene quantity
value`. With UPDATE_BASELINE=1 the baseline is written instead of compared, and the tables to
`src/guide/firmware.md`. Counts depend on the compiler: a baseline of another one is not compared.
"""
import contextlib
import io
import os
import sys

SCENES = {
    "box": "box (6 dofs, 4 contacts, 3 rows)",
    "quadruped": "quadruped (18, 4, 3)",
    "quadruped_planar": "the same, planar rows (18, 4, 2)",
    "quadruped_frictionless": "the same, normal rows (18, 4, 1)",
    "walker": "planar walker (9, 4, 2)",
    "stack": "stack of boxes (18, 12, 3)",
    "sharing": "sharing out forces (6, 4, 3)",
    "sharing_slip": "the same, near slipping",
}
# Of the race beside a loop by hand: those above, and some of `tests/scenes`.
RACES = {
    **{scene: text for scene, text in SCENES.items() if scene.startswith("quadruped")},
    "ice": "quadruped pushed on ice (18, 4, 3)",
    "trot": "quadruped in a trot (18, 5, 3)",
    "walker": SCENES["walker"],
    "skid": "skid-steered rover that spins (10, 4, 3)",
    "box": SCENES["box"],
    "conveyor": "box on a conveyor (6, 4, 3)",
    "slope": "box on a slope just too steep (6, 4, 3)",
    "stack": SCENES["stack"],
}
COLUMNS = ["prepare", "prepare_restart", "iteration", "newton_step", "cold_1e-3", "cold_1e-4", "cold_1e-5",
           "warm_1e-3", "warm_1e-4", "warm_1e-5", "piece", "slice"]
# Of a chip: its clock, and cycles for an instruction without and with five wait states (`examples/cycles`).
MEGAHERTZ, CYCLES = 168, (1.8, 2.5)
BYTES = ["ram_scene", "ram_factor", "ram_solver", "ram_restart",
         "stack_prepare", "stack_solve", "stack_restart", "stack_all_phases"]


PAGE = """# On a microcontroller

Written by `UPDATE_BASELINE=1 .ci/firmware` ({compiler}), which measures under QEMU: instructions, not cycles; no board
was measured. `.ci/firmware` fails where a number differs by more than 2 %; with another compiler it does not compare.

- `prepare` and `prepare_restart` are `Factor::prepare` and `AdmmFactor::prepare`; an iteration is one of ADMM, a Newton step the first
  of a cold solve, with what it takes to find its length.
- `cold` and `warm` are solves to a tolerance with all prepared; a warm one starts from the solution of a free impulse
  1 % smaller.
- A `piece` is what each call costs more where a cold solve to 1e-5 is made of the smallest pieces of work (`Solver::advance`);
  a `slice` is the longest of these calls.
- `restart` means `AdmmSolver`: `ram_restart` is its size, `stack_restart` the stack of its solve.
- Bytes of stack are what a call takes beyond what its caller holds. `stack_solve` is that of the cold solve to 1e-5, which
  need not reach the interior point. `stack_all_phases` is that of a solve that goes through sweeps, Newton's method, a
  search for a proof and the interior point.
- `rover` has 9 dofs, 3 contacts of 3 rows and 3 motors as joint rows.
- `c_quadruped` is the library of `examples/c_firmware` for (18, 5, 3), with all that a control loop in C calls.
- `sharing` is the convex relaxation with compliance, see "Sharing out forces": a push of 0.3 of the friction that there
  is, and of 0.9. A warm solve comes after the push has turned by 0.01 rad.
- A scene has N dofs, up to C contacts and D rows for each contact: the labels are (N, C, D).

## Flags to build with

A compiler unrolls loops over contacts and dofs, which takes flash and hardly gains time. Three flags, in `.cargo/config.toml`
beside `-Tlink.x`, stop it. All numbers on this page are measured with them:

```toml
[target.thumbv7em-none-eabihf]
rustflags = [
    "-C", "link-arg=-Tlink.x",
    "-C", "llvm-args=-unroll-allow-partial=false",
    "-C", "llvm-args=-unroll-runtime=false",
    "-C", "llvm-args=-unroll-threshold=150",
]
```

The threshold is what an unrolled loop may be large. With 60 a kernel is smaller and somewhat slower; with
`"-C", "llvm-args=-inline-threshold=75"` fewer functions are repeated where they are called. Bytes of flash of all that a program
calls to prepare and solve, and instructions of a cold solve to 1e-4:

{flags}

`opt-level = "s"` is no alternative to a low threshold: it saves hardly more, and takes two to four times as many instructions.

## What can be left out

A solver has the phases of its type, and what a program leaves out is not linked. A solution that is called solved is one, whatever solved it.

{phases}

- `SweepsAndNewton` leaves out the central path and the search for a proof that a scene is infeasible (its budget ends), `SweepsOnly` also
  Newton's method; both have warm starts, joint rows (R = 0 costs nothing), the convex relaxation, and the bound on rounding in twice the digits.
- The share is of {scenes} drawn scenes of three rows a contact, cold, in f32, with the default budget, as a stranger judges; work is the
  work within which half, and nine of ten, are solved. `cargo run --release -p phases` counts them.
- Of the smallest, 26 KB, the judge of what "solved" promises takes 8, the factor and its substitutions 5, the sweep and what it leaves 4, the
  relaxation 2, warm starts 2; the rest is the monitor, the data's way to the contacts, and checks. The bound in twice the digits is
  1.5 of the judge's: without it drawn scenes solved to 1e-4 fall from 99.90 to 98.19 %. Warm starts
  stay: they save three quarters of the work of a box that slides, and a sixth of a trot's.

## Microseconds

QEMU counts instructions. Cycles of a Cortex-M4F are modelled from each instruction that it executed and the timing tables of the core's
manual, with bounds where those leave something open (`.ci/chip_race`, `examples/cycles`, tested on loops whose timing the manual gives). The
last column has an STM32F4's flash in mind: five wait states, and a cache of 64 lines of 16 bytes. Left out: interrupts and DMA, more than one
cycle for data in RAM, and what [the report](../../examples/chip_race/report/CYCLES.md) names below its tables.

{cycles}

What it really takes the same program prints on a board, in cycles by `DWT::CYCCNT`: `cd examples/embedded/boards`, then

- `cargo run --release` on an STM32F4 (an STM32F429 and its kin; others by their sizes in `stm32f4.x` and their name in `.cargo/config.toml`);
- `cargo run --release --target thumbv8m.main-none-eabihf` on an RP2350 (`rp2350.x`, Raspberry Pi Pico 2).

That needs the target (`rustup target add`), `probe-rs` and a debug probe; the core runs at the clock that it has after a reset. Nobody had a
board so far: there are no figures. `.ci/chip_race` links both.

## Beside a real-time framework

`.ci/rtos` runs a trot in [RTIC](../../examples/rtic_firmware/main.rs) and in [Embassy](../../examples/embassy_firmware/main.rs): control at 1 kHz,
below it the solver, one slice of work a tick. What is not solved when the next state is due is cut off: used if `is_usable`,
otherwise the last good impulses are held. Control feeds the watchdog while the solver gives signs of life.

## The same bits elsewhere

`.ci/firmware` compares the impulses of a recorded trot on the emulated boards with the host's, `.ci/same_bits` those of aarch64 and of
WebAssembly. The programs for Arm take square roots by an instruction (feature `hardware-sqrt`), the host by its own, or by `libm`.
"""


# Below the first table of the race.
HAND = """
Instructions to prepare and solve cold, both together. The loop is what a good engineer writes in its place
([220 lines](../../examples/embedded/gauss_seidel.rs), 6 KB of flash): Cholesky's factor of `M` and `W = H M⁻¹ Hᵀ` once, Gauss-Seidel over the
blocks of `W`, the error after every second sweep; a dash is more than 400 sweeps. It finds no `v`, bounds no rounding, and does not see that a
scene has no solution.

- The crate wins on robots of many joints, by a fifth to a half: its `prepare` leaves out the zeros of `M` and `H`. The loop's solve alone
  is the shorter one there.
- It wins by factors where contacts depend on one another: at the limit of friction to 1e-4 and finer, in stacks.
- The loop wins on few bodies that slide with friction to spare: boxes, conveyors, a rover that spins, by 1.3 to 2.8 times. Whoever
  has only such scenes, and asks for no promise, writes the loop."""


def read(path):
    """The compiler of the first line, if it is a comment, and the values by their names."""
    compiler, values = "", {}
    with open(path) as lines:
        for line in lines:
            if line.startswith("#"):
                compiler = line[1:].strip()
            else:
                *name, value = line.split()
                values[tuple(name)] = int(value)
    return compiler, values


def table(title, head, rows):
    print(f"\n## {title}\n\n| {' | '.join(head)} |\n|{'---|' + '---:|' * (len(head) - 1)}")
    for row in rows:
        print(f"| {' | '.join(row)} |")


def flags(values):
    """What the flags are worth."""
    head = ["`-unroll-threshold`", "quadruped", "rover: 9 dofs, 3 contacts, 3 motors as joint rows", "`AdmmSolver`",
            "instructions, quadruped", "box"]
    lines = [f"| {' | '.join(head)} |", f"|{'---|' + '---:|' * (len(head) - 1)}"]
    names = ["flash_quadruped", "flash_rover", "flash_restart", "cold_quadruped", "cold_box"]
    default = [("quadruped", "flash_firmware"), ("rover", "flash_firmware"), ("quadruped_restart", "flash_firmware"),
               ("quadruped", "cold_1e-4"), ("box", "cold_1e-4")]
    for label, text in [("none", "no flags"), (None, "150"), ("60", "60"), ("small", "60, `-inline-threshold=75`")]:
        cells = default if label is None else [(f"flags_{label}", name) for name in names]
        lines.append(f"| {' | '.join([text, *(cell(values, 'm4f32', *name) for name in cells)])} |")
    return "\n".join(lines)


def cycles():
    """What `.ci/chip_race` has modelled, of the solves by Coulomb's law to 1e-4."""
    with open("examples/chip_race/report/CYCLES.md") as lines:
        scenes = lines.read().split("\n## ")[1:]
    rows = {}
    for scene in scenes:
        name, *lines = scene.splitlines()
        cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("|")]
        rows[name] = {row[0]: row[1:] for row in cells}
    head = ["f32 on a Cortex-M4F", *rows["box"]["call"]]
    lines = [f"| {' | '.join(head)} |", f"|{'---|' + '---:|' * (len(head) - 1)}"]
    for name, text in [("quadruped", "quadruped"), ("box", "sliding box")]:
        for call, what in [("prepare 0", "prepare"), ("cold 1e-4", "cold to 1e-4"), ("warm 1e-4", "warm to 1e-4")]:
            lines.append(f"| {text}: {what} | {' | '.join(rows[name][call])} |")
    return "\n".join(lines)


def phases(values):
    """What can be left out, and what it costs."""
    head = ["", "flash, threshold 150", "the smallest flags", "RAM of the solver: quadruped", "stack to 1e-4: box", "quadruped",
            "cold to 1e-4: box", "quadruped", "solved to 1e-3", "to 1e-4", "work to 1e-4: 50 %", "90 %"]
    lines = [f"| {' | '.join(head)} |", f"|{'---|' + '---:|' * (len(head) - 1)}"]
    share = lambda *name: f"{values['m4f32', 'phases', '_'.join(name)] / 100:.2f} %"
    for name, text in [("all", "`AllPhases` (default)"), ("newton", "`SweepsAndNewton`"), ("sweeps", "`SweepsOnly`"),
                       ("restart", "`AdmmSolver`")]:
        flash = "quadruped" if name == "all" else f"quadruped_{name}"
        other = {"all": "flash_quadruped"}.get(name, f"flash_{name}")
        cells = [(flash, "flash_firmware"), ("flags_small", other)]
        if name == "restart":
            cells += [("quadruped", "ram_restart"), ("box", "stack_restart"), ("quadruped", "stack_restart"), ("", ""), ("", "")]
        else:
            cells += [("quadruped", f"{name}_ram"), ("box", f"{name}_stack"), ("quadruped", f"{name}_stack"),
                      ("box", f"{name}_cold_1e-4"), ("quadruped", f"{name}_cold_1e-4")]
        lines.append("| " + " | ".join([text, *(cell(values, "m4f32", *name) for name in cells),
                                        share(name, "solved_1e-3"), share(name, "solved_1e-4"),
                                        *(cell(values, "m4f32", "phases", f"{name}_work_{percent}_1e-4") for percent in (50, 90))]) + " |")
    return "\n".join(lines)


def quoted(names):
    return [f"`{name}`" for name in names]


def cell(values, *name):
    return f"{values[name]:,}" if name in values else "–"


def by_hand(values, machine, title):
    """Gauss-Seidel in contact space, what a user would write instead, and how much of it this crate takes."""
    rows = []
    for scene, text in RACES.items():
        value = lambda name: values.get((machine, scene, f"race_{name}"))
        if value("gs_prepare") is None:
            continue
        row = [text, *(cell(values, machine, scene, f"race_{name}") for name in ("prepare", "gs_prepare", "gs_sweep"))]
        for tolerance in ("1e-3", "1e-4", "1e-5"):
            loop, ours = value(f"gs_{tolerance}"), value("prepare") + value(tolerance)
            if loop is None:
                row += [f"{ours:,} / –", "–"]
                continue
            loop += value("gs_prepare")
            row += [f"{ours:,} / {loop:,} ({value(f'gs_sweeps_{tolerance}')})", f"{ours / loop:.2f}"]
        rows.append(row)
    to = [head for tolerance in ("1e-3", "1e-4", "1e-5") for head in (f"to {tolerance}: crate / loop (sweeps)", "ratio")]
    table(f"{title}, beside a loop by hand", ["instructions", "`prepare`", "loop's", "its sweep", *to], rows)
    if machine == "m4f32":
        print(HAND)


def report(values):
    for machine, title in [("m4f32", "f32 on a Cortex-M4F"), ("m7f64", "f64 on a Cortex-M7")]:
        rows = [[text, *(cell(values, machine, scene, column) for column in COLUMNS)]
                for scene, text in SCENES.items()]
        table(title, ["instructions", *quoted(COLUMNS)], rows)
        by_hand(values, machine, title)
        rows = [[text, *(cell(values, machine, scene, column) for column in BYTES)]
                for scene, text in SCENES.items()]
        table(f"{title}, bytes", ["bytes", *quoted(BYTES)], rows)
        limits(values, machine, title)
        robot(values, machine, title)
    flash = [name for name in ("quadruped", "quadruped_restart", "quadruped_planar",
                               "quadruped_frictionless", "rover", "c_quadruped")]
    rows = [[f"`{name}`", cell(values, "m4f32", name, "flash_firmware"),
             cell(values, "m4f32", name, "flash_size")] for name in flash]
    targets(values)
    table("bytes of flash for prepare and solve, f32 on a Cortex-M4F",
          ["", "opt-level 3", 'opt-level "s"'], rows)
    print('\nAt opt-level "s" `prepare` and a solve take two to four times as many instructions.')


def limits(values, machine, title):
    """A tick of the quadruped with joint limits: the scene filled, prepared and solved to 1e-4."""
    ticks = [("contacts", "contacts alone"), ("none", "the same with room for 12 joint rows"),
             ("far", "12 limits, none reached"), ("two_cold", "12 limits, 2 reached, cold"), ("two_warm", "the same, warm")]
    alone = values.get((machine, "limits", "contacts"))
    if alone is None:
        return
    rows = [[text, f"{values[machine, 'limits', name]:,}", f"{values[machine, 'limits', name] / alone:.2f}"]
            for name, text in ticks]
    table(f"A tick of the quadruped with joint limits, {title}: filled, prepared, solved to 1e-4",
          ["", "instructions", "of contacts alone"], rows)


def robot(values, machine, title):
    """A tick of `examples/robot_firmware`."""
    if (machine, "robot", "tick_mean") not in values:
        return
    stages = [("dynamics", "kinematics, `M`, `H` and bias"), ("fill", "scene and free impulse"), ("solve", "prepare, solve to 1e-3"),
              ("torques", "torques"), ("tick", "a tick with a solve")]
    rows = [[text, *(cell(values, machine, "robot", f"{name}_{which}") for which in ("mean", "most"))] for name, text in stages]
    table(f"A tick of a whole robot, {title}", ["instructions", "mean", "most"], rows)
    times = [values[machine, "robot", f"tick_{which}"] * cycles / MEGAHERTZ for cycles in CYCLES for which in ("mean", "most")]
    is_kept = "is kept" if times[1] <= 1000 else "is **not** kept"
    print("\nA quadruped of 12 motors drops, is pushed and loses sensors (`examples/robot_firmware`). At {} MHz and {} cycles an instruction such a"
          "\ntick takes {:,.0f} µs in the mean and {:,.0f} at most: 1 kHz {}. At {} cycles, which five wait states may take, it takes {:,.0f} and {:,.0f}."
          .format(MEGAHERTZ, CYCLES[0], *times[:2], is_kept, CYCLES[1], *times[2:]))


def targets(values):
    """What was aimed at for the quadruped."""
    value = lambda name: values[("m4f32", "quadruped", name)]
    ram = value("ram_scene") + value("ram_factor") + value("ram_solver")
    aims = [
        ("instructions to prepare and solve cold to 1e-4", value("prepare") + value("cold_1e-4"), 60_000),
        ("bytes of RAM: scene, factor, solver", ram, 8192),
        ("bytes of stack, a cold solve to 1e-5", value("stack_solve"), 1024),
        ("instructions an iteration", value("iteration"), 800),
        ("instructions of a warm solve to 1e-4", value("warm_1e-4"), 10_000),
        ("bytes of flash at opt-level 3", value("flash_firmware"), 12 * 1024),
        ('bytes of flash at opt-level "s"', value("flash_size"), 7 * 1024),
    ]
    rows = [[text, f"{aim:,}", f"{number:,}", "holds" if number <= aim else "**missed**"] for text, number, aim in aims]
    table("What was aimed at for the quadruped, f32 on a Cortex-M4F", ["", "aim", "measured", ""], rows)


def compare(compiler, values, path):
    of, baseline = read(path)
    if of != compiler:
        print(f"\nnot compared: the baseline is of {of}, this is {compiler}")
        return 0
    missing = [name for name in baseline if name not in values and not name[1].startswith(("flags_", "phases"))]
    changed = [name for name, old in baseline.items()
               if abs(values.get(name, old) - old) > 0.02 * old]
    for name in missing:
        print(f"{' '.join(name)}: {baseline[name]}, now missing")
    for name in changed:
        print(f"{' '.join(name)}: {baseline[name]} is {values[name]} now")
    if changed:
        print("UPDATE_BASELINE=1 writes down what is meant to change, a gain as well")
    if not missing and not changed:
        print(f"\n{len(baseline)} numbers within 2 % of the baseline")
    return 1 if missing or changed else 0


def main():
    measured, path, compiler = sys.argv[1:]
    values = read(measured)[1]
    tables = io.StringIO()
    with contextlib.redirect_stdout(tables):
        report(values)
    print(tables.getvalue(), end="")
    if os.environ.get("UPDATE_BASELINE"):
        with open("src/guide/firmware.md", "w") as out:
            out.write(PAGE.format(compiler=compiler, flags=flags(values), phases=phases(values), cycles=cycles(),
                                  scenes=f"{values['m4f32', 'phases', 'scenes']:,}") + tables.getvalue())
        with open(path, "w") as out:
            out.write(f"# {compiler}\n")
            out.writelines(f"{' '.join(name)} {value}\n" for name, value in values.items())
        return 0
    return compare(compiler, values, path)


sys.exit(main())
