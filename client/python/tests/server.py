"""A real `bendtwin` server for tests, named by BENDTWIN_BIN."""

import os
import subprocess
import time
from contextlib import contextmanager

import pytest

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


def run(*arguments, address=None):
    """Runs a command of the binary, with JSON as its output; returns the finished process."""
    command = [BINARY, "--json", *arguments]
    if address:
        command += ["--server", f"http://{address}"]
    return subprocess.run(command, capture_output=True, text=True)
