"""What people look at: visualization_msgs and diagnostic_msgs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from bendtwin_ros.messages.basic import ColorRGBA, Duration, Header, Point, Pose, Vector3


@dataclass
class Marker:
    """A shape in RViz."""

    LINE_STRIP: ClassVar[int] = 4
    SPHERE_LIST: ClassVar[int] = 7
    TRIANGLE_LIST: ClassVar[int] = 11
    ADD: ClassVar[int] = 0
    DELETEALL: ClassVar[int] = 3

    ROS: ClassVar[str] = "visualization_msgs/msg/Marker"
    header: Header = field(default_factory=Header)
    ns: str = ""
    id: int = 0
    type: int = 0
    action: int = 0
    pose: Pose = field(default_factory=Pose)
    scale: Vector3 = field(default_factory=Vector3)
    color: ColorRGBA = field(default_factory=ColorRGBA)
    lifetime: Duration = field(default_factory=Duration)
    points: list[Point] = field(default_factory=list)
    colors: list[ColorRGBA] = field(default_factory=list)


@dataclass
class MarkerArray:
    """Markers that are shown together."""

    ROS: ClassVar[str] = "visualization_msgs/msg/MarkerArray"
    markers: list[Marker] = field(default_factory=list)


@dataclass
class KeyValue:
    """A fact of a status."""

    ROS: ClassVar[str] = "diagnostic_msgs/msg/KeyValue"
    key: str = ""
    value: str = ""


@dataclass
class DiagnosticStatus:
    """The status of a part."""

    OK: ClassVar[bytes] = b"\0"
    WARN: ClassVar[bytes] = b"\1"
    ERROR: ClassVar[bytes] = b"\2"

    ROS: ClassVar[str] = "diagnostic_msgs/msg/DiagnosticStatus"
    level: bytes = OK
    name: str = ""
    message: str = ""
    hardware_id: str = ""
    values: list[KeyValue] = field(default_factory=list)


@dataclass
class DiagnosticArray:
    """Statuses at a time."""

    ROS: ClassVar[str] = "diagnostic_msgs/msg/DiagnosticArray"
    header: Header = field(default_factory=Header)
    status: list[DiagnosticStatus] = field(default_factory=list)
