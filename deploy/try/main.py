"""Builds the images, starts the compose files, and does in them what people do.

    deploy/try/run                      compiles the program in the image: some 20 minutes
    deploy/try/run --program FILE       takes a program that was built on this machine
    deploy/try/run --stand-ins          takes images of base-images, without asking a registry
    deploy/try/run --engine podman      takes this engine, otherwise the first that runs

It ends with 0 if all went well, 1 if something is wrong, and 3 if
this machine cannot run it, with the reason in its last line. What it starts has separate names
(bendtwin-try-...), and is removed at the end; images are kept, so that the next run is shorter.
"""

import argparse
import os
import re
import shutil
import signal
import sys
import tempfile
from pathlib import Path

import stories
from engine import DEPLOY, DOCKERFILE, Engine, Failure, Unavailable, call, compose, works

CANNOT_RUN = 3
ENGINES = ["docker", "podman"]
IMAGE = "bendtwin-try/bendtwin"
CUDA_IMAGE = "bendtwin-try/bendtwin:cuda"
PROGRAM_IMAGE = "bendtwin-try/program"
ONE_MACHINE = DEPLOY / "compose.yaml"
FLEET = DEPLOY / "compose.fleet.yaml"
GPU = DEPLOY / "compose.gpu.yaml"
HERE = DEPLOY / "try"


def step(title: str) -> None:
    """Prints what comes next."""
    print(f"== {title}", flush=True)


def defaults() -> dict[str, str]:
    """The images that the Dockerfile names."""
    return dict(re.findall(r"^ARG (\w+_IMAGE)=(\S+)", DOCKERFILE.read_text(), re.MULTILINE))


def base_images(engine: Engine, may_pull: bool, with_rust: bool) -> dict[str, str]:
    """Images to start from, as arguments of the build; none if those of the file can be had."""
    named = defaults().items()
    if may_pull and all(
        engine.pulls(image) for name, image in named if name != "RUST_IMAGE" or with_rust
    ):
        return {}
    step("base images without a registry")
    can_make = os.geteuid() == 0 and shutil.which("debootstrap") is not None
    if not engine.has_image("bendtwin-try/services") and not can_make:
        raise Unavailable("no image registry is reached, and base images take root and debootstrap")
    print(call(HERE / "base-images", engine.name, *(["rust"] if with_rust else [])), end="")
    rust = {"RUST_IMAGE": "bendtwin-try/rust"} if with_rust else {}
    return {"DEBIAN_IMAGE": "bendtwin-try/debian", **rust}


def use_program(engine: Engine, program: Path) -> dict[str, str]:
    """Takes a program of this machine, without its symbols."""
    with tempfile.TemporaryDirectory() as folder:
        stripped = Path(folder) / "bendtwin"
        if not works("strip", "-o", str(stripped), str(program)):
            shutil.copy(program, stripped)
        engine.import_program(stripped, PROGRAM_IMAGE)
    return {"PROGRAM": PROGRAM_IMAGE}


def build(engine: Engine, options: argparse.Namespace, arguments: dict[str, str]) -> None:
    """Builds both images, and requires the program to run in them."""
    for image, target in ((IMAGE, "cpu"), (CUDA_IMAGE, "cuda")):
        step(f"image for {target}")
        engine.build(image, arguments, target)
        size = int(engine("image", "inspect", "--format", "{{.Size}}", image))
        print(f"   {size / 1e6:.0f} MB", flush=True)
    try:
        print("   " + engine("run", "--rm", IMAGE, "--version"), end="")
    except Failure as failure:
        if options.program and "GLIBC" in str(failure):
            raise Unavailable(
                f"{options.program} needs a newer C library than the image has"
            ) from failure
        raise


def main() -> int:
    """Runs everything, and returns the status of the exit."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", type=Path)
    parser.add_argument("--stand-ins", action="store_true")
    parser.add_argument("--engine", choices=ENGINES)
    options = parser.parse_args()
    try:
        engine = Engine.find([options.engine] if options.engine else ENGINES)
        print(f"{engine.name} with {' '.join(compose(engine))}", flush=True)
        arguments = base_images(engine, not options.stand_ins, with_rust=options.program is None)
        engine.require_containers(arguments.get("DEBIAN_IMAGE", defaults()["DEBIAN_IMAGE"]))
        stand_ins = [HERE / "stand-ins.yaml"] if arguments else []
        if options.program:
            arguments |= use_program(engine, options.program)
        build(engine, options, arguments)
        name = f"bendtwin-try-{os.getpid()}"
        env = {"BENDTWIN_IMAGE": IMAGE}
        step("docker run")
        stories.one_line(engine, IMAGE, name)
        step("compose.yaml")
        stories.one_machine(engine, [ONE_MACHINE], env, name)
        step("compose.fleet.yaml")
        stories.fleet(engine, [FLEET, HERE / "fleet.yaml", *stand_ins], env, name)
        step("compose.gpu.yaml")
        stories.has_compiler(engine, CUDA_IMAGE)
        if engine.has_gpu(CUDA_IMAGE):
            stories.on_gpu(engine, [ONE_MACHINE, GPU], {"BENDTWIN_IMAGE": CUDA_IMAGE}, name)
        else:
            print("   SKIPPED: fits in the image for GPUs, since no container gets one", flush=True)
    except Unavailable as reason:
        print(f"cannot run here: {reason}")
        return CANNOT_RUN
    except Failure as failure:
        print(f"FAILED: {failure}")
        return 1
    print("the images and the compose files work")
    return 0


if __name__ == "__main__":
    sys.exit(main())
