"""MuJoCo's viewer with this law: on a display of its own, by pictures of it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import ImageGrab

from stiction._viewer import draw_forces
from stiction.mujoco import Stepper
from stiction.view import main

MODELS = Path(__file__).parents[1] / "models"
#: A wheel that is pressed on the floor, and turned by its motor without going anywhere.
WHEEL = """<mujoco><worldbody><light pos="0 0 3"/><geom type="plane" size="2 2 0.1"/>
<body pos="0 0 0.1"><joint type="slide" axis="0 0 1"/><joint name="axle" axis="0 1 0"/>
<geom type="sphere" size="0.1" friction="0.8"/></body></worldbody>
<actuator><velocity joint="axle" kv="10"/></actuator><keyframe><key ctrl="20"/></keyframe></mujoco>"""


def view(*arguments: str | Path, display: str = "") -> subprocess.Popen[str]:
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    command = [sys.executable, "-m", "stiction.view", *map(str, arguments)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, env={**environment, "DISPLAY": display}, text=True, **pipes)  # type: ignore[call-overload, no-any-return]


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    if shutil.which("Xvfb") is None:
        pytest.skip("Xvfb is not installed")
    # Without -noreset the server starts anew whenever its last client leaves, and turns away who comes in between.
    command = ["Xvfb", "-displayfd", "1", "-screen", "0", "800x600x24", "-noreset"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        assert server.stdout
        try:
            yield f":{server.stdout.readline().strip()}"
        finally:
            server.terminate()


@contextmanager
def watched(model: Path, display: str) -> Iterator[Callable[[Callable[[int, int], bool]], None]]:
    """A viewer, and a function that waits for a picture with such numbers of blue and of orange pixels."""
    process = view(model, display=display)

    def shows(wanted: Callable[[int, int], bool]) -> None:
        for _ in range(600):
            red, _, blue = np.moveaxis(np.asarray(ImageGrab.grab(xdisplay=display), int)[..., :3], -1, 0)
            seen = int(np.sum(blue > red + 80)), int(np.sum(red > blue + 80))
            if wanted(*seen):
                return
            assert process.poll() is None, process.stderr and process.stderr.read()
            time.sleep(0.1)
        pytest.fail(f"{seen[0]} blue and {seen[1]} orange pixels")

    with process:
        try:
            yield shows
        finally:
            process.terminate()


def test_what_sticks_is_blue(display: str) -> None:
    with watched(MODELS / "quadruped.xml", display) as shows:
        shows(lambda blue, orange: blue > 100 and orange == 0)


def test_what_slips_is_orange_and_space_changes_the_law(display: str, tmp_path: Path) -> None:
    model = tmp_path / "wheel.xml"
    model.write_text(WHEEL)
    with watched(model, display) as shows:
        for wanted in (True, False, True):
            shows(lambda blue, orange, wanted=wanted: blue == 0 and (orange > 100) == wanted)  # type: ignore[misc]
            if shutil.which("xdotool") is None:
                pytest.skip("xdotool is not installed: no key was pressed")
            subprocess.run(["xdotool", "key", "space"], env={**os.environ, "DISPLAY": display}, check=True)


def test_it_ends_with_its_counters(display: str) -> None:
    process = view(MODELS / "quadruped.xml", "--for", "0.5", display=display)
    output, complaints = process.communicate()
    assert process.returncode == 0, complaints
    last = output.splitlines()[-1]  # before it counters of each second, of viewers without texts
    assert "4 stick, 0 slip" in last and "unsolved 0" in last
    steps = int(last.split("steps ")[1].split(",")[0])
    assert steps in (250, 251)


@pytest.mark.parametrize(
    ("model", "reason"),
    [
        ("<mujoco/>", "model: it has no velocities"),
        ("<mujoco>", "XML"),
        (WHEEL, "there is no display"),
    ],
)
def test_a_reason_is_one_line(model: str, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(model)
    process = view(path)
    output, complaints = process.communicate()
    assert process.returncode == 2 and output == ""
    (line,) = complaints.splitlines()
    assert line.startswith("python -m stiction.view: ") and reason in line


def test_without_mujoco_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    monkeypatch.setattr(sys, "argv", ["view", "model.xml"])
    with pytest.raises(SystemExit, match="2"):
        main()
    assert "pip install 'stiction[mujoco]'" in capsys.readouterr().err


def test_arrows_add_up_to_the_weight() -> None:
    model = mujoco.MjModel.from_xml_path(str(MODELS / "quadruped.xml"))
    data, stepper = mujoco.MjData(model), Stepper(model, tol=1e-8)
    stepper.step(data, 5000)
    scene = mujoco.MjvScene(model, 10)
    draw_forces(model, data, scene, stepper.modes)
    arrows = [scene.geoms[i] for i in range(scene.ngeom)]
    forces = sum(arrow.size[2] * arrow.mat[:, 2] for arrow in arrows)
    assert len(arrows) == 4 and np.allclose(forces, [0, 0, model.stat.extent], atol=1e-3)
    few = mujoco.MjvScene(model, 3)
    draw_forces(model, data, few)
    assert few.ngeom == 3 and len(set(few.geoms[0].rgba[:3])) == 1  # grey
