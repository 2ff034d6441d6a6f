#!/usr/bin/env python3
"""Runs the contestants of the race on the chip under QEMU, and judges what they print.

Usage: race.py IMAGES REPORT. IMAGES has a program CONTESTANT_SCENE for each, as `.ci/chip_race` builds them; REPORT is the folder for the
table and the picture. `race.py --header SCENE` prints a scene as C; `race.py --records FOLDER` writes those that share out forces.
"""
import struct
import subprocess
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
SCENES = {
    "sharing": ("four feet share out a wrench, push 0.3 of friction", HERE / "sharing.bin"),
    "sharing_slip": ("the same, push 0.9", HERE / "sharing_slip.bin"),
    "hand_6": ("six fingertips hold a thing of 8 cm", HERE / "hand_6.bin"),
    "hand_9": ("nine fingertips", HERE / "hand_9.bin"),
    "quadruped": ("standing quadruped", HERE / "../measure/quadruped.bin"),
    "box": ("sliding box", HERE / "../measure/box.bin"),
}
DOFS = {"quadruped": 18}  # six for the others
ALPHA = {"sharing": 1e-3, "sharing_slip": 1e-3, "hand_6": 1e-2, "hand_9": 1e-2}  # compliance of the scenes that share out forces


@dataclass(frozen=True)
class Scene:
    """`M`, free impulse, `H`, `w`, `mu` and compliance, in f64, of the records that the board reads as f32."""
    mass: np.ndarray
    push: np.ndarray
    jacobian: np.ndarray
    offset: np.ndarray
    mu: np.ndarray
    alpha: float

    @cached_property
    def delassus(self) -> np.ndarray:
        """`W`, with compliance."""
        return self.jacobian @ np.linalg.solve(self.mass, self.jacobian.T) + self.alpha * np.eye(3 * len(self.mu))

    @cached_property
    def least(self) -> np.ndarray:
        """The forces that share out the wrench, by many iterations of plain ADMM."""
        without = self.jacobian @ np.linalg.solve(self.mass, self.push) + self.offset
        inverse = np.linalg.inv(self.delassus + 0.3 * np.eye(len(without)))
        force, dual = np.zeros_like(without), np.zeros_like(without)
        for _ in range(20_000):
            target = inverse @ (0.3 * (force - dual) - without) + dual
            force = np.concatenate([project(z, mu) for z, mu in zip(target.reshape(-1, 3), self.mu)])
            dual = target - force
        return force

    def error(self, impulses: np.ndarray, convex: bool) -> float:
        """The error of the guide, of impulses alone: velocities are computed from them, so that momentum is exact."""
        contacts = len(self.mu)
        free = np.linalg.solve(self.mass, self.push)
        delassus = self.delassus
        steps = [3 / np.trace(delassus[3 * i:3 * i + 3, 3 * i:3 * i + 3]) for i in range(contacts)]

        def mapped(u: np.ndarray, r: np.ndarray) -> np.ndarray:
            """`Π_K(r - alpha û)`, contact by contact."""
            out = np.zeros_like(r)
            for i, (mu, step) in enumerate(zip(self.mu, steps)):
                at = slice(3 * i, 3 * i + 3)
                shifted = u[at].copy()
                if not convex:
                    shifted[0] += mu * np.hypot(*shifted[1:])
                out[at] = project(r[at] - step * shifted, mu)
            return out

        without = self.jacobian @ free + self.offset
        residual = impulses - mapped(delassus @ impulses + without, impulses)
        alone = mapped(without, np.zeros(3 * contacts))
        gapless = np.abs(self.offset)
        gapless[::3] = np.abs(np.minimum(self.offset[::3], 0))
        stop = np.repeat(steps, 3) * (np.abs(self.jacobian) @ np.abs(free) + gapless) / 100
        return float(np.linalg.norm(residual) / max(np.linalg.norm(x) for x in (impulses, alone, stop)))


def project(z: np.ndarray, mu: float) -> np.ndarray:
    """Nearest point of the friction cone `|z_T| <= mu z_N`."""
    size = np.hypot(*z[1:])
    if size <= mu * z[0]:
        return z
    if mu * size <= -z[0]:
        return np.zeros(3)
    normal = (z[0] + mu * size) / (1 + mu * mu)
    return np.concatenate([[normal], mu * normal * z[1:] / size])


