"""A real `bendtwin` server for tests, named by BENDTWIN_BIN."""

import os
import subprocess
import time
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest

from bendtwin import Client

BINARY = os.environ.get("BENDTWIN_BIN")
START_S = 60

needs_server = pytest.mark.skipif(not BINARY, reason="BENDTWIN_BIN names no binary")


@contextmanager
def running(folder):
    """The address of a server with one worker, whose data is in a folder."""
    port_file = folder / "port"
    command = [BINARY, "server", "--listen", "127.0.0.1:0", "--port-file", port_file]
    with (folder / "log").open("w") as log:
        server = subprocess.Popen([*command, "--data-dir", folder / "data"], stdout=log, stderr=log)
    try:
        deadline = time.monotonic() + START_S
        while not port_file.exists() or not port_file.read_text().strip():
            assert server.poll() is None, (folder / "log").read_text()
            assert time.monotonic() < deadline, "the server does not start"
            time.sleep(0.05)
        yield f"127.0.0.1:{port_file.read_text().strip()}"
    finally:
        server.terminate()
        server.wait(START_S)


def make_rope(path):
    """Makes a small recording of a rope."""
    subprocess.run([BINARY, "capture", "make", "rope", path, "--tiny"], check=True)


@contextmanager
def with_rope(folder):
    """A running server, with a draft of a short recording of a rope, and its control points at rest
    as a nominal plan of three knots."""
    make_rope(folder / "rope.zip")
    settings = {
        "graph": {"max_nodes": 30},
        "search": {"generations": 3, "population": 6},
        "refine": {"passes": 2},
    }
    with running(folder) as address, Client(address) as client:
        capture = client.wait_for_capture(client.upload_capture(folder / "rope.zip"))
        twin = client.twin(client.wait(client.fit(capture.name, settings), timeout_s=120).twin)
        controls = twin.geometry().controls
        nominal = np.repeat(controls[None, None], 3, axis=1)
        yield SimpleNamespace(
            address=address, client=client, twin=twin, controls=controls, nominal=nominal
        )


def run(*arguments, address=None):
    """Runs a command of the binary, with JSON as its output; returns the finished process."""
    command = [BINARY, "--json", *arguments]
    if address:
        command += ["--server", f"http://{address}"]
    return subprocess.run(command, capture_output=True, text=True)
