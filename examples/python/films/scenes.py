"""The cube and the gripper, simulated by MuJoCo under settings of its own, or by this package.

Lengths in m, times in s.
"""

from __future__ import annotations

import itertools
import pathlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from stiction.mujoco import Stepper

MODELS = pathlib.Path(__file__).resolve().parents[1] / "models"
SPEED, MU, GRAVITY, HALF = 6.0, 0.5, 9.81, 0.05
CORNERS = HALF * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Settings:
    """How MuJoCo solves contacts; what is not given is its default."""

    name: str
    elliptic: bool = False
    impratio: float = 1.0
    noslip: int = 0
    solref: tuple[float, float] = (0.02, 1.0)
    solimp: tuple[float, float, float] = (0.9, 0.95, 0.001)

    def stepper(self, model: mujoco.MjModel) -> Callable[[mujoco.MjData], None]:
        """Set the model up; the function that makes a step."""
        kinds = mujoco.mjtCone
        model.opt.cone = kinds.mjCONE_ELLIPTIC if self.elliptic else kinds.mjCONE_PYRAMIDAL
        model.opt.impratio = self.impratio
        model.opt.noslip_iterations = self.noslip
        model.geom_solref[:] = self.solref
        model.geom_solimp[:, :3] = self.solimp
        return lambda data: mujoco.mj_step(model, data)


@dataclass(frozen=True)
class Ours:
    """This package, to a tolerance."""

    name: str = "stiction"
    tolerance: float = 1e-8

    def stepper(self, model: mujoco.MjModel) -> Callable[[mujoco.MjData], None]:
        """Take the model over; the function that makes a step, and raises if it was not solved."""
        stepper = Stepper(model, tol=self.tolerance)

        def step(data: mujoco.MjData) -> None:
            stepper.step(data)
            if stepper.unsolved:
                raise RuntimeError(f"step {stepper.steps} is not solved: error {stepper.error}")

        return step


Engine = Settings | Ours
HERE = Ours()
DEFAULT = Settings("default (pyramids)")
CAREFUL = Settings("elliptic, impratio 100, noslip 50", elliptic=True, impratio=100, noslip=50)
STIFF = (0.9999, 0.9999, 0.001)
TRIED = (
    DEFAULT,
    Settings("pyramids, noslip 50", noslip=50),
    Settings("elliptic", elliptic=True),
    Settings("elliptic, impratio 100", elliptic=True, impratio=100),
    Settings("elliptic, noslip 50", elliptic=True, noslip=50),
    CAREFUL,
    Settings("elliptic, stiff solref (two steps)", elliptic=True, solref=(1e-6, 1.0)),
    Settings("pyramids, stiff solimp 0.9999", solimp=STIFF),
    Settings("elliptic, stiff solimp 0.9999", elliptic=True, solimp=STIFF),
    Settings("elliptic, solref and solimp stiff", elliptic=True, solref=(1e-6, 1.0), solimp=STIFF),
    Settings("elliptic, soft solref 0.1 s", elliptic=True, solref=(0.1, 1.0)),
)


def searched() -> Iterator[Settings]:
    """Every combination that the search for MuJoCo's best goes through."""
    axes = (
        (False, True),
        (0.01, 0.1, 1.0, 10.0, 100.0),
        (0, 50),
        tuple(itertools.product((0.005, 0.02, 0.05, 0.1, 0.2, 0.3), (0.5, 1.0, 2.0, 5.0))),
        ((0.9, 0.95, 0.001), STIFF, (0.5, 0.5, 0.001), (0.99, 0.99, 0.01)),
    )
    for elliptic, impratio, noslip, solref, solimp in itertools.product(*axes):
        name = f"{'elliptic' if elliptic else 'pyramids'}, impratio {impratio:g}, noslip {noslip}"
        name += f", solref {solref[0]:g} {solref[1]:g}, solimp {solimp[0]:g} {solimp[1]:g}"
        yield Settings(name, elliptic, impratio, noslip, solref, solimp)


#: How many these are.
SEARCHED = sum(1 for _ in searched())


