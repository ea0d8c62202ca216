"""Dataclasses to messages of ROS, and back, by the names of their fields.

The generated classes of ROS are found by the name that each dataclass has in `ROS`, so this file
imports no package of messages until one is needed.
"""

from __future__ import annotations

from array import array
from dataclasses import fields, is_dataclass
from functools import cache
from importlib import import_module
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

_Message = TypeVar("_Message")


@cache
def ros_class(name: str) -> Any:
    """The class of a message, service or action: `sensor_msgs/msg/Image`; parts of a service or
    an action are named `..._Request` or `..._Goal`."""
    package, kind, cls = name.split("/")
    module = import_module(f"{package}.{kind}")
    whole, _, part = cls.rpartition("_")
    return getattr(getattr(module, whole), part) if part and whole else getattr(module, cls)


def to_ros(message: Any) -> Any:
    """The message of ROS with the fields of a dataclass."""
    ros = ros_class(message.ROS)()
    for field in fields(message):
        value = getattr(message, field.name)
        if is_dataclass(value):
            value = to_ros(value)
        elif isinstance(value, list) and value and is_dataclass(value[0]):
            value = [to_ros(one) for one in value]
        elif isinstance(value, bytes) and not isinstance(getattr(ros, field.name), bytes):
            # Bytes of a `byte` are bytes there; those of `uint8[]` are an array, which is set
            # without a look at each.
            value = array("B", value)
        setattr(ros, field.name, value)
    return ros


def from_ros(cls: type[_Message], ros: Any) -> _Message:
    """The dataclass with those fields of a message of ROS that it has."""
    given: dict[str, Any] = {}
    hint: Any
    # Any type is hashable, but types do not say so.
    of: Any = cls
    for name, hint in _hints(of).items():
        value = getattr(ros, name)
        if get_origin(hint) is list:
            item: Any
            [item] = get_args(hint)
            is_message = _is_message(item)
            value = [from_ros(item, one) if is_message else item(one) for one in value]
        elif _is_message(hint):
            value = from_ros(hint, value)
        elif hint is bytes:
            value = bytes(value)
        given[name] = value
    return cls(**given)


def _is_message(hint: Any) -> bool:
    return is_dataclass(hint)


@cache
def _hints(cls: Any) -> dict[str, Any]:
    hints = get_type_hints(cls)
    return {field.name: hints[field.name] for field in fields(cls)}