def read(name: str) -> Scene:
    """The scene of a file as `examples/bake` writes it."""
    words = np.fromfile(SCENES[name][1], "<f4").astype(float)
    dofs, at = DOFS.get(name, 6), 1
    mass = np.zeros((dofs, dofs))
    lower = np.tril_indices(dofs)
    mass[lower] = words[at:at + len(lower[0])]
    mass = mass + np.tril(mass, -1).T
    at += len(lower[0])
    push = -words[at:at + dofs]
    contacts = words[at + dofs:].reshape(-1, 5 + 3 * dofs)
    return Scene(mass, push, contacts[:, 5:].reshape(-1, dofs), contacts[:, 2:5].reshape(-1), contacts[:, 1],
                 ALPHA.get(name, 0.0))


def records(folder: Path) -> None:
    """Writes the scenes of `examples/forces/scene.rs`: 12 kg, mu = 0.4, weights 25 for moments, pushed at 30°."""
    weight, weights = 12.0 * 9.81, [1, 1, 1, 25, 25, 25]
    for name, share in (("sharing", 0.3), ("sharing_slip", 0.9)):
        words = [struct.pack("<I", 4)]
        words += [struct.pack("<f", 1 / weights[i] if i == j else 0) for i in range(6) for j in range(i + 1)]
        words.append(struct.pack("<6f", share * 0.4 * 0.866 * weight, share * 0.4 * 0.5 * weight, weight, 0, 0, 0))
        for key, (x, y) in enumerate(((0.19, 0.13), (0.19, -0.13), (-0.19, 0.13), (-0.19, -0.13))):
            z = -0.28
            rows = (0, 0, 1, y, -x, 0, 1, 0, 0, 0, z, -y, 0, 1, 0, -z, 0, x)
            words.append(struct.pack("<I22f", key, 0.4, 0, 0, 0, *rows))
        (folder / f"{name}.bin").write_bytes(b"".join(words))
    hands(folder)


def hands(folder: Path) -> None:
    """Writes the scenes of fingertips around a thing of 8 cm and 0.8 kg, mu = 0.6, that bear 0.3 N each beyond what they are asked for."""
    least, weights = 0.3, [1, 1, 1, 600, 600, 600]
    for contacts in (6, 9):
        pushed, feet = np.array([0.2, -0.15, 8.0, 0.003, -0.002, 0.006]), []
        for i in range(contacts):
            angle, ring = 2 * np.pi * (i % 3) / 3, i // 3 - (contacts // 3 - 1) / 2
            out = np.array([np.cos(angle), np.sin(angle), 0.25 * ring])
            out /= np.linalg.norm(out)
            along = np.array([-np.sin(angle), np.cos(angle), 0])
            axes = np.array([-out, along, np.cross(-out, along)])
            rows = np.hstack([axes, np.cross(0.04 * out, axes)])
            pushed -= least * rows[0]
            feet.append(struct.pack("<I22f", i, 0.6, ALPHA[f"hand_{contacts}"] * least, 0, 0, *rows.ravel()))
        words = [struct.pack("<I", contacts)]
        words += [struct.pack("<f", 1 / weights[i] if i == j else 0) for i in range(6) for j in range(i + 1)]
        (folder / f"hand_{contacts}.bin").write_bytes(b"".join([*words, struct.pack("<6f", *pushed), *feet]))


def header(name: str) -> str:
    """The scene as constants in C, with the free impulse of the tick before, as `main.rs` has it."""
    scene = read(name)
    before = 0.99 * scene.push
    if scene.alpha:
        before = scene.push.copy()
        before[0] += 0.01 * scene.push[1]
        before[1] -= 0.01 * scene.push[0]

    def c(values: np.ndarray) -> str:
        return "{" + ", ".join(c(v) if v.ndim else repr(float(v)) for v in values) + "}"

    return (f"enum {{ N = {len(scene.push)}, C = {len(scene.mu)} }};\n#define ALPHA {scene.alpha}\n"
            f"static const double mass[N][N] = {c(scene.mass)}, jacobian[3 * C][N] = {c(scene.jacobian)},\n"
            f"    push[N] = {c(scene.push)}, before[N] = {c(before)}, offset[3 * C] = {c(scene.offset)}, mu[C] = {c(scene.mu)};")


@dataclass(frozen=True)
class Contestant:
    """Rows of the table: whose image, what they are called, and which calls are theirs, cold and warm."""

    image: str
    name: str
    cold: str
    warm: str
    law: str  # "Coulomb", or "relaxed": its convex relaxation
    promised: bool = False  # the setting is the error that it promises

    @property
    def machine(self) -> list[str]:
        """QEMU, with the board of its core."""
        board = ["mps2-an500", "cortex-m7"] if "m7" in self.image else ["mps2-an386", "cortex-m4"]
        return ["qemu-system-arm", "-M", board[0], "-cpu", board[1], "-icount", "shift=10", "-nographic",
                "-semihosting-config", "enable=on,target=native", "-kernel"]


