#!/usr/bin/env python3
"""Prints the measurements of `.ci/firmware` as a table and compares them with the baseline.

Usage: firmware_table.py MEASURED BASELINE COMPILER. A line of a file is `machine scene quantity
value`. With UPDATE_BASELINE=1 the baseline is written instead of compared, and the tables to
`src/guide/reports/firmware.md`. Counts depend on the compiler: a baseline of another one is not compared.
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

Three answers, in `f32` on a Cortex-M4F at 168 MHz, to a tolerance of 1e-4:

{answers}

The tables behind these answers follow. `UPDATE_BASELINE=1 .ci/firmware` writes this page ({compiler}). QEMU counts the
instructions; a model turns them into microseconds; nobody has measured a board yet. `.ci/firmware` fails if a number grows by more than 5 %.

## Flags to build with

The compiler unrolls loops over contacts and velocities. That costs flash and gains hardly any time. Three flags in `.cargo/config.toml`,
beside `-Tlink.x`, stop it. All numbers on this page are measured with them, and with the feature `hardware-sqrt` (7 to 10 % fewer instructions):

```toml
[target.thumbv7em-none-eabihf]
rustflags = [
    "-C", "link-arg=-Tlink.x",
    "-C", "llvm-args=-unroll-allow-partial=false",
    "-C", "llvm-args=-unroll-runtime=false",
    "-C", "llvm-args=-unroll-threshold=150",
]
```

The threshold limits the size of an unrolled loop. `"-C", "llvm-args=-inline-threshold=75"` makes the compiler copy fewer functions into their
callers. Bytes of flash of everything a program needs to prepare and solve, and instructions of a cold solve to 1e-4:

{flags}

Do not use `opt-level = "s"`: it saves hardly more than a low threshold, and takes two to four times as many instructions.

## What can be left out

The type of a solver names its phases: `Kernel::<f32, 18, 3, 4, 0, 0, SweepsAndNewton>::with_phases(SweepsAndNewton)`. The linker leaves out all other
phases. "Solved" means the same for every type.

{phases}

- `SweepsAndNewton` has no central path and no proof of infeasibility: an infeasible scene uses up its budget. `SweepsOnly` also has no Newton's method.
- All types keep warm starts, joint rows (`R` = 0 costs nothing) and the convex relaxation. `SweepsOnly` has no errors with twice the digits.
- The shares are of {scenes} random scenes (boxes, piles, grasps, robots, any matrices; three rows a contact): cold, `f32`, default budget. "Work" is the budget that solves half,
  and nine tenths, of them. `cargo run --release -p phases` counts them.
- The smallest program, `SweepsOnly`, has 30 KB: 8 compute the error, 5 the factor, 4 the sweeps, 2 the relaxation, 2 warm starts. The rest selects the best point,
  prepares contacts and checks data. The tight bound on rounding takes 1.5 KB; without it 1.7 of 100 scenes more are not solved to 1e-4. Warm
  starts save three quarters of the work of a box that slides, and a sixth of the work of a trot.

## Microseconds

The model takes each executed instruction and the timing tables in the manual of the core. Where the manual leaves a timing open, the model gives
bounds (`.ci/chip_race`, `examples/cycles`). The last column is for the flash of an STM32F4: five wait states, and a cache of 64 lines of 16 bytes.
The model knows no interrupts, no DMA and no wait for RAM; [its report](../../../examples/chip_race/report/CYCLES.md) names the rest.

{cycles}

To measure your own board, run the same program there. It prints cycles (`DWT::CYCCNT`) at the clock that the core has after a reset. You need
the target (`rustup target add`), `probe-rs` and a debug probe. In `examples/embedded/boards`:

- `cargo run --release` for an STM32F469 and its kin (for others, change sizes in `stm32f4.x` and the name in `.cargo/config.toml`);
- `cargo run --release --target thumbv8m.main-none-eabihf` for an RP2350 (`rp2350.x`, Raspberry Pi Pico 2).

## Beside a real-time framework

`.ci/rtos` runs a trot in [RTIC](../../../examples/rtic_firmware/main.rs) and in [Embassy](../../../examples/embassy_firmware/main.rs). A control
task runs at 1 kHz. A task of lower priority solves, one slice of work a tick. When the next state is due, the control task takes the answer if it is
usable, and holds the last good impulses otherwise. It feeds the watchdog as long as the solver shows signs of life.

## Other cores

`.ci/cores` builds the recorded trot of `examples/firmware` for each of these, runs it under QEMU ([`examples/cores`](../../../examples/cores/main.rs)), and compares its impulses
with those of the host. A Cortex-M0+ runs the code of the M0, whose emulated board has too little RAM for `f64`. Flash is what prepare and solve of the quadruped
take, in bytes, with the flags above:

{cores}

A core without floating point does not keep 1 kHz: a step of the trot takes 610,000 instructions of a Cortex-M3 in the median, where an M4F takes 33,500 from nothing. The
instruction for roots comes with `hardware-sqrt`, by the target: `eabihf` for Arm, an `f` in the name for RISC-V.

## The same bits elsewhere

`.ci/firmware` compares the impulses of a recorded trot on the emulated boards with those of the host, `.ci/same_bits` with those of aarch64 and
WebAssembly. The programs for Arm take square roots by an instruction (feature `hardware-sqrt`), the host by its own, or by `libm`.

## What the columns of the tables mean

- A label such as (18, 4, 3) gives velocities, contacts, and rows of each contact.
- `prepare` is `Factor::prepare`, `cold` and `warm` are solves to a tolerance after it. A warm solve follows one whose free impulse was 1 % larger.
- `newton_step` is the first step of a cold solve, with its line search.
- `piece` is the extra cost of each call if `Solver::advance` does a cold solve to 1e-5 in the smallest pieces; `slice` is the longest call.
- `restart` means `AdmmSolver`: `prepare_restart` is `AdmmFactor::prepare`, `iteration` one iteration, `ram_restart` the size of the solver.
- `stack` is the stack that a call takes: `stack_solve` of the cold solve to 1e-5, `stack_all_phases` of a solve through all phases.
- `rover` has 9 velocities, 3 contacts of 3 rows and 3 motors as joint rows. `c_quadruped` is the library of `examples/c_firmware` for (18, 5, 3).
- `sharing` shares out a push of 0.3 or 0.6 of the friction by the recipe of "Sharing out forces", which counts on two thirds of it: the first tick, and the twelfth, whose
  push has turned by 0.01 rad.
"""


