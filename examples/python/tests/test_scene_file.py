"""Scene files: what is written is read, what is wrong is refused by name, and the schema knows all of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import stiction

from conftest import REPOSITORY, SCENES
from judge import read

SCHEMA = json.loads((REPOSITORY / "src/guide/scene.schema.json").read_text())
MIXED = sorted((REPOSITORY / "tests/mixed").glob("*.json"))
SEQUENCES = sorted((REPOSITORY / "tests/sequences").glob("*.json"))
SCENE: dict[str, Any] = {
    "n_dof": 2,
    "n_contacts": 1,
    "dim": 2,
    "M": [[2.0, 0.0], [0.0, 2.0]],
    "H": [[0.0, 1.0], [1.0, 0.0]],
    "free_impulse": [0.03, -0.02],
    "w": [0.0, 0.0],
    "mu": [0.5],
}


@pytest.fixture
def refused(tmp_path: Path) -> Any:
    """What is said of a scene in which something is changed."""

    def complaint(changes: dict[str, Any], gone: str = "", named_by_the_schema: bool = True) -> str:
        path = tmp_path / "scene.json"
        path.write_text(json.dumps({key: value for key, value in (SCENE | changes).items() if key != gone}))
        with pytest.raises(ValueError) as error:
            stiction.load(path)
        if named_by_the_schema:
            assert not jsonschema.Draft202012Validator(SCHEMA).is_valid(json.loads(path.read_text()))
        return str(error.value)

    return complaint


def test_all_bundled_files_follow_the_schema() -> None:
    for path in [*SCENES, *MIXED, *SEQUENCES]:
        jsonschema.validate(json.loads(path.read_text()), SCHEMA)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_bundled_scenes_are_read(path: Path) -> None:
    scene = stiction.load(path)
    for found, expected in zip(scene.values(), read(json.loads(path.read_text())), strict=True):
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("path", MIXED, ids=lambda path: path.stem)
def test_what_is_saved_is_loaded(path: Path, tmp_path: Path) -> None:
    scene = stiction.load(path)
    stiction.save(tmp_path / "copy.json", **scene, h=0.002)
    copy = stiction.load(tmp_path / "copy.json")
    assert copy.keys() == scene.keys()
    first, second = stiction.solve(**scene, tol=1e-9), stiction.solve(**copy, tol=1e-9)
    assert first.status is second.status and first.status in (stiction.Status.SOLVED, stiction.Status.INFEASIBLE)
    np.testing.assert_array_equal(first.v, second.v)
    written = json.loads((tmp_path / "copy.json").read_text())
    jsonschema.validate(written, SCHEMA)
    assert written["h"] == 0.002 and "f" not in written


def test_a_sequence_is_read_step_by_step() -> None:
    path = REPOSITORY / "tests/sequences/go2_trot.json"
    steps = stiction.load_sequence(path)
    assert len(steps) == len(json.loads(path.read_text())["problems"])
    assert all(stiction.solve(**step, tol=1e-6).solved for step in steps)
    with pytest.raises(ValueError, match="^problems: this is a sequence"):
        stiction.load(path)
    with pytest.raises(ValueError, match="^problems: this is one scene"):
        stiction.load_sequence(SCENES[0])


def test_what_is_wrong_is_named(refused: Any) -> None:
    for key in SCHEMA["else"]["required"]:
        assert refused({}, gone=key) == f"{key}: it is missing"
    assert refused({}, gone="free_impulse").startswith("free_impulse: it is missing")
    assert refused({"f": [-0.03, 0.02]}).startswith("free_impulse and f: ")
    assert refused({"rows": []}) == "rows: a scene file has no such key"
    joint = {"kind": "limit", "row": [1.0, 0.0], "offset": 0.0, "mu": 1.0}
    assert refused({"joints": [joint]}) == "joints: mu: a scene file has no such key"
    assert refused({"joints": [joint | {"kind": "motor"}]}) == "joints: mu: a scene file has no such key"
    del joint["mu"]
    assert refused({"joints": [joint | {"kind": "motor"}]}) == "joints: kind 'motor' is not limit, equality or box"
    assert refused({"joints": [joint | {"row": [1.0]}]}, named_by_the_schema=False) == "joints: row: shape [1, 1] is not [1, 2]"
    assert refused({"joints": [joint | {"kind": "box"}]}, named_by_the_schema=False) == "joints: lower: it is missing"
    assert refused({"w": [0, "a"]}).startswith("w: these are not numbers")
    assert refused({"mu": 0.8}) == "mu: shape [] is not [1]"
    assert refused({"n_dof": 2.5}) == "n_dof: 2.5 is no number of them"
    assert refused({"h": 0.0}) == "h: 0.0 is no time step"
    assert refused({"mu": []}, named_by_the_schema=False) == "mu: shape [0] is not [1]"


def test_both_signs_are_one_scene(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text(json.dumps({**{key: value for key, value in SCENE.items() if key != "free_impulse"}, "f": [-0.03, 0.02]}))
    negative = stiction.load(path)
    path.write_text(json.dumps(SCENE))
    np.testing.assert_array_equal(negative["free_impulse"], stiction.load(path)["free_impulse"])
    solution = stiction.solve(**negative, tol=1e-9)
    np.testing.assert_allclose(solution.v, [0.01, 0.0], atol=1e-12)  # 0.03 - 0.5 · 0.02 of 2 kg
