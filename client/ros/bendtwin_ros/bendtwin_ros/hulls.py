"""Convex hulls: of what an object sweeps, as obstacles of MoveIt, and of meshes, as colliders."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from bendtwin_ros.messages.basic import Pose
from bendtwin_ros.messages.scene import CollisionObject, Mesh, MeshTriangle
from bendtwin_ros.poses import Array, to_points

#: A hull of V points has at most 2 V - 4 triangles, and a collider at most 128.
_MOST_POINTS = 66
#: A flat or a straight set of points is given this thickness to have a hull, metres.
_THIN_M = 1.0e-4


def hull(points: npt.NDArray[Any]) -> tuple[Array, npt.NDArray[np.int64]]:
    """Corners [V, 3] and triangles [F, 3], counter-clockwise from outside, of a convex hull."""
    found, points = _hull(np.asarray(points, dtype=np.float64))
    used, renumbered = np.unique(found.simplices, return_inverse=True)
    corners, triangles = points[used], renumbered.reshape(-1, 3)
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    outwards = np.einsum("fi,fi->f", np.cross(b - a, c - a), found.equations[:, :3]) > 0.0
    triangles[~outwards] = triangles[~outwards][:, ::-1]
    return corners, triangles


def _hull(points: Array) -> tuple[Any, Array]:
    try:
        return ConvexHull(points), points
    except (QhullError, ValueError):
        box = np.array(np.meshgrid(*[[-_THIN_M, _THIN_M]] * 3)).reshape(3, -1).T
        points = (points[:, None] + box).reshape(-1, 3)
        return ConvexHull(points), points


def few(points: Array) -> tuple[Array, float]:
    """Corners of a hull, at most 66, and how far the others stick out of theirs, metres.

    Kept are the farthest points along directions that are spread evenly over a sphere.
    """
    corners, _ = hull(points)
    if len(corners) <= _MOST_POINTS:
        return corners, 0.0
    number = np.arange(_MOST_POINTS) + 0.5
    height = 1.0 - 2.0 * number / _MOST_POINTS
    around = np.pi * (1.0 + 5.0**0.5) * number
    flat = np.sqrt(1.0 - height**2)
    ways = np.stack([flat * np.cos(around), flat * np.sin(around), height], axis=1)
    kept = corners[np.unique((ways @ corners.T).argmax(axis=1))]
    found, kept = _hull(kept)
    beyond = corners @ found.equations[:, :3].T + found.equations[:, 3]
    return kept, float(max(beyond.max(), 0.0))


def parts(vertices: Array, triangles: npt.NDArray[np.int64]) -> list[Array]:
    """The used vertices of each connected part of a mesh; vertices in one place are one."""
    _, same = np.unique(vertices, axis=0, return_inverse=True)
    corners = same.reshape(-1)[triangles]
    ends = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]]])
    count = int(same.max()) + 1
    joined = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    _, labels = connected_components(joined, directed=False)
    part_of_triangle = labels[corners[:, 0]]
    return [
        vertices[np.unique(triangles[part_of_triangle == part])]
        for part in np.unique(part_of_triangle)
    ]


def swept(positions: npt.NDArray[Any], count: int) -> list[Array]:
    """Sets of points whose hulls together contain what points [T, M, 3] sweep, one after the other
    in time; neighbours share a time, so that no motion falls between them."""
    times = len(positions)
    pieces = max(min(count, times - 1), 1)
    ends = np.linspace(0, times - 1, pieces + 1).round().astype(int)
    return [
        np.asarray(positions[a : b + 1], dtype=np.float64).reshape(-1, 3) for a, b in pairwise(ends)
    ]


def collision_object(name: str, points: npt.NDArray[Any]) -> CollisionObject:
    """The hull of points as an obstacle of MoveIt, without header."""
    corners, triangles = hull(points)
    mesh = Mesh([MeshTriangle(t) for t in triangles.tolist()], to_points(corners))
    return CollisionObject(id=name, meshes=[mesh], mesh_poses=[Pose()])
