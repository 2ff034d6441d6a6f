"""Film strip of the cube: `python examples/python/films/cube.py` writes cube.png beside it."""

from __future__ import annotations

import pathlib

import draw
import mujoco
import numpy as np
import scenes
from PIL import Image

STEP, EVERY, END = 0.01, 0.1, 2.0
WIDTH, LEFT, RIGHT = 1800, -0.15, 4.35
PIXELS = WIDTH / (RIGHT - LEFT)  # a metre
TALL, LOW, FLOOR = 240, 130, 40  # heights of rows where it flies and where it does not, and of the floor before it
HEAD, CAPTION, FOOT = 66, 46, 40
BOX = mujoco.mjtGeom.mjGEOM_BOX


def strip(poses: draw.Array, colour: tuple[float, float, float], height: int) -> Image.Image:
    """One row: the cube at several instants, seen from the side."""
    spec = mujoco.MjSpec.from_string(draw.SKY)
    spec.visual.global_.fovy = height / PIXELS
    spec.stat.extent, spec.stat.center = 2.5, [2.0, 0.0, 0.0]
    world = spec.worldbody
    sun = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    world.add_light(pos=[2.0, -1.0, 4.0], dir=[0.0, 0.2, -1.0], type=sun, diffuse=[0.4] * 3)

    def lay(x: float, width: float, rgb: tuple[float, float, float]) -> None:
        world.add_geom(type=BOX, size=[width, 0.6, 0.0005], pos=[x, 0.3, 0], rgba=[*rgb, 1])

    world.add_geom(type=BOX, size=[10, 0.6, 0.05], pos=[2, 0.3, -0.05], rgba=[0.93, 0.93, 0.94, 1])
    for metre in np.arange(0.0, 4.1, 0.5):
        lay(metre, 0.002, (0.7, 0.7, 0.72))
    lay(scenes.paper(STEP, END)[-1], 0.006, (0.0, 0.55, 0.2))
    half = scenes.HALF
    for pose in poses:
        body = world.add_body(pos=pose[:3], quat=pose[3:])
        body.add_geom(type=BOX, size=[half, half, 0.7 * half], pos=[0, 0, -0.3 * half], rgba=[*colour, 1])
        body.add_geom(type=BOX, size=[half, half, 0.3 * half], pos=[0, 0, 0.7 * half], rgba=[1, 0.8, 0.2, 1])
    camera = draw.look((0.5 * (LEFT + RIGHT), 0.0, (0.5 * height - FLOOR) / PIXELS), 5.0, 90.0, -12.0)
    camera.orthographic = 1
    model = spec.compile()
    return next(draw.shots(model, camera, (WIDTH, height), [model.qpos0]))


def instants(slide: scenes.Slide) -> draw.Array:
    """The first pose, one each `EVERY` seconds that does not hide behind the last, and the last."""
    every = round(EVERY / STEP)
    start = np.array([0.0, 0.0, slide.poses[0, 2], 1.0, 0.0, 0.0, 0.0])
    last = slide.poses[-1]
    between = [pose for pose in slide.poses[every - 1 :: every] if np.linalg.norm((pose - last)[:3]) > 2 * scenes.HALF]
    return np.array([start, *between, last])


def main() -> None:
    """Run, search, draw."""
    best = scenes.best(STEP)
    orange, blue = (0.85, 0.36, 0.1), (0.15, 0.35, 0.75)
    rows = (
        ("MuJoCo, default", scenes.DEFAULT, orange, draw.ORANGE, TALL),
        ("MuJoCo, elliptic, impratio 100, noslip", scenes.CAREFUL, orange, draw.ORANGE, TALL),
        (f"MuJoCo, the best of {scenes.SEARCHED:,} settings for it", best, orange, draw.ORANGE, LOW),
        ("stiction", scenes.HERE, blue, draw.BLUE, LOW),
    )
    picture = Image.new("RGB", (WIDTH, HEAD + FOOT + sum(row[-1] + CAPTION for row in rows)), "white")
    title = "A cube of 10 cm slides at 6 m/s, friction 0.5, in steps of 10 ms; drawn every 0.1 s"
    draw.text(picture, (20, 12), title, 34)
    top = HEAD
    for name, engine, colour, ink, height in rows:
        slide = scenes.slide(engine, STEP, END)
        picture.paste(strip(instants(slide), colour, height), (0, top + CAPTION))
        numbers = f"lifts {1000 * abs(slide.lift):.0f} mm, tilts {slide.tilt:.0f}°, stops at {slide.stop:.3f} m; "
        numbers += f"creeps {1000 * scenes.rest(engine, STEP)[0]:.2f} mm/s on a 20° slope"
        draw.text(picture, (20, top + 2), name, 32, ink, bold=True)
        draw.text(picture, (WIDTH - 20, top + 6), numbers, 26, anchor="ra")
        top += height + CAPTION
    for metre in np.arange(0.0, 3.1, 0.5):
        draw.text(picture, ((metre - LEFT) * PIXELS, top + 4), f"{metre:g} m", 24, draw.GREY, anchor="ma")
    stop = scenes.paper(STEP, END)[-1]
    draw.text(picture, ((stop - LEFT) * PIXELS, top + 2), f"on paper {stop:.3f} m", 28, draw.GREEN, "ma", bold=True)
    draw.save(picture, pathlib.Path(__file__).with_suffix(".png"))


if __name__ == "__main__":
    main()
