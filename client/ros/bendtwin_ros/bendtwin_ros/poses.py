"""Poses as seven numbers (x, y, z in metres, quaternion x, y, z, w), and times as nanoseconds."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin import rotations
from bendtwin_ros.messages.basic import (
    Duration,
    Point,
    Pose,
    Quaternion,
    Time,
    Transform,
    Vector3,
)

Array = npt.NDArray[np.float64]

IDENTITY: Array = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
SECOND = 1_000_000_000
#: Farther away nothing is, metres; and sums of such numbers are finite.
_FARTHEST_M = 1.0e6
#: Quaternions whose length differs from 1 by more are no rotations.
_OFF_UNIT = 0.1


def nanoseconds(time: Time | Duration) -> int:
    """A time or a duration as one number."""
    return int(time.sec) * SECOND + int(time.nanosec)


def time_of(nanoseconds: int) -> Time:
    """The time of a number; times of ROS end in 2038."""
    sec, nanosec = divmod(min(max(nanoseconds, 0), (2**31 - 1) * SECOND), SECOND)
    return Time(sec, nanosec)


def duration_of(seconds: float) -> Duration:
    """A duration of seconds."""
    sec, nanosec = divmod(round(seconds * SECOND), SECOND)
    return Duration(sec, nanosec)


def settled(numbers: npt.ArrayLike) -> Array | None:
    """A pose with a unit quaternion; None if it has numbers that are not finite or very
    large, or no rotation."""
    pose = np.array(numbers, dtype=np.float64)
    if pose.shape != (7,) or not (np.abs(pose) <= _FARTHEST_M).all():
        return None
    length = float(np.linalg.norm(pose[3:]))
    if abs(length - 1.0) > _OFF_UNIT:
        return None
    pose[3:] /= length
    return pose


def of_pose(pose: Pose) -> Array | None:
    """The numbers of a message; None if it is no pose."""
    p, q = pose.position, pose.orientation
    return settled([p.x, p.y, p.z, q.x, q.y, q.z, q.w])


def of_transform(transform: Transform) -> Array | None:
    """The numbers of a message; None if it is no pose."""
    p, q = transform.translation, transform.rotation
    return settled([p.x, p.y, p.z, q.x, q.y, q.z, q.w])


def to_pose(pose: npt.ArrayLike) -> Pose:
    """The message of a pose."""
    n = [float(x) for x in np.asarray(pose)]
    return Pose(Point(*n[:3]), Quaternion(*n[3:]))


def to_transform(pose: npt.ArrayLike) -> Transform:
    """The message of a pose as a transform."""
    n = [float(x) for x in np.asarray(pose)]
    return Transform(Vector3(*n[:3]), Quaternion(*n[3:]))


def points_of(points: list[Point]) -> Array:
    """Positions [M, 3]."""
    return np.array([[p.x, p.y, p.z] for p in points], dtype=np.float64).reshape(-1, 3)


def to_points(points: npt.NDArray[Any]) -> list[Point]:
    """Messages of positions [M, 3]."""
    return [Point(x, y, z) for x, y, z in np.asarray(points, dtype=np.float64).tolist()]


def applied(pose: Array, points: npt.ArrayLike) -> Array:
    """Points [..., 3] of a frame, where its pose places them."""
    return np.asarray(
        np.asarray(points) @ rotations.matrices(pose[3:]).T + pose[:3], dtype=np.float64
    )


def product(a: Array, b: Array) -> Array:
    """The pose `b` of a frame that has the pose `a`."""
    found = rotations.compose(a, b)
    found[3:] /= np.linalg.norm(found[3:])
    return found


def inverse(pose: Array) -> Array:
    """The pose that undoes a pose."""
    turned = rotations.conjugate(pose[3:])
    return np.concatenate([-rotations.rotated(turned, pose[:3]), turned])


def between(a: Array, b: Array, share: float) -> Array:
    """The pose at a share 0..1 of the way from `a` to `b`, along the shorter turn."""
    to = b[3:] if a[3:] @ b[3:] >= 0.0 else -b[3:]
    turned = (1.0 - share) * a[3:] + share * to
    at = (1.0 - share) * a[:3] + share * b[:3]
    return np.concatenate([at, turned / np.linalg.norm(turned)])
