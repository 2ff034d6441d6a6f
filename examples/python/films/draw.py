"""Poses rendered by MuJoCo off-screen (EGL in software does), with captions."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Iterable, Iterator

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np
from matplotlib import font_manager
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

Array = NDArray[np.float64]
ORANGE, BLUE, GREEN, BLACK, GREY = "#b84a00", "#003ca0", "#007a30", "#111111", "#666666"
SKY = """
<mujoco>
  <visual>
    <global offwidth="4000" offheight="2400"/>
    <quality offsamples="8" shadowsize="4096"/>
    <headlight ambient="0.45 0.45 0.45" diffuse="0.4 0.4 0.4" specular="0 0 0"/>
    <map znear="0.01" zfar="100"/>
  </visual>
  <asset><texture type="skybox" builtin="flat" rgb1="1 1 1" rgb2="1 1 1" width="64" height="64"/></asset>
  <worldbody/>
</mujoco>
"""


def font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    """The font of captions, which comes with matplotlib."""
    name = font_manager.FontProperties(family="DejaVu Sans", weight="bold" if bold else "normal")
    return ImageFont.truetype(font_manager.findfont(name), size)


def shots(model: mujoco.MjModel, camera: mujoco.MjvCamera, size: tuple[int, int], poses: Iterable[Array]) -> Iterator[Image.Image]:
    """A model in several poses, seen by a camera; `size` is width and height in pixels."""
    data = mujoco.MjData(model)
    with mujoco.Renderer(model, size[1], size[0]) as renderer:
        for pose in poses:
            data.qpos[:] = pose
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera)
            yield Image.fromarray(renderer.render())


def look(at: tuple[float, float, float], distance: float, azimuth: float, elevation: float) -> mujoco.MjvCamera:
    """A free camera; angles in degrees."""
    camera = mujoco.MjvCamera()
    mujoco.mjv_defaultCamera(camera)
    camera.lookat[:] = at
    camera.distance, camera.azimuth, camera.elevation = distance, azimuth, elevation
    return camera


def save(picture: Image.Image, path: pathlib.Path) -> None:
    """Write a PNG in 256 colours, which halves it."""
    picture.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path}: {picture.width} x {picture.height}, {path.stat().st_size // 1024} KB")


def text(
    picture: Image.Image,
    at: tuple[float, float],
    words: str,
    size: int,
    colour: str = BLACK,
    anchor: str = "la",
    bold: bool = False,
) -> None:
    """A caption at a place in pixels."""
    ImageDraw.Draw(picture).text(at, words, colour, font(size, bold), anchor)
