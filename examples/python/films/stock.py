"""A puck of metaworld, gripped, lifted and held: `python examples/python/films/stock.py` writes stock.png beside it.

Fetches the package with pip, as `stock_models.py` does; `--cache DIR` keeps it.
"""

from __future__ import annotations

import argparse
import pathlib
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable

import draw
import mujoco
import numpy as np
from PIL import Image

from stiction.mujoco import Stepper

PACKAGE, MODEL = "metaworld==3.1.1", "metaworld/assets/sawyer_xyz/sawyer_pick_place_v3.xml"
BEFORE, LOW, HIGH = 0.2, 0.05, 0.2  # height that the hand is told (m)
# What the hand does: height at the end (m), time (s), motors of the fingers.
MOVES = ((LOW, 0.8, -1), (LOW, 0.6, 1), (HIGH, 1.0, 1), (HIGH, 1.0, 1), (HIGH, 5.0, 1))
SHOWN = ((1, "gripped"), (3, "lifted, 1 s later"), (4, "held for 5 s more"))
WIDTH, HEIGHT, SIDE, HEAD = 420, 340, 240, 110
Step = Callable[[mujoco.MjData], None]


def moved(model: mujoco.MjModel, step: Step) -> list[tuple[draw.Array, float, float]]:
    """Pose, height of the hand and of the puck after each move."""
    data = mujoco.MjData(model)
    model.eq_data[0, :11] = (0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 5)  # the hand is where the mocap body is
    mujoco.mj_forward(model, data)
    hand, puck, joint = model.body("hand").id, model.body("obj").id, model.joint("objjoint").id
    place, turn = data.xpos[hand].copy(), data.xquat[hand].copy()
    goal = np.array((1, 0, 1, 0)) / np.sqrt(2)
    turn *= np.sign(turn @ goal)
    for share in np.minimum(np.arange(1200) / 800, 1):  # to above the puck
        data.mocap_pos[0] = (1 - share) * place + share * np.array((0, 0.6, BEFORE))
        quat = (1 - share) * turn + share * goal
        data.mocap_quat[0] = quat / np.linalg.norm(quat)
        data.ctrl[:] = (-1, 1)
        data.qpos[model.jnt_qposadr[joint] :][:3], data.qvel[model.jnt_dofadr[joint] :][:6] = (0, 0.6, 0.03), 0
        step(data)
    ends = []
    for height, time, motor in MOVES:
        start, steps = data.mocap_pos[0, 2], round(time / model.opt.timestep)
        data.ctrl[:] = (motor, -motor)
        for frame in range(steps):
            data.mocap_pos[0, 2] = start + (height - start) * (frame + 1) / steps
            step(data)
        ends.append((data.qpos.copy(), float(data.xpos[hand, 2]), float(data.xpos[puck, 2])))
    return ends


def main() -> None:
    """Run and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cache", type=pathlib.Path, help="folder of the package; it is fetched if it is not there")
    options = parser.parse_args()
    picture = Image.new("RGB", (SIDE + WIDTH * len(SHOWN), HEAD + HEIGHT * 2), "white")
    draw.text(picture, (20, 12), "Metaworld: a hand that follows a mocap body grips a puck and holds it at 0.2 m", 30)
    with tempfile.TemporaryDirectory() as folder:
        cache = options.cache or pathlib.Path(folder)
        if not list(cache.glob("metaworld-*.whl")):
            pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", str(cache), PACKAGE]
            subprocess.run(pip, check=True)
        with zipfile.ZipFile(next(cache.glob("metaworld-*.whl"))) as archive:
            archive.extractall(folder)
        for row, (name, ink) in enumerate((("MuJoCo,\ndefault", draw.ORANGE), ("stiction", draw.BLUE))):
            model = mujoco.MjModel.from_xml_path(str(pathlib.Path(folder, MODEL)))
            step = Stepper(model, tol=1e-8).step if row else lambda data, model=model: mujoco.mj_step(model, data)
            ends = moved(model, step)
            data, top = mujoco.MjData(model), HEAD + row * HEIGHT
            draw.text(picture, (20, top + 40), name, 30, ink, bold=True)
            with mujoco.Renderer(model, HEIGHT - 60, WIDTH - 20) as renderer:
                for column, (move, caption) in enumerate(SHOWN):
                    data.qpos[:], hand, puck = ends[move]
                    mujoco.mj_forward(model, data)
                    renderer.update_scene(data, draw.look((0.0, 0.6, 0.16), 0.75, 160.0, -12.0))
                    left = SIDE + column * WIDTH
                    picture.paste(Image.fromarray(renderer.render()), (left, top))
                    words = f"hand {1e3 * hand:.1f} mm, puck {1e3 * puck:.1f} mm"
                    draw.text(picture, (left + WIDTH / 2, top + HEIGHT - 54), words, 24, anchor="ma")
                    if not row:
                        draw.text(picture, (left + WIDTH / 2, 68), caption, 26, draw.GREY, anchor="ma")
    draw.save(picture, pathlib.Path(__file__).with_suffix(".png"))


if __name__ == "__main__":
    main()
