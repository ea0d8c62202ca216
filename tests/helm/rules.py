"""What holds for every release: each rule yields the faults that it finds, as sentences.

`breaks.py` has a change for each rule that it must notice.
"""

import fnmatch
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import yaml
from release import Object, Pods, Release, documents, metrics

ROOT = Path(__file__).resolve().parents[2]
RULES: list[Callable[[Release], Iterator[str]]] = []

SECURITY = {
    "runAsNonRoot": True,
    "runAsUser": 10001,
    "runAsGroup": 10001,
    "fsGroup": 10001,
    "fsGroupChangePolicy": "OnRootMismatch",
    "seccompProfile": {"type": "RuntimeDefault"},
}
CONFINEMENT = {
    "allowPrivilegeEscalation": False,
    "readOnlyRootFilesystem": True,
    "capabilities": {"drop": ["ALL"]},
}


def rule(check: Callable[[Release], Iterator[str]]) -> Callable[[Release], Iterator[str]]:
    """Adds a rule to the list."""
    RULES.append(check)
    return check


@rule
def pods_are_confined(release: Release) -> Iterator[str]:
    """The restricted standard of pod security, and no token of the cluster."""
    for pods in release.pods():
        if pods.spec.get("securityContext") != SECURITY:
            yield f"{pods.name}: the security of the pod is not {SECURITY}"
        if pods.spec.get("automountServiceAccountToken") is not False:
            yield f"{pods.name}: it has a token of the cluster"
        for key in ("hostNetwork", "hostPID", "hostIPC"):
            if pods.spec.get(key):
                yield f"{pods.name}: {key}"
        for container in pods.containers:
            if container.get("securityContext") != CONFINEMENT:
                yield f"{pods.name}: container {container['name']} is not confined"


@rule
def containers_have_resources_and_images(release: Release) -> Iterator[str]:
    """Requests of processor and memory, a limit of memory, an image with a version."""
    for pods in release.pods():
        for container in pods.containers:
            where = f"{pods.name}, container {container['name']}"
            requests = container["resources"].get("requests", {})
            if not {"cpu", "memory"} <= requests.keys():
                yield f"{where}: requests of processor and memory are missing"
            if "memory" not in container["resources"].get("limits", {}):
                yield f"{where}: the limit of memory is missing"
            if not re.search(r":(?!latest$)[^:/]+$", container["image"]):
                yield f"{where}: the image {container['image']} has no version"


@rule
def servers_are_probed(release: Release) -> Iterator[str]:
    """Start and life by /healthz, readiness without workers, over what the server speaks."""
    paths = {
        "startupProbe": "/healthz",
        "livenessProbe": "/healthz",
        "readinessProbe": "/readyz?without=workers",
    }
    for pods in release.pods("server"):
        (container,) = pods.containers
        speaks = "HTTPS" if "BENDTWIN_TLS_CERTIFICATE" in pods.environment(container) else "HTTP"
        for name, path in paths.items():
            get = container.get(name, {}).get("httpGet", {})
            if get.get("path") != path:
                yield f"{pods.name}: {name} does not ask {path}"
            if get.get("port") not in pods.ports or get.get("scheme") != speaks:
                yield f"{pods.name}: {name} does not reach the server over {speaks}"


@rule
def workers_are_probed(release: Release) -> Iterator[str]:
    """Start and readiness by the command; no probe of life, which would end working ones."""
    for pods in release.pods("worker"):
        (container,) = pods.containers
        for name in ("startupProbe", "readinessProbe"):
            command = container.get(name, {}).get("exec", {}).get("command")
            if command != ["bendtwin", "healthcheck", "worker"]:
                yield f"{pods.name}: {name} does not run `bendtwin healthcheck worker`"
        if "livenessProbe" in container:
            yield f"{pods.name}: a worker that computes must not be ended by a livenessProbe"


