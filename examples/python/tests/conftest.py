"""Where the scenes of the repository stand."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

REPOSITORY = Path(__file__).parents[3]
SCENES = sorted((REPOSITORY / "tests/scenes").glob("*.json"))


@pytest.fixture(params=SCENES, ids=lambda path: path.stem)
def bundled(request: pytest.FixtureRequest) -> dict[str, Any]:
    """Each bundled scene."""
    found: dict[str, Any] = json.loads(request.param.read_text())
    return found


@pytest.fixture(scope="session")
def trot() -> list[dict[str, Any]]:
    """The time steps of a trotting quadruped."""
    steps: list[dict[str, Any]] = json.loads((REPOSITORY / "tests/sequences/go2_trot.json").read_text())["problems"]
    return steps
