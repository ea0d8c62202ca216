"""Rendered objects of a release, and what the rules ask of them."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

Object = dict[str, Any]

WORKLOADS = ("Deployment", "StatefulSet", "CronJob", "Pod")


@dataclass
class Pods:
    """The pods of a workload: the object that makes them, their labels and specification."""

    owner: Object
    labels: dict[str, str]
    spec: Object

    @property
    def name(self) -> str:
        """Kind and name of the workload, for messages."""
        return f"{self.owner['kind']} {self.owner['metadata']['name']}"

    @property
    def component(self) -> str:
        """What the pods are: server, worker, backup or test."""
        return self.labels["app.kubernetes.io/component"]

    @property
    def containers(self) -> list[Object]:
        """All containers, those that run first included."""
        return [*self.spec.get("initContainers", []), *self.spec["containers"]]

    @property
    def ports(self) -> dict[str, int]:
        """Numbers of the ports by name."""
        all_ports = [port for c in self.containers for port in c.get("ports", [])]
        return {port["name"]: port["containerPort"] for port in all_ports}

    @property
    def replicas(self) -> int | None:
        """Number of pods; None if something else decides it."""
        return self.owner["spec"].get("replicas")

    def environment(self, container: Object) -> dict[str, str]:
        """Variables of a container whose values are known."""
        return {v["name"]: v["value"] for v in container.get("env", []) if "value" in v}


class Release:
    """Everything that the chart renders for one file of values."""

    def __init__(self, objects: list[Object], external: set[str] = frozenset()) -> None:
        """Takes the documents of `helm template`, and names of claims that users have made."""
        self.objects = objects
        self.external = set(external)

    def all(self, *kinds: str) -> list[Object]:
        """Objects of these kinds."""
        return [o for o in self.objects if o["kind"] in kinds]

    def names(self, kind: str) -> set[str]:
        """Names of the objects of a kind."""
        return {o["metadata"]["name"] for o in self.all(kind)}

    def pods(self, *components: str) -> list[Pods]:
        """Pods of all workloads, or of those of these components."""
        found = [self._pods_of(o) for o in self.all(*WORKLOADS)]
        return [p for p in found if not components or p.component in components]

    @staticmethod
    def _pods_of(owner: Object) -> Pods:
        template = owner
        if owner["kind"] == "CronJob":
            template = owner["spec"]["jobTemplate"]["spec"]["template"]
        elif owner["kind"] != "Pod":
            template = owner["spec"]["template"]
        return Pods(owner, template["metadata"]["labels"], template["spec"])

    def selected(self, labels: dict[str, str]) -> list[Pods]:
        """Workloads whose pods have these labels."""
        return [p for p in self.pods() if labels.items() <= p.labels.items()]

    def config(self) -> str:
        """The options of the servers, in TOML."""
        name = next(
            volume["configMap"]["name"]
            for volume in self.pods("server")[0].spec["volumes"]
            if volume["name"] == "config"
        )
        found = [o for o in self.all("ConfigMap") if o["metadata"]["name"] == name]
        return found[0]["data"]["config.toml"] if found else ""


def metrics(text: str) -> set[str]:
    """Names of metrics in a text, those of histograms without their ends."""
    names = re.findall(r"\bbendtwin_[a-z_]+", text)
    return {re.sub(r"_(bucket|count|sum)$", "", name) for name in names}


def documents(value: Any) -> Iterator[str]:
    """All texts in an object."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for part in value.values():
            yield from documents(part)
    elif isinstance(value, list):
        for part in value:
            yield from documents(part)
