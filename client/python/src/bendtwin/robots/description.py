"""Parts of a robot: links, the joints between them, and the shapes of links."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

JointKind = Literal["revolute", "continuous", "prismatic", "fixed"]
Array = npt.NDArray[np.float64]


class RobotError(ValueError):
    """A robot description that cannot be used; the message says what to change."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Limits of a joint: radians, or metres of a prismatic one."""

    low: float = -np.inf
    high: float = np.inf
    #: Highest speed, per second.
    speed: float = np.inf


@dataclass(frozen=True)
class Joint:
    """A joint that moves by itself: neither fixed nor a mimic of another one."""

    name: str
    kind: JointKind
    #: Infinite where the description says nothing.
    limits: Limits


@dataclass(frozen=True)
class Mimic:
    """A joint that moves as another one: factor times its position, plus an offset."""

    joint: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Attachment:
    """The joint that attaches a link to its parent."""

    name: str
    kind: JointKind
    parent: str
    child: str
    #: Pose of the child in the parent's coordinates where the joint is at 0, [7].
    origin: Array
    #: Unit vector in the child's coordinates [3].
    axis: Array
    limits: Limits
    mimic: Mimic | None = None


@dataclass(frozen=True)
class Ball:
    """A sphere about the origin."""

    radius_m: float


@dataclass(frozen=True)
class Box:
    """A box about the origin, with the lengths of its sides [3]."""

    sides_m: Array


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z, with its middle in the origin."""

    radius_m: float
    length_m: float


@dataclass(frozen=True)
class MeshFile:
    """A mesh in a file."""

    #: Name in the description.
    name: str
    #: Factors of x, y and z [3].
    scale: Array
    #: Places where the file may be.
    candidates: tuple[Path, ...]


Form = Ball | Box | Cylinder | MeshFile


@dataclass(frozen=True)
class Part:
    """A collision shape of a link, at a pose [7] in its coordinates."""

    form: Form
    pose: Array


@dataclass(frozen=True)
class Link:
    """A rigid body of a robot."""

    name: str
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Description:
    """A robot as its file describes it."""

    name: str
    links: tuple[Link, ...]
    attachments: tuple[Attachment, ...]
