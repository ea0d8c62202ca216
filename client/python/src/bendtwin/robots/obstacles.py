"""Depth of a robot's links in the ground and in static colliders.

Links are points with a reach, sampled on their shapes; obstacles are exact. What is thinner than
the distance of the samples, 3 cm or more on large shapes, may slip between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.robots.meshes import hull_planes
from bendtwin.robots.transforms import IDENTITY, Array, checked_poses
from bendtwin.rotations import conjugate, matrices
from bendtwin.simulation.world import Capsule, Collider, Cuboid, Plane, Sphere

#: Rows that are handled together, so that memory is bounded.
_ROWS = 1024


class Obstacles:
    """The ground and static colliders; colliders that move are left out."""

    def __init__(self, ground: Plane | None, colliders: Sequence[Collider]) -> None:
        self._ground = ground
        static = [c for c in colliders if c.gripper is None and c.path is None]
        self._solids = [_Solid(collider) for collider in static]

    def depth(self, points: Array, reach: Array) -> Array:
        """The largest depth [N] of points [N, P, 3] that reach [P] around themselves, metres: 0
        where none is inside of anything."""
        depths = np.zeros(len(points))
        for first in range(0, len(points), _ROWS):
            rows = points[first : first + _ROWS]
            distance = np.full(rows.shape[:2], np.inf)
            if self._ground is not None:
                normal = np.asarray(self._ground.normal, np.float64)
                distance = rows @ normal - self._ground.offset_m
            for solid in self._solids:
                distance = np.minimum(distance, solid.distance(rows))
            deepest = (reach - distance).max(axis=1, initial=0.0)
            depths[first : first + _ROWS] = np.maximum(deepest, 0.0)
        return depths


class _Solid:
    """A static collider."""

    def __init__(self, collider: Collider) -> None:
        self._shape = collider.shape
        pose = IDENTITY if collider.pose is None else collider.pose
        self._pose: Array = checked_poses("pose of a collider", pose, (7,))
        self._planes: Array | None = None
        if not isinstance(self._shape, (Sphere, Capsule, Cuboid)):
            self._planes = hull_planes(np.asarray(self._shape.points, np.float64))

    def distance(self, points: Array) -> Array:
        """Distances [...] of points [..., 3], below 0 inside; from a convex mesh at least the one
        to the nearest of its planes."""
        back = matrices(conjugate(self._pose[3:]))
        local = (points - self._pose[:3]) @ back.T
        shape = self._shape
        if isinstance(shape, Sphere):
            distance = np.linalg.norm(local - np.asarray(shape.center), axis=-1) - shape.radius_m
            return np.asarray(distance)
        if isinstance(shape, Capsule):
            return np.asarray(_from_segment(local, shape.start, shape.end) - shape.radius_m)
        if isinstance(shape, Cuboid):
            low, high = np.asarray(shape.low, np.float64), np.asarray(shape.high, np.float64)
            beyond = np.abs(local - 0.5 * (low + high)) - 0.5 * (high - low)
            outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
            return np.asarray(outside + np.minimum(beyond.max(axis=-1), 0.0))
        assert self._planes is not None
        return np.asarray((local @ self._planes[:, :3].T + self._planes[:, 3]).max(axis=-1))


def _from_segment(points: Array, start: npt.ArrayLike, end: npt.ArrayLike) -> Any:
    a, b = np.asarray(start, np.float64), np.asarray(end, np.float64)
    along = b - a
    share = np.clip((points - a) @ along / max(float(along @ along), 1e-300), 0.0, 1.0)
    return np.linalg.norm(points - a - share[..., None] * along, axis=-1)


def carried(poses: Array, points: Array) -> Array:
    """Points [P, 3] in the coordinates of poses [N, 7], in the world [N, P, 3]."""
    return np.asarray(poses[:, None, :3] + points @ np.swapaxes(matrices(poses[:, 3:]), 1, 2))