@rule
def ends_are_graceful(release: Release) -> Iterator[str]:
    """A pod has time for its drain and for the grace of its program."""
    found = re.search(r"^shutdown_grace_s = ([\d.]+)$", release.config(), re.MULTILINE)
    if found is None:
        yield "the configuration has no shutdown_grace_s"
        return
    for pods in release.pods("server"):
        lifecycle = pods.containers[0].get("lifecycle", {})
        drain = lifecycle.get("preStop", {}).get("sleep", {}).get("seconds", 0)
        if pods.spec["terminationGracePeriodSeconds"] < drain + float(found[1]) + 5:
            yield f"{pods.name}: it is killed before its grace of {found[1]} s has ended"
    for pods in release.pods("worker"):
        # Fifteen seconds for jobs, and as many for rollouts.
        if pods.spec["terminationGracePeriodSeconds"] < 35:
            yield f"{pods.name}: it is killed before its jobs are handed back"


@rule
def selectors_find_their_pods(release: Release) -> Iterator[str]:
    """What selects pods selects some, and ports have names there."""
    for owner in release.all("Deployment", "StatefulSet"):
        name = f"{owner['kind']} {owner['metadata']['name']}"
        labels = owner["spec"]["selector"]["matchLabels"]
        if [p.owner for p in release.selected(labels)] != [owner]:
            yield f"{name}: its selector does not select its pods alone"
        service = owner["spec"].get("serviceName")
        if service is not None and service not in release.names("Service"):
            yield f"{name}: there is no service {service}"
    for service in release.all("Service"):
        name = f"Service {service['metadata']['name']}"
        found = release.selected(service["spec"]["selector"])
        if not found:
            yield f"{name}: it selects no pods"
        for port in service["spec"]["ports"]:
            if any(port["targetPort"] not in pods.ports for pods in found):
                yield f"{name}: its pods have no port {port['targetPort']}"
    for kind in ("PodDisruptionBudget", "NetworkPolicy", "PodMonitor"):
        for object_ in release.all(kind):
            spec = object_["spec"]
            selector = spec["podSelector" if kind == "NetworkPolicy" else "selector"]
            if not release.selected(selector["matchLabels"]):
                yield f"{kind} {object_['metadata']['name']}: it selects no pods"
    for ingress in release.all("Ingress"):
        served = {
            (service["metadata"]["name"], port["name"])
            for service in release.all("Service")
            for port in service["spec"]["ports"]
        }
        for backend in backends(ingress):
            if (backend["name"], backend["port"]["name"]) not in served:
                yield f"Ingress {ingress['metadata']['name']}: there is no service for it"


def backends(ingress: Object) -> list[Object]:
    """Services of an Ingress."""
    paths = [path for rule in ingress["spec"]["rules"] for path in rule["http"]["paths"]]
    return [path["backend"]["service"] for path in paths]


@rule
def several_pods_survive_a_node(release: Release) -> Iterator[str]:
    """Workloads of several pods have a budget and are spread."""
    for pods in release.pods("server", "worker"):
        if pods.replicas in (0, 1):
            continue
        budgets = release.all("PodDisruptionBudget")
        if not any(selects(budget["spec"]["selector"], pods) for budget in budgets):
            yield f"{pods.name}: there is no PodDisruptionBudget"
        spread = pods.spec.get("topologySpreadConstraints", [])
        avoided = pods.spec.get("affinity", {}).get("podAntiAffinity", {})
        terms = avoided.get("preferredDuringSchedulingIgnoredDuringExecution", [])
        selectors = [c["labelSelector"]["matchLabels"] for c in spread]
        selectors += [t["podAffinityTerm"]["labelSelector"]["matchLabels"] for t in terms]
        if not spread or (pods.component == "server" and not terms):
            yield f"{pods.name}: its pods are not spread"
        if any(pods not in release.selected(labels) for labels in selectors):
            yield f"{pods.name}: it is spread among the pods of others"


