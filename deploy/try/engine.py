"""The container engine, the compose command and the builder of this machine."""

import json
import os
import shutil
import subprocess
import tarfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

ROOT = Path(__file__).resolve().parents[2]
DEPLOY = ROOT / "deploy"
DOCKERFILE = DEPLOY / "Dockerfile"
# Versions of Docker's command line that have BuildKit without buildx.
BUILDKIT_INSIDE = range(19, 23)

Found = TypeVar("Found")


class Unavailable(Exception):
    """Something that this machine lacks, which is no fault of the images."""


class Failure(Exception):
    """An expectation that did not hold."""


def call(
    *command: str | Path,
    env: dict[str, str] | None = None,
    quiet: bool = False,
    allow: bool = False,
) -> str:
    """Runs a command and returns its output, which failures show."""
    done = subprocess.run(
        [str(word) for word in command],
        env={**os.environ, **(env or {})},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE if quiet or not allow else subprocess.DEVNULL,
        text=True,
        check=False,
    )
    if done.returncode != 0 and not allow:
        said = "\n".join((done.stdout + (done.stderr or "")).strip().splitlines()[-20:])
        raise Failure(f"{' '.join(map(str, command))}\nended with {done.returncode}:\n{said}")
    return done.stdout


def works(*command: str, env: dict[str, str] | None = None) -> bool:
    """True if a command exists and succeeds."""
    if shutil.which(command[0]) is None:
        return False
    done = subprocess.run(
        command,
        env={**os.environ, **(env or {})},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
    )
    return done.returncode == 0


def until(what: str, seconds: float, probe: Callable[[], Found | None]) -> Found:
    """What a probe finds, which must be before a deadline."""
    end = time.monotonic() + seconds
    while True:
        found = probe()
        if found:
            return found
        if time.monotonic() > end:
            raise Failure(f"{what}: not within {seconds:.0f} s")
        time.sleep(0.1)


class Engine:
    """Docker or podman."""

    def __init__(self, name: str) -> None:
        self.name = name

    @classmethod
    def find(cls, names: list[str]) -> "Engine":
        """The first of these that runs."""
        for name in names:
            if works(name, "info"):
                return cls(name)
        raise Unavailable(f"{' and '.join(names)} cannot be used here: no engine runs")

    def __call__(self, *arguments: str | Path, quiet: bool = False, allow: bool = False) -> str:
        """Runs a command of the engine and returns its output."""
        return call(self.name, *arguments, quiet=quiet, allow=allow)

    def has_image(self, image: str) -> bool:
        """True if the engine has an image, without asking a registry."""
        return works(self.name, "image", "inspect", image)

    def pulls(self, image: str) -> bool:
        """True if the engine has an image, or gets it from a registry."""
        return self.has_image(image) or works("timeout", "120", self.name, "pull", "--quiet", image)

    def require_containers(self, image: str) -> None:
        """Refuses an engine that answers but starts nothing, as in some sandboxes."""
        if not works(self.name, "run", "--rm", "--entrypoint", "true", image):
            raise Unavailable(f"{self.name} runs, but cannot start a container")
        if self.name == "podman" and not Path("/run/systemd/system").exists():
            raise Unavailable("podman has systemd run the health checks, which this machine lacks")

    def has_gpu(self, image: str) -> bool:
        """True if a container gets a GPU of NVIDIA."""
        return works(self.name, "run", "--rm", "--gpus", "all", "--entrypoint", "true", image)

    def import_program(self, program: Path, image: str) -> None:
        """Makes an image that has nothing but a program at /usr/local/bin/bendtwin."""
        with (
            subprocess.Popen(
                [self.name, "import", "-", image], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
            ) as importing,
            tarfile.open(fileobj=importing.stdin, mode="w|") as archive,
        ):
            archive.add(program, "usr/local/bin/bendtwin")
        if importing.returncode != 0:
            raise Failure(f"{self.name} cannot import {program}")

    def build(self, image: str, arguments: dict[str, str], target: str = "cpu") -> None:
        """Builds a target of the Dockerfile with a builder of this machine."""
        options = [
            "--file",
            str(DOCKERFILE),
            "--target",
            target,
            "--network",
            "host",
            "--tag",
            image,
        ]
        for name, value in arguments.items():
            options += ["--build-arg", f"{name}={value}"]
        if self.name == "podman":
            # OCI's own format has no health checks.
            call("podman", "build", "--pull=never", "--format=docker", *options, ROOT)
        elif works("docker", "buildx", "version"):
            call("docker", "buildx", "build", "--load", *options, ROOT)
        elif self.client_version() in BUILDKIT_INSIDE:
            call("docker", "build", *options, ROOT, env={"DOCKER_BUILDKIT": "1"})
        elif shutil.which("buildah"):
            self.build_with_buildah(image, arguments, options)
        else:
            raise Unavailable("there is no builder: install docker-buildx or buildah")

    def client_version(self) -> int:
        """The main version of Docker's command line."""
        version = call("docker", "version", "--format", "{{.Client.Version}}", allow=True)
        return int(version.split(".")[0] or 0)

    def build_with_buildah(self, image: str, arguments: dict[str, str], options: list[str]) -> None:
        """Buildah has separate images: copies those of the engine, and the result back."""
        for name, base in arguments.items():
            if name.endswith("_IMAGE") or name == "PROGRAM":
                call("buildah", "pull", "--quiet", f"docker-daemon:{tagged(base)}")
        call(
            "buildah",
            "build",
            "--isolation=chroot",
            "--layers",
            "--pull-never",
            "--format=docker",
            *options,
            ROOT,
        )
        call("buildah", "push", "--quiet", image, f"docker-daemon:{tagged(image)}")


