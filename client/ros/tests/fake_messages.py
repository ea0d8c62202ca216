"""Classes of messages as rosidl generates them for Python: fields with defaults, keyword arguments,
and assignments that refuse unknown fields and wrong types.

The fields of official messages are listed below, whole, so that a name that this package gets wrong
is refused; those of bendtwin_msgs are read from its files.
"""

from __future__ import annotations

import re
import sys
from array import array
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import numpy as np

FILES = Path(__file__).parents[1] / "bendtwin_msgs"

OFFICIAL = """
builtin_interfaces/msg/Time: int32 sec, uint32 nanosec
builtin_interfaces/msg/Duration: int32 sec, uint32 nanosec
std_msgs/msg/Header: builtin_interfaces/Time stamp, string frame_id
std_msgs/msg/ColorRGBA: float32 r, float32 g, float32 b, float32 a
geometry_msgs/msg/Point: float64 x, float64 y, float64 z
geometry_msgs/msg/Point32: float32 x, float32 y, float32 z
geometry_msgs/msg/Vector3: float64 x, float64 y, float64 z
geometry_msgs/msg/Quaternion: float64 x, float64 y, float64 z, float64 w
geometry_msgs/msg/Pose: geometry_msgs/Point position, geometry_msgs/Quaternion orientation
geometry_msgs/msg/PoseStamped: std_msgs/Header header, geometry_msgs/Pose pose
geometry_msgs/msg/PoseArray: std_msgs/Header header, geometry_msgs/Pose[] poses
geometry_msgs/msg/Transform: geometry_msgs/Vector3 translation, geometry_msgs/Quaternion rotation
geometry_msgs/msg/TransformStamped: std_msgs/Header header, string child_frame_id, \
geometry_msgs/Transform transform
geometry_msgs/msg/Wrench: geometry_msgs/Vector3 force, geometry_msgs/Vector3 torque
geometry_msgs/msg/WrenchStamped: std_msgs/Header header, geometry_msgs/Wrench wrench
sensor_msgs/msg/PointField: string name, uint32 offset, uint8 datatype, uint32 count
sensor_msgs/msg/PointCloud2: std_msgs/Header header, uint32 height, uint32 width, \
sensor_msgs/PointField[] fields, bool is_bigendian, uint32 point_step, uint32 row_step, \
uint8[] data, bool is_dense
sensor_msgs/msg/JointState: std_msgs/Header header, string[] name, float64[] position, \
float64[] velocity, float64[] effort
visualization_msgs/msg/Marker: std_msgs/Header header, string ns, int32 id, int32 type, \
int32 action, geometry_msgs/Pose pose, geometry_msgs/Vector3 scale, std_msgs/ColorRGBA color, \
builtin_interfaces/Duration lifetime, bool frame_locked, geometry_msgs/Point[] points, \
std_msgs/ColorRGBA[] colors, string text
visualization_msgs/msg/MarkerArray: visualization_msgs/Marker[] markers
diagnostic_msgs/msg/KeyValue: string key, string value
diagnostic_msgs/msg/DiagnosticStatus: byte level, string name, string message, \
string hardware_id, diagnostic_msgs/KeyValue[] values
diagnostic_msgs/msg/DiagnosticArray: std_msgs/Header header, diagnostic_msgs/DiagnosticStatus[] \
status
shape_msgs/msg/SolidPrimitive: uint8 type, float64[] dimensions
shape_msgs/msg/MeshTriangle: uint32[3] vertex_indices
shape_msgs/msg/Mesh: shape_msgs/MeshTriangle[] triangles, geometry_msgs/Point[] vertices
shape_msgs/msg/Plane: float64[4] coef
moveit_msgs/msg/CollisionObject: std_msgs/Header header, geometry_msgs/Pose pose, string id, \
shape_msgs/SolidPrimitive[] primitives, geometry_msgs/Pose[] primitive_poses, \
shape_msgs/Mesh[] meshes, geometry_msgs/Pose[] mesh_poses, shape_msgs/Plane[] planes, \
geometry_msgs/Pose[] plane_poses, string[] subframe_names, geometry_msgs/Pose[] subframe_poses, \
byte operation
moveit_msgs/msg/AttachedCollisionObject: string link_name, moveit_msgs/CollisionObject object, \
string[] touch_links, float64 weight
moveit_msgs/msg/PlanningSceneWorld: moveit_msgs/CollisionObject[] collision_objects
moveit_msgs/msg/PlanningScene: string name, string robot_model_name, \
moveit_msgs/PlanningSceneWorld world, bool is_diff
std_srvs/srv/Trigger_Request:
std_srvs/srv/Trigger_Response: bool success, string message
"""

_RANGES = {"uint8": (0, 2**8), "uint32": (0, 2**32), "int32": (-(2**31), 2**31)}
_CODES = {"uint8": "B", "uint32": "I", "float64": "d"}
_SCALARS = {"string": str, "bool": bool, "float32": float, "float64": float, "byte": bytes}


