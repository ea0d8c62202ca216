"""The node without ROS: messages in, messages out through a function, time as a number.

`node` calls it from callbacks of rclpy. The methods that change the session exclude one another;
a plan runs beside them.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from bendtwin import BendTwinError
from bendtwin_ros import planning, showing
from bendtwin_ros.frames import Frames
from bendtwin_ros.grippers import Gripper
from bendtwin_ros.link import Link, Unavailable
from bendtwin_ros.messages.basic import (
    Header,
    JointState,
    PointCloud2,
    PoseStamped,
    TransformStamped,
)
from bendtwin_ros.messages.own import (
    PlanFeedback,
    PlanGoal,
    PlanResult,
    RegisterRequest,
    RegisterResponse,
    TriggerResponse,
)
from bendtwin_ros.messages.scene import PlanningScene
from bendtwin_ros.parameters import ParameterFault, Settings
from bendtwin_ros.poses import SECOND, time_of, to_transform
from bendtwin_ros.scene import Obstacles, SceneFault
from bendtwin_ros.status import Status
from bendtwin_ros.tracker import Estimate, Tracker

#: Publishes a message on a topic; topics below the node's own name begin with `~/`.
Publish = Callable[[str, Any], None]

CLOUD, JOINTS, SCENE = "cloud", "joint_states", "planning_scene"
MARKERS, SKIN, DIAGNOSTICS = "~/markers", "~/skin", "/diagnostics"


def wrench_topic(gripper: str) -> str:
    """The topic of a gripper's wrench."""
    return f"~/wrench/{gripper}"