def tagged(image: str) -> str:
    """The name of an image with its tag."""
    return image if ":" in image else f"{image}:latest"


class Project:
    """Services of compose files under a separate name, which leave nothing behind."""

    def __init__(self, engine: Engine, name: str, files: list[Path], env: dict[str, str]) -> None:
        self.engine, self.name, self.env = engine, name, env
        self.command = [*compose(engine), "--project-name", name]
        for file in files:
            self.command += ["--file", str(file)]

    def __enter__(self) -> "Project":
        return self

    def __exit__(self, kind: type | None, *_: object) -> None:
        if kind is not None and kind is not KeyboardInterrupt:
            print(self("logs", "--no-color", "--tail", "40", allow=True)[-8000:], flush=True)
        self("down", "--volumes", "--timeout", "2", allow=True)

    def __call__(self, *arguments: str, allow: bool = False) -> str:
        """Runs a command of Compose and returns its output."""
        return call(*self.command, *arguments, env=self.env, allow=allow)

    def container(self, service: str) -> str:
        """The id of the container of a service."""
        return self("ps", "--quiet", service).strip()

    def inside(self, service: str, *command: str, allow: bool = False) -> str:
        """Runs a command in the container of a service."""
        return self.engine("exec", self.container(service), *command, allow=allow)

    def json(self, service: str, *command: str) -> Any:
        """Runs `bendtwin ... --json` in the container of a service."""
        return json.loads(self.inside(service, "bendtwin", *command, "--json"))

    def logs(self, service: str) -> str:
        """What a service has written."""
        return logs(self.engine, self.container(service))

    def health(self, service: str) -> str:
        """The state of the health check of a service."""
        return health(self.engine, self.container(service))

    def is_healthy(self, service: str) -> bool:
        """True if the health check of a service has succeeded."""
        return self.health(service) == "healthy"

    def become_healthy(self, *services: str, seconds: float = 60) -> None:
        """Waits until all of these services are healthy."""
        for service in services:
            until(f"{service} is healthy", seconds, partial(self.is_healthy, service))


def health(engine: Engine, container: str) -> str:
    """The state of the health check of a container."""
    return engine("inspect", "--format", "{{.State.Health.Status}}", container, allow=True).strip()


def logs(engine: Engine, container: str) -> str:
    """What a container has written."""
    done = subprocess.run(
        [engine.name, "logs", container],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return done.stdout


def compose(engine: Engine) -> list[str]:
    """The compose command for an engine."""
    found = {
        "docker": [["docker", "compose"], ["docker-compose"]],
        "podman": [["podman", "compose"], ["podman-compose"]],
    }[engine.name]
    for command in found:
        if works(*command, "version"):
            return command
    raise Unavailable(f"{engine.name} runs, but there is no {' or '.join(map(' '.join, found))}")
