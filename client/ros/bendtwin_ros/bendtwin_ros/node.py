"""The node in ROS 2: parameters, topics, services and the action, around `TwinNode`."""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import rclpy
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from rclpy.time import Time
from tf2_ros import Buffer, StaticTransformBroadcaster, TransformException, TransformListener

from bendtwin_ros import logic
from bendtwin_ros.convert import from_ros, ros_class, to_ros
from bendtwin_ros.frames import MissingTransform
from bendtwin_ros.messages import basic, own, scene, shown
from bendtwin_ros.parameters import (
    GRIPPER_PARAMETERS,
    PARAMETERS,
    ParameterFault,
    Settings,
    gripper_names,
    settings_of,
)
from bendtwin_ros.poses import Array, of_transform

_REPORT_S = 1.0
#: Only the newest matters: an older cloud or state would only delay it.
_LATEST = QoSProfile(depth=1)
_CLOUDS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
_KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_MANY = QoSProfile(depth=100)


class TfFrames:
    """Frames out of a buffer of tf2."""

    def __init__(self, buffer: Buffer, timeout_s: float) -> None:
        self._buffer = buffer
        self._timeout = Duration(seconds=timeout_s)

    def pose(self, target: str, source: str, at_ns: int) -> Array:
        """See `bendtwin_ros.frames.Frames`."""
        try:
            found = self._buffer.lookup_transform(
                target, source, Time(nanoseconds=at_ns), timeout=self._timeout
            )
        except (TransformException, ValueError) as error:
            raise MissingTransform(f"from `{source}` to `{target}`: {error}") from error
        pose = of_transform(from_ros(basic.Transform, found.transform))
        if pose is None:
            raise MissingTransform(f"from `{source}` to `{target}`: it has NaN, or no rotation")
        return pose


class BendTwinNode(Node):
    """The node `bendtwin`."""

    def __init__(self) -> None:
        super().__init__("bendtwin")
        self.settings: Settings = self._declared()
        timeout_s = self.settings["transform_timeout_s"]
        self._buffer = Buffer()
        # Its callbacks run in other threads of the executor, so that transforms come while a
        # callback waits for them.
        self._listener = TransformListener(self._buffer, self)
        self._publishers_of: dict[str, Any] = {}
        frames = TfFrames(self._buffer, timeout_s)
        self.twin_node = logic.TwinNode(self.settings, frames, self._publish)
        self._following = MutuallyExclusiveCallbackGroup()
        # Goals and their cancellations are answered while a plan is made.
        self._beside = ReentrantCallbackGroup()
        self._add_publishers()
        self._add_subscriptions()
        self._add_services()
        transform = self.twin_node.transform(self._now_ns())
        if transform is not None:
            self._broadcaster = StaticTransformBroadcaster(self)
            self._broadcaster.sendTransform(to_ros(transform))

    def close(self) -> None:
        """Ends the session."""
        self.twin_node.close()

    def _declared(self) -> Settings:
        try:
            for parameter in PARAMETERS:
                self.declare_parameter(parameter.name, parameter.default)
            for name in gripper_names(self._value("grippers")):
                for parameter in GRIPPER_PARAMETERS:
                    self.declare_parameter(f"{name}.{parameter.name}", parameter.default)
        except InvalidParameterTypeException as error:
            raise ParameterFault(str(error)) from error
        return settings_of(self._value)

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _now_ns(self) -> int:
        return int(self.get_clock().now().nanoseconds)

    def _add_publishers(self) -> None:
        settings = self.settings
        topics: list[tuple[str, Any]] = [(logic.DIAGNOSTICS, shown.DiagnosticArray)]
        if settings["publish.markers"]:
            topics.append((logic.MARKERS, shown.MarkerArray))
        if settings["publish.skin"]:
            topics.append((logic.SKIN, basic.PointCloud2))
        if settings["publish.wrenches"]:
            names = [gripper.name for gripper in settings.grippers]
            topics += [(logic.wrench_topic(name), basic.WrenchStamped) for name in names]
        for topic, message in topics:
            publisher = self.create_publisher(ros_class(message.ROS), topic, _LATEST)
            self._publishers_of[topic] = publisher

    def _publish(self, topic: str, message: Any) -> None:
        self._publishers_of[topic].publish(to_ros(message))

    def _add_subscriptions(self) -> None:
        def subscribe(kind: Any, topic: str, take: Any, qos: QoSProfile) -> None:
            def callback(message: Any) -> None:
                take(from_ros(kind, message))

            cls = ros_class(kind.ROS)
            group = self._following
            self.create_subscription(cls, topic, callback, qos, callback_group=group)

        node = self.twin_node

        def take_cloud(cloud: basic.PointCloud2) -> None:
            node.on_cloud(cloud, self._now_ns())

        subscribe(basic.PointCloud2, logic.CLOUD, take_cloud, _CLOUDS)
        subscribe(basic.JointState, logic.JOINTS, node.on_joints, qos_profile_sensor_data)
        subscribe(scene.PlanningScene, logic.SCENE, node.on_scene, _KEPT)
        for gripper in self.settings.grippers:
            if gripper.pose_topic:
                take = partial(node.on_pose, gripper.name)
                subscribe(basic.PoseStamped, gripper.pose_topic, take, _MANY)
        period_s = 1.0 / self.settings["publish.rate_hz"]
        group = self._following
        self.create_timer(period_s, lambda: node.tick(self._now_ns()), callback_group=group)
        self.create_timer(_REPORT_S, lambda: node.report(self._now_ns()), callback_group=group)

    def _add_services(self) -> None:
        node = self.twin_node

        def register(request: Any, _: Any) -> Any:
            asked = from_ros(own.RegisterRequest, request)
            return to_ros(node.register(asked, self._now_ns()))

        def reset(_: Any, __: Any) -> Any:
            return to_ros(node.reset())

        group = self._following
        kind = ros_class("bendtwin_msgs/srv/Register")
        self.create_service(kind, "~/register", register, callback_group=group)
        kind = ros_class("std_srvs/srv/Trigger")
        self.create_service(kind, "~/reset", reset, callback_group=group)
        self._action = ActionServer(
            self,
            ros_class("bendtwin_msgs/action/PlanDeformable"),
            "~/plan",
            self._execute,
            callback_group=self._beside,
            goal_callback=lambda _: GoalResponse.ACCEPT,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def _execute(self, handle: Any) -> Any:
        goal = from_ros(own.PlanGoal, handle.request)

        def tell(feedback: own.PlanFeedback) -> None:
            handle.publish_feedback(to_ros(feedback))

        result = self.twin_node.plan(goal, lambda: bool(handle.is_cancel_requested), tell)
        if result.success:
            handle.succeed()
        elif result.reason == "CANCELLED":
            handle.canceled()
        else:
            handle.abort()
        return to_ros(result)


def main() -> int:
    """Runs the node until it is stopped."""
    rclpy.init()
    try:
        node = BendTwinNode()
    except ParameterFault as fault:
        print(f"bendtwin: {fault}", file=sys.stderr)
        rclpy.try_shutdown()
        return 2
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.close()
        node.destroy_node()
        rclpy.try_shutdown()
    return 0
