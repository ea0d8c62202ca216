"""Environment steps per second.

python -m bendtwin.envs.benchmark --twin object.twin --envs 64
python -m bendtwin.envs.benchmark --server http://127.0.0.1:7070 --twin twins/... --pictures 96

Without `--server` it starts one in a temporary folder, with the program of `--bin`; without
`--twin` it makes the recording of a scene and fits a draft of it. A step is a frame of the twin
unless `--frames` says otherwise. Actions are random; episodes that end begin again, which counts as
part of their steps.
"""

from __future__ import annotations

import argparse
import cProfile
import json
import os
import pstats
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from bendtwin.client import Client
from bendtwin.envs.actions import Actions
from bendtwin.envs.observations import Observations
from bendtwin.envs.randomisation import Randomisation
from bendtwin.envs.registry import make
from bendtwin.envs.vector_env import TwinVectorEnv
from bendtwin.twin import Twin

_START_S = 60.0


def main(arguments: list[str] | None = None) -> None:
    """Measures, and prints a line, or JSON."""
    given = _parser().parse_args(arguments)
    with ExitStack() as stack:
        server = given.server or stack.enter_context(
            _server(_program(given.bin), given.server_options)
        )
        client = stack.enter_context(Client(server))
        twin = _twin(client, given)
        cameras = ["front", "side", "top"][: given.cameras] if given.pictures else []
        env = make(
            given.task,
            twin,
            num_envs=given.envs,
            actions=Actions(frames=given.frames),
            observations=Observations(
                cameras=cameras, width=given.pictures or 96, height=given.pictures or 96
            ),
            randomisation=Randomisation(mass=(0.9, 1.1)) if given.randomise else None,
            horizon=given.horizon,
            fidelity=given.fidelity,
        )
        stack.callback(env.close)
        profile = cProfile.Profile() if given.profile else None
        measured = measure(env, given.seconds, profile)
        geometry = twin.geometry()
        measured |= {
            "task": given.task,
            "envs": given.envs,
            "nodes": len(geometry.rest_positions),
            "substeps": geometry.substeps,
            "frames": given.frames,
            "pictures": f"{len(cameras)} x {given.pictures} x {given.pictures}"
            if cameras
            else "none",
        }
    print(json.dumps(measured) if given.json else _line(measured))
    if profile is not None:
        pstats.Stats(profile).sort_stats("cumulative").print_stats(25)


def measure(
    env: TwinVectorEnv, seconds: float, profile: cProfile.Profile | None = None
) -> dict[str, Any]:
    """Steps environments for a time, after a few steps that do not count."""
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(16)]
    for i in range(3):
        env.step(actions[i])
    times: list[float] = []
    if profile is not None:
        profile.enable()
    begin = time.perf_counter()
    while not times or time.perf_counter() - begin < seconds:
        last = time.perf_counter()
        env.step(actions[len(times) % len(actions)])
        times.append(time.perf_counter() - last)
    took = time.perf_counter() - begin
    if profile is not None:
        profile.disable()
    return {
        "steps_per_s": round(len(times) * env.num_envs / took, 1),
        "step_ms": round(1e3 * float(np.median(times)), 3),
        "p99_ms": round(1e3 * float(np.quantile(times, 0.99)), 3),
        "steps": len(times) * env.num_envs,
    }


def _line(measured: dict[str, Any]) -> str:
    return (
        f"{measured['steps_per_s']:.0f} steps/s: {measured['envs']} environments of "
        f"{measured['task']}, {measured['nodes']} nodes, {measured['substeps']} substeps, "
        f"{measured['frames']} frames a step, pictures: {measured['pictures']}; a step of all "
        f"takes {measured['step_ms']:.2f} ms (median), {measured['p99_ms']:.2f} ms (p99)"
    )


@contextmanager
def _server(program: str, options: str) -> Iterator[str]:
    """A server with an empty data folder."""
    with tempfile.TemporaryDirectory() as folder:
        port = Path(folder) / "port"
        command = [program, "server", "--listen", "127.0.0.1:0", "--port-file", str(port)]
        command += ["--data-dir", str(Path(folder) / "data")]
        command += options.split()
        server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            deadline = time.monotonic() + _START_S
            while not port.exists() or not port.read_text().strip():
                if server.poll() is not None or time.monotonic() > deadline:
                    raise SystemExit(f"{program} does not start")
                time.sleep(0.05)
            yield f"http://127.0.0.1:{port.read_text().strip()}"
        finally:
            server.terminate()
            server.wait()


def _twin(client: Client, given: argparse.Namespace) -> Twin:
    """The twin of a file or of the server, or a draft of a simulated recording."""
    if given.twin is not None and Path(given.twin).is_file():
        return client.import_twin(given.twin)
    if given.twin is not None:
        return client.twin(given.twin)
    settings = {
        "graph": {"max_nodes": given.nodes},
        "search": {"generations": 3, "population": 6},
        "refine": {"passes": 0},
    }
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / f"{given.scene}.zip"
        command = [_program(given.bin), "capture", "make", given.scene, str(recording)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        capture = client.wait_for_capture(client.upload_capture(recording))
    return client.twin(client.wait(client.fit(capture.name, settings)).twin)


def _program(given: str | None) -> str:
    program = given or os.environ.get("BENDTWIN_BIN") or shutil.which("bendtwin")
    if program is None:
        raise SystemExit("there is no program `bendtwin`: give --bin")
    return program


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m bendtwin.envs.benchmark", description="Environment steps per second."
    )
    parser.add_argument("--twin", help="file of a twin, or its name at the server")
    parser.add_argument("--scene", default="toy", help="without --twin: of `bendtwin capture make`")
    parser.add_argument("--nodes", type=int, default=200, help="nodes of that draft")
    parser.add_argument("--server", help="address of a running server")
    parser.add_argument(
        "--bin", help="program to start a server with [BENDTWIN_BIN, or on the path]"
    )
    parser.add_argument("--server-options", default="", help="further options of that server")
    parser.add_argument("--task", default="MoveTip")
    parser.add_argument("--envs", type=int, default=64)
    parser.add_argument("--frames", type=int, default=1, help="frames of a step")
    parser.add_argument("--horizon", type=int, default=200, help="steps of an episode")
    parser.add_argument("--fidelity", choices=["exact", "fast"], default="exact")
    parser.add_argument("--pictures", type=int, help="width and height of pictures, pixels")
    parser.add_argument("--cameras", type=int, choices=[1, 2, 3], default=1)
    parser.add_argument("--randomise", action="store_true", help="another mass in each episode")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--profile", action="store_true", help="print where Python spends its time")
    parser.add_argument("--json", action="store_true")
    return parser


if __name__ == "__main__":
    main()
