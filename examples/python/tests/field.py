"""Small models as people build them: shared by the tests of what public reports and stock models brought."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from stiction.mujoco import Stepper

Array = NDArray[np.float64]
G = 9.81
FLOOR = '<geom type="plane" size="5 5 1"/>'


@dataclass
class Scene:
    """A model, its data, and what steps it."""

    model: mujoco.MjModel
    data: mujoco.MjData
    stepper: Stepper

    @property
    def h(self) -> float:
        """The time step (s)."""
        return float(self.model.opt.timestep)

    def step(self, steps: int = 1) -> mujoco.MjData:
        """Take steps."""
        self.stepper.step(self.data, steps)
        return self.data

    def run(self, time: float) -> mujoco.MjData:
        """Take steps for that long."""
        return self.step(round(time / self.h))

    def is_clean(self) -> bool:
        """Were all steps solved by the exact law, with nothing left out?"""
        s = self.stepper
        return s.unsolved == s.contradictions == s.fallbacks == s.crowded == 0

    def forces(self) -> Array:
        """Normal forces on each body from what it stands on (N); of a pair the second is said to stand."""
        total, force = np.zeros(self.model.nbody), np.zeros(6)
        for index, contact in enumerate(self.data.contact):
            mujoco.mj_contactForce(self.model, self.data, index, force)
            total[self.model.geom_bodyid[contact.geom[1]]] += force[0]
        return total

    def overlap(self) -> float:
        """How deep things overlap where they are now (m), looked for apart from the data."""
        other = mujoco.MjData(self.model)
        other.qpos[:], other.mocap_pos[:] = self.data.qpos, self.data.mocap_pos
        mujoco.mj_kinematics(self.model, other)
        mujoco.mj_collision(self.model, other)
        return -float(other.contact.dist.min(initial=0.0))


def scene(world: str, rest: str = "", option: str = "", h: float = 0.002, tol: float = 1e-9, **more: Any) -> Scene:
    """Build it."""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco>{more.get("head", "")}<option timestep="{h}" {option}/><worldbody>{world}</worldbody>{rest}</mujoco>'
    )
    return Scene(model, mujoco.MjData(model), Stepper(model, tol=tol))


def box(size: str, at: str, mass: float = 1.0, friction: float = 1.0, more: str = "") -> str:
    """A free box."""
    return f'<body pos="{at}"><freejoint/><geom type="box" size="{size}" mass="{mass}" friction="{friction} 0 0" {more}/></body>'


def slope(angle: float) -> str:
    """Gravity on a slope that rises along x, seen from it."""
    return f'gravity="{-G * np.sin(angle)} 0 {-G * np.cos(angle)}"'
