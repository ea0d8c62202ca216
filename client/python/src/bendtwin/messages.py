"""Values of messages: dataclasses with the fields of a message, which are read from it."""

from __future__ import annotations

import enum
import functools
import json
from collections.abc import Callable
from dataclasses import fields
from datetime import datetime, timezone
from types import UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

_Value = TypeVar("_Value", bound="FromMessage")


class FromMessage:
    """Base of dataclasses with the fields of a message, each converted to its type here.

    An optional field is None where the message has none. A dictionary is read from the text of
    `<name>_json`, and a literal is the word of an enum.
    """

    @classmethod
    def from_proto(cls: type[_Value], message: Any) -> _Value:
        """Reads the wire form."""
        kind: Any = cls
        return cls(**{name: read(message) for name, read in _readers(kind).items()})


@functools.cache
def _readers(kind: Any) -> dict[str, Callable[[Any], Any]]:
    hints = get_type_hints(kind)
    return {field.name: _reader(field.name, hints[field.name]) for field in fields(kind)}


def _reader(name: str, hint: Any) -> Callable[[Any], Any]:
    """A function that reads a field of that type from a message."""
    if get_origin(hint) in (Union, UnionType):
        (given,) = (one for one in get_args(hint) if one is not type(None))
        convert = _conversion(given)
        return lambda message: convert(getattr(message, name)) if message.HasField(name) else None
    if get_origin(hint) is dict:
        return lambda message: json.loads(getattr(message, f"{name}_json") or "{}")
    if get_origin(hint) is Literal:
        return lambda message: _word(message, name)
    convert = _conversion(hint)
    return lambda message: convert(getattr(message, name))


def _word(message: Any, name: str) -> str:
    """The value of an enum in small letters."""
    words = message.DESCRIPTOR.fields_by_name[name].enum_type.values_by_number
    word: str = words[getattr(message, name)].name
    return word.lower()


def _conversion(hint: Any) -> Callable[[Any], Any]:
    """A function that converts the value of a field to that type."""
    origin = get_origin(hint)
    if origin in (list, tuple):
        convert = _conversion(get_args(hint)[0])
        return lambda items: origin(map(convert, items))
    if hint is datetime:
        return lambda time: time.ToDatetime(tzinfo=timezone.utc)
    read: Callable[[Any], Any] | None = getattr(hint, "from_proto", None)
    if read is not None:
        return read
    return hint if issubclass(hint, enum.Enum) else lambda value: value
