"""The Python of docs/use/robot-recordings.md, one block after the other, against a real server."""

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest
from server import needs_server, running

pytest.importorskip("av")
pytest.importorskip("pyarrow")
from robot_recordings import write_lerobot, write_masks

PAGE = Path(__file__).parents[3] / "docs" / "use" / "robot-recordings.md"

pytestmark = [
    needs_server,
    pytest.mark.skipif(not PAGE.is_file(), reason="no docs folder beside the package"),
]


def test_an_episode_becomes_a_twin(filmed, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    made = filmed
    write_lerobot(made, tmp_path / "rope_dataset")
    write_masks(made, tmp_path / "masks")
    calibration = {}
    (tmp_path / "tracks").mkdir()
    for i, camera in enumerate(made.cameras):
        (tmp_path / "masks" / str(i)).rename(tmp_path / "masks" / f"cam{i}")
        points, visible = camera["tracks"]
        points = np.where(visible[..., None], points, np.nan)
        np.save(tmp_path / "tracks" / f"cam{i}.npy", points)
        lens, pose = camera["intrinsics"], np.eye(4)
        pose[:3] = np.column_stack([camera["pose"]["rotation"], camera["pose"]["translation"]])
        numbers = [lens[name] for name in ("fx", "fy", "cx", "cy")]
        calibration[f"cam{i}"] = {"intrinsics": numbers, "pose": pose.tolist()}
    (tmp_path / "cameras.json").write_text(json.dumps(calibration))
    page, names = PAGE.read_text(), {}
    snippets = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    with running(tmp_path) as address:
        for snippet in snippets:
            line = page[: page.index(snippet)].count("\n")
            code = snippet.replace("127.0.0.1:7070", address)
            exec(compile("\n" * line + code, os.fspath(PAGE), "exec"), names)
    # The gripper is a hand of the twin, where the hand held the rope.
    assert names["geometry"].hand_count == 1
    assert np.linalg.norm(names["held"] - made.poses[0, :3]) < 0.03
    assert 0.05 < names["rise"] < 0.3
    assert "nodes, held at" in capsys.readouterr().out
