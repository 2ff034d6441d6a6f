"""Opens the page in a browser, moves its sliders, and compares where things let go with the answers on paper.

Usage: test.py FOLDER. The folder is that of `examples/web/build`; Playwright and Debian's Chromium are needed.
"""

import functools
import http.server
import math
import pathlib
import re
import sys
import threading
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Page, sync_playwright

GRAVITY = 9.81
RECORD = pathlib.Path(__file__).parents[1] / "python/tests/trot.txt"
STICK, SLIP = 1, 2


class Quiet(http.server.SimpleHTTPRequestHandler):
    """A server without a log."""

    def log_message(self, format: str, *args: object) -> None:
        """Says nothing."""


def move(page: Page, slider: str, value: float) -> None:
    """Moves a slider by a click near the value and by arrow keys from there."""
    handle = page.locator(f"#{slider}")
    least, most, step = (float(handle.get_attribute(name) or 0) for name in ("min", "max", "step"))
    box = handle.bounding_box()
    assert box
    share = (value - least) / (most - least)
    handle.click(position={"x": 8 + share * (box["width"] - 16), "y": box["height"] / 2})
    steps = round((value - float(handle.input_value())) / step)
    for _ in range(abs(steps)):
        handle.press("ArrowRight" if steps > 0 else "ArrowLeft")
    assert abs(float(handle.input_value()) - value) < step / 2, f"{slider} is at {handle.input_value()}, not at {value}"


def run(page: Page, steps: int) -> dict[str, Any]:
    """Takes steps of 2 ms; the page has to have solved them."""
    state: dict[str, Any] = page.evaluate("steps => stiction.step(steps)", steps)
    assert state["solved"], state
    return state


def begin(page: Page, scene: str, **sliders: float) -> None:
    """Begins a scene with these sliders, at rest."""
    page.get_by_role("tab", name=scene).click()
    for slider, value in sliders.items():
        move(page, slider, value)
    page.click("#reset")


def bisect(page: Page, slider: str, least: float, most: float, gives_way: Callable[[], bool]) -> tuple[float, float]:
    """The two neighbouring places of a slider between which something gives way, each tried from the beginning."""
    step = float(page.get_attribute(f"#{slider}", "step") or 0)
    low, high = round(least / step), round(most / step)

    def tried(place: int) -> bool:
        move(page, slider, place * step)
        page.click("#reset")
        return gives_way()

    below = tried(low)
    assert tried(high) != below, f"the same at {least} and at {most}"
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if tried(middle) == below else (low, middle)
    return low * step, high * step


def between(what: str, ends: tuple[float, float], paper: float) -> None:
    """The answer on paper is between two neighbouring places of the slider."""
    print(f"{what}: between {ends[0]:.2f} and {ends[1]:.2f}, on paper {paper:.3f}")
    assert ends[0] <= paper <= ends[1], what


def check_slope(page: Page) -> None:
    """The box lets go at the angle of friction, in either number type, and a push moves that angle."""

    def slides() -> bool:
        state = run(page, 1000)
        assert state["modes"][0] == state["modes"][1]
        return bool(state["modes"][0] == SLIP and state["positions"][0] < -1e-5)

    for mu, single in ((0.3, False), (0.62, False), (0.5, True)):
        begin(page, "Box on a slope", mu=mu)
        page.locator("#single").set_checked(single)
        ends = bisect(page, "slope", 0, 45, slides)
        between(f"slope at mu {mu}{' in f32' if single else ''} (°)", ends, math.degrees(math.atan(mu)))
    page.locator("#single").set_checked(False)
    begin(page, "Box on a slope", mu=0.4, push=10)
    angle = math.atan(0.4)
    paper = angle + math.asin(10 * math.cos(angle) / (5 * GRAVITY))
    between("slope with a push of 10 N (°)", bisect(page, "slope", 0, 45, slides), math.degrees(paper))


def check_leg(page: Page) -> None:
    """The foot slips at a pull of mu times the weight; below, the torques are those on paper."""
    weight = (8.0 + 0.6 + 0.2) * GRAVITY
    for mu in (0.4, 0.7):
        begin(page, "Leg", mu=mu)
        ends = bisect(page, "pull", 10, 80, lambda: bool(run(page, 2000)["modes"][2] == SLIP))
        between(f"pull at mu {mu} (N)", ends, mu * weight)
    begin(page, "Leg", mu=0.7, pull=40, height=0.4)
    state = run(page, 3000)
    numbers = state["numbers"]
    for name in ("normal", "friction", "hip", "knee"):
        label, computed, paper, unit = numbers[name]
        print(f"{label}: {computed:.4f} {unit}, on paper {paper:.4f}")
        assert abs(computed - paper) < 1e-4, label
    # As moments about the joints: the pull at the height of the hip, and the weight of the leg.
    _, height, hip, knee, _ = state["positions"]
    thigh, shank = 0.35 * math.sin(hip), 0.35 * math.sin(hip + knee)
    hip_torque = 40 * height - weight * (thigh + shank) + GRAVITY * (0.6 * thigh + 0.2 * (thigh + shank))
    assert abs(numbers["hip"][1] - hip_torque) < 1e-4


def check_gripper(page: Page) -> None:
    """The block falls at a squeeze of m g / (2 mu)."""
    for mu, mass in ((0.6, 1.0), (0.45, 0.8)):
        begin(page, "Gripper", mu=mu, mass=mass)
        ends = bisect(page, "squeeze", 2, 30, lambda: bool(run(page, 1000)["positions"][1] < -1e-5))
        between(f"squeeze at mu {mu}, {mass} kg (N)", ends, mass * GRAVITY / (2 * mu))


def check_pointer(page: Page) -> None:
    """The pointer pulls the box down the slope and lets it go."""
    begin(page, "Box on a slope", slope=10, mu=0.5)
    before = run(page, 200)["positions"][0]
    box = page.locator("#scene").bounding_box()
    assert box
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] - 120, middle[1] + 20, steps=5)
    moved = run(page, 400)["positions"][0]
    page.mouse.up()
    run(page, 400)
    rests = run(page, 400)
    print(f"pulled by {before - moved:.3f} m")
    assert moved < before - 0.1
    assert rests["modes"][:2] == [STICK, STICK]


def check_bits(page: Page) -> None:
    """The fingerprint is that of the record, and so are all steps."""
    lines = RECORD.read_text().splitlines()
    digits = "".join(re.findall(r"\b[0-9a-f]{8}\b", "\n".join(lines)))
    print_of = 0xCBF29CE484222325
    for digit in digits.encode():
        print_of = (print_of ^ digit) * 0x100000001B3 % 2**64
    here, chip = page.inner_text("#here"), page.inner_text("#chip")
    print(f"fingerprint {here}, recorded {print_of:016x}")
    assert here == chip == f"{print_of:016x}"
    assert page.inner_text("#same") == f"{len(lines)} of {len(lines)}"


def main(folder: str) -> None:
    """Serves the folder and checks the page."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        errors: list[str] = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(f"http://127.0.0.1:{server.server_port}/?paused")
        page.wait_for_function("window.stiction")
        for check in (check_bits, check_slope, check_leg, check_gripper, check_pointer):
            check(page)
        page.set_viewport_size({"width": 390, "height": 800})
        assert page.evaluate("document.documentElement.scrollWidth") <= 390, "wider than a phone"
        assert not errors, errors
        browser.close()
    server.shutdown()


if __name__ == "__main__":
    main(sys.argv[1])