# Below the first table of the race.
HAND = """
Instructions to prepare and solve cold, both together. The loop is what a good engineer writes instead
([220 lines](../../../examples/embedded/gauss_seidel.rs), 6 KB of flash): Cholesky's factor of `M` and `W = H M⁻¹ Hᵀ` once, Gauss-Seidel sweeps over
the blocks of `W`, the error after every second sweep. A dash stands for more than 400 sweeps. The loop computes no `v`, bounds no rounding, and
does not notice a scene without a solution.

- The crate takes fewer instructions for robots with many joints, because `prepare` skips the zeros of `M` and `H`. The solve of the loop alone
  is shorter there.
- The crate takes a small fraction where contacts depend on one another: at the limit of friction to 1e-4 and finer, and in stacks.
- The loop takes fewer for single bodies that slide with friction to spare: boxes, conveyors, a rover that spins. If you have only such scenes and
  need no promise, write the loop."""


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


def modelled():
    """Names of the columns, and what `.ci/chip_race` has modelled of each solve by Coulomb's law to 1e-4, by scene."""
    with open("examples/chip_race/report/CYCLES.md") as lines:
        scenes = lines.read().split("\n## ")[1:]
    rows = {}
    for scene in scenes:
        name, *lines = scene.splitlines()
        cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("|")]
        rows[name] = {row[0]: row[1:] for row in cells}
    return rows["box"]["call"], rows


def cycles():
    """The table of modelled cycles."""
    columns, rows = modelled()
    head = ["f32 on a Cortex-M4F", *columns]
    lines = [f"| {' | '.join(head)} |", f"|{'---|' + '---:|' * (len(head) - 1)}"]
    for name, text in [("quadruped", "quadruped"), ("box", "sliding box")]:
        for call, what in [("prepare 0", "prepare"), ("cold 1e-4", "cold to 1e-4"), ("warm 1e-4", "warm to 1e-4")]:
            lines.append(f"| {text}: {what} | {' | '.join(rows[name][call])} |")
    return "\n".join(lines)


