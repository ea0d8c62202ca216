"""TLS: a real server and a worker of another host, with certificates of a private authority."""

import os
import socket
import subprocess
from contextlib import suppress
from threading import Thread

import numpy as np
import pytest

from bendtwin import BendTwinError, Client, Returns
from bendtwin.connection.transport import tls_fault, transport

BINARY = os.environ.get("BENDTWIN_BIN")
TOKEN = "a-token-of-workers"
START_S = 60
SETTINGS = {
    "graph": {"max_nodes": 30},
    "search": {"generations": 3, "population": 6},
    "refine": {"passes": 2},
}


def bendtwin(*arguments):
    subprocess.run([BINARY, *arguments], check=True, capture_output=True)


class Processes:
    """A server that has no workers of its own, and a worker that it reaches over TLS alone."""

    def __init__(self, folder):
        self.folder, self.started = folder, []
        authority = folder / "authority"
        bendtwin("ca", "init", authority)
        for role, name in (("server", "twin"), ("worker", "gpu1")):
            order = ("--role", role, "--name", name, "--host", "127.0.0.1")
            bendtwin("ca", "issue", authority, *order)
        self.ca, self.authority = authority / "ca.pem", authority
        self.environment = {**os.environ, "XDG_STATE_HOME": str(folder / "state")}
        self.environment.pop("BENDTWIN_CA", None)
        self.environment["BENDTWIN_WORKER_TOKEN"] = TOKEN

    def start(self, *arguments):
        with (self.folder / "log").open("a") as log:
            process = subprocess.Popen(
                [BINARY, *arguments], env=self.environment, stdout=subprocess.PIPE, stderr=log
            )
        self.started.append(process)
        return process

    def server(self):
        pair = ("certificate", self.authority / "twin.pem"), ("key", self.authority / "twin.key")
        files = [word for name, path in pair for word in (f"--tls-{name}", path)]
        files += [word for name, path in pair for word in (f"--worker-tls-{name}", path)]
        process = self.start(
            *("server", "--listen", "127.0.0.1:0", "--workers", "0"),
            *("--listen-workers-tls", "127.0.0.1:0", "--worker-tls-ca", self.ca, *files),
            *("--data-dir", self.folder / "data"),
        )
        clients = process.stdout.readline().decode().split(" at ")[1].split()[0]
        workers = process.stdout.readline().decode().split(" at ")[1].strip()
        return clients, workers

    def worker(self, server):
        pair = ("--certificate", self.authority / "gpu1.pem", "--key", self.authority / "gpu1.key")
        self.start("worker", "--server", server, "--ca", self.ca, *pair, "--backend", "cpu")

    def end(self):
        for process in reversed(self.started):
            process.terminate()
            process.wait(START_S)


@pytest.fixture
def processes(tmp_path):
    processes = Processes(tmp_path)
    try:
        yield processes
    finally:
        processes.end()


@pytest.mark.skipif(not BINARY, reason="BENDTWIN_BIN names no binary")
def test_a_worker_of_another_host_fits_and_rolls_out_over_tls(processes, tmp_path):
    clients, workers = processes.server()
    assert clients.startswith("https://")
    assert workers.startswith("https://")
    token = (tmp_path / "data" / "client-token").read_text().strip()
    processes.worker(workers)

    archive = tmp_path / "rope.zip"
    bendtwin("capture", "make", "rope", archive, "--tiny")
    with Client(clients, token=token, ca=processes.ca) as client:
        capture = client.push_capture(archive)
        twin = client.twin(client.wait(client.fit(capture.name, SETTINGS), timeout_s=300).twin)
        plans = np.tile(twin.geometry().controls, (2, 2, 1, 1))
        reply = twin.rollout(trajectories=plans, frames=3, returns=Returns(final_state=True))
        assert np.isfinite(reply.final_positions).all()
        assert len(list(client.workers())) == 1

    # With the authorities of the system, under another name, and without TLS.
    other = tmp_path / "other"
    bendtwin("ca", "init", other)
    for address, ca, reason, advice in (
        (clients, other / "ca.pem", "TLS_CERTIFICATE_REFUSED", "authority"),
        (
            clients.replace("127.0.0.1", "localhost"),
            processes.ca,
            "TLS_CERTIFICATE_REFUSED",
            "host",
        ),
        (clients.replace("https", "http"), None, "TLS_REQUIRED", "https://"),
    ):
        with Client(address, token=token, ca=ca) as client:
            with pytest.raises(BendTwinError, match=advice) as refused:
                next(client.captures(), None)
            assert refused.value.reason == reason
            if reason != "TLS_REQUIRED":
                with pytest.raises(BendTwinError, match=advice):
                    client.push_capture(archive, display_name="refused")


def test_addresses_say_whether_there_is_tls(monkeypatch, tmp_path):
    monkeypatch.delenv("BENDTWIN_CA", raising=False)
    for address, target, is_https in (
        ("127.0.0.1:7070", "127.0.0.1:7070", False),
        ("http://host:7070/", "host:7070", False),
        ("https://host:7070", "host:7070", True),
        ("https://host/", "host:443", True),
        ("https://[::1]", "[::1]:443", True),
        ("https://[::1]:7070", "[::1]:7070", True),
    ):
        found = transport(address, None)
        assert (found.target, found.is_https, found.ca) == (target, is_https, None)
    monkeypatch.setenv("BENDTWIN_CA", str(tmp_path / "ca.pem"))
    assert transport("https://host", None).ca == tmp_path / "ca.pem"
    assert transport("https://host", "other.pem").ca.name == "other.pem"


def test_an_answer_of_http1_is_explained():
    """A proxy that passes HTTP/1 alone."""

    def answer(listener):
        with suppress(OSError):
            while True:
                stream, _ = listener.accept()
                with stream:
                    stream.recv(1024)
                    stream.sendall(b"HTTP/1.1 400 Bad Request\r\nconnection: close\r\n\r\n")
                    while stream.recv(1024):
                        pass

    with socket.create_server(("127.0.0.1", 0)) as listener:
        Thread(target=answer, args=(listener,), daemon=True).start()
        port = listener.getsockname()[1]
        with (
            Client(f"http://127.0.0.1:{port}") as client,
            pytest.raises(BendTwinError, match="grpc_pass") as refused,
        ):
            next(client.captures(), None)
    assert refused.value.reason == "PROXY_WITHOUT_GRPC"


def test_other_failures_are_none_of_tls():
    assert tls_fault("failed to connect to all addresses; Connection refused") is None
    expired = tls_fault("CERTIFICATE_VERIFY_FAILED: certificate has expired")
    assert expired is not None
    assert "expired" in expired[1]
    plain = tls_fault("[SSL: WRONG_VERSION_NUMBER] wrong version number (_ssl.c:1000)")
    assert plain is not None
    assert plain[0] == "TLS_NOT_SPOKEN"
