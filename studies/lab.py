"""Laboratory of the studies in Python: a server in a temporary folder, made scenes and their twins.

A twin may be kept as a file between runs, so that controllers are compared on the same twins.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from bendtwin import BendTwinError, Client, Returns, Settled, State, Twin, Vary, World

_START_S = 60


def binary(given: str | None = None) -> Path:
    """The program `bendtwin`: the one given, that of BENDTWIN_BIN, or the one on the path.

    Raises:
        SystemExit: If there is none.
    """
    name = given or os.environ.get("BENDTWIN_BIN") or shutil.which("bendtwin")
    if name is None or not Path(name).is_file():
        sys.exit("no program bendtwin: name it with --bin, or in BENDTWIN_BIN")
    return Path(name).resolve()


class Lab:
    """A running server, and the twins that were made there."""

    def __init__(self, program: Path, client: Client, folder: Path, kept: Path | None) -> None:
        self.client = client
        self._program, self._folder, self._kept = program, folder, kept
        self._twins: dict[str, Twin] = {}

    def twin(self, name: str, settings: dict[str, Any], capture: Callable[[], Path]) -> Twin:
        """The twin of a name: fitted to a capture with these settings, unless it is there."""
        if name not in self._twins:
            file = self._kept / f"{name}.safetensors" if self._kept else None
            if file is not None and file.exists():
                twin = self.client.import_twin(file, display_name=name)
            else:
                twin = self._fitted(name, settings, capture())
                if file is not None:
                    file.parent.mkdir(parents=True, exist_ok=True)
                    self.client.export_twin(twin.name, file)
            self._twins[name] = twin
        return self._twins[name]

    def made(self, scene: str, *, tiny: bool = False, mass_kg: float | None = None) -> Path:
        """The capture of a made scene, as a ZIP archive; with a mass its forces are newtons."""
        path = self._folder / f"{scene}{'-tiny' if tiny else ''}.zip"
        if not path.exists():
            command = [self._program, "capture", "make", scene, path, *["--tiny"] * tiny]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            if mass_kg is not None:
                _weigh(path, mass_kg)
        return path

    def _fitted(self, name: str, settings: dict[str, Any], path: Path) -> Twin:
        began = time.monotonic()
        capture = self.client.upload_capture(path)
        self.client.wait_for_capture(capture)
        fit = self.client.wait(self.client.fit(capture.name, settings, display_name=name))
        print(f"{name}: fitted in {time.monotonic() - began:.0f} s", file=sys.stderr)
        return self.client.twin(fit.twin)


@contextmanager
def open_lab(program: Path, *, kept: Path | None = None, cores: int | None = None) -> Iterator[Lab]:
    """A laboratory whose server lives in a temporary folder until the end.

    Args:
        program: The binary.
        kept: A folder in which twins are found again, and left; none by default.
        cores: The number of CPU cores that the server and its worker may use; all by default.
    """
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="bendtwin-lab-")))
        address = stack.enter_context(_server(program, folder, cores))
        client = stack.enter_context(Client(address))
        _await_worker(client)
        yield Lab(program, client, folder, kept)


@contextmanager
def _server(program: Path, folder: Path, cores: int | None) -> Iterator[str]:
    port_file, log_file = folder / "port", folder / "log"
    command = [program, "server", "--listen", "127.0.0.1:0", "--port-file", port_file]
    with log_file.open("w") as log:
        server = subprocess.Popen(
            [*_on(cores), *command, "--data-dir", folder / "data"],
            stdout=log,
            stderr=log,
            cwd=folder,
        )
    try:
        deadline = time.monotonic() + _START_S
        while not (port_file.exists() and port_file.read_text().strip()):
            if server.poll() is not None or time.monotonic() > deadline:
                sys.exit(f"the server does not start:\n{log_file.read_text()}")
            time.sleep(0.05)
        yield f"127.0.0.1:{port_file.read_text().strip()}"
    finally:
        server.terminate()
        server.wait(_START_S)


def _await_worker(client: Client) -> None:
    """A twin that is kept needs no fit, which would wait for a worker."""
    deadline = time.monotonic() + _START_S
    while not any(client.workers()):
        if time.monotonic() > deadline:
            sys.exit("the server starts no worker")
        time.sleep(0.05)


def _on(cores: int | None) -> list[str]:
    """Command that confines what follows it to some cores of those that are allowed."""
    if cores is None or not hasattr(os, "sched_getaffinity") or shutil.which("taskset") is None:
        return []
    allowed = sorted(os.sched_getaffinity(0))[:cores]
    return ["taskset", "--cpu-list", ",".join(map(str, allowed))]


def at_rest(twin: Twin, *, world: World | None = None, vary: Vary | None = None) -> State:
    """The state in which a twin lies, held: settled, or after three seconds of lying there."""
    geometry = twin.geometry()
    around: Any = {
        "trajectories": np.stack([geometry.controls] * 2)[None],
        "world": world,
        "vary": vary,
        "returns": Returns(final_state=True),
    }
    try:
        return twin.rollout(**around, frames=1, initial=Settled()).state(0)
    except BendTwinError as error:
        if error.reason != "NEVER_AT_REST":
            raise
    return twin.rollout(**around, frames=round(3 * geometry.fps)).state(0)


def _weigh(path: Path, mass_kg: float) -> None:
    """Writes the mass of the object into a capture."""
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    about = json.loads(files["capture.json"])
    about["mass_kg"] = mass_kg
    files["capture.json"] = json.dumps(about).encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
