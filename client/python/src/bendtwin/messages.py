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

import numpy as np

from bendtwin.tensors import unpack

_Value = TypeVar("_Value", bound="FromMessage")


class FromMessage:
    """Base of dataclasses with the fields of a message, each converted to its type here.

    An optional field is None where the message has none, a list or an array is empty. A dictionary
    is read from the text of `<name>_json`, a literal is the word of an enum (its first word where
    the enum is not set), and a pair of numbers is a message of two.
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
    hint = _meant(hint)
    if get_origin(hint) in (Union, UnionType):
        (given,) = (_meant(one) for one in get_args(hint) if one is not type(None))
        convert = unpack if get_origin(given) is np.ndarray else _conversion(given)
        return lambda message: convert(getattr(message, name)) if message.HasField(name) else None
    if get_origin(hint) is dict:
        return lambda message: json.loads(getattr(message, f"{name}_json") or "{}")
    if get_origin(hint) is Literal:
        return lambda message: _word(message, name, get_args(hint))
    convert = _conversion(hint)
    return lambda message: convert(getattr(message, name))


def _meant(hint: Any) -> Any:
    """The type that an alias stands for, as `NDArray` is one from NumPy 2.5 on."""
    while (meant := getattr(get_origin(hint) or hint, "__value__", None)) is not None:
        given = get_args(hint)
        hint = meant[given] if given else meant
    return hint


def _word(message: Any, name: str, known: tuple[str, ...]) -> str:
    """The value of an enum in small letters; the first that is known in place of another."""
    words = message.DESCRIPTOR.fields_by_name[name].enum_type.values_by_number
    value = words.get(getattr(message, name))
    word: str = "" if value is None else value.name.lower()
    return word if word in known else known[0]


def _conversion(hint: Any) -> Callable[[Any], Any]:
    """A function that converts the value of a field to that type."""
    hint = _meant(hint)
    origin, inner = get_origin(hint), get_args(hint)
    if origin is list or (origin is tuple and inner[-1] is ...):
        convert = _conversion(inner[0])
        return lambda items: origin(map(convert, items))
    if origin is tuple:
        return lambda pair: tuple(getattr(pair, field.name) for field in pair.DESCRIPTOR.fields)
    if origin is np.ndarray:
        return _array
    if hint is datetime:
        return lambda time: time.ToDatetime(tzinfo=timezone.utc)
    read: Callable[[Any], Any] | None = getattr(hint, "from_proto", None)
    if read is not None:
        return read
    return hint if issubclass(hint, enum.Enum) else lambda value: value


def _array(tensor: Any) -> Any:
    array = unpack(tensor)
    return np.zeros(0) if array is None else array
