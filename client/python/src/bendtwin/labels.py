"""Names, notes and tags of captures, fits and twins: how they are changed, and listed by."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypedDict

from google.protobuf.field_mask_pb2 import FieldMask


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


class ListArguments(TypedDict, total=False):
    """Selection of a list; without any of it everything, newest first."""

    #: Text in display name or note, ignoring case.
    search: str
    tag: str
    #: Owner of the key that created them.
    owner: str
    #: `create_time`, `name` or, of fits and twins, `error`, with ` desc` behind it if descending.
    order_by: str


def fields(change: LabelArguments) -> dict[str, Any]:
    """The fields of a resource that a change sets."""
    given: dict[str, Any] = {}
    if "display_name" in change:
        given["display_name"] = change["display_name"]
    if "note" in change:
        given["note"] = change["note"]
    if "tags" in change:
        given["tags"] = list(change["tags"])
    return given


def beside(change: LabelArguments) -> dict[str, Any]:
    """The part of a request beside the resource."""
    return {
        "update_mask": FieldMask(paths=list(fields(change))),
        "add_tags": list(change.get("add_tags", ())),
        "remove_tags": list(change.get("remove_tags", ())),
    }
