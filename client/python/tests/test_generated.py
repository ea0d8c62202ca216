"""The checked-in stubs are what `generate` makes of proto/ now."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1]


def test_stubs_are_current(tmp_path):
    if not (PACKAGE / "../../proto/bendtwin/v1").is_dir():
        pytest.skip("no proto folder beside the package")
    env = {**os.environ, "PYTHON": sys.executable}
    subprocess.run([PACKAGE / "generate", tmp_path], check=True, env=env)
    made = {p.name: p.read_text() for p in (tmp_path / "bendtwin/v1").iterdir()}
    kept = {p.name: p.read_text() for p in (PACKAGE / "src/bendtwin/v1").glob("*.py*")}
    assert kept == made, "run client/python/generate and commit what it writes"