@rule
def only_those_talk_who_must(release: Release) -> Iterator[str]:
    """Every port is open to somebody, workers and servers reach each other, and nobody else can."""
    policies = release.all("NetworkPolicy")
    for pods in release.pods("server", "worker", "backup"):
        mine = [p for p in policies if selects(p["spec"]["podSelector"], pods)]
        if [p["spec"]["policyTypes"] for p in mine] != [["Ingress", "Egress"]]:
            yield f"{pods.name}: there is not one NetworkPolicy for both directions"
            continue
        spec = mine[0]["spec"]
        came = [(port["port"], r) for r in spec.get("ingress", []) for port in r["ports"]]
        went = [(port["port"], r) for r in spec["egress"] for port in r["ports"]]
        if {port for port, _ in came} != set(pods.ports.values()):
            yield f"{pods.name}: the ports {pods.ports} are not those of its NetworkPolicy"
        if 53 not in [port for port, _ in went]:
            yield f"{pods.name}: it cannot resolve names"
        others = {"server": "worker", "worker": "server"}.get(pods.component)
        for other in release.pods(others) if others else []:
            for way, rules in (("from", came), ("to", went)):
                lists = [r.get(way, []) for port, r in rules if port == 7072]
                selectors = [peer.get("podSelector", {}) for peers in lists for peer in peers]
                if not any(selects(selector, other) for selector in selectors):
                    yield f"{pods.name}: the way {way} {other.name} is closed"
                if not all(lists):
                    yield f"{pods.name}: port 7072 is open to everybody"


def selects(selector: Object, pods: Pods) -> bool:
    """Whether a selector with labels selects these pods."""
    labels = selector.get("matchLabels")
    return labels is not None and labels.items() <= pods.labels.items()


@rule
def references_lead_somewhere(release: Release) -> Iterator[str]:
    """Volumes are mounted, files of variables are on them, and objects of the release exist."""
    claims = release.names("PersistentVolumeClaim") | release.external
    made = {c["spec"]["secretName"] for c in release.all("Certificate")}
    for pods in release.pods():
        volumes = {volume["name"]: volume for volume in pods.spec.get("volumes", [])}
        for container in pods.containers:
            mounts = container.get("volumeMounts", [])
            for missing in {mount["name"] for mount in mounts} - volumes.keys():
                yield f"{pods.name}: there is no volume {missing}"
            for name, value in pods.environment(container).items():
                paths = [mount["mountPath"] for mount in mounts]
                if value.startswith("/") and not any(value.startswith(path) for path in paths):
                    yield f"{pods.name}: {name} names {value}, where nothing is mounted"
        for volume in volumes.values():
            config = volume.get("configMap", {}).get("name")
            if config is not None and config not in release.names("ConfigMap"):
                yield f"{pods.name}: there is no ConfigMap {config}"
            claim = volume.get("persistentVolumeClaim", {}).get("claimName")
            if claim is not None and claim not in claims:
                yield f"{pods.name}: there is no claim {claim}"
            secret = volume.get("secret", {}).get("secretName")
            if secret is not None and made and secret.endswith("-tls") and secret not in made:
                yield f"{pods.name}: no certificate makes the secret {secret}"
        account = pods.spec.get("serviceAccountName")
        if account is not None and account not in release.names("ServiceAccount"):
            yield f"{pods.name}: there is no ServiceAccount {account}"
    issuers = release.names("Issuer")
    for certificate in release.all("Certificate"):
        if certificate["spec"]["issuerRef"]["name"] not in issuers:
            yield f"Certificate {certificate['metadata']['name']}: there is no such issuer"


@rule
def certificates_have_the_names_that_are_called(release: Release) -> Iterator[str]:
    """Workers call servers, servers call workers, and tests call the service."""
    hosts = [name for c in release.all("Certificate") for name in c["spec"].get("dnsNames", [])]
    services = [f"{name}.bendtwin.svc" for name in release.names("Service")]
    for pods in release.pods("worker", "test"):
        for container in pods.containers:
            environment = pods.environment(container)
            for name in ("BENDTWIN_SERVER", "BENDTWIN_WORKER_ADVERTISE"):
                host = re.sub(r"^https?://|:\d+$", "", environment.get(name, ""))
                host = host.replace("$(POD)", "pod-0")
                if host and not any(host == s or host.endswith(f".{s}") for s in services):
                    yield f"{pods.name}: {name} names {host}, which is no service"
                if host and hosts and not any(fnmatch.fnmatch(host, h) for h in hosts):
                    yield f"{pods.name}: no certificate is for {host}"


