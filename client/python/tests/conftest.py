from __future__ import annotations

import pytest
from fake import Fake, serve

from bendtwin import Client


@pytest.fixture
def fake():
    return Fake()


@pytest.fixture
def client(fake):
    server, address = serve(fake)
    with Client(address) as client:
        yield client
    server.stop(None)
