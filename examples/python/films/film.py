"""Films, MuJoCo left and this package right: `python examples/python/films/film.py` writes gripper.webp and hammer.webp beside it.

The hammer is a task of metaworld, done by metaworld's own policy; first `pip install --no-deps metaworld==3.1.1 scipy`.
"""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from typing import Any

import draw
import metaworld
import mujoco
import numpy as np
import scenes
from metaworld.policies import ENV_POLICY_MAP
from metaworld.sawyer_xyz_env import SawyerMocapBase
from PIL import Image

import stiction.mujoco

WIDTH, HEIGHT, HEAD, LINE, GAP = 420, 320, 84, 30, 4  # of a side, the title, a line, and between sides (pixels)
STAY = 2.0  # how long the last picture stays (s)
SHARES, STEP, LASTS, EVERY, SLOW = (0.90, 1.00, 1.10), 0.002, 3.0, 16, 2  # friction over critical; steps a picture; slow motion
TASK, STEPS, STILL, FRAMES = "hammer-v3", 500, 200, 5  # steps of the policy: all, until the hammer is held still, a picture
Side = list[tuple[Image.Image, list[str]]]  # pictures, each with lines below


def film(name: str, words: tuple[str, str, str], sides: tuple[Side, Side], interval: float, slow: float) -> None:
    """Set two sides beside each other; words are the title, the left side's name, and what is written below."""
    title, left_name, below = words
    pictures = []
    for number, pair in enumerate(zip(*sides, strict=True)):
        picture = Image.new("RGB", (2 * WIDTH + GAP, HEAD + HEIGHT + LINE * (1 + len(pair[0][1]))), "white")
        draw.text(picture, (10, 8), title, 22)
        draw.text(picture, (picture.width - 10, 8), f"{(number + 1) * interval:.1f} s", 22, draw.GREY, "ra")
        draw.text(picture, (picture.width / 2, picture.height - LINE + 6), below, 16, draw.GREY, "ma")
        for column, (shot, lines) in enumerate(pair):
            left, ink = column * (WIDTH + GAP), (draw.ORANGE, draw.BLUE)[column]
            middle = left + WIDTH / 2
            picture.paste(shot, (left, HEAD))
            draw.text(picture, (middle, HEAD - 38), (left_name, "stiction")[column], 24, ink, "ma", bold=True)
            for row, line in enumerate(lines):
                draw.text(picture, (middle, HEAD + HEIGHT + 4 + LINE * row), line, 20, ink, "ma", bold=not row)
        pictures.append(picture)
    ends = np.round(1000 * slow * interval * np.arange(len(pictures))).astype(int)
    lasts = [*np.diff(ends).tolist(), round(1000 * STAY)]
    path = pathlib.Path(__file__).with_name(f"{name}.webp")
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=lasts, loop=0, quality=60, method=6)
    print(f"{path}: {len(pictures)} pictures, {sum(lasts) / 1000:.1f} s, {path.stat().st_size // 1024} KB")


def grippers(engine: scenes.Engine) -> Side:
    """A gripper for each friction."""
    spec = mujoco.MjSpec.from_file(str(scenes.MODELS / "gripper.xml"))
    sky = mujoco.MjSpec.from_string(draw.SKY)
    for name in ("ambient", "diffuse", "specular"):
        setattr(spec.visual.headlight, name, getattr(sky.visual.headlight, name))
    spec.visual.quality.offsamples = 8
    white = {"builtin": mujoco.mjtBuiltin.mjBUILTIN_FLAT, "rgb1": [1, 1, 1], "rgb2": [1, 1, 1], "width": 64, "height": 64}
    spec.add_texture(type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, **white)
    model, camera, wide = spec.compile(), draw.look((0.0, 0.0, 0.46), 0.4, 70.0, -12.0), WIDTH // len(SHARES)
    count, caption = round(LASTS / STEP) // EVERY, "how far the block has slid"
    side: Side = [(Image.new("RGB", (WIDTH, HEIGHT)), [caption]) for _ in range(count)]
    for column, share in enumerate(SHARES):
        poses, drops = scenes.grip(engine, STEP, share, LASTS)
        shots = draw.shots(model, camera, (wide, HEIGHT), poses[EVERY - 1 :: EVERY])
        for (picture, _), shot, drop in zip(side, shots, drops[EVERY - 1 :: EVERY], strict=True):
            picture.paste(shot, (wide * column, 0))
            middle = wide * (column + 0.5)
            draw.text(picture, (middle, 6), f"{share:.2f}", 24, anchor="ma", bold=True)
            draw.text(picture, (middle, HEIGHT - 32), scenes.length(abs(drop)), 22, anchor="ma", bold=True)
    return side


