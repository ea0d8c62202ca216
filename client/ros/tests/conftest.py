"""Servers and twins by hand are those of the tests of the client."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).parents[1]
CLIENT = ROOT.parent / "python"

for folder in (CLIENT / "tests", ROOT / "bendtwin_ros"):
    sys.path.insert(0, str(folder))


@pytest.fixture(scope="session", autouse=True)
def state(tmp_path_factory):
    """Servers of the tests leave their tokens here, not in the user's own folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        patch.delenv("BENDTWIN_TOKEN", raising=False)
        yield


@pytest.fixture(scope="session")
def server(tmp_path_factory):
    """A server with two twins by hand: a sheet that one hand drags, and a cable in two hands."""
    from scenes import dragged
    from server import running

    from bendtwin import Client
    from made_ros import cable_file

    folder = tmp_path_factory.mktemp("server")
    (folder / "sheet.twin").write_bytes(dragged()[0].encode())
    (folder / "cable.twin").write_bytes(cable_file().encode())
    with running(folder) as address, Client(address) as client:
        yield SimpleNamespace(
            address=address,
            client=client,
            sheet=client.import_twin(folder / "sheet.twin"),
            cable=client.import_twin(folder / "cable.twin"),
        )
