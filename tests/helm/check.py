"""Checks the Helm chart: lint, schemas, rules, refusals, the package and its documentation.

python tests/helm/check.py HELM             everything; needs kubernetes-validate
python tests/helm/check.py values --write   writes docs/run/kubernetes-values.md
"""

import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path

import breaks
import yaml
from release import Release
from rules import ROOT, RULES
from values import PAGE, page, schema_faults

CHART = ROOT / "deploy/helm/bendtwin"
# The oldest that Chart.yaml allows, and a new one.
VERSIONS = ("1.30", "1.35")
# APIs that a cluster with the operators has, for what is rendered only then.
APIS = ["monitoring.coreos.com/v1"]
# Files of the chart that are links, and what they lead to.
LINKS = {"alerts.yaml": "prometheus/alerts.yaml", "dashboard.json": "grafana/bendtwin.json"}
# Values that are refused, with words of the message.
REFUSED = [
    ("mode=fleet", "secrets.store"),
    ("mode=fleet,secrets.store=a", "secrets.clientToken"),
    ("workers.cpu.replicas=1", "secrets.workerToken"),
    ("workers.cpu.replicas=1,secrets.workerToken=a", "tls.workers.serverSecret"),
    ("tls.public.source=secret", "tls.public.secret"),
    ("tls.public.source=certManager", "tls.public.issuerRef"),
    (
        "workers.cpu.replicas=1,secrets.workerToken=a,tls.workers.source=certManager,tls.workers.revocationList=true",
        "no revocation lists",
    ),
    (
        "workers.cpu.autoscaling.enabled=true,secrets.workerToken=a,tls.workers.source=certManager",
        "set mode=fleet",
    ),
    ("server.config=shutdown_grace_s = 3", "server.shutdownGraceSeconds"),
    ("ingress.enabled=true", "ingress.hosts"),
    ("unknown=1", "unknown"),
    ("workers.cpu.unknown=1", "unknown"),
    ("workers.a-name-that-is-too-long.replicas=1", "a-name-that-is-too-long"),
    ("fullnameOverride=a-name-that-is-longer-than-28-x", "fullnameOverride"),
    ("server.replicas=0", "replicas"),
    ("tls.public.source=none", "source"),
]


class Helm:
    """The program."""

    def __init__(self, program: str) -> None:
        """Takes its path."""
        self.program = program

    def run(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Runs a command and returns its result, also if it failed."""
        return subprocess.run([self.program, *arguments], capture_output=True, text=True)

    def render(self, values: Path) -> Release:
        """What an installation with these values would create."""
        apis = [f"--api-versions={api}" for api in APIS]
        chart = ["bendtwin", str(CHART), "--namespace=bendtwin", f"--values={values}"]
        result = self.run("template", *chart, *apis)
        if result.returncode != 0:
            sys.exit(f"{values.name}: {result.stderr}")
        given = yaml.safe_load(values.read_text())
        claim = given.get("server", {}).get("persistence", {}).get("existingClaim")
        objects = [o for o in yaml.safe_load_all(result.stdout) if o is not None]
        return Release(objects, {claim} - {None})


def lint_faults(helm: Helm, files: list[Path]) -> Iterator[str]:
    """What `helm lint` says against the chart."""
    for values in files:
        result = helm.run("lint", "--strict", "--quiet", str(CHART), f"--values={values}")
        if result.returncode != 0:
            yield f"{values.name}: {result.stdout}{result.stderr}"


def kubernetes_faults(release: Release) -> Iterator[str]:
    """What Kubernetes would refuse or ignore, by its schemas; objects of operators have none."""
    import kubernetes_validate

    for version in VERSIONS:
        for object_ in release.objects:
            try:
                kubernetes_validate.validate(object_, version, strict=True)
            except kubernetes_validate.SchemaNotFoundError:
                if "k8s.io" in object_["apiVersion"] or "." not in object_["apiVersion"]:
                    yield f"Kubernetes {version} does not know {object_['kind']}"
            except kubernetes_validate.ValidationError as error:
                where = f"{object_['kind']} {object_['metadata']['name']}"
                yield f"{where}, Kubernetes {version}: {error.message}"


def refusal_faults(helm: Helm) -> Iterator[str]:
    """Values that are accepted, or refused without saying why."""
    for values, words in REFUSED:
        result = helm.run("template", "bendtwin", str(CHART), f"--set={values}")
        if result.returncode == 0:
            yield f"{values}: it is not refused"
        elif words not in result.stderr:
            yield f"{values}: the refusal does not name {words}: {result.stderr}"


def package_faults(helm: Helm) -> Iterator[str]:
    """Whether the package has what are links in the source tree."""
    with tempfile.TemporaryDirectory() as folder:
        result = helm.run("package", str(CHART), f"--destination={folder}")
        if result.returncode != 0:
            yield f"helm package: {result.stderr}"
            return
        (package,) = Path(folder).iterdir()
        with tarfile.open(package) as archive:
            opened = {m.name: archive.extractfile(m) for m in archive}
            files = {name: file.read() for name, file in opened.items() if file is not None}
    for name, source in LINKS.items():
        if files.get(f"bendtwin/files/{name}") != (ROOT / "deploy" / source).read_bytes():
            yield f"helm package: files/{name} is not deploy/{source}"


def check(helm: Helm) -> list[str]:
    """All faults."""
    files = sorted((CHART / "ci").glob("*-values.yaml"))
    releases = {path.name.removesuffix("-values.yaml"): helm.render(path) for path in files}
    faults = [*lint_faults(helm, files), *refusal_faults(helm), *package_faults(helm)]
    faults += schema_faults()
    for name, release in releases.items():
        found = [*kubernetes_faults(release), *(f for rule in RULES for f in rule(release))]
        faults += [f"{name}: {fault}" for fault in found]
        print(f"{name}: {len(release.objects)} objects")
    faults += breaks.unnoticed(releases)
    print(f"{len(RULES)} rules, {len(breaks.CHANGES)} breaks, {len(REFUSED)} refusals")
    if PAGE.read_text() != page():
        faults.append(f"{PAGE.relative_to(ROOT)} is old: tests/helm/check.py values --write")
    return faults


def main(arguments: list[str]) -> int:
    """Runs the command."""
    if arguments == ["values", "--write"]:
        PAGE.write_text(page())
    elif len(arguments) == 1:
        faults = check(Helm(arguments[0]))
        print(*faults, sep="\n")
        return int(bool(faults))
    else:
        print(__doc__, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
