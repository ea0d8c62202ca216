from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSProfile
from rclpy.time import Time

class Parameter:
    @property
    def value(self) -> Any: ...

class Clock:
    def now(self) -> Time: ...

class Publisher:
    def publish(self, msg: Any) -> None: ...

class Node:
    def __init__(self, node_name: str) -> None: ...
    def declare_parameter(self, name: str, value: Any = None) -> Parameter: ...
    def get_parameter(self, name: str) -> Parameter: ...
    def get_clock(self) -> Clock: ...
    def create_publisher(
        self, msg_type: Any, topic: str, qos_profile: QoSProfile | int
    ) -> Publisher: ...
    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[[Any], None],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
    ) -> object: ...
    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[[], None],
        callback_group: CallbackGroup | None = None,
    ) -> object: ...
    def create_service(
        self,
        srv_type: Any,
        srv_name: str,
        callback: Callable[[Any, Any], Any],
        *,
        callback_group: CallbackGroup | None = None,
    ) -> object: ...
    def destroy_node(self) -> None: ...
