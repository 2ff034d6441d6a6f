"""Pictures of the gripper at critical friction: `python examples/python/films/gripper.py` writes gripper.png beside it."""

from __future__ import annotations

import pathlib

import draw
import mujoco
import scenes
from PIL import Image

STEP, END = 0.002, 5.0
SHARES = (0.90, 0.98, 1.00, 1.02, 1.10)
WIDTH, HEIGHT, SIDE = 300, 290, 300  # of a cell, and of the names of rows
HEAD = 110
ROWS: tuple[tuple[str, scenes.Engine, str], ...] = (
    ("MuJoCo,\ndefault", scenes.DEFAULT, draw.ORANGE),
    ("MuJoCo,\nelliptic,\nimpratio 100,\nnoslip", scenes.CAREFUL, draw.ORANGE),
    ("stiction", scenes.HERE, draw.BLUE),
)


def cell(pose: draw.Array) -> Image.Image:
    """Fingers, block and table."""
    spec = mujoco.MjSpec.from_file(str(scenes.MODELS / "gripper.xml"))
    sky = mujoco.MjSpec.from_string(draw.SKY)
    for name in ("ambient", "diffuse", "specular"):
        setattr(spec.visual.headlight, name, getattr(sky.visual.headlight, name))
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 4000, 2400
    spec.visual.quality.offsamples = 8
    white = {"builtin": mujoco.mjtBuiltin.mjBUILTIN_FLAT, "rgb1": [1, 1, 1], "rgb2": [1, 1, 1], "width": 64, "height": 64}
    spec.add_texture(type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, **white)
    return draw.render(spec, draw.look((0.0, 0.0, 0.46), 0.4, 70.0, -12.0), (WIDTH, HEIGHT), pose)


def main() -> None:
    """Run and draw."""
    picture = Image.new("RGB", (SIDE + WIDTH * len(SHARES), HEAD + HEIGHT * len(ROWS)), "white")
    draw.text(picture, (20, 12), f"Two fingers hold a block by friction: {END:g} s later (steps of {1e3 * STEP:g} ms)", 34)
    draw.text(picture, (20, 70), "friction / critical", 26, draw.GREY)
    for column, share in enumerate(SHARES):
        left = SIDE + column * WIDTH
        draw.text(picture, (left + WIDTH / 2, 66), f"{share:.2f}", 34, anchor="ma", bold=True)
        for row, (_, engine, _) in enumerate(ROWS):
            top = HEAD + row * HEIGHT
            pose, drop = scenes.grip(engine, STEP, share, END)
            picture.paste(cell(pose), (left, top))
            fate = scenes.length(max(drop, 0.0))
            words = fate if fate == "fell" else f"slid {fate}"
            draw.text(picture, (left + WIDTH / 2, top + HEIGHT - 40), words, 26, anchor="ma")
    for row, (name, _, ink) in enumerate(ROWS):
        draw.text(picture, (20, HEAD + row * HEIGHT + 50), name, 30, ink, bold=True)
    draw.save(picture, pathlib.Path(__file__).with_suffix(".png"))


if __name__ == "__main__":
    main()
