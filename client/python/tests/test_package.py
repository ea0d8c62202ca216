"""Names that modules of the package list."""

import importlib

import pytest


@pytest.mark.parametrize("module", ["bendtwin", "bendtwin.planners", "bendtwin.aio"])
def test_every_listed_name_is_there(module):
    names = {}
    exec(f"from {module} import *", names)
    missing = set(getattr(importlib.import_module(module), "__all__", ())) - names.keys()
    assert not missing
