"""Grippers: their poses and openings at any time, and the grasps that they stand for."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from bendtwin import Geometry, Grasp, Sphere
from bendtwin_ros.frames import Frames, MissingTransform
from bendtwin_ros.messages.basic import JointState, PoseStamped
from bendtwin_ros.parameters import GripperSettings, ParameterFault
from bendtwin_ros.poses import (
    IDENTITY,
    SECOND,
    Array,
    between,
    nanoseconds,
    of_pose,
    product,
    settled,
)
from bendtwin_ros.status import Status

#: Samples that are kept: four seconds at 1 kHz.
_MOST_SAMPLES = 4000
#: A sample farther away in time says nothing.
_REACH_NS = SECOND // 2
#: An open gripper closes below its threshold, a closed one opens this far above it.
_HYSTERESIS_M = 0.002


class Hold(NamedTuple):
    """What a gripper holds: nodes in its region, or what a hand of the capture held."""

    region: bool
    hand: bool


class Samples:
    """Values by time, sorted, in whichever order they arrive."""

    def __init__(self) -> None:
        self._rows: list[tuple[int, Any]] = []

    def add(self, at_ns: int, value: Any) -> bool:
        """Adds a value; False if there is one of that time."""
        place = bisect_left(self._rows, at_ns, key=lambda row: row[0])
        if place < len(self._rows) and self._rows[place][0] == at_ns:
            return False
        insort(self._rows, (at_ns, value), key=lambda row: row[0])
        if len(self._rows) > _MOST_SAMPLES:
            del self._rows[0]
        return True

    def forget(self) -> None:
        """Removes all, as when a clock begins anew."""
        self._rows.clear()

    def around(self, at_ns: int) -> tuple[Any, Any, float] | None:
        """The values before and after a time and the share of the way between; None if the nearest
        is half a second away."""
        place = bisect_left(self._rows, at_ns, key=lambda row: row[0])
        near = self._rows[max(place - 1, 0) : place + 1]
        near = [row for row in near if abs(row[0] - at_ns) <= _REACH_NS]
        if not near:
            return None
        (start, first), (end, last) = near[0], near[-1]
        share = 0.0 if end == start else (at_ns - start) / (end - start)
        return first, last, min(max(share, 0.0), 1.0)


class Gripper:
    """A gripper: its last known pose in the twin's frame, and whether it is closed."""

    def __init__(self, settings: GripperSettings) -> None:
        self.settings = settings
        #: Last known pose [7] in the twin's frame; None until it was seen.
        self.pose: Array | None = None
        self.closed: bool = not settings.joints or settings.hand is not None
        #: Whether it takes hold of what is in its region: from the start, or once it has released
        #: what it holds as a hand of the capture.
        self.takes: bool = settings.hand is None
        self._widths: dict[str, Samples] = {joint: Samples() for joint in settings.joints}
        self._poses = Samples()

    def add_pose(self, message: PoseStamped, status: Status) -> None:
        """Takes a pose from a topic."""
        pose = of_pose(message.pose)
        if pose is None:
            status.count("gripper pose invalid", f"{self.settings.name}: no pose, or NaN in it")
        elif not self._poses.add(
            nanoseconds(message.header.stamp), (message.header.frame_id, pose)
        ):
            status.count("gripper pose repeated", f"{self.settings.name}: two of one stamp")

    def add_joints(self, message: JointState) -> None:
        """Takes positions of joints; those of others, or that are not finite, are left out."""
        at = nanoseconds(message.header.stamp)
        for name, position in zip(message.name, message.position, strict=False):
            if name in self._widths and np.isfinite(position):
                self._widths[name].add(at, float(position))

    def forget(self) -> None:
        """Forgets all samples, as when a clock begins anew."""
        self._poses.forget()
        for samples in self._widths.values():
            samples.forget()

    def moved_to(self, frame: str, at_ns: int, frames: Frames, status: Status) -> bool:
        """Takes the pose in a frame at a time as the last known one; False if it is missing."""
        try:
            found = self._pose_at(frame, at_ns, frames)
        except MissingTransform as missing:
            status.count("gripper pose missing", f"{self.settings.name}: {missing}")
            return False
        if found is not None:
            self.pose = found
        return found is not None

    def _pose_at(self, frame: str, at_ns: int, frames: Frames) -> Array | None:
        if not self.settings.pose_topic:
            return settled(frames.pose(frame, self.settings.frame, at_ns))
        near = self._poses.around(at_ns)
        if near is None:
            raise MissingTransform(f"no pose on {self.settings.pose_topic} within 0.5 s")
        (parent, first), (other, last), share = near
        pose = between(first, last, share) if parent == other else last
        return product(frames.pose(frame, other, at_ns), pose)

    def closes_at(self, at_ns: int) -> Hold:
        """What it holds at a time; the opening is kept until joints say otherwise."""
        if self._widths:
            near = [samples.around(at_ns) for samples in self._widths.values()]
            known = [a + share * (b - a) for a, b, share in (one for one in near if one)]
            if len(known) == len(near):
                width = self.settings.offset_m + self.settings.scale * sum(known)
                limit = self.settings.closed_below_m + (_HYSTERESIS_M if self.closed else 0.0)
                self.closed = width < limit
        self.takes = self.takes or not self.closed
        return self.hold

    @property
    def hold(self) -> Hold:
        """What it holds with the last known opening."""
        region = self.closed and self.takes and self.pose is not None
        return Hold(region, not self.takes)


