"""The generated files are what `generate` makes now of proto/ and of the synchronous client."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1]
SOURCE = PACKAGE / "src" / "bendtwin"
BY_HAND = {"v1": set(), "aio": {"__init__.py"}}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Contents of the generated files, by folder and name."""
    if not (PACKAGE / "../../proto/bendtwin/v1").is_dir():
        pytest.skip("no proto folder beside the package")
    out = tmp_path_factory.mktemp("generated")
    env = {**os.environ, "PYTHON": sys.executable}
    subprocess.run([PACKAGE / "generate", out], check=True, env=env)
    folders = {folder: (out / "bendtwin" / folder).iterdir() for folder in BY_HAND}
    return {f: {p.name: p.read_text() for p in files} for f, files in folders.items()}


@pytest.mark.parametrize("folder", ["v1", "aio"])
def test_generated_files_are_current(made, folder):
    names = {p.name for p in (SOURCE / folder).glob("*.py*")} - BY_HAND[folder]
    kept = {name: (SOURCE / folder / name).read_text() for name in names}
    assert kept == made[folder], "run client/python/generate and commit what it writes"
