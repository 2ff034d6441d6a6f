from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiction

from conftest import REPOSITORY, SCENES


def test_the_table_has_all_scenes(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "stiction", "--repeat", "1"]
    lines = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True).stdout.splitlines()[1:]
    assert [line.split()[0] for line in lines] == [path.stem for path in SCENES]
    endings = {line.split()[0]: line.split()[-1] for line in lines}
    assert endings.pop("infeasible_squeeze") == "INFEASIBLE"
    assert endings["box_slide_spin"] == "~~~~" and all(set(ending) <= set("=~o") for ending in endings.values())


def blocks(path: Path) -> list[str]:
    return re.findall(r"```python\n(.*?)```", path.read_text(), re.DOTALL)


PAGES = sorted(path for path in (REPOSITORY / "src/guide").glob("*.md") if blocks(path))


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_the_python_of_the_guide_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "examples").symlink_to(REPOSITORY / "examples")
    monkeypatch.chdir(tmp_path)
    if page.stem == "pinocchio":
        pytest.importorskip("pinocchio")  # it has no wheel for Windows
    names: dict[str, Any] = {}
    for block in blocks(page):
        exec(block, names)


def test_the_code_of_the_readme_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    folder = Path(__file__).parents[1]
    monkeypatch.chdir(folder)
    found = blocks(folder / "README.md")
    names: dict[str, Any] = {}
    steppers = []
    for block in found:
        exec(block, names)
        if "Stepper(" in block:
            steppers.append(names["stepper"])
    assert len(found) == 7
    assert names["solution"].solved and names["solution"].modes[0] == stiction.Mode.SLIP
    leg = names["leg"]
    assert leg.solved and leg.row_impulses[0] / names["h"] == pytest.approx(-30.0)
    assert leg.row_modes.tolist() == [stiction.RowMode.AT_LOWER, stiction.RowMode.AT_LIMIT]
    assert names["change"].facts.has_unique_impulses and names["gradient"].mu[0] < 0
    assert len(steppers) == 2 and all(stepper.steps > 900 and stepper.unsolved == 0 for stepper in steppers)
    data = names["data"]  # of a pole that stands, and lies without its regulator
    assert np.abs(data.qpos).max() < 1e-3 and names["facts"].margin > 0.5
    data.qvel[3], data.ctrl[:] = 0.2, 0.0
    steppers[-1].step(data, 200)
    assert np.abs(data.qpos).max() > 1.0
