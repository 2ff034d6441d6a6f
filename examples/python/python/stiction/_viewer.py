"""MuJoCo's passive viewer with the forces of contacts, stepped by this law or by MuJoCo's."""

from __future__ import annotations

import queue
import sys
import threading
import time
import warnings
from collections.abc import Sequence

import glfw
import mujoco
import mujoco.viewer
import numpy as np

from ._types import Mode
from .mujoco import Stepper

BLUE, ORANGE, GREY = np.array([[0.12, 0.47, 0.71, 1], [0.9, 0.43, 0.04, 1], [0.5, 0.5, 0.5, 1]], np.float32)
_ARROW = mujoco.mjtGeom.mjGEOM_ARROW
_FRAME = 1 / 60  # s, of a picture, at least
_MOST = 0.1  # s, of steps between two pictures: a slow screen is behind real time
_SPACE = 32


def draw_forces(model: mujoco.MjModel, data: mujoco.MjData, scene: mujoco.MjvScene, modes: Sequence[int] | None = None) -> None:
    """Add the forces of contacts to a scene as arrows, blue where they stick, orange where they slip.

    The weight of all that moves is as long as the model, ``stat.extent``.

    Args:
        model: of the data.
        data: after a step.
        scene: of a viewer (``user_scn``), or of a ``mujoco.Renderer`` after ``update_scene``.
        modes: those of the :class:`Stepper`, ``(ncon,)``; without them, after ``mujoco.mj_step``, arrows are grey.
    """
    width = model.vis.scale.forcewidth * model.stat.meansize
    scale = model.stat.extent / (9.81 * model.body_mass[model.body_weldid > 0].sum())
    for i, contact in enumerate(data.contact[: data.ncon]):
        force = np.zeros(6)
        mujoco.mj_contactForce(model, data, i, force)
        if scene.ngeom == scene.maxgeom or force[0] <= 0.0:
            continue
        colour = GREY if modes is None else ORANGE if modes[i] == Mode.SLIP else BLUE
        arrow = scene.geoms[scene.ngeom]
        mujoco.mjv_initGeom(arrow, _ARROW, np.zeros(3), np.zeros(3), np.zeros(9), colour)
        mujoco.mjv_connector(arrow, _ARROW, width, contact.pos, contact.pos + scale * (contact.frame.reshape(3, 3).T @ force[:3]))
        scene.ngeom += 1


def watch(model: mujoco.MjModel, end: float) -> str:
    """Step a model in real time until its viewer is closed, or the time is ``end`` (s). The space key changes the law.

    It begins at the first keyframe, if there is one.

    Returns:
        The counters at the end.

    Raises:
        TypeError, ValueError: the :class:`Stepper` does not take the model.
        RuntimeError: there is no display.
    """
    data, own = mujoco.MjData(model), (model.opt.cone, model.opt.jacobian)
    stepper, is_exact = Stepper(model, tol=1e-8), True
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    exact = (model.opt.cone, model.opt.jacobian)
    presses, h, clock, told = queue.SimpleQueue[int](), model.opt.timestep, time.perf_counter(), -1
    check_display()
    others = set(threading.enumerate())
    with mujoco.viewer.launch_passive(model, data, key_callback=presses.put, show_left_ui=False, show_right_ui=False) as viewer:
        while viewer.is_running() and data.time < end:
            now = time.perf_counter()
            steps = max(1, int(min(now - clock, _MOST, end - data.time) / h))
            clock = max(clock, now - _MOST) + steps * h
            while not presses.empty():
                if presses.get() == _SPACE:
                    is_exact = not is_exact
                    model.opt.cone, model.opt.jacobian = exact if is_exact else own
                    stepper.reset()
            if is_exact:
                stepper.step(data, steps)
            else:
                mujoco.mj_step(model, data, steps)
            with viewer.lock():
                viewer.user_scn.ngeom = 0
                draw_forces(model, data, viewer.user_scn, stepper.modes if is_exact else None)
            lines = counters(stepper, data, is_exact)
            if hasattr(viewer, "set_texts"):
                viewer.set_texts((None, None, "\n".join(lines), "\n".join(lines.values())))
            elif int(data.time) != told:  # the viewer of MuJoCo 3.3.0 has no texts
                told = int(data.time)
                print(one_line(lines))
            viewer.sync()
            time.sleep(max(0.0, now + _FRAME - time.perf_counter(), clock - time.perf_counter()))
    for thread in set(threading.enumerate()) - others:
        thread.join()  # it draws until its window is gone, which the end of the program would take from it
    return one_line(counters(stepper, data, is_exact))


def check_display() -> None:
    """Refuse to go on without a display, where MuJoCo's viewer would end the program."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if sys.platform != "darwin" and not glfw.init():  # there mjpython opens windows
            raise RuntimeError("there is no display")


def counters(stepper: Stepper, data: mujoco.MjData, is_exact: bool) -> dict[str, str]:
    """What is told beside the picture."""
    modes = stepper.modes if is_exact else []
    return {
        "time": f"{data.time:.2f} s",
        "law": "Coulomb's (space: mj_step)" if is_exact else "mj_step (space: Coulomb's)",
        "contacts": f"{modes.count(Mode.STICK)} stick, {modes.count(Mode.SLIP)} slip" if is_exact else f"{data.ncon}",
        "steps": f"{stepper.steps}",
        "unsolved": f"{stepper.unsolved}",
        "largest error": f"{stepper.max_error:.1g}",
    }


def one_line(lines: dict[str, str]) -> str:
    """Counters without a picture."""
    return ", ".join(f"{name} {value}" for name, value in lines.items())
