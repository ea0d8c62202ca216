# The parts of tf2_ros that the node uses, by its documentation.
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time

class TransformException(Exception): ...

class Buffer:
    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Time, timeout: Duration = ...
    ) -> Any: ...

class TransformListener:
    def __init__(self, buffer: Buffer, node: Node, *, spin_thread: bool = False) -> None: ...

class StaticTransformBroadcaster:
    def __init__(self, node: Node) -> None: ...
    def sendTransform(self, transform: Any) -> None: ...