@rule
def gpus_are_asked_for(release: Release) -> Iterator[str]:
    """A pod on CUDA has the image with the compiler and one GPU, and others have neither."""
    for pods in release.pods("server", "worker"):
        (container,) = pods.containers
        cuda = pods.environment(container).get("BENDTWIN_BACKEND") == "cuda"
        gpus = [
            {name: n for name, n in container["resources"].get(part, {}).items() if "/" in name}
            for part in ("requests", "limits")
        ]
        if gpus[0] != gpus[1] or list(gpus[1].values()) != (["1"] if cuda else []):
            yield f"{pods.name}: it asks for {gpus[1] or 'no GPU'}"
        if container["image"].endswith("-cuda") != cuda:
            yield f"{pods.name}: {container['image']} is not the image of its backend"


@rule
def scaled_pools_exist(release: Release) -> Iterator[str]:
    """KEDA finds the pool, decides its size alone, and has the credentials for the database."""
    pools = {pods.owner["metadata"]["name"]: pods for pods in release.pods("worker")}
    scaled = set()
    for object_ in release.all("ScaledObject"):
        name = object_["spec"]["scaleTargetRef"]["name"]
        scaled.add(name)
        if name not in pools or pools[name].replicas is not None:
            yield f"ScaledObject {name}: there is no pool without a size for it"
            continue
        triggers = {trigger["name"]: trigger for trigger in object_["spec"]["triggers"]}
        if not {"fits", "ingests"} <= triggers.keys():
            yield f"ScaledObject {name}: fits or ingests do not count"
        known = release.names("TriggerAuthentication")
        for trigger in triggers.values():
            reference = trigger.get("authenticationRef", {}).get("name")
            if trigger["type"] == "postgresql" and reference not in known:
                yield f"ScaledObject {name}: it has no credentials for the database"
    for name in {n for n, pods in pools.items() if pods.replicas is None} - scaled:
        yield f"StatefulSet {name}: nothing decides its size"


@rule
def names_are_short_enough(release: Release) -> Iterator[str]:
    """Kubernetes puts suffixes behind names, and bounds the results to 63 characters."""
    most = {"CronJob": 52, "StatefulSet": 52}
    for object_ in release.objects:
        name = object_["metadata"]["name"]
        if len(name) > most.get(object_["kind"], 63):
            yield f"{object_['kind']} {name}: the name is too long"


@rule
def options_and_metrics_are_documented(release: Release) -> Iterator[str]:
    """Tests compare docs/run with the program: what is not there does not exist."""
    pages = [page for page in (ROOT / "docs/run").glob("*.md") if "kubernetes" not in page.name]
    texts = "".join(page.read_text() for page in pages)
    known = set(re.findall(r"\bBENDTWIN_[A-Z0-9_]+", texts))
    monitoring = metrics((ROOT / "docs/run/monitoring.md").read_text())
    for pods in release.pods():
        for container in pods.containers:
            for variable in container.get("env", []):
                name = variable["name"]
                if name.startswith("BENDTWIN_") and name not in known:
                    yield f"{pods.name}: docs/run does not know {name}"
    for object_ in release.all("ScaledObject", "PrometheusRule"):
        for text in documents(object_["spec"]):
            for name in metrics(text) - monitoring:
                yield f"{object_['kind']} {object_['metadata']['name']}: there is no metric {name}"


@rule
def monitors_are_complete(release: Release) -> Iterator[str]:
    """The operator reads the port of clients, and gets the rules that Prometheus has."""
    for monitor in release.all("PodMonitor"):
        for endpoint in monitor["spec"]["podMetricsEndpoints"]:
            for pods in release.selected(monitor["spec"]["selector"]["matchLabels"]):
                if endpoint["port"] not in pods.ports:
                    yield f"PodMonitor {monitor['metadata']['name']}: {pods.name} has no such port"
            if "authorization" not in endpoint:
                yield f"PodMonitor {monitor['metadata']['name']}: it has no key"
    rules = yaml.safe_load((ROOT / "deploy/prometheus/alerts.yaml").read_text())
    for object_ in release.all("PrometheusRule"):
        if object_["spec"] != rules:
            yield "PrometheusRule: its rules are not those of deploy/prometheus/alerts.yaml"