class TwinNode:
    """A twin that follows its object."""

    def __init__(
        self,
        settings: Settings,
        frames: Frames,
        publish: Publish,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`clock`: seconds that only grow, for pauses."""
        self.settings = settings
        self.status = Status()
        self.grippers = [Gripper(one) for one in settings.grippers]
        self._frames = frames
        self._publish = publish
        self._link = Link(settings, self.status, clock)
        self._tracker = Tracker(settings, self._link, self.grippers, frames, self.status, clock)
        self._obstacles = Obstacles()
        self._lock = threading.Lock()
        self._planning = threading.Lock()
        self._shown: Estimate | None = None
        self._shown_ns = 0

    @property
    def estimate(self) -> Estimate | None:
        """The object now; None before it was found."""
        return self._tracker.estimate

    def close(self) -> None:
        """Ends the session and the connection."""
        with self._lock:
            self._link.close()

    # Messages

    def on_cloud(self, cloud: PointCloud2, now_ns: int) -> None:
        """Follows the object by a cloud."""
        with self._lock:
            self._guarded(lambda: self._tracker.observe(cloud, now_ns))
            self._show(now_ns)

    def on_joints(self, message: JointState) -> None:
        """Takes positions of joints, among them those of grippers."""
        with self._lock:
            for gripper in self.grippers:
                gripper.add_joints(message)

    def on_pose(self, gripper: str, message: PoseStamped) -> None:
        """Takes a pose of a gripper."""
        with self._lock:
            for one in self.grippers:
                if one.settings.name == gripper:
                    one.add_pose(message, self.status)

    def on_scene(self, scene: PlanningScene) -> None:
        """Takes a scene of MoveIt, or a change of it, for the plans that follow."""
        with self._lock:
            try:
                self._obstacles.update(scene)
            except SceneFault as fault:
                self.status.count("scene invalid", str(fault))

    def tick(self, now_ns: int) -> None:
        """Coasts if no clouds come, and shows the object; to be called at `publish.rate_hz`."""
        with self._lock:
            self._guarded(lambda: self._tracker.coast(now_ns))
            self._show(now_ns)

    def report(self, now_ns: int) -> None:
        """Publishes the status; to be called once a second."""
        with self._lock:
            header = Header(time_of(now_ns))
            self._publish(DIAGNOSTICS, self.status.report(header, self._link.twin_name))

    # Services

    def register(self, request: RegisterRequest, now_ns: int) -> RegisterResponse:
        """Finds the object in a cloud."""
        with self._lock:
            before = self.status.counts.copy()
            try:
                found = self._tracker.register(request.cloud, request.near, now_ns)
            except (Unavailable, BendTwinError, ValueError) as error:
                return RegisterResponse(message=str(error))
            if found is None:
                [reason] = self.status.counts - before or ["cloud left out"]
                return RegisterResponse(message=f"{reason}: {self.status.last.get(reason, '')}")
            self._show(now_ns)
            return RegisterResponse(
                success=True,
                message="found",
                median_mm=found.after.median_mm,
                explained_points=found.explained_points,
            )

    def reset(self) -> TriggerResponse:
        """Forgets the object: the next cloud finds it anew."""
        with self._lock:
            try:
                self._tracker.reset()
            except (Unavailable, BendTwinError) as error:
                return TriggerResponse(message=str(error))
            return TriggerResponse(True, "the next cloud finds the object anew")

    # The action

    def plan(
        self,
        goal: PlanGoal,
        cancelled: Callable[[], bool],
        feedback: Callable[[PlanFeedback], None],
    ) -> PlanResult:
        """Plans for a goal, beside the tracking. A result without success has the reason
        `CANCELLED`, `BUSY`, `INVALID_GOAL`, `NOT_READY`, or one of the server."""
        if not self._planning.acquire(blocking=False):
            return _failure("BUSY", "another plan is being made: cancel it, or wait")
        try:
            with self._lock:
                session, geometry, hands, estimate = self._tracker.ready_to_plan()
                plan = planning.plan_of(
                    goal, self.settings, geometry, hands, estimate, self._obstacles, self._frames
                )
            best = planning.search(session, plan, cancelled, feedback)
            if best is None:
                return _failure("CANCELLED", "the plan was cancelled")
            return planning.result_of(goal, plan, best, self.settings, hands, estimate.at_ns)
        except Unavailable as error:
            return _failure("NOT_READY", str(error))
        except planning.GoalFault as fault:
            return _failure(fault.reason, str(fault))
        except BendTwinError as error:
            return _failure(error.reason, str(error))
        except ValueError as error:
            # Found by the client before anything was sent.
            return _failure(planning.GoalFault.reason, str(error))
        finally:
            self._planning.release()

    # What is published

    def transform(self, now_ns: int) -> TransformStamped | None:
        """The twin's frame, for /tf_static, if the parameters say where it is."""
        parent = self.settings["parent_frame"]
        if not parent:
            return None
        pose = to_transform(self.settings.twin_pose)
        return TransformStamped(Header(time_of(now_ns), parent), self.settings["twin_frame"], pose)

    def _guarded(self, call: Callable[[], Any]) -> None:
        """Calls what may fail for reasons that the status tells."""
        try:
            call()
        except Unavailable:
            self.status.count("server not available", self.status.down)
        except BendTwinError as error:
            self.status.count(f"call refused: {error.reason}", str(error))
        except ParameterFault as fault:
            self.status.count("parameter not possible", str(fault))
        except ValueError as error:
            # Found by the client before anything was sent.
            self.status.count("call not possible", str(error))

    def _show(self, now_ns: int) -> None:
        """Publishes an estimate that is new, at most at `publish.rate_hz`."""
        estimate = self._tracker.estimate
        if estimate is None:
            if self._shown is not None and self.settings["publish.markers"]:
                self._publish(MARKERS, showing.no_markers(self.settings))
            self._shown = None
            return
        period_ns = SECOND / self.settings["publish.rate_hz"]
        if estimate is self._shown or 0 <= now_ns - self._shown_ns < 0.9 * period_ns:
            return
        self._guarded(lambda: self._publish_all(estimate))
        self._shown, self._shown_ns = estimate, now_ns

    def _publish_all(self, estimate: Estimate) -> None:
        twin = self._link.twin()
        settings, geometry = self.settings, twin.geometry()
        if settings["publish.markers"]:
            surface = self._link.run(twin.surface)
            self._publish(MARKERS, showing.markers(settings, geometry, surface, estimate))
        if settings["publish.skin"]:
            self._publish(SKIN, showing.skin(settings, geometry, estimate))
        if settings["publish.wrenches"]:
            messages = showing.wrenches(self.grippers, estimate)
            for gripper, message in zip(self.grippers, messages, strict=False):
                self._publish(wrench_topic(gripper.settings.name), message)


def _failure(reason: str, message: str) -> PlanResult:
    return PlanResult(reason=reason, message=message)
