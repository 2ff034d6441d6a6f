"""How a box and a quadruped creep while they stand on a slope, here and in MuJoCo: report/STANDING.md, report/standing.svg.

    cargo build --release -p pictures --bin standing
    python3 examples/peers/standing.py      # needs mujoco, numpy, matplotlib
"""
import datetime
import pathlib
import subprocess
import time

import mujoco
import numpy as np
import report
import standing_scenes as scenes

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "examples/peers/report"
SETTLE, STAND, SAMPLE = 5.0, 60.0, 0.1
STEPS = (0.001, 0.002)
ROBOTS = {"box": scenes.BOX, "quadruped": scenes.QUADRUPED}
OURS, SINGLE = "stiction, f64, tolerance 1e-11", "stiction, f32, tolerance 1e-4"
HARD = {"cone": "elliptic", "impratio": 100}
TIGHT = {"tolerance": 1e-15, "iterations": 1000}
# The first four are MuJoCo's defaults (Newton, tolerance 1e-8, 100 iterations) but for what they name.
PEERS = {
    "pyramidal (default)": {"cone": "pyramidal"},
    "elliptic": {"cone": "elliptic"},
    "pyramidal, impratio 100": {"cone": "pyramidal", "impratio": 100},
    "elliptic, impratio 100": HARD,
    "pyramidal, tolerance 1e-15": {"cone": "pyramidal", **TIGHT},
    "elliptic, impratio 100, tolerance 1e-15": {**HARD, **TIGHT},
    "elliptic, impratio 100, CG, tolerance 1e-15": {**HARD, **TIGHT, "solver": "CG"},
    "elliptic, impratio 100, PGS, tolerance 1e-15": {**HARD, **TIGHT, "solver": "PGS"},
    "elliptic, impratio 100, solimp 0.9999": {**HARD, "solimp": "0.9999 0.9999 0.001"},
    "pyramidal, noslip 10": {"cone": "pyramidal", "noslip_iterations": 10},
    "elliptic, impratio 100, noslip 10": {**HARD, "noslip_iterations": 10},
    "elliptic, impratio 100, noslip 100": {**HARD, "noslip_iterations": 100, "noslip_tolerance": 1e-15},
}
DRAWN = {
    "pyramidal (default)": ("#cd5500", "-"), "elliptic": ("#cd5500", "--"),
    "pyramidal, impratio 100": ("#82397f", "-"), "elliptic, impratio 100": ("#82397f", "--"),
    "elliptic, impratio 100, noslip 100": ("#777777", "-"), OURS: ("#003ca0", "-"),
}


def contact_time(m, d):
    """Least time of the contact solve alone, less what a call from Python takes."""
    def least(call, *arguments):
        times = []
        for _ in range(20):
            start = time.perf_counter()
            for _ in range(100):
                call(*arguments)
            times.append((time.perf_counter() - start) / 100)
        return min(times)

    empty = least(mujoco.mj_isSparse, m)
    return sum(least(call, m, d) - empty for call in (mujoco.mj_projectConstraint, mujoco.mj_fwdConstraint))


def peer(body, step, options):
    """Samples of the body's position, time a step and of its contact solve (µs)."""
    m = scenes.model(body, step, **options)
    d = scenes.start(m)
    samples, best, count = [], np.inf, round(SAMPLE / step)
    for _ in range(round((SETTLE + STAND) / SAMPLE)):
        start = time.perf_counter()
        mujoco.mj_step(m, d, count)
        best = min(best, (time.perf_counter() - start) / count)
        samples.append(d.qpos[:3].copy())
    if d.ncon != 4:
        print("   ", d.ncon, "contacts at the end")
    return np.array(samples), 1e6 * best, 1e6 * contact_time(m, d)


def ours(name, body, step, number):
    path = ROOT / f"target/standing_{name}_{round(1e3 * step)}ms.json"
    scenes.dump(path, scenes.model(body, step))
    program = [ROOT / "target/release/standing", path, str(step), str(SETTLE + STAND), *number]
    done = subprocess.run(program, stdout=subprocess.PIPE, text=True, check=True)
    lines = [np.array(line.split(), float) for line in done.stdout.splitlines()]
    return np.array([line[1:] for line in lines[:-1]]), *lines[-1]


