from __future__ import annotations

import pytest
from fake import Fake, serve
from server import with_rope

from bendtwin import Client


@pytest.fixture(scope="session", autouse=True)
def state(tmp_path_factory):
    """Servers of the tests leave their tokens here, not in the user's own folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        patch.delenv("BENDTWIN_TOKEN", raising=False)
        yield


@pytest.fixture(scope="session")
def rope(tmp_path_factory):
    """A running server with a draft of a rope, which several modules share."""
    with with_rope(tmp_path_factory.mktemp("rope")) as rope:
        yield rope


@pytest.fixture(scope="session")
def filmed(tmp_path_factory):
    """A simulated recording of a robot that lifts a rope."""
    from robot_recordings import simulated

    return simulated(tmp_path_factory.mktemp("filmed"))


@pytest.fixture
def fake():
    return Fake()


@pytest.fixture
def client(fake):
    server, address = serve(fake)
    with Client(address) as client:
        yield client
    server.stop(None)