def contestants(scene: str) -> list[Contestant]:
    """Those of a scene; forces are shared out by the relaxation, which is the programme itself."""
    loop = "Gauss-Seidel by hand, f32"
    if scene in ALPHA:
        ours = [Contestant("stiction", "this crate, f32", "convex_cold", "convex_warm", "relaxed", True),
                Contestant("admm", "this crate's `AdmmSolver`, f32", "convex_cold", "convex_warm", "relaxed", True),
                Contestant("admm_by_hand", "ADMM by hand, f32, iterations known beforehand", "cold", "warm", "relaxed")]
        law = "relaxed"
    else:
        ours = [Contestant("stiction", "this crate, f32", "cold", "warm", "Coulomb", True),
                Contestant("stiction", "this crate, f32", "convex_cold", "convex_warm", "relaxed", True)]
        law = "Coulomb"
    ours += [Contestant("gauss_seidel", f"{loop}, stops by itself", "tested_cold", "", law, True),
             Contestant("gauss_seidel", f"{loop}, sweeps known beforehand", "cold", "warm", law)]
    if scene.startswith("hand"):
        return ours
    return [*ours,
            Contestant("tinympc", "TinyMPC, f32", "convex_cold", "convex_warm", "relaxed"),
            Contestant("ecos_m4", "ECOS, f64 in software", "convex_cold", "", "relaxed"),
            Contestant("ecos_m7", "ECOS, f64 of a Cortex-M7", "convex_cold", "", "relaxed")]


@dataclass(frozen=True)
class Call:
    """One measured call of a contestant: its setting, instructions, and the judged error."""

    label: str
    setting: str
    instructions: int
    error: float
    #: From the least forces, over their size; of scenes that share out forces.
    distance: float


@dataclass(frozen=True)
class Result:
    """A row of the table: instructions to each tolerance, cold and warm; bytes."""

    contestant: Contestant
    prepare: int
    cold: list[int | None]
    warm: list[int | None]
    #: Cold and warm, until forces are within 1 % of the least ones.
    near: list[int | None]
    flash: int
    ram: int
    stack: int


TOLERANCES = {"1e-3": 1e-3, "1e-4": 1e-4, "1e-5": 1e-5}


def numbers(words: list[str]) -> np.ndarray:
    """Impulses: bits of `f32` as eight hexadecimal digits, or decimals."""
    if all(len(word) == 8 and "." not in word for word in words):
        return np.array([struct.unpack(">f", bytes.fromhex(word))[0] for word in words])
    return np.array([float(word) for word in words])


def sizes(path: Path) -> tuple[int, int]:
    """Bytes of flash and of static RAM of an image."""
    printed = subprocess.run(["arm-none-eabi-size", str(path)], check=True, capture_output=True, text=True).stdout
    text, data, bss = map(int, printed.splitlines()[1].split()[:3])
    return text + data, data + bss


def play(images: Path, name: str, scene: Scene, of: Contestant) -> Result:
    """Runs a contestant and judges it. `SystemExit` if it breaks a promise that is ours to keep."""
    image = images / f"{of.image}_{name}"
    printed = subprocess.run([*of.machine, str(image)], check=True, capture_output=True, text=True, timeout=600).stdout
    lines = [line.split() for line in printed.splitlines()]
    held = {line[1]: int(line[2]) for line in lines if line[0] == "bytes"}
    calls = []
    for label, setting, count, *words in (line for line in lines if line[0] != "bytes"):
        impulses = numbers(words)
        distance = np.linalg.norm(impulses - scene.least) / np.linalg.norm(scene.least) if scene.alpha else np.inf
        calls.append(Call(label, setting, int(count), scene.error(impulses, of.law == "relaxed"), float(distance)))

    def cheapest(label: str) -> list[int | None]:
        mine = [call for call in calls if call.label == label]
        found: list[int | None] = []
        for setting, tolerance in TOLERANCES.items():
            kept = [call for call in mine if call.error <= tolerance and (not of.promised or call.setting == setting)]
            if of.image in ("stiction", "admm") and not kept:
                raise SystemExit(f"{name}: {label} to {setting} is off by {[c.error for c in mine if c.setting == setting]}")
            found.append(min((call.instructions for call in kept), default=None))
        return found

    empty = "c_empty" if of.image.startswith(("ecos", "tinympc")) else "empty"
    flash, static = (a - b for a, b in zip(sizes(image), sizes(images / f"{empty}_{name}")))
    ram = held["ram"] if "ram" in held else static + held["heap"]
    prepare = max(call.instructions for call in calls if call.label == "prepare")
    near = [min((call.instructions for call in calls if call.label == label and call.distance <= 0.01), default=None)
            for label in (of.cold, of.warm)]
    return Result(of, prepare, cheapest(of.cold), cheapest(of.warm) if of.warm else [None] * 3, near, flash, ram, held["stack"])