def hammer(start: Callable[[Any], object]) -> tuple[Side, str]:
    """The hammer, after `start` was called with the environment; and how far it has slid in the hand at the end."""
    tasks = metaworld.MT1(TASK, seed=0)
    env, policy = tasks.train_classes[TASK](), ENV_POLICY_MAP[TASK]()
    env.set_task(tasks.train_tasks[0])
    seen, _ = env.reset()  # by MuJoCo, so that both start alike
    start(env)
    data, hand, tool = env.data, env.data.body("hand"), env.data.body("hammerbody")
    poses, places, lags = [], [], []
    for _ in range(STEPS):
        seen = env.step(np.clip(policy.get_action(seen), -1, 1))[0]
        poses.append(data.qpos.copy())
        places.append(hand.xmat.reshape(3, 3).T @ (tool.xpos - hand.xpos))
        lags.append(1e3 * np.linalg.norm(data.mocap_pos[0] - hand.xpos))
    slid = np.maximum.accumulate(np.linalg.norm(np.array(places[STILL:]) - places[STILL], axis=1))
    fates = [*["–"] * STILL, *map(scenes.length, slid)]
    at, camera = slice(FRAMES - 1, None, FRAMES), draw.look((0.02, 0.65, 0.13), 0.85, 160.0, -18.0)
    shots = draw.shots(env.model, camera, (WIDTH, HEIGHT), poses[at])
    lines = [[f"hammer slid in the hand: {a}", f"hand {b:.1f} mm from where it is told"] for a, b in zip(fates, lags, strict=True)]
    return list(zip(shots, lines[at], strict=True)), fates[-1]


def main() -> None:
    """Run and draw."""
    careful = scenes.length(scenes.grip(scenes.CAREFUL, STEP, 1.0, LASTS)[1][-1])
    below = f"half speed, steps of 2 ms; MuJoCo with elliptic cones, impratio 100 and noslip: {careful} at 1.00"
    words = "Held by friction: 0.90, 1.00 and 1.10 of what the weight needs", "MuJoCo, default", below
    film("gripper", words, (grippers(scenes.DEFAULT), grippers(scenes.HERE)), EVERY * STEP, SLOW)

    def reset_welds(env: SawyerMocapBase) -> None:
        """As metaworld has it; MuJoCo 4 has a number more."""
        env.model.eq_data[:, :11] = (0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 5)

    SawyerMocapBase.reset_mocap_welds = reset_welds
    left, _ = hammer(lambda env: None)
    _, stiff = hammer(lambda env: setattr(env.model.opt, "impratio", 100))
    right, _ = hammer(lambda env: stiction.mujoco.patch(env, tol=1e-8))
    below = f"real time; slid since {0.0125 * STILL:g} s; metaworld's cones are elliptic; with impratio 100 MuJoCo's end is {stiff}"
    words = "Metaworld's task “hammer”, done by metaworld's own policy", "MuJoCo, as metaworld sets it", below
    film("hammer", words, (left, right), 0.0125 * FRAMES, 1)


if __name__ == "__main__":
    main()