class _Field:
    """A field of a message, which knows its default and refuses what is of another type."""

    def __init__(self, kind, classes):
        self._kind, size = re.fullmatch(r"([\w/]+)(\[\d*\])?", kind).groups()
        self._size = None if size is None else size[1:-1]
        self._classes = classes

    def _class(self):
        package, name = self._kind.split("/")
        return self._classes[f"{package}/msg/{name}"]

    def _one(self):
        if self._kind in _RANGES:
            return 0
        if self._kind == "byte":
            return b"\0"
        return _SCALARS[self._kind]() if self._kind in _SCALARS else self._class()()

    def default(self):
        if self._size is None:
            return self._one()
        if self._size:
            dtype = "<u4" if self._kind == "uint32" else "<f8"
            return np.zeros(int(self._size), dtype)
        return array(_CODES[self._kind]) if self._kind in _CODES else []

    def taken(self, value):
        """The value as the message keeps it."""
        if self._size is None:
            assert self._fits(value), f"{value!r} is no {self._kind}"
            return value
        if isinstance(value, array):
            assert value.typecode == _CODES[self._kind]
            return value
        if isinstance(value, np.ndarray):
            assert value.dtype.str == self.default().dtype.str
            return value
        assert isinstance(value, Sequence), f"{value!r} is no list"
        assert not isinstance(value, str)
        assert all(self._fits(one) for one in value), f"a list of {self._kind} has another type"
        assert not self._size or len(value) == int(self._size)
        if self._size:
            return np.array(value, "<u4" if self._kind == "uint32" else "<f8")
        return array(_CODES[self._kind], value) if self._kind in _CODES else list(value)

    def _fits(self, value):
        if self._kind in _RANGES:
            low, high = _RANGES[self._kind]
            return isinstance(value, int) and low <= value < high
        if self._kind == "byte":
            return isinstance(value, bytes) and len(value) == 1
        if self._kind in _SCALARS:
            return isinstance(value, _SCALARS[self._kind])
        return isinstance(value, self._class())


def _made(name, text, classes):
    """A class of messages from `type name, type name`."""
    pairs = [one.split() for one in text.split(",") if one.strip()]
    kinds = {field: _Field(kind, classes) for kind, field in pairs}

    class Message:
        __slots__ = tuple(f"_{field}" for field in kinds)

        def __init__(self, **given):
            for field, kind in kinds.items():
                setattr(self, field, given.pop(field, kind.default()))
            assert not given, f"{name} has no {sorted(given)}"

        @classmethod
        def get_fields_and_field_types(cls):
            return {field: kind for kind, field in pairs}

    for field, kind in kinds.items():

        def put(self, value, field=field, kind=kind):
            object.__setattr__(self, f"_{field}", kind.taken(value))

        def get(self, field=field):
            return getattr(self, f"_{field}")

        setattr(Message, field, property(get, put))
    Message.__name__ = Message.__qualname__ = name
    return Message


def parts_of(file):
    """The parts of an interface file, each as `type name, type name`; constants are left out."""
    parts = []
    for part in re.split(r"^---$", file.read_text(), flags=re.MULTILINE):
        lines = [line.split("#")[0].strip() for line in part.splitlines()]
        parts.append(", ".join(line for line in lines if line and "=" not in line))
    return parts


def install(patch):
    """Makes the modules of all messages, for as long as a patch of pytest lasts."""
    classes = {}
    joined = OFFICIAL.replace("\\\n", "")
    texts = dict(line.split(":", 1) for line in joined.strip().splitlines())
    for kind, names in (("msg", [""]), ("srv", ["_Request", "_Response"])):
        for file in sorted((FILES / kind).iterdir()):
            named = [f"bendtwin_msgs/{kind}/{file.stem}{name}" for name in names]
            texts |= dict(zip(named, parts_of(file), strict=True))
    for file in sorted((FILES / "action").iterdir()):
        parts = ["_Goal", "_Result", "_Feedback"]
        named = [f"bendtwin_msgs/action/{file.stem}{name}" for name in parts]
        texts |= dict(zip(named, parts_of(file), strict=True))
    for name, text in texts.items():
        classes[name] = _made(name, text, classes)
        package, kind, cls = name.split("/")
        for module in (package, f"{package}.{kind}"):
            if module not in sys.modules or not getattr(sys.modules[module], "is_fake", False):
                made = ModuleType(module)
                made.is_fake = True
                patch.setitem(sys.modules, module, made)
        home = sys.modules[f"{package}.{kind}"]
        whole, _, part = cls.rpartition("_")
        if not whole:
            setattr(home, cls, classes[name])
            continue
        if not hasattr(home, whole):
            setattr(home, whole, type(whole, (), {}))
        setattr(getattr(home, whole), part, classes[name])
