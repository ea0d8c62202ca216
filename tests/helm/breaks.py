"""Changes of a release that the rules must notice: a rule that cannot fail proves nothing.

Each change is for a file of values in which it is possible, and its fault contains the words beside it.
"""

# A table with a line for each change.
# ruff: noqa: E501

import copy
from collections.abc import Callable

from release import Object, Release
from rules import RULES

Change = Callable[[Release], object]


def container(release: Release, component: str) -> Object:
    """The container of a component."""
    return release.pods(component)[0].spec["containers"][0]


def owner(release: Release, component: str) -> Object:
    """The specification of the workload of a component."""
    return release.pods(component)[0].owner["spec"]


def first(release: Release, kind: str) -> Object:
    """The specification of the first object of a kind."""
    return release.all(kind)[0]["spec"]


def variable(release: Release, component: str, name: str) -> Object:
    """A variable of a container."""
    (found,) = (v for v in container(release, component)["env"] if v["name"] == name)
    return found


def without(release: Release, kind: str) -> None:
    """Removes the objects of a kind."""
    release.objects = [o for o in release.objects if o["kind"] != kind]


def closed(release: Release, way: str, port: int) -> None:
    """Removes a port from the NetworkPolicy of servers."""
    (spec,) = (
        policy["spec"]
        for policy in release.all("NetworkPolicy")
        if policy["metadata"]["name"].endswith("-server")
    )
    spec[way] = [r for r in spec[way] if port not in [p["port"] for p in r["ports"]]]


def named(release: Release, kind: str, name: str) -> None:
    """Gives the first object of a kind another name."""
    release.all(kind)[0]["metadata"]["name"] = name