def way(samples):
    """How far the body is from where it was when it had settled."""
    settled = round(SETTLE / SAMPLE) - 1
    return np.linalg.norm(samples[settled + 1 :] - samples[settled], axis=1)


def creep(samples):
    return 1e6 * way(samples)[-1] / STAND


def number(x):
    return f"{x:,.0f}" if x >= 100 else f"{x:.1e}" if x < 0.01 else f"{x:.3g}"


def table(runs):
    header = ["creep, µm/s"] + [f"{name}, {round(1e3 * step)} ms" for name in ROBOTS for step in STEPS]
    header += [f"{name}: µs a step" for name in ROBOTS]
    rows = []
    for label in [OURS, SINGLE, *PEERS]:
        row = [label] + [number(creep(runs[label, name, step][0])) for name in ROBOTS for step in STEPS]
        for name in ROBOTS:
            whole, part = (min(runs[label, name, step][k] for step in STEPS) for k in (1, 2))
            row.append(f"{whole:.1f} ({part:.1f})")
        rows.append(row)
    return report.table(header, rows)


def draw(runs, path):
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "standing", "svg.fonttype": "none", "font.family": "sans-serif"})
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(13, 4.6), sharey=True)
    low, times = 1e-14, SAMPLE * np.arange(1, round(STAND / SAMPLE) + 1)
    for axis, name in zip(axes, ROBOTS):
        ends = []
        for label, (color, line) in DRAWN.items():
            far = np.maximum(way(runs[label, name, STEPS[0]][0]), low)
            width = 3 if label == OURS else 1.6
            axis.plot(times[9::10], far[9::10], color=color, linestyle=line, linewidth=width)
            short = label.split(",")[0] if label == OURS else "MuJoCo " + label
            ends.append([np.log10(far[-1]), short.replace("elliptic, impratio 100, noslip", "with noslip"), color])
        for lower, upper in zip(sorted(ends), sorted(ends)[1:]):
            upper[0] = max(upper[0], lower[0] + 0.72)
        for y, text, color in ends:
            weight = "bold" if text == "stiction" else "normal"
            axis.text(61, 10**y, text, color=color, va="center", fontsize=9, weight=weight)
        axis.set(yscale="log", xlim=(0, 60), ylim=(low / 2, 20), xlabel="time after it has settled, s")
        axis.set_title({"box": "2 kg box", "quadruped": "15 kg quadruped"}[name] + ", 20° slope, mu = 0.5")
        axis.set_yticks([1, 1e-3, 1e-6, 1e-9, 1e-12], ["1 m", "1 mm", "1 µm", "1 nm", "1 pm"])
        axis.minorticks_off()
        axis.grid(axis="y", color="#dddddd", linewidth=0.8)
        axis.axhline(1e-10, color="#bbbbbb", linewidth=0.8, linestyle=":", zorder=0)
        axis.text(59, 0.7e-10, "size of an atom", color="#777777", fontsize=8, ha="right", va="top")
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].set_ylabel("how far it has crept")
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    figure.savefig(ROOT / "target/standing.png", backend="agg")  # to be looked at


def main():
    runs = {}
    for name, body in ROBOTS.items():
        for step in STEPS:
            runs[OURS, name, step] = ours(name, body, step, [])
            runs[SINGLE, name, step] = ours(name, body, step, ["f32"])
            for label, options in PEERS.items():
                runs[label, name, step] = peer(body, step, options)
            for label in [OURS, SINGLE, *PEERS]:
                samples, *times = runs[label, name, step]
                print(f"{name:9} {step} {label:45} {creep(samples):12.3e} µm/s, {times[0]:.2f} ({times[1]:.2f}) µs")
    draw(runs, FOLDER / "standing.svg")
    text = (pathlib.Path(__file__).parent / "standing_template.md").read_text()
    machine = f"{datetime.date.today()}, one core of {report.processor()}, MuJoCo {mujoco.__version__}"
    (FOLDER / "STANDING.md").write_text(text.replace("{table}", table(runs)).replace("{machine}", machine))


if __name__ == "__main__":
    main()
