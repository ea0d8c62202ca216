"""Names that modules of the package list, which programs import."""

import importlib
from pathlib import Path

import pytest

pytest.importorskip("gymnasium")

MODULES = [
    "bendtwin",
    "bendtwin.aio",
    "bendtwin.coupling",
    "bendtwin.envs",
    "bendtwin.planners",
    "bendtwin.robots",
]


def test_the_public_names_are_these():
    names = [f"{m}.{name}" for m in MODULES for name in sorted(importlib.import_module(m).__all__)]
    known = (Path(__file__).parent / "public_names.txt").read_text().splitlines()
    assert names == known, "change public_names.txt on purpose only: programs import these names"


@pytest.mark.parametrize("module", MODULES)
def test_every_listed_name_is_there(module):
    names = {}
    exec(f"from {module} import *", names)
    missing = set(importlib.import_module(module).__all__) - names.keys()
    assert not missing
