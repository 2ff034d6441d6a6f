from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from conftest import SCENES


def test_the_table_has_all_scenes(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "stiction", "--repeat", "1"]
    lines = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True).stdout.splitlines()[1:]
    assert [line.split()[0] for line in lines] == [path.stem for path in SCENES]
    endings = {line.split()[0]: line.split()[-1] for line in lines}
    assert endings.pop("infeasible_squeeze") == "infeasible"
    assert endings["box_slide_spin"] == "~~~~" and all(set(ending) <= set("=~o") for ending in endings.values())
