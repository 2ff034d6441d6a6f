"""Films, MuJoCo left and this package right: `python examples/python/films/film.py` writes gripper.webp and hammer.webp beside it.

The hammer is a task of metaworld, done by metaworld's own policy; first `pip install --no-deps metaworld==3.1.1 scipy`.
With `--count` it says in how many tasks the hammer falls, and how many kinds of tasks are done (a quarter of an hour).
"""

from __future__ import annotations

import pathlib
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import draw
import metaworld
import mujoco
import numpy as np
import scenes
from metaworld.policies import ENV_POLICY_MAP
from PIL import Image

import stiction.mujoco

WIDTH, HEIGHT, HEAD, LINE, GAP = 420, 320, 84, 30, 4  # of a side, the title, a line, and between sides (pixels)
STAY = 2.0  # how long the last picture stays (s)
SHARES, STEP, LASTS, EVERY, SLOW = (0.90, 1.00, 1.10), 0.002, 3.0, 16, 2  # friction over critical; steps a picture; slow motion
STEPS, STILL, FRAMES = 500, 200, 5  # steps of the policy, 80 a second: all, until the hammer is held still, a picture
FALLEN = 0.03  # m
Side = Iterable[tuple[Image.Image, list[str]]]  # pictures, each with lines below


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
    side = [(Image.new("RGB", (WIDTH, HEIGHT)), [caption]) for _ in range(count)]
    for column, share in enumerate(SHARES):
        poses, drops = scenes.grip(engine, STEP, share, LASTS)
        shots = draw.shots(model, camera, (wide, HEIGHT), poses[EVERY - 1 :: EVERY])
        for (picture, _), shot, drop in zip(side, shots, drops[EVERY - 1 :: EVERY], strict=True):
            picture.paste(shot, (wide * column, 0))
            middle = wide * (column + 0.5)
            draw.text(picture, (middle, 6), f"{share:.2f}", 24, anchor="ma", bold=True)
            draw.text(picture, (middle, HEIGHT - 32), scenes.length(abs(drop)), 22, anchor="ma", bold=True)
    return side


@dataclass
class Run:
    """What became of a task after each step of the policy."""

    model: mujoco.MjModel
    poses: list[draw.Array]
    lags: list[float]  # how far the hand is from where it is told (mm)
    slid: draw.Array  # the farthest that the object was in the hand from where it was at `STILL`, from then on
    done: bool  # at any time, as metaworld counts


def run(start: Callable[[Any], object], kind: str = "hammer-v3", number: int = 0) -> Run:
    """A task of metaworld by metaworld's policy, after `start` was called with the environment."""
    tasks = metaworld.MT1(kind, seed=0)
    env, policy = tasks.train_classes[kind](), ENV_POLICY_MAP[kind]()
    env.set_task(tasks.train_tasks[number])
    seen, _ = env.reset()  # by MuJoCo, so that all start alike
    start(env)
    data, hand = env.data, env.data.body("hand")
    poses, lags, places, done = [], [], [], False
    for _ in range(STEPS):
        seen, *_, told = env.step(np.clip(policy.get_action(seen), -1, 1))
        poses.append(data.qpos.copy())
        lags.append(1e3 * float(np.linalg.norm(data.mocap_pos[0] - hand.xpos)))
        places.append(hand.xmat.reshape(3, 3).T @ (seen[4:7] - hand.xpos))
        done |= bool(told["success"])
    slid = np.linalg.norm(np.array(places[STILL:]) - places[STILL], axis=1)
    return Run(env.model, poses, lags, np.maximum.accumulate(slid), done)


def hammer(done: Run) -> Side:
    """The hammer in the hand."""
    fates = [*["–"] * STILL, *map(scenes.length, done.slid)]
    at, camera = slice(FRAMES - 1, None, FRAMES), draw.look((0.02, 0.65, 0.13), 0.85, 160.0, -18.0)
    lines = [
        [f"hammer slid in the hand: {a}", f"hand {b:.1f} mm from where it is told"] for a, b in zip(fates, done.lags, strict=True)
    ]
    return zip(draw.shots(done.model, camera, (WIDTH, HEIGHT), done.poses[at]), lines[at], strict=True)


def stiffen(env: Any, share: int) -> None:
    """Contacts and stops as stiff as MuJoCo can have them, at a share of the step."""
    model = env.model
    model.opt.timestep /= share
    env.frame_skip *= share
    model.opt.impratio = 10
    model.geom_solref[:] = model.jnt_solref[:] = 2.5 * model.opt.timestep, 1
    model.geom_solimp[:] = model.jnt_solimp[:] = 0.99, 0.999, 1e-5, 0.5, 2


STARTS: dict[str, Callable[[Any], object]] = {
    "as metaworld sets it": lambda env: None,
    "noslip 50": lambda env: setattr(env.model.opt, "noslip_iterations", 50),
    "impratio 100": lambda env: setattr(env.model.opt, "impratio", 100),
    "stiction": lambda env: stiction.mujoco.patch(env, tol=1e-8),
}


def count() -> None:
    """All hammers, and the first task of each kind."""
    for name, start in STARTS.items():
        runs = [run(start, number=number) for number in range(50)]
        ends = [scenes.length(slid) for slid in np.quantile([each.slid[-1] for each in runs], (0.5, 1.0), method="lower")]
        fell = sum(each.slid[-1] > FALLEN for each in runs)
        print(
            f"hammer, {name}: {sum(each.done for each in runs)} of 50 done, {fell} fell; slid {ends[0]} (median), {ends[1]} (most)"
        )
    stiff = {f"stiff contacts, 1/{share} of the step": lambda env, share=share: stiffen(env, share) for share in (1, 10)}
    kinds = {name: STARTS[name] for name in ("as metaworld sets it", "stiction")} | stiff
    for name, start in kinds.items():
        fails = [kind for kind in ENV_POLICY_MAP if not run(start, kind).done]
        print(f"kinds of tasks, {name}: {len(fails)} of {len(ENV_POLICY_MAP)} are not done: {', '.join(fails)}")


def main() -> None:
    """Run and draw."""
    stiction.mujoco.compat()
    if "--count" in sys.argv:
        count()
        return
    careful = scenes.length(scenes.grip(scenes.CAREFUL, STEP, 1.0, LASTS)[1][-1])
    below = f"half speed, steps of 2 ms; MuJoCo with elliptic cones, impratio 100 and noslip: {careful} at 1.00"
    words = "Held by friction: 0.90, 1.00 and 1.10 of what the weight needs", "MuJoCo, default", below
    film("gripper", words, (grippers(scenes.DEFAULT), grippers(scenes.HERE)), EVERY * STEP, SLOW)

    soft, stiff, here = (run(STARTS[name]) for name in ("as metaworld sets it", "impratio 100", "stiction"))
    below = f"real time; slid since {STILL / 80:g} s; metaworld's cones are elliptic; "
    below += f"with impratio 100 MuJoCo's end is {scenes.length(stiff.slid[-1])}"
    words = "Metaworld's task “hammer”, done by metaworld's own policy", "MuJoCo, as metaworld sets it", below
    film("hammer", words, (hammer(soft), hammer(here)), FRAMES / 80, 1)


if __name__ == "__main__":
    main()