def answers(values):
    """How long, how many bytes, and what can be left out."""
    _, rows = modelled()

    def microseconds(scene, calls):
        """Sums of least, most, and with wait states."""
        least, most = zip(*(rows[scene][call][2].split(" to ") for call in calls))
        total = lambda numbers: sum(map(int, numbers))
        return f"{total(least)} to {total(most)} µs, with five wait states {total(rows[scene][call][3] for call in calls)} µs"

    value = lambda *name: values[("m4f32", *name)]
    cold = ["prepare 0", "cold 1e-4"]
    ram = sum(value("quadruped", f"ram_{part}") for part in ("scene", "factor", "solver"))
    flash = [f"{value(name, 'flash_firmware'):,}" for name in ("quadruped", "quadruped_newton", "quadruped_sweeps")]
    smallest = value("flags_small", "flash_quadruped")
    solved = [f"{value('phases', f'{name}_solved_1e-4') / 100:.2f}" for name in ("all", "newton", "sweeps")]
    tick = [value("robot", f"tick_{which}") * CYCLES[0] / MEGAHERTZ for which in ("mean", "most")]
    return "\n".join([
        "1. **How many microseconds?** To prepare and solve from nothing, a quadruped (18 velocities, 4 contacts) takes",
        f"   {microseconds('quadruped', cold)}; a sliding box (6 velocities, 4 contacts) takes",
        f"   {microseconds('box', cold)}. A whole tick of a robot with 12 motors, dynamics and torques included,",
        f"   takes {tick[0]:,.0f} µs in the mean and {tick[1]:,.0f} at most, to 1e-3. `Kernel::worst_cycles` bounds a call for any data ([A tick that fits]).",
        f"2. **How many bytes?** The quadruped takes {flash[0]} bytes of flash ({smallest:,} with the smallest flags), {ram:,} of RAM, and",
        f"   {value('quadruped', 'stack_solve'):,} of stack ({value('quadruped', 'stack_all_phases'):,} if a solve goes through all phases).",
        f"3. **What can be left out?** The central path ({flash[1]} bytes of flash remain), and Newton's method as well ({flash[2]} remain).",
        f"   Of random boxes, piles, grasps and robots {solved[1]} and {solved[2]} % are then solved, in place of {solved[0]} %.",
    ])


def cores():
    """The table that `.ci/cores` has written."""
    with open("examples/cores/CORES.md") as lines:
        return lines.read().strip()


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
    table("bytes of flash for prepare and solve, f32 on a Cortex-M4F",
          ["", "opt-level 3", 'opt-level "s"'], rows)
    print('\nAt opt-level "s" `prepare` and a solve take two to four times as many instructions.')


def limits(values, machine, title):
    """A tick of the quadruped with joint limits: the scene filled, prepared and solved to 1e-4."""
    ticks = [("contacts", "contacts alone"), ("none", "the same with room for 12 joint rows"),
             ("far", "12 limits, none reached"), ("two_cold", "12 limits, 2 reached, cold"), ("two_warm", "the same, warm"),
             ("slice_mean", "the cold solve alone in the smallest pieces: mean of a piece"), ("slice", "longest piece")]
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
    is_kept = lambda most: "is kept" if most <= 1000 else "is **not** kept"
    print("\nA quadruped of 12 motors drops, is pushed and loses sensors (`examples/robot_firmware`). At {} MHz and {} cycles an instruction such a"
          "\ntick takes {:,.0f} µs in the mean and {:,.0f} at most: 1 kHz {}. At {} cycles, which five wait states may take, it takes {:,.0f} and {:,.0f}:"
          "\n1 kHz {} in the longest ticks."
          .format(MEGAHERTZ, CYCLES[0], *times[:2], is_kept(times[1]), CYCLES[1], *times[2:], is_kept(times[3])))


def targets(values):
    """The aims for the quadruped: printed for contributors, not part of the page."""
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
    table("Aims for the quadruped, f32 on a Cortex-M4F (see .github/AIMS.md)", ["", "aim", "measured", ""], rows)


def compare(compiler, values, path):
    of, baseline = read(path)
    if of != compiler:
        print(f"\nnot compared: the baseline is of {of}, this is {compiler}")
        return 0
    missing = [name for name in baseline if name not in values and not name[1].startswith(("flags_", "phases"))]
    grown = [name for name, old in baseline.items() if values.get(name, old) > 1.05 * old]
    for name in missing:
        print(f"{' '.join(name)}: {baseline[name]}, now missing")
    for name in grown:
        print(f"{' '.join(name)}: {baseline[name]} is {values[name]} now")
    if grown:
        print("UPDATE_BASELINE=1 writes down what is meant to grow")
    if not missing and not grown:
        print(f"\n{len(baseline)} numbers at most 5 % above the baseline")
    return 1 if missing or grown else 0


def main():
    measured, path, compiler = sys.argv[1:]
    values = read(measured)[1]
    tables = io.StringIO()
    with contextlib.redirect_stdout(tables):
        report(values)
    print(tables.getvalue(), end="")
    targets(values)
    if os.environ.get("UPDATE_BASELINE"):
        with open("src/guide/reports/firmware.md", "w") as out:
            out.write(PAGE.format(compiler=compiler, flags=flags(values), phases=phases(values), cycles=cycles(), answers=answers(values), cores=cores(),
                                  scenes=f"{values['m4f32', 'phases', 'scenes']:,}") + tables.getvalue() + "\n[A tick that fits]: ../tick.md\n")
        with open(path, "w") as out:
            out.write(f"# {compiler}\n")
            out.writelines(f"{' '.join(name)} {value}\n" for name, value in values.items())
        return 0
    return compare(compiler, values, path)


sys.exit(main())
