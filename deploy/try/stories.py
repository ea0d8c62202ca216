"""What people do with the containers: first steps, fits through failures, life in a fleet."""

import re
import secrets
import socket
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

from engine import Engine, Failure, Project, health, logs, until

# A fit of some seconds on an idle machine, most of it search, so that it can be disturbed.
FIT = [
    word
    for setting in (
        "compare_axial=false",
        "graph.max_nodes=40",
        "search.starts=1",
        "search.generations=60",
        "search.population=8",
        "refine.passes=8",
    )
    for word in ("--set", setting)
]
FIT_SECONDS = 300
# Longest time from readiness to the health check that finds it.
HEALTHY_SECONDS = 5


def free_port() -> int:
    """A port of this machine that nothing uses."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


def require(holds: bool, what: str) -> None:
    """Fails if an expectation does not hold."""
    if not holds:
        raise Failure(what)


def say(what: str) -> None:
    """Prints a step that has succeeded."""
    print(f"   {what}", flush=True)


def link(log: str) -> str | None:
    """The address that logs in, once a server has printed it."""
    found = re.search(r"http://127\.0\.0\.1:\d+/#/\?token=\S+", log)
    return found.group() if found else None


def opens(address: str) -> None:
    """Requires an address to show the console, and its token to be accepted."""
    page, token = address.split("#/?token=")
    with urllib.request.urlopen(page, timeout=10) as answer:
        require("<html" in answer.read().decode().lower(), f"{page} shows no page")
    request = urllib.request.Request(
        f"{page}v1/twins", headers={"Authorization": f"Bearer {token}"}
    )
    with urllib.request.urlopen(request, timeout=10) as answer:
        require(answer.status == 200, f"{page}v1/twins is refused")


def starts_well(read: Callable[[], str], state: Callable[[], str]) -> str:
    """Waits for a server to be ready and then healthy, and returns its link."""
    address = until("the server prints an address that logs in", 60, lambda: link(read()))
    ready = time.monotonic()
    until("the server is healthy", HEALTHY_SECONDS, lambda: state() == "healthy")
    say(f"healthy {time.monotonic() - ready:.1f} s after it was ready")
    warnings = [line for line in read().splitlines() if "WARN" in line or "ERROR" in line]
    require(not warnings, f"the log warns: {warnings}")
    opens(address)
    say("the printed address logs in, and the log has no warning")
    return address


def is_well(report: str) -> None:
    """Requires a report of `bendtwin doctor` without problems."""
    require("PROBLEM" not in report, f"bendtwin doctor:\n{report}")


def one_line(engine: Engine, image: str, name: str) -> None:
    """`docker run` with a port and a volume alone."""
    port = free_port()
    options = [
        "--name",
        name,
        "--detach",
        "--publish",
        f"{port}:7070",
        "--volume",
        f"{name}:/var/lib/bendtwin",
    ]
    options += ["--env", f"BENDTWIN_PUBLIC_URL=http://127.0.0.1:{port}"]
    engine("run", *options, image)
    try:
        starts_well(lambda: logs(engine, name), lambda: health(engine, name))
        is_well(engine("exec", name, "bendtwin", "doctor"))
        say("bendtwin doctor finds no problem")
        began = time.monotonic()
        engine("stop", "--time", "20", name)
        code = engine("inspect", "--format", "{{.State.ExitCode}}", name).strip()
        require(code == "0", f"it ended with {code}")
        say(f"it stops in {time.monotonic() - began:.1f} s")
    finally:
        engine("rm", "--force", name, allow=True)
        engine("volume", "rm", "--force", name, allow=True)


def begin_fit(project: Project, service: str) -> str:
    """Pushes a capture and starts a fit of it; its name."""
    made = "/tmp/rope.zip"
    project.inside(service, "bendtwin", "capture", "make", "rope", made, "--tiny")
    capture = project.json(service, "capture", "push", made)["name"]
    fit = project.json(service, "fit", "start", capture, *FIT)["name"]
    return str(fit)


def fit_of(project: Project, service: str, fit: str) -> dict[str, Any] | None:
    """A fit as a server shows it; none while the server does not answer."""
    try:
        shown = project.json(service, "fit", "show", fit)
    except (Failure, ValueError):
        return None
    return dict(shown)


def fraction(project: Project, service: str, fit: str) -> float:
    """The part of a fit that is done."""
    shown = fit_of(project, service, fit) or {"job": {}}
    return float((shown["job"].get("progress") or {}).get("fraction") or 0)


def beyond(project: Project, service: str, fit: str, part: float) -> None:
    """Waits until a part of a fit is done."""
    until(f"{part:.0%} of the fit", FIT_SECONDS, lambda: fraction(project, service, fit) >= part)


def twin_of(project: Project, service: str, fit: str) -> str:
    """Waits for the twin of a fit."""

    def ended() -> dict[str, Any] | None:
        shown = fit_of(project, service, fit)
        return shown if shown and shown["job"]["end_time"] else None

    shown = until("the end of the fit", FIT_SECONDS, ended)
    require(shown["job"]["state"] == "SUCCEEDED", f"the fit ended as {shown['job']}")
    return str(shown["twin"])


def rolls_out(project: Project, service: str, twin: str) -> None:
    """Requires a twin to answer a rollout."""
    project.inside(service, "bendtwin", "rollout", twin)


def one_machine(engine: Engine, files: list[Path], env: dict[str, str], name: str) -> None:
    """compose.yaml: push, fit, kill, restart, rollout."""
    port = free_port()
    env = {**env, "BENDTWIN_PORT": str(port), "BENDTWIN_VOLUME": f"{name}-data"}
    with Project(engine, name, files, env) as project:
        project("up", "--detach", "--no-build")
        starts_well(lambda: project.logs("server"), lambda: project.health("server"))
        is_well(project.inside("server", "bendtwin", "doctor"))
        say("bendtwin doctor finds no problem in a read-only container")
        fit = begin_fit(project, "server")
        beyond(project, "server", fit, 0.1)
        # Process 1 waits for the server; the engine starts the container again.
        project.inside(
            "server", "bash", "-c", "kill -KILL $(cat /proc/1/task/1/children)", allow=True
        )
        until("an answer after the kill", 60, lambda: fit_of(project, "server", fit))
        say("killed in the middle of a fit, it comes back")
        beyond(project, "server", fit, 0.3)
        project("restart", "--timeout", "20", "server")
        until("an answer after the restart", 60, lambda: fit_of(project, "server", fit))
        say("restarted in the middle of a fit")
        twin = twin_of(project, "server", fit)
        rolls_out(project, "server", twin)
        say("the fit has its twin, which rolls out")


def fleet(engine: Engine, files: list[Path], env: dict[str, str], name: str) -> None:
    """compose.fleet.yaml: a fit through a partition and a lost server, and certificates."""
    random = {
        key: secrets.token_hex(16)
        for key in ("POSTGRES_PASSWORD", "S3_SECRET", "BENDTWIN_WORKER_TOKEN")
    }
    ports = {"BENDTWIN_PORT": str(free_port()), "BENDTWIN_PORT2": str(free_port())}
    with Project(engine, name, files, {**env, **random, **ports}) as project:
        began = time.monotonic()
        project("up", "--detach", "--no-build")
        project.become_healthy("server1", "server2", "worker1", "worker2")
        say(f"servers and workers are healthy after {time.monotonic() - began:.0f} s")
        keys_are_apart(project)
        for server in ("server1", "server2"):
            is_well(project.inside(server, "bendtwin", "doctor"))
        say("bendtwin doctor finds no problem at either server")

        fit = begin_fit(project, "server1")
        beyond(project, "server2", fit, 0.1)
        holder = until("a worker has the fit", 60, lambda: worker_with(project, fit))
        network = f"{name}_default"
        engine("network", "disconnect", network, project.container(holder))
        until(
            "the fit runs at the other worker",
            60,
            lambda: worker_with(project, fit) not in (None, holder),
        )
        engine("network", "connect", "--alias", holder, network, project.container(holder))
        say(f"{holder} was partitioned, and its fit moved")
        engine("kill", project.container("server1"))
        twin = twin_of(project, "server2", fit)
        rolls_out(project, "server2", twin)
        say("server1 was killed, and the fit has its twin at server2")
        engine("start", project.container("server1"))
        project.become_healthy("server1")

        token = project.inside("server1", "cat", "/certificates/client-token")
        project.inside("server2", "env", f"BENDTWIN_TOKEN={token}", "bendtwin", "twin", "list")
        say("server2 takes the client token of server1")
        until("the partitioned worker is back", 60, lambda: len(workers(project)) == 2)
        renews_and_revokes(project)


def keys_are_apart(project: Project) -> None:
    """Requires each service to have its own key alone."""
    for service, own in {
        "server1": "server",
        "server2": "server",
        "worker1": "worker1",
        "worker2": "worker2",
    }.items():
        found = project.inside(service, "bash", "-c", "cd /certificates && echo *.key").split()
        require(found == [f"{own}.key"], f"{service} can read {found}")
    say("each service has its own key alone, without that of the authority")


def workers(project: Project) -> dict[str, dict[str, Any]]:
    """The workers that server2 knows, by the services that their labels name."""
    return {worker["labels"][0]: worker for worker in project.json("server2", "worker", "list")}


def worker_with(project: Project, fit: str) -> str | None:
    """The service of the worker that has a fit, if one has."""
    shown = fit_of(project, "server2", fit)
    holder = shown["job"]["worker"] if shown else None
    return next(
        (label for label, worker in workers(project).items() if worker["name"] == holder), None
    )


def renews_and_revokes(project: Project) -> None:
    """Renews the certificates of the fleet under way, and shuts a worker out and in again."""

    def serial(service: str) -> str:
        shown = project.json(service, "ca", "show", f"/certificates/{service.rstrip('12')}.pem")
        return str(shown[0]["serial"])

    def run(*arguments: str) -> None:
        project("run", "--rm", "certificates", *arguments)

    before = serial("server1")
    # As on the day on which they end within 30 days.
    project(
        "run",
        "--rm",
        "--entrypoint",
        "bendtwin",
        "certificates",
        "ca",
        "renew",
        "/authority",
        "--within",
        "400d",
    )
    run()
    require(serial("server1") != before, "the certificate of the servers is not renewed")
    is_well(project.inside("server1", "bendtwin", "doctor"))
    until("both workers after the renewal", 60, lambda: len(workers(project)) == 2)
    say("all certificates were renewed while the fleet ran")
    run("revoke", "worker1")
    until("worker1 is shut out", 60, lambda: "worker1" not in workers(project))
    require("worker2" in workers(project), "worker2 is shut out as well")
    say("worker1 was revoked, and is shut out")
    run("admit", "worker1")
    until("worker1 is admitted", 60, lambda: "worker1" in workers(project))
    say("worker1 has another certificate, and is back")


def on_gpu(engine: Engine, files: list[Path], env: dict[str, str], name: str) -> None:
    """compose.gpu.yaml: a fit and a rollout on a GPU, with NVRTC from the image."""
    env = {**env, "BENDTWIN_PORT": str(free_port()), "BENDTWIN_VOLUME": f"{name}-data"}
    with Project(engine, name, files, env) as project:
        project("up", "--detach", "--no-build")
        project.become_healthy("server", seconds=180)
        twin = twin_of(project, "server", begin_fit(project, "server"))
        rolls_out(project, "server", twin)
        say("a twin was fitted on the GPU, and rolls out")


def has_compiler(engine: Engine, image: str) -> None:
    """The image for GPUs has the compiler of the kernels where the dynamic loader finds it."""
    known = engine("run", "--rm", "--entrypoint", "ldconfig", image, "-p")
    require("libnvrtc.so.13" in known, f"{image} has no libnvrtc.so.13")
    say("the dynamic loader finds NVRTC")
