"""Reads URDF: https://wiki.ros.org/urdf/XML, without what only looks or weighs.

A description may come from anyone, so that nothing in it is trusted: there are no entities, sizes
are limited, and all numbers are finite and of a robot's magnitude.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

from bendtwin.robots.description import (
    Array,
    Attachment,
    Ball,
    Box,
    Cylinder,
    Description,
    Form,
    JointKind,
    Limits,
    Link,
    MeshFile,
    Mimic,
    Part,
    RobotError,
)
from bendtwin.rotations import of_angles

_LARGEST_BYTES = 16 << 20
_MOST_LINKS = 1000
_LONGEST_NAME = 100
#: Largest length, in metres, and largest value of any other number.
_FARTHEST_M = 1000.0
_LARGEST = 1e9
_KINDS: dict[str, JointKind] = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "fixed": "fixed",
}

_XACRO = "the description has parts of xacro: expand it first, with `xacro FILE > robot.urdf`"

_Element = Any


def read_urdf(
    path_or_text: str | os.PathLike[str], package_dirs: Sequence[str | os.PathLike[str]] = ()
) -> Description:
    """The description in a file, or in text that contains a tag.

    Raises:
        RobotError: If it is not a URDF, or describes no robot.
        OSError: If the file cannot be read.
    """
    text, folder = _text(path_or_text)
    root = _parsed(text)
    places = _Places(folder, [Path(p) for p in package_dirs])
    links = [_link(element, places) for element in root.findall("link")]
    if not links:
        raise RobotError("the description has no links")
    if len(links) > _MOST_LINKS:
        raise RobotError(f"the description has {len(links)} links: at most {_MOST_LINKS}")
    _unique("link", [link.name for link in links])
    attachments = [_attachment(element) for element in root.findall("joint")]
    _unique("joint", [joint.name for joint in attachments])
    return Description(root.get("name", "robot"), tuple(links), tuple(attachments))


def _text(path_or_text: str | os.PathLike[str]) -> tuple[str, Path | None]:
    if isinstance(path_or_text, str) and "<" in path_or_text:
        if len(path_or_text) > _LARGEST_BYTES:
            raise RobotError(f"the text is longer than {_LARGEST_BYTES} characters")
        return path_or_text, None
    path = Path(path_or_text)
    with path.open("rb") as file:
        data = file.read(_LARGEST_BYTES + 1)
    if len(data) > _LARGEST_BYTES:
        raise RobotError(f"{path} has more than {_LARGEST_BYTES} bytes")
    try:
        return data.decode("utf-8-sig"), path.parent
    except UnicodeDecodeError:
        raise RobotError(f"{path} is not a URDF: it is not text in UTF-8") from None


def _parsed(text: str) -> _Element:
    # Entities are declared there. Some expand to gigabytes, others read files.
    if re.search(r"<!(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise RobotError("the description has a DOCTYPE, which no URDF needs: remove it")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        if "<xacro:" in text:
            raise RobotError(_XACRO) from None
        raise RobotError(f"the description is not XML: {error}") from None
    for element in root.iter():
        values = [value for value in element.attrib.values() if "${" in value or "$(" in value]
        if values or "xacro" in str(element.tag):
            raise RobotError(_XACRO)
    if root.tag != "robot":
        raise RobotError(f"the description begins with <{root.tag}>, a URDF with <robot>")
    return root


class _Places:
    """Where the files of meshes are."""

    def __init__(self, folder: Path | None, packages: list[Path]) -> None:
        self._folder, self._packages = folder, packages

    def of(self, name: str) -> tuple[Path, ...]:
        """Candidates for a file that a mesh names."""
        for scheme in ("package://", "model://"):
            if name.startswith(scheme):
                package, _, rest = unquote(name.removeprefix(scheme)).partition("/")
                inside = [p / package / rest for p in self._packages]
                inside += [p / rest for p in self._packages if p.name == package]
                return tuple(inside)
        plain = Path(unquote(name.removeprefix("file://")))
        if plain.is_absolute():
            return (plain,)
        folders = [] if self._folder is None else [self._folder]
        return tuple(folder / plain for folder in [*folders, *self._packages])


def _link(element: _Element, places: _Places) -> Link:
    name = _name(element, "a link")
    what = f"link {name!r}"
    parts = [_part(collision, what, places) for collision in element.findall("collision")]
    return Link(name, tuple(parts))


def _part(element: _Element, what: str, places: _Places) -> Part:
    geometry = element.find("geometry")
    if geometry is None or not len(geometry):
        raise RobotError(f"{what} has a collision shape without a geometry")
    return Part(_form(geometry[0], what, places), _origin(element, what))


def _form(element: _Element, what: str, places: _Places) -> Form:
    if element.tag == "sphere":
        return Ball(_length(element, "radius", what))
    if element.tag == "box":
        sides = _numbers(element, "size", 3, None, what, _FARTHEST_M)
        if not (sides > 0.0).all():
            raise RobotError(f"{what} has a box of the size {sides}: sides must be above 0")
        return Box(sides)
    if element.tag in ("cylinder", "capsule"):
        return Cylinder(_length(element, "radius", what), _length(element, "length", what))
    if element.tag == "mesh":
        name = element.get("filename", "")
        if not name or "\0" in name:
            raise RobotError(f"{what} has a mesh without a filename")
        scale = _numbers(element, "scale", 3, (1.0, 1.0, 1.0), what, _FARTHEST_M)
        if not scale.all():
            raise RobotError(f"{what} has a mesh with a scale of 0")
        return MeshFile(name, scale, places.of(name))
    raise RobotError(
        f"{what} has a collision shape {element.tag!r}: use box, cylinder, sphere or mesh"
    )


def _attachment(element: _Element) -> Attachment:
    name = _name(element, "a joint")
    what = f"joint {name!r}"
    kind = _KINDS.get(element.get("type", ""))
    if kind is None:
        raise RobotError(
            f"{what} is of the type {element.get('type')!r}: use revolute, continuous, prismatic "
            "or fixed, several of them where it moves in several ways"
        )
    ends = []
    for end in ("parent", "child"):
        found = element.find(end)
        if found is None or not found.get("link"):
            raise RobotError(f"{what} has no {end}: add <{end} link=...>")
        ends.append(found.get("link"))
    axis_element = element.find("axis")
    axis = np.array([1.0, 0.0, 0.0])
    if axis_element is not None:
        axis = _numbers(axis_element, "xyz", 3, (1.0, 0.0, 0.0), what, _LARGEST)
    if kind != "fixed":
        length = np.linalg.norm(axis)
        if length < 1e-6:
            raise RobotError(f"{what} has an axis of zeros")
        axis = axis / length
    return Attachment(
        name=name,
        kind=kind,
        parent=ends[0],
        child=ends[1],
        origin=_origin(element, what),
        axis=axis,
        limits=_limits(element.find("limit"), kind, what),
        mimic=_mimic(element.find("mimic"), what),
    )


def _limits(element: _Element | None, kind: JointKind, what: str) -> Limits:
    if element is None or kind == "fixed":
        return Limits()
    speed = _number(element, "velocity", np.inf, what)
    if speed < 0.0:
        raise RobotError(f"{what} has a velocity limit below 0")
    if kind == "continuous":
        return Limits(speed=speed)
    if element.get("lower") is None and element.get("upper") is None:
        return Limits(speed=speed)
    low, high = _number(element, "lower", 0.0, what), _number(element, "upper", 0.0, what)
    if low > high:
        raise RobotError(f"{what} has its lower limit {low} above its upper one {high}")
    return Limits(low=low, high=high, speed=speed)


def _mimic(element: _Element | None, what: str) -> Mimic | None:
    if element is None:
        return None
    leader = element.get("joint")
    if not leader:
        raise RobotError(f"{what} has a mimic without a joint")
    factor = _number(element, "multiplier", 1.0, what)
    return Mimic(leader, factor, _number(element, "offset", 0.0, what))


def _origin(element: _Element, what: str) -> Array:
    origin = element.find("origin")
    if origin is None:
        return np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    zeros = (0.0, 0.0, 0.0)
    xyz = _numbers(origin, "xyz", 3, zeros, what, _FARTHEST_M)
    rpy = _numbers(origin, "rpy", 3, zeros, what, _LARGEST)
    return np.concatenate([xyz, of_angles(rpy)])


def _length(element: _Element, name: str, what: str) -> float:
    value = float(_numbers(element, name, 1, None, what, _FARTHEST_M)[0])
    if not value > 0.0:
        raise RobotError(f"{what} has a {name} of {value}: it must be above 0")
    return value


def _number(element: _Element, name: str, default: float, what: str) -> float:
    return float(_numbers(element, name, 1, (default,), what, _LARGEST)[0])


def _numbers(
    element: _Element,
    name: str,
    count: int,
    default: tuple[float, ...] | None,
    what: str,
    largest: float,
) -> Array:
    text = element.get(name)
    if text is None:
        if default is None:
            raise RobotError(f"{what} has a {element.tag} without {name}")
        return np.array(default)
    words = text.split(maxsplit=count)
    try:
        values = np.array([float(word) for word in words])
    except ValueError:
        values = np.zeros(0)
    if len(values) != count:
        raise RobotError(f"{what} has {name}={_short(text)}: give {count} numbers")
    if not (np.abs(values) <= largest).all():
        raise RobotError(
            f"{what} has {name}={_short(text)}: numbers must be finite and at most {largest:g}; "
            "the units are metres and radians"
        )
    return values


def _name(element: _Element, what: str) -> str:
    name: str = element.get("name", "")
    if not name:
        raise RobotError(f"{what} of the description has no name")
    if len(name.encode()) > _LONGEST_NAME or not name.isprintable():
        raise RobotError(
            f"{what} has the name {_short(name)}: names are printable, and at most "
            f"{_LONGEST_NAME} bytes long"
        )
    return name


def _unique(what: str, names: list[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise RobotError(f"the description has two {what}s {name!r}: names must differ")
        seen.add(name)


def _short(text: str) -> str:
    return repr(text if len(text) <= 40 else text[:40] + "…")