class Hands:
    """All grippers of the robot, as the poses and the grasps of a request."""

    def __init__(self, grippers: list[Gripper], geometry: Geometry) -> None:
        """
        Raises:
            ParameterFault: If a gripper is to carry a hand that the twin does not have.
        """
        self.grippers = grippers
        self.count = max(len(grippers), 1)
        taken = {g.settings.hand for g in grippers}
        for gripper in grippers:
            hand = gripper.settings.hand
            if hand is not None and hand >= geometry.hand_count:
                raise ParameterFault(
                    f"{gripper.settings.name}.hand is {hand}, but the twin has "
                    f"{geometry.hand_count} hands: give -1, or one below that"
                )
        #: Hands of the capture that no gripper stands for: they hold nothing.
        self._free = [hand for hand in range(geometry.hand_count) if hand not in taken]
        #: The gripper that carries each control point of the capture [C].
        carriers = {g.settings.hand: i for i, g in enumerate(grippers)}
        self.gripper_of_control = [carriers.get(int(hand), 0) for hand in geometry.hands]

    def grasps(self, holds: Sequence[Sequence[Hold]]) -> list[Grasp]:
        """The grasps, with what each gripper holds from each knot on [K][G]: of each gripper the
        nodes in its region, then the hands of the capture."""
        grasps = [
            Grasp(
                gripper=i,
                region=Sphere(gripper.settings.region_radius_m, gripper.settings.region_center),
                closed=[hold[i].region for hold in holds],
                max_force_n=gripper.settings.max_force_n,
            )
            for i, gripper in enumerate(self.grippers)
        ]
        grasps += [
            Grasp(
                gripper=i,
                hand=gripper.settings.hand,
                closed=[hold[i].hand for hold in holds],
                max_force_n=gripper.settings.max_force_n,
            )
            for i, gripper in enumerate(self.grippers)
            if gripper.settings.hand is not None
        ]
        return grasps + [Grasp(hand=hand, closed=False) for hand in self._free]

    def holds(self) -> list[Hold]:
        """What each gripper holds with its last known opening [G]."""
        return [gripper.hold for gripper in self.grippers]

    def poses(self) -> Array:
        """The last known poses [G, 7]; that of a gripper that was never seen is of no effect."""
        poses = np.tile(IDENTITY, (self.count, 1))
        for i, gripper in enumerate(self.grippers):
            if gripper.pose is not None:
                poses[i] = gripper.pose
        return poses

    def forget(self) -> None:
        """Forgets samples of an earlier clock."""
        for gripper in self.grippers:
            gripper.forget()

    def grasps_of(self, number: int) -> list[int]:
        """Numbers of the grasps of a gripper."""
        with_hand = [i for i, g in enumerate(self.grippers) if g.settings.hand is not None]
        if number not in with_hand:
            return [number]
        return [number, len(self.grippers) + with_hand.index(number)]
