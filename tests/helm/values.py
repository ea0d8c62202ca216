"""The values of the chart: their tables for the documentation, and their schema."""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import yaml
from rules import ROOT

CHART = ROOT / "deploy/helm/bendtwin"
PAGE = ROOT / "docs/run/kubernetes-values.md"
HEAD = """# Values of the Helm chart

Give them in a file (`--values FILE`) or one by one (`--set NAME=VALUE`).
[kubernetes.md](kubernetes.md) shows how they belong together.
This page is made of the comments in `values.yaml` of the chart.
`values.schema.json` refuses everything else.
"""


@dataclass
class Value:
    """A value with its description."""

    path: str
    default: Any
    text: str


def described() -> list[Value]:
    """Values with a comment that begins with `--`, in the order of the file."""
    text = (CHART / "values.yaml").read_text()
    defaults = yaml.safe_load(text)
    found, keys, comment = [], [], None
    for line in text.splitlines():
        if note := re.match(r" *# -- (.*)", line):
            comment = note[1]
        elif key := re.match(r"( *)([A-Za-z]+):", line):
            keys = [*keys[: len(key[1]) // 2], key[2]]
            if comment is not None:
                found.append(Value(".".join(keys), at(defaults, keys), comment))
            comment = None
    return found


def at(values: Any, keys: list[str]) -> Any:
    """The part of values at a path."""
    for key in keys:
        values = values[key]
    return values


def page() -> str:
    """The page of the documentation: a table for each part, first what belongs to none."""
    lines, part = [HEAD], None
    for value in sorted(described(), key=lambda value: "." in value.path):
        own = value.path.split(".")[0] if "." in value.path else "general"
        if own != part:
            lines.append(f"\n## {own}\n\n| value | default | meaning |\n|---|---|---|\n")
            part = own
        default = "" if value.default in ("", [], {}) else f"`{json.dumps(value.default)}`"
        text = value.text.replace("|", "\\|")
        lines.append(f"| `{value.path}` | {default} | {text} |\n")
    return "".join(lines)


def schema_faults() -> Iterator[str]:
    """Values without a description or a schema, and schemas without a value."""
    schema = json.loads((CHART / "values.schema.json").read_text())
    defaults = yaml.safe_load((CHART / "values.yaml").read_text())
    texts = {value.path for value in described()}
    in_schema = set(leaves_of_schema(schema, schema, ""))
    in_values = set(leaves(defaults, texts, ""))
    for path in sorted(in_values - texts):
        yield f"values.yaml: {path} has no description (# --)"
    for path in sorted(in_values - in_schema):
        yield f"values.schema.json: {path} is missing"
    for path in sorted(in_schema - in_values):
        yield f"values.yaml: {path} is missing, which values.schema.json has"


def leaves(values: dict[str, Any], texts: set[str], prefix: str) -> Iterator[str]:
    """Paths of single values: a map with a description is one."""
    for key, value in values.items():
        path = prefix + key
        if isinstance(value, dict) and path not in texts:
            yield from leaves(value, texts, f"{path}.")
        else:
            yield path


def leaves_of_schema(schema: dict[str, Any], root: dict[str, Any], prefix: str) -> Iterator[str]:
    """Paths of what the schema bounds, without `global`, which Helm adds."""
    for key, part in schema["properties"].items():
        path = prefix + key
        while "$ref" in part:
            part = root["$defs"][part["$ref"].removeprefix("#/$defs/")]
        closed = part.get("additionalProperties") is False
        if closed and key not in ("resources", "issuerRef"):
            yield from leaves_of_schema(part, root, f"{path}.")
        elif path != "global":
            yield path
