"""All settings tried, as text: `python examples/python/films/table.py` writes TABLE.md beside it."""

from __future__ import annotations

import pathlib

import mujoco
import numpy as np
import scenes

STEPS = (0.01, 0.005, 0.002, 0.001)
SHARES = (0.90, 0.98, 1.00, 1.02, 1.10)
HEAD = f"""# A cube and a gripper, in MuJoCo {mujoco.__version__} and here

Written by `films/table.py`; a picture by `films/cube.py`, a film by `films/film.py`. The models are in `models`.
`stiction` solves each step to {scenes.HERE.tolerance:g}.

## The cube

It rests on the floor for 1 s, then slides off at 6 m/s with friction 0.5. On paper it stops after 3.640 m with steps
of 10 ms (3.667 m with 1 ms), and neither lifts off nor turns over. *Off by* is the largest distance of a corner from
its place on paper, at any time. Once a cube tumbles, its figures are those of a chaotic motion: another version or
machine gets others."""
BEST = f"""
The last of MuJoCo in each table is the best of {scenes.SEARCHED:,} for this scene and step: both cones, `impratio`
0.01 to 100, `noslip` off and 50, `solref` 0.005 to 0.3 s with damping ratios 0.5 to 5, and four `solimp`. What helps
is softness, and the next table has its price. Stiffer contacts (`solimp` 0.9999) cure most of the tumbling and not the
lift; a stiffer `solref` makes both worse at short steps.

## Creep, and the time of a step

The cube lies on a slope of 20°, steps of 10 ms. `noslip` cures creep, with elliptic cones; it does not cure the lift.
Time is that of a whole step called from Python, collision and all, the median of 500, four contacts.
"""
GRIPPER = """
## The gripper

Two fingers press a block, which is carried for 0.5 s; then its weight acts for 5 s, steps of 2 ms. Columns: friction
over the critical friction m g / (2 F). On paper the block falls below 1.00 and stays from 1.00 on. At exactly 1.00
nothing is left to brake it: it slides on after the slightest push, and the errors of all steps add up. *Turned* is
the same experiment, gravity and all, in axes turned by 45° about the squeeze: on paper nothing changes, but a pyramid
holds less between its edges, and `noslip` keeps the pyramid.

The fingers touch the block along a line. With flat pads, four contacts each, the law itself has several answers at
exactly 1.00: the pressure may lie at a corner, and the block turns about it.
"""
NOT_TRIED = """
## Not tried

The solvers CG and PGS, RK4 and the implicit integrators, `margin` and `gap`, `noslip` beyond 50 iterations, single
precision (MJX, Warp).
A search like that for the cube was not made for the gripper.
"""


def row(cells: list[str]) -> str:
    """A row of a table."""
    return "| " + " | ".join(cells) + " |"


def cube(settings: list[scenes.Engine], step: float) -> list[str]:
    """One step length: what became of the cube under each setting."""
    lines = [f"\n### Steps of {1e3 * step:g} ms\n", row(["settings", "lifts, mm", "tilts, °", "stops at, m", "off by"])]
    lines.append("|---|--:|--:|--:|--:|")
    for engine in settings:
        slide = scenes.slide(engine, step)
        off = f"{1e3 * slide.off:.0f} mm" if slide.off > 0.01 else scenes.length(slide.off)
        lines.append(row([engine.name, f"{1e3 * abs(slide.lift):.1f}", f"{slide.tilt:.1f}", f"{slide.stop:.3f}", off]))
    return lines


def creep(settings: list[scenes.Engine]) -> list[str]:
    """The cube at rest on a slope."""
    lines = [row(["settings", "creep a second", "step, µs"]), "|---|--:|--:|"]
    for engine in settings:
        speed, microseconds = scenes.rest(engine, 0.01)
        lines.append(row([engine.name, scenes.length(speed), f"{microseconds:.0f}"]))
    return lines


def gripper(settings: list[scenes.Engine]) -> list[str]:
    """How far the block slides in the fingers."""
    lines = [row(["settings", "axes", *[f"{share:.2f}" for share in SHARES]]), "|---|---|" + "--:|" * len(SHARES)]
    for engine in settings:
        for turned, axes in ((0.0, "upright"), (np.pi / 4, "turned")):
            drops = [scenes.grip(engine, 0.002, share, 5.0, turned)[1][-1] for share in SHARES]
            lines.append(row([engine.name, axes, *[scenes.length(max(drop, 0.0)) for drop in drops]]))
    return lines


def main() -> None:
    """Run everything and write it down."""
    tried: list[scenes.Engine] = [*scenes.TRIED]
    lines, best = [HEAD], {step: scenes.best(step) for step in STEPS}
    for step in STEPS:
        lines += cube([*tried, best[step], scenes.HERE], step)
    lines += [BEST, *creep([*tried, best[0.01], scenes.HERE]), GRIPPER, *gripper([*tried, scenes.HERE]), NOT_TRIED.rstrip()]
    path = pathlib.Path(__file__).with_name("TABLE.md")
    path.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