# The file of values, what is changed, how, and the words of the fault.
CHANGES: list[tuple[str, str, Change, str]] = [
    ("single", "root", lambda r: owner(r, "server")["template"]["spec"]["securityContext"].pop("runAsNonRoot"), "the security of the pod"),
    ("fleet", "token of the cluster", lambda r: owner(r, "worker")["template"]["spec"].pop("automountServiceAccountToken"), "a token of the cluster"),
    ("fleet", "host network", lambda r: owner(r, "worker")["template"]["spec"].update(hostNetwork=True), "hostNetwork"),
    ("fleet", "writable root", lambda r: r.pods("backup")[0].containers[0]["securityContext"].pop("readOnlyRootFilesystem"), "is not confined"),
    ("minimal", "requests", lambda r: container(r, "server")["resources"].pop("requests"), "requests of processor"),
    ("minimal", "limits", lambda r: container(r, "test")["resources"].pop("limits"), "limit of memory"),
    ("minimal", "version", lambda r: container(r, "server").update(image="bendtwin:latest"), "has no version"),
    ("fleet", "startup probe", lambda r: container(r, "server").pop("startupProbe"), "does not ask /healthz"),
    ("fleet", "readiness with workers", lambda r: container(r, "server")["readinessProbe"]["httpGet"].update(path="/readyz"), "does not ask /readyz?without"),
    ("fleet", "probe without TLS", lambda r: container(r, "server")["livenessProbe"]["httpGet"].update(scheme="HTTP"), "over HTTPS"),
    ("fleet", "worker's probe", lambda r: container(r, "worker").pop("readinessProbe"), "does not run `bendtwin healthcheck worker`"),
    ("gpu", "worker's life", lambda r: container(r, "worker").update(livenessProbe={}), "livenessProbe"),
    ("minimal", "grace", lambda r: owner(r, "server")["template"]["spec"].update(terminationGracePeriodSeconds=15), "before its grace"),
    ("fleet", "grace of workers", lambda r: owner(r, "worker")["template"]["spec"].update(terminationGracePeriodSeconds=15), "before its jobs"),
    ("fleet", "service", lambda r: first(r, "Service")["selector"].update(pool="x"), "selects no pods"),
    ("fleet", "port", lambda r: first(r, "Service")["ports"][0].update(targetPort="http"), "have no port http"),
    ("gpu", "two pools of one selector", lambda r: [p.owner["spec"]["selector"]["matchLabels"].pop("pool") for p in r.pods("worker")], "its pods alone"),
    ("gpu", "service of names", lambda r: owner(r, "worker").update(serviceName="none"), "there is no service none"),
    ("fleet", "budget of nobody", lambda r: first(r, "PodDisruptionBudget")["selector"]["matchLabels"].update(pool="x"), "selects no pods"),
    ("single", "ingress", lambda r: first(r, "Ingress")["rules"][0]["http"]["paths"][0]["backend"]["service"].update(name="x"), "there is no service for it"),
    ("fleet", "budgets", lambda r: without(r, "PodDisruptionBudget"), "no PodDisruptionBudget"),
    ("fleet", "affinity", lambda r: owner(r, "server")["template"]["spec"].pop("affinity"), "are not spread"),
    ("gpu", "zones", lambda r: owner(r, "worker")["template"]["spec"].pop("topologySpreadConstraints"), "are not spread"),
    ("fleet", "zones of others", lambda r: owner(r, "server")["template"]["spec"]["topologySpreadConstraints"][0]["labelSelector"]["matchLabels"].update({"app.kubernetes.io/component": "x"}), "among the pods of others"),
    ("fleet", "policies", lambda r: without(r, "NetworkPolicy"), "not one NetworkPolicy"),
    ("fleet", "clients", lambda r: closed(r, "ingress", 7070), "are not those of its NetworkPolicy"),
    ("fleet", "workers", lambda r: closed(r, "egress", 7072), "the way to StatefulSet"),
    ("fleet", "names", lambda r: closed(r, "egress", 53), "cannot resolve names"),
    ("fleet", "everybody", lambda r: first(r, "NetworkPolicy")["ingress"][-1].pop("from"), "is open to everybody"),
    ("fleet", "mount", lambda r: container(r, "server")["volumeMounts"].pop(), "where nothing is mounted"),
    ("fleet", "volume", lambda r: owner(r, "server")["template"]["spec"]["volumes"].pop(), "there is no volume"),
    ("minimal", "configuration", lambda r: named(r, "ConfigMap", "x"), "there is no ConfigMap"),
    ("fleet", "claim", lambda r: without(r, "PersistentVolumeClaim"), "there is no claim"),
    ("single", "claim of users", lambda r: r.external.clear(), "there is no claim"),
    ("fleet", "account", lambda r: without(r, "ServiceAccount"), "there is no ServiceAccount"),
    ("gpu", "issuer", lambda r: without(r, "Issuer"), "there is no such issuer"),
    ("gpu", "secret", lambda r: [c["spec"].update(secretName="x-tls") for c in r.all("Certificate")], "no certificate makes the secret"),
    ("gpu", "host", lambda r: variable(r, "worker", "BENDTWIN_SERVER").update(value="https://x:7072"), "which is no service"),
    ("gpu", "certificate", lambda r: [c["spec"].update(dnsNames=["x"]) for c in r.all("Certificate")], "no certificate is for"),
    ("gpu", "GPU", lambda r: r.pods("worker")[1].containers[0]["resources"]["limits"].popitem(), "asks for no GPU"),
    ("gpu", "image", lambda r: r.pods("worker")[1].containers[0].update(image="bendtwin:1"), "not the image of its backend"),
    ("gpu", "target", lambda r: first(r, "ScaledObject")["scaleTargetRef"].update(name="x"), "no pool without a size"),
    ("gpu", "two sizes", lambda r: owner(r, "worker").update(replicas=3), "no pool without a size"),
    ("gpu", "no size", lambda r: without(r, "ScaledObject"), "nothing decides its size"),
    ("gpu", "ingests", lambda r: first(r, "ScaledObject")["triggers"].pop(1), "do not count"),
    ("gpu", "credentials", lambda r: without(r, "TriggerAuthentication"), "no credentials"),
    ("fleet", "long name", lambda r: named(r, "CronJob", "x" * 53), "too long"),
    ("fleet", "option", lambda r: container(r, "server")["env"].append({"name": "BENDTWIN_X", "value": ""}), "does not know BENDTWIN_X"),
    ("gpu", "metric", lambda r: first(r, "ScaledObject")["triggers"][2]["metadata"].update(query="bendtwin_x"), "no metric bendtwin_x"),
    ("single", "monitored port", lambda r: first(r, "PodMonitor")["podMetricsEndpoints"][0].update(port="http"), "has no such port"),
    ("single", "key", lambda r: first(r, "PodMonitor")["podMetricsEndpoints"][0].pop("authorization"), "it has no key"),
    ("fleet", "alerts", lambda r: first(r, "PrometheusRule")["groups"][0]["rules"].pop(), "are not those of"),
    ("minimal", "shutdown", lambda r: r.all("ConfigMap")[0]["data"].update({"config.toml": ""}), "no shutdown_grace_s"),
]  # fmt: skip


def unnoticed(releases: dict[str, Release]) -> list[str]:
    """Changes of which the rules say nothing, or something else; and rules that no change breaks."""
    missed, broken = [], set()
    for file, what, change, words in CHANGES:
        original = releases[file]
        release = Release(copy.deepcopy(original.objects), original.external)
        change(release)
        found = {rule: [fault for fault in rule(release) if words in fault] for rule in RULES}
        if not any(found.values()):
            missed.append(f"{what}, in {file}: no rule says `{words}`")
        broken |= {rule for rule, faults in found.items() if faults}
    return missed + [f"no change breaks {rule.__name__}" for rule in RULES if rule not in broken]
