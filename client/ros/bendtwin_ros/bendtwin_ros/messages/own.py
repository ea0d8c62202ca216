"""Interfaces of bendtwin_msgs; its files explain the fields."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from bendtwin_ros.messages.basic import Duration, Header, Point, PointCloud2, PoseArray
from bendtwin_ros.messages.scene import AttachedCollisionObject, CollisionObject, PlanningScene


@dataclass
class GripperPath:
    """The waypoints of a gripper."""

    ROS: ClassVar[str] = "bendtwin_msgs/msg/GripperPath"
    gripper: str = ""
    waypoints: PoseArray = field(default_factory=PoseArray)
    times_from_start: list[Duration] = field(default_factory=list)
    closed: bool = False


@dataclass
class PlanGoal:
    """What the object is to do."""

    HULL_NONE: ClassVar[int] = 0
    HULL_WORLD: ClassVar[int] = 1
    HULL_ATTACHED: ClassVar[int] = 2

    ROS: ClassVar[str] = "bendtwin_msgs/action/PlanDeformable_Goal"
    header: Header = field(default_factory=Header)
    nodes: list[int] = field(default_factory=list)
    skin_points: list[int] = field(default_factory=list)
    targets: list[Point] = field(default_factory=list)
    target_cloud: PointCloud2 = field(default_factory=PointCloud2)
    horizon_s: float = 0.0
    knots: int = 0
    samples: int = 0
    iterations: int = 0
    deadline_s: float = 0.0
    seed: int = 0
    grippers: list[str] = field(default_factory=list)
    scene: PlanningScene = field(default_factory=PlanningScene)
    hull: int = 0
    hulls: int = 0
    touch_links: list[str] = field(default_factory=list)


@dataclass
class PlanResult:
    """The best plan, or the reason why no plan was found."""

    ROS: ClassVar[str] = "bendtwin_msgs/action/PlanDeformable_Result"
    success: bool = False
    reason: str = ""
    message: str = ""
    cost: float = 0.0
    nominal_cost: float = 0.0
    paths: list[GripperPath] = field(default_factory=list)
    hulls: list[CollisionObject] = field(default_factory=list)
    attached_hulls: list[AttachedCollisionObject] = field(default_factory=list)


@dataclass
class PlanFeedback:
    """The search so far."""

    ROS: ClassVar[str] = "bendtwin_msgs/action/PlanDeformable_Feedback"
    iterations: int = 0
    cost: float = 0.0
    nominal_cost: float = 0.0
    time_s: float = 0.0


@dataclass
class RegisterRequest:
    """Points in which the object is to be found."""

    ROS: ClassVar[str] = "bendtwin_msgs/srv/Register_Request"
    cloud: PointCloud2 = field(default_factory=PointCloud2)
    near: bool = False


@dataclass
class RegisterResponse:
    """Whether it was found."""

    ROS: ClassVar[str] = "bendtwin_msgs/srv/Register_Response"
    success: bool = False
    message: str = ""
    median_mm: float = 0.0
    explained_points: float = 0.0


@dataclass
class TriggerResponse:
    """The response of std_srvs/Trigger."""

    ROS: ClassVar[str] = "std_srvs/srv/Trigger_Response"
    success: bool = False
    message: str = ""
