"""The part of rclpy and tf2_ros that the node uses, in one process and without threads.

It behaves as the documented interface does where that matters to the node: parameters have the type
of their default, publishers refuse other messages, and an action ends as its handle says.
"""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace
from typing import ClassVar

import fake_messages


class InvalidParameterTypeException(Exception):
    """A value of another type than the declared one."""


class ExternalShutdownException(Exception):
    """The context was shut down."""


class TransformException(Exception):
    """A transform is not known."""


class Duration:
    def __init__(self, *, seconds=0, nanoseconds=0):
        self.nanoseconds = round(seconds * 1e9) + nanoseconds


class Time:
    def __init__(self, *, seconds=0, nanoseconds=0):
        assert isinstance(nanoseconds, int)
        self.nanoseconds = round(seconds * 1e9) + nanoseconds


class Buffer:
    #: Poses by (target, source): a message of a transform, or a function of the time.
    known: ClassVar[dict] = {}

    def lookup_transform(self, target, source, time, timeout=None):
        assert isinstance(timeout, Duration)
        if target == source:
            return SimpleNamespace(transform=transform_of([0, 0, 0, 0, 0, 0, 1]))
        if (target, source) not in self.known:
            raise TransformException(f'"{source}" passed to lookupTransform does not exist')
        found = self.known[target, source]
        found = found(time.nanoseconds) if callable(found) else found
        return SimpleNamespace(transform=transform_of(found))


def transform_of(pose):
    """The message of a pose."""
    msg = sys.modules["geometry_msgs.msg"]
    x, y, z, *turn = (float(number) for number in pose)
    names = ("x", "y", "z", "w")
    rotation = msg.Quaternion(**dict(zip(names, turn, strict=True)))
    return msg.Transform(translation=msg.Vector3(x=x, y=y, z=z), rotation=rotation)


class TransformListener:
    def __init__(self, buffer, node, *, spin_thread=False):
        assert not spin_thread, "it would add the node to a second executor, in another thread"


class StaticTransformBroadcaster:
    def __init__(self, node):
        self._node = node

    def sendTransform(self, transform):
        assert type(transform).__name__ == "geometry_msgs/msg/TransformStamped"
        self._node.published.setdefault("/tf_static", []).append(transform)


class Publisher:
    def __init__(self, kind, sent):
        self._kind, self._sent = kind, sent

    def publish(self, message):
        assert type(message) is self._kind
        self._sent.append(message)


class Node:
    #: Overrides, as a file of parameters gives them.
    given: ClassVar[dict] = {}
    now_ns = 0

    def __init__(self, name):
        self.name = name
        self._values = {}
        self.published, self.subscriptions_of, self.services_of = {}, {}, {}
        self.timers_of = []

    def declare_parameter(self, name, default):
        assert name not in self._values, f"{name} is declared twice"
        value = self.given.get(name, default)
        if type(value) is not type(default):
            kind = type(default).__name__
            raise InvalidParameterTypeException(f"'{name}' of type {kind} cannot be {value!r}")
        self._values[name] = value

    def get_parameter(self, name):
        return SimpleNamespace(value=self._values[name])

    def get_clock(self):
        return SimpleNamespace(now=lambda: Time(nanoseconds=self.now_ns))

    def create_publisher(self, kind, topic, qos):
        assert isinstance(qos, QoSProfile)
        return Publisher(kind, self.published.setdefault(topic, []))

    def create_subscription(self, kind, topic, callback, qos, *, callback_group=None):
        assert topic not in self.subscriptions_of
        self.subscriptions_of[topic] = (kind, callback)

    def create_timer(self, period_s, callback, *, callback_group=None):
        self.timers_of.append((period_s, callback))

    def create_service(self, kind, name, callback, *, callback_group=None):
        self.services_of[name] = (kind, callback)

    def destroy_node(self):
        self.published.clear()

    def send(self, topic, message):
        """Lets a message arrive."""
        kind, callback = self.subscriptions_of[topic]
        assert type(message) is kind
        callback(message)

    def call(self, name, request):
        """The response of a service."""
        kind, callback = self.services_of[name]
        assert type(request) is kind.Request
        response = callback(request, kind.Response())
        assert type(response) is kind.Response
        return response