def load(name: str, step: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A model of the folder and its data, at its first keyframe if it has one."""
    model = mujoco.MjModel.from_xml_path(str(MODELS / f"{name}.xml"))
    model.opt.timestep = step
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    return model, data


def paper(step: float, time_end: float) -> Array:
    """How far the cube has slid after each step, on paper: it loses `mu g h` a step until it stands."""
    steps = np.arange(1, round(time_end / step) + 1)
    return np.cumsum(step * np.maximum(SPEED - steps * MU * GRAVITY * step, 0.0))


@dataclass(frozen=True)
class Slide:
    """What became of the cube."""

    poses: Array  # steps × 7
    lift: float  # of its lowest corner
    tilt: float  # degrees
    off: float  # the largest distance of a corner from where it is on paper

    @property
    def stop(self) -> float:
        """Where it lies at the end."""
        return float(self.poses[-1, 0])


def slide(engine: Engine, step: float, end: float = 2.5) -> Slide:
    """Let the cube come to rest on the floor for 1 s, then throw it along x."""
    model, data = load("cube", step)
    advance = engine.stepper(model)
    data.qvel[:] = 0.0
    for _ in range(round(1.0 / step)):
        advance(data)
    start = data.qpos[:3].copy()
    data.qvel[:] = (SPEED, 0.0, 0.0, 0.0, 0.0, 0.0)
    poses = []
    for _ in range(round(end / step)):
        advance(data)
        poses.append(data.qpos.copy())
    moved = np.array(poses)
    moved[:, :2] -= start[:2]
    turns = np.empty((len(moved), 9))
    for turn, pose in zip(turns, moved, strict=True):
        mujoco.mju_quat2Mat(turn, pose[3:])
    corners = moved[:, None, :3] + np.einsum("sij,cj->sci", turns.reshape(-1, 3, 3), CORNERS)
    there = CORNERS + np.array((0.0, 0.0, start[2]))
    wanted = there[None] + np.stack([paper(step, end), *[np.zeros(len(moved))] * 2], axis=1)[:, None]
    return Slide(
        poses=moved,
        lift=float(corners[..., 2].min(axis=1).max()),
        tilt=float(np.degrees(np.arccos(np.clip(turns[:, 8], -1.0, 1.0))).max()),
        off=float(np.linalg.norm(corners - wanted, axis=2).max()),
    )


def best(step: float) -> Settings:
    """The settings, of all searched, with which the cube stays nearest to where it is on paper."""
    return min(searched(), key=lambda settings: slide(settings, step).off)


def rest(engine: Engine, step: float, end: float = 5.0) -> tuple[float, float]:
    """Let the cube lie on a slope of 20°: its speed in the last second (m/s), and microseconds of a step, the median."""
    model, data = load("cube", step)
    tilt = np.radians(20.0)
    model.opt.gravity[:] = GRAVITY * np.array((np.sin(tilt), 0.0, -np.cos(tilt)))
    advance = engine.stepper(model)
    data.qvel[:] = 0.0
    places, times = [], []
    for _ in range(round(end / step)):
        begin = time.perf_counter()
        advance(data)
        times.append(time.perf_counter() - begin)
        places.append(data.qpos[0])
    return abs(float(places[-1] - places[-1 - round(1.0 / step)])), float(np.median(times)) * 1e6


def grip(engine: Engine, step: float, share: float, end: float, turned: float = 0.0) -> tuple[Array, Array]:
    """Pinch the block for 0.5 s while its weight is carried, then let that act: positions after each step, and drops.

    Args:
        engine: what makes steps.
        step: its length.
        share: of the critical friction.
        end: how long it acts.
        turned: the whole scene, gravity too, in axes turned by this angle about the squeeze (rad): the same experiment.
    """
    model, data = load("gripper", step)
    model.geom_friction[:, 0] = share * MU
    spin = np.array((np.cos(turned / 2), np.sin(turned / 2), 0.0, 0.0))
    gravity = np.empty(3)
    mujoco.mju_rotVecQuat(gravity, np.array((0.0, 0.0, -GRAVITY)), spin)
    for body in range(1, model.nbody):
        mujoco.mju_rotVecQuat(model.body_pos[body], model.body_pos[body].copy(), spin)
        mujoco.mju_mulQuat(model.body_quat[body], spin, model.body_quat[body].copy())
    table = model.geom("table").id
    mujoco.mju_rotVecQuat(model.geom_pos[table], model.geom_pos[table].copy(), spin)
    mujoco.mju_mulQuat(model.geom_quat[table], spin, model.geom_quat[table].copy())
    model.geom_sameframe[table] = 0  # it has a pose of its own now
    mujoco.mju_rotVecQuat(data.qpos[2:5], data.qpos[2:5].copy(), spin)
    mujoco.mju_mulQuat(data.qpos[5:], spin, data.qpos[5:].copy())
    advance = engine.stepper(model)
    model.opt.gravity[:] = gravity
    for carried, duration in ((1.0, 0.5), (0.0, end)):
        data.qfrc_applied[2:5] = -carried * model.body("block").mass * gravity
        start, poses = data.qpos[2:5].copy(), []
        for _ in range(round(duration / step)):
            advance(data)
            poses.append(data.qpos.copy())
    moved = np.array(poses)
    return moved, (moved[:, 2:5] - start) @ gravity / GRAVITY


def length(metres: float) -> str:
    """How far something slid, in words, or that it fell out of the fingers."""
    if metres > 0.04:
        return "fell"
    if metres < 1e-12:
        return "< 1 pm"
    unit, name = next((unit for unit in ((1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")) if metres > unit[0]), (1e-12, "pm"))
    return f"{float(f'{metres / unit:.2g}'):g} {name}"
