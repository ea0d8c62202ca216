"""Obstacles as MoveIt has them: shape_msgs and moveit_msgs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from bendtwin_ros.messages.basic import Header, Point, Pose


@dataclass
class SolidPrimitive:
    """A box (x, y, z), a sphere (radius), or a cylinder or cone along z (height, radius)."""

    BOX: ClassVar[int] = 1
    SPHERE: ClassVar[int] = 2
    CYLINDER: ClassVar[int] = 3
    CONE: ClassVar[int] = 4

    ROS: ClassVar[str] = "shape_msgs/msg/SolidPrimitive"
    type: int = 0
    dimensions: list[float] = field(default_factory=list)


@dataclass
class MeshTriangle:
    """Corners of a triangle, as indices of vertices."""

    ROS: ClassVar[str] = "shape_msgs/msg/MeshTriangle"
    vertex_indices: list[int] = field(default_factory=lambda: [0, 0, 0])


@dataclass
class Mesh:
    """Triangles."""

    ROS: ClassVar[str] = "shape_msgs/msg/Mesh"
    triangles: list[MeshTriangle] = field(default_factory=list)
    vertices: list[Point] = field(default_factory=list)


@dataclass
class Plane:
    """The plane a x + b y + c z + d = 0; its normal points out of the obstacle."""

    ROS: ClassVar[str] = "shape_msgs/msg/Plane"
    coef: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0, 0.0])


@dataclass
class CollisionObject:
    """An obstacle: shapes with poses in the object, which has a pose in its frame."""

    ADD: ClassVar[bytes] = b"\0"
    REMOVE: ClassVar[bytes] = b"\1"
    APPEND: ClassVar[bytes] = b"\2"
    MOVE: ClassVar[bytes] = b"\3"

    ROS: ClassVar[str] = "moveit_msgs/msg/CollisionObject"
    header: Header = field(default_factory=Header)
    pose: Pose = field(default_factory=Pose)
    id: str = ""
    primitives: list[SolidPrimitive] = field(default_factory=list)
    primitive_poses: list[Pose] = field(default_factory=list)
    meshes: list[Mesh] = field(default_factory=list)
    mesh_poses: list[Pose] = field(default_factory=list)
    planes: list[Plane] = field(default_factory=list)
    plane_poses: list[Pose] = field(default_factory=list)
    operation: bytes = ADD


@dataclass
class AttachedCollisionObject:
    """An obstacle that a link carries."""

    ROS: ClassVar[str] = "moveit_msgs/msg/AttachedCollisionObject"
    link_name: str = ""
    object: CollisionObject = field(default_factory=CollisionObject)
    touch_links: list[str] = field(default_factory=list)


@dataclass
class PlanningSceneWorld:
    """The obstacles of a scene."""

    ROS: ClassVar[str] = "moveit_msgs/msg/PlanningSceneWorld"
    collision_objects: list[CollisionObject] = field(default_factory=list)


@dataclass
class PlanningScene:
    """A scene, or a change of one."""

    ROS: ClassVar[str] = "moveit_msgs/msg/PlanningScene"
    name: str = ""
    world: PlanningSceneWorld = field(default_factory=PlanningSceneWorld)
    is_diff: bool = False
