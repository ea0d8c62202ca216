"""The closed loops of studies/loops, and the measurements of contact at rest and of coupled
simulation, as commands."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import hanging
from server import BINARY, needs_server

ROOT = Path(__file__).parents[3]

pytestmark = [
    needs_server,
    pytest.mark.skipif(not (ROOT / "studies" / "loops").is_dir(), reason="no studies beside"),
]


def study(name, *options):
    """The standard output of a study that succeeds."""
    command = [sys.executable, "-m", f"studies.{name}", "--bin", Path(BINARY).resolve(), *options]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_loop_runs_with_one_command_and_again_with_the_same_result(tmp_path):
    quick = ("loops", "--quick", "--loops", "push", "--twins", tmp_path)
    found = json.loads(study(*quick, "--variants", "corrected,known", "--json"))
    corrected, known = found["episodes"]
    assert corrected["ended_by"] == known["ended_by"] == ""
    assert corrected["corrections"] == 5
    assert known["corrections"] == 0
    for episode in (corrected, known):
        assert len(episode["errors_mm"]) == len(episode["latencies_s"]["plan"]) == 5
        assert np.isfinite(episode["errors_mm"]).all()
        assert 0.0 < episode["largest_strain"] < 1.5
        # The sphere has begun to push.
        assert episode["errors_mm"][-1] < episode["errors_mm"][0]
    assert [row["variant"] for row in found["loops"]] == ["corrected", "known"]

    table = study(*quick, "--variants", "corrected", "--out", tmp_path / "again.json")
    assert "| push | corrected |" in table
    (again,) = json.loads((tmp_path / "again.json").read_text())["episodes"]
    assert again["errors_mm"] == corrected["errors_mm"]


def test_contact_at_rest_is_measured(tmp_path):
    found = json.loads(study("rest", "--scenes", "toy", "--tiny", "--json"))
    assert [row["lowered by, mm"] for row in found["lowered"]] == [0, 10, 20, 60]
    assert [row["slope, rad"] for row in found["creep"]] == [0.15, 0.255]
    assert [row["object"] for row in found["settled"]] == ["toy"]


def test_coupled_simulation_is_measured(tmp_path):
    pytest.importorskip("mujoco")
    # A twin that is there already is not fitted.
    (tmp_path / "coupling-rope-tiny.safetensors").write_bytes(hanging().encode())
    found = json.loads(study("coupling", "--quick", "--json", "--twins", tmp_path))
    cases = [(row["coupling"], row["colliders"]) for row in found["speed"]]
    assert cases == [("explicit", 0), ("explicit", 2), ("implicit", 2)]
    for row in found["speed"]:
        assert row["nodes"] == 7
        assert 0 < row["physics of the twin, ms"] < row["frame, ms"] <= row["p99, ms"]
        assert row["frames a second"] == pytest.approx(1e3 / row["frame, ms"])
    assert len(found["stability"]) == 3
    implicit = [row for row in found["stability"] if row["coupling"] == "implicit"]
    assert all(row["ended"] == "simulated after 0.2 s" for row in implicit)