def table(results: dict[str, list[Result]]) -> str:
    """The results in Markdown."""
    def cell(value: int | None) -> str:
        return "–" if value is None else f"{value:,}"

    out = []
    for name, rows in results.items():
        out.append(f"\n## {SCENES[name][0].capitalize()}\n")
        near = ["forces to 1 %: cold", "warm"] if name in ALPHA else []
        heads = ["prepare", "cold 1e-3", "1e-4", "1e-5", "warm 1e-3", "1e-4", "1e-5", *near, "flash", "RAM", "stack"]
        out.append(f"| instructions | law | {' | '.join(heads)} |")
        out.append("|---|---|" + "---:|" * len(heads))
        for row in rows:
            values = [row.prepare, *row.cold, *row.warm, *(row.near if near else []), row.flash, row.ram, row.stack]
            out.append(f"| {' | '.join([row.contestant.name, row.contestant.law, *map(cell, values)])} |")
    return "\n".join(out)


def picture(results: dict[str, list[Result]], path: Path) -> None:
    """Instructions to prepare and solve, a panel a scene, a row a contestant, a mark a tolerance."""
    import matplotlib
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "race"  # the same file each time
    from matplotlib import pyplot

    heights = [len(rows) for rows in results.values()]
    figure, axes = pyplot.subplots(len(results), 1, figsize=(9, 0.34 * sum(heights) + 2), sharex=True, height_ratios=heights)
    for axis, (name, rows) in zip(axes, results.items()):
        for at, row in enumerate(reversed(rows)):
            colour = "C3" if row.contestant.image in ("stiction", "admm") else "0.35"
            for values, lift, filled in ((row.cold, 0.13, True), (row.warm, -0.13, False)):
                reached = [(row.prepare + value, mark) for value, mark in zip(values, "os^") if value is not None]
                axis.plot([x for x, _ in reached], [at + lift] * len(reached), color=colour, linewidth=0.8)
                for x, mark in reached:
                    axis.plot(x, at + lift, mark, color=colour, markersize=5, markerfacecolor=colour if filled else "white")
        axis.set_xscale("log")
        axis.set_xlim(5e3, 6e7)
        axis.set_ylim(-0.6, len(rows) - 0.4)
        axis.set_yticks(range(len(rows)), [f"{row.contestant.name.replace('`', '')} ({row.contestant.law})" for row in reversed(rows)], fontsize=8)
        axis.set_title(SCENES[name][0], loc="left", fontsize=9)
        axis.grid(axis="x", which="major", color="0.85")
        axis.spines[["top", "right"]].set_visible(False)
    marks = [pyplot.Line2D([], [], marker=mark, linestyle="", color="0.35", label=f"to {setting}") for mark, setting in zip("os^", TOLERANCES)]
    marks.append(pyplot.Line2D([], [], marker="o", linestyle="", color="0.35", markerfacecolor="white", label="warm"))
    axes[-1].set_xlabel("instructions to prepare and solve, Cortex-M4F (168 million a second at one a cycle)", fontsize=9)
    figure.legend(handles=marks, loc="upper right", ncols=4, fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0, 1, 0.98))
    figure.savefig(path, metadata={"Date": None})


def main(images: Path, report: Path) -> None:
    """Plays all scenes and writes the report."""
    results = {name: [play(images, name, read(name), of) for of in contestants(name)] for name in SCENES}
    report.mkdir(exist_ok=True)
    text = (HERE / "template.md").read_text().replace("{table}", table(results))
    (report / "REPORT.md").write_text(text)
    picture(results, report / "race.svg")
    print(table(results))


if __name__ == "__main__":
    if sys.argv[1] == "--header":
        print(header(sys.argv[2]))
    elif sys.argv[1] == "--records":
        records(Path(sys.argv[2]))
    else:
        main(Path(sys.argv[1]), Path(sys.argv[2]))