class ActionServer:
    """Goals run while `send` is called; `last` is the server that was made last."""

    last = None

    def __init__(
        self, node, kind, name, execute, *, callback_group, goal_callback, cancel_callback
    ):
        self.kind, self.name, self._execute = kind, name, execute
        self._accepts = goal_callback
        ActionServer.last = self

    def send(self, goal, cancel_after=None):
        """How a goal ended, its result, and the feedback. It is cancelled after `cancel_after`
        messages of feedback."""
        assert type(goal) is self.kind.Goal
        assert self._accepts(goal) == GoalResponse.ACCEPT
        handle = GoalHandle(self.kind, goal, cancel_after)
        result = self._execute(handle)
        assert type(result) is self.kind.Result
        return handle.ended, result, handle.feedback


class GoalHandle:
    def __init__(self, kind, request, cancel_after):
        self._kind, self.request, self._cancel_after = kind, request, cancel_after
        self.feedback, self.ended = [], None

    @property
    def is_cancel_requested(self):
        return self._cancel_after is not None and len(self.feedback) >= self._cancel_after

    def publish_feedback(self, feedback):
        assert type(feedback) is self._kind.Feedback
        self.feedback.append(feedback)

    def _end(self, how):
        assert self.ended is None
        self.ended = how

    def succeed(self):
        self._end("succeeded")

    def abort(self):
        self._end("aborted")

    def canceled(self):
        assert self.is_cancel_requested
        self._end("canceled")


class QoSProfile:
    def __init__(self, *, depth, reliability=None, durability=None):
        assert depth > 0


class GoalResponse:
    REJECT, ACCEPT = 1, 2


class CancelResponse:
    REJECT, ACCEPT = 1, 2


class MultiThreadedExecutor:
    def __init__(self, num_threads=None):
        self.node = None

    def add_node(self, node):
        self.node = node

    def spin(self):
        raise ExternalShutdownException


def install(patch):
    """Makes the modules, for as long as a patch of pytest lasts."""
    fake_messages.install(patch)
    group = type("CallbackGroup", (), {})
    contents = {
        "rclpy": {"init": lambda: None, "try_shutdown": lambda: None},
        "rclpy.action": {
            "ActionServer": ActionServer,
            "CancelResponse": CancelResponse,
            "GoalResponse": GoalResponse,
        },
        "rclpy.callback_groups": {
            "MutuallyExclusiveCallbackGroup": group,
            "ReentrantCallbackGroup": group,
        },
        "rclpy.duration": {"Duration": Duration},
        "rclpy.exceptions": {"InvalidParameterTypeException": InvalidParameterTypeException},
        "rclpy.executors": {
            "ExternalShutdownException": ExternalShutdownException,
            "MultiThreadedExecutor": MultiThreadedExecutor,
        },
        "rclpy.node": {"Node": Node},
        "rclpy.qos": {
            "DurabilityPolicy": SimpleNamespace(TRANSIENT_LOCAL=1),
            "QoSProfile": QoSProfile,
            "ReliabilityPolicy": SimpleNamespace(BEST_EFFORT=2),
            "qos_profile_sensor_data": QoSProfile(depth=5),
        },
        "rclpy.time": {"Time": Time},
        "tf2_ros": {
            "Buffer": Buffer,
            "StaticTransformBroadcaster": StaticTransformBroadcaster,
            "TransformException": TransformException,
            "TransformListener": TransformListener,
        },
    }
    for name, content in contents.items():
        module = ModuleType(name)
        vars(module).update(content)
        patch.setitem(sys.modules, name, module)
