"""What people state about captures, fits and twins: at an upload, in a change, and to list them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from typing import Any, TypedDict, cast

from google.protobuf.field_mask_pb2 import FieldMask

from bendtwin.resources import Requirements


class CaptureArguments(TypedDict, total=False):
    """Facts that accompany the upload of a capture; None is the same as omitted."""

    #: By default the name of the file or folder.
    display_name: str | None
    #: The same content with the same `request_id` is one capture.
    request_id: str | None
    #: Settings of the ingest that differ from the defaults (docs/use/settings.md).
    ingest: dict[str, Any] | None
    #: Worker that reads the capture; by default any.
    ingest_requirements: Requirements | None
    #: Who recorded it.
    recorded_by: str | None


class LabelArguments(TypedDict, total=False):
    """A change of name, note and tags; omitted ones stay."""

    display_name: str
    #: Note written by users.
    note: str
    #: All tags, replacing the existing ones.
    tags: Iterable[str]
    #: Tags to add and to remove, so that two clients do not undo each other's changes.
    add_tags: Iterable[str]
    remove_tags: Iterable[str]


class CaptureLabelArguments(LabelArguments, total=False):
    """A change of what is stated about a capture; omitted facts stay."""

    #: Who recorded it; empty removes it.
    recorded_by: str


class ListArguments(TypedDict, total=False):
    """Selection of a list; without any of it everything, newest first."""

    #: Text in display name or note, ignoring case.
    search: str
    tag: str
    #: Owner of the key that created them.
    owner: str
    #: `create_time`, `name` or, of fits and twins, `error`, with ` desc` behind it if descending.
    order_by: str


class CaptureListArguments(ListArguments, total=False):
    """Selection of a list of captures."""

    #: Who recorded them.
    recorded_by: str


def named(facts: CaptureArguments, name: str) -> CaptureArguments:
    """The facts of an upload, with a display name where none is stated.

    Raises `TypeError` for facts that do not exist, as for any other wrong argument.
    """
    unknown = sorted(facts.keys() - CaptureArguments.__optional_keys__)
    if unknown:
        raise TypeError(f"unexpected facts of a capture: {', '.join(unknown)}")
    return facts if facts.get("display_name") is not None else {**facts, "display_name": name}


def metadata(facts: CaptureArguments) -> dict[str, Any]:
    """The facts of an upload as fields of its message."""
    fields: dict[str, Any] = {}
    for name, fact in _stated(facts):
        if isinstance(fact, Requirements):
            fields[name] = fact.to_proto()
        elif isinstance(fact, dict):
            fields[f"{name}_json"] = json.dumps(fact)
        else:
            fields[name] = fact
    return fields


def texts(facts: CaptureArguments) -> dict[str, str]:
    """The facts of an upload as the metadata of tus: texts unchanged, others as JSON."""
    return {
        name: fact
        if isinstance(fact, str)
        else json.dumps(asdict(fact) if isinstance(fact, Requirements) else fact, sort_keys=True)
        for name, fact in _stated(facts)
    }


def _stated(facts: CaptureArguments) -> Iterator[tuple[str, Any]]:
    for name, fact in facts.items():
        if fact is not None and fact not in ({}, Requirements()):
            yield name, fact


def fields(change: LabelArguments) -> dict[str, Any]:
    """The fields of a resource that a change sets."""
    given = cast("Mapping[str, Any]", change).items()
    # All are texts but the tags.
    return {
        name: value if isinstance(value, str) else list(value)
        for name, value in given
        if name not in ("add_tags", "remove_tags")
    }


def beside(change: LabelArguments) -> dict[str, Any]:
    """The part of a request beside the resource."""
    return {
        "update_mask": FieldMask(paths=list(fields(change))),
        "add_tags": list(change.get("add_tags", ())),
        "remove_tags": list(change.get("remove_tags", ())),
    }
