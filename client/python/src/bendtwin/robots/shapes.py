"""Collision shapes of links, as the colliders of a world, and as points to measure depths with.

A collider contains the shape that it stands for. Spheres and boxes are exact. A cylinder at least
twice as long as thick becomes a capsule, which is cheapest for the server and sticks out at both
ends by the radius; another one becomes a prism of 12 sides around it, 3.5 % thicker. A mesh becomes
the polytope around it that `bendtwin.robots.meshes` makes.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from bendtwin.robots.description import Ball, Box, Cylinder, MeshFile, Part
from bendtwin.robots.meshes import Hull, hull_of, read_hull
from bendtwin.robots.transforms import Array, placed
from bendtwin.simulation.world import Capsule, ConvexMesh, Cuboid, Shape, Sphere

Cylinders = Literal["auto", "capsules", "prisms"]

Solid = Ball | Box | Cylinder | Hull

_SIDES = 12
#: Largest distance of sampled points on a box [m], and most of them along a side.
_SPACING_M = 0.03
_MOST_ALONG = 8


def solid_of(part: Part, what: str) -> Solid:
    """The body of a part of a link (`what`); meshes are read."""
    form = part.form
    return read_hull(form, what) if isinstance(form, MeshFile) else form


def shape_of(solid: Solid, cylinders: Cylinders) -> Shape:
    """The collider's shape around a body, in the same coordinates."""
    if isinstance(solid, Ball):
        return Sphere(solid.radius_m)
    if isinstance(solid, Box):
        return Cuboid(-0.5 * solid.sides_m, 0.5 * solid.sides_m)
    if isinstance(solid, Cylinder) and _is_capsule(solid, cylinders):
        end = np.array([0.0, 0.0, 0.5 * solid.length_m])
        return Capsule(-end, end, solid.radius_m)
    return ConvexMesh(outline(solid))


def merged(solids: list[Solid], poses: list[Array]) -> Shape:
    """Convex shape around several bodies, in the coordinates of their poses."""
    points = np.concatenate(
        [placed(pose, outline(solid)) for solid, pose in zip(solids, poses, strict=True)]
    )
    return ConvexMesh(hull_of(points).points)


def outline(solid: Solid) -> Array:
    """Points [M, 3] whose hull contains a body."""
    if isinstance(solid, Ball):
        rings = [_ring(solid.radius_m, z, r) for z, r in ((-1, 0.5), (0, 1), (1, 0.5))]
        # The hull of the unit rings contains a sphere of this radius.
        return np.concatenate(rings) / _ROUNDNESS
    if isinstance(solid, Box):
        signs = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        return np.asarray(signs * solid.sides_m)
    if isinstance(solid, Cylinder):
        radius = solid.radius_m / np.cos(np.pi / _SIDES)
        ends = (-0.5 * solid.length_m, 0.5 * solid.length_m)
        return np.concatenate([_ring(1.0, z, radius) for z in ends])
    return solid.points


def samples(solid: Solid) -> tuple[Array, Array]:
    """Points [P, 3] of a body, and how far the body reaches around each [P]."""
    if isinstance(solid, Ball):
        return np.zeros((1, 3)), np.array([solid.radius_m])
    if isinstance(solid, Box):
        points = _box_points(solid.sides_m)
    elif isinstance(solid, Cylinder):
        count = _along(solid.length_m)
        levels = np.linspace(-0.5, 0.5, count) * solid.length_m
        points = np.concatenate([_ring(1.0, z, solid.radius_m) for z in levels])
    else:
        points = np.concatenate([solid.points, solid.middles])
    return points, np.zeros(len(points))


def _is_capsule(solid: Cylinder, cylinders: Cylinders) -> bool:
    if cylinders == "auto":
        return solid.length_m >= 4.0 * solid.radius_m
    return cylinders == "capsules"


def _ring(scale: float, height: float, radius: float) -> Array:
    """Points on a circle about z."""
    angles = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    circle = [radius * np.cos(angles), radius * np.sin(angles), np.full(_SIDES, height)]
    return np.asarray(scale * np.stack(circle, axis=1))


def _along(length_m: float) -> int:
    return int(np.clip(np.ceil(length_m / _SPACING_M), 1, _MOST_ALONG)) + 1


def _box_points(sides_m: Array) -> Array:
    """Points on the surface of a box."""
    axes = [np.linspace(-0.5, 0.5, _along(float(side))) for side in sides_m]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    on_surface = (np.abs(grid) == 0.5).any(axis=1)
    return np.asarray(grid[on_surface] * sides_m)


def _roundness() -> float:
    """The radius of the largest sphere about the origin in the hull of the rings of `outline`."""
    # Between two corners of the widest ring and the middle of a side of the upper one.
    cosine = np.cos(np.pi / _SIDES)
    below, above = np.array([cosine, 0.0]), np.array([0.5 * cosine, 1.0])
    slope = above - below
    normal = np.array([slope[1], -slope[0]]) / np.linalg.norm(slope)
    return float(min(normal @ below, cosine, 1.0))


_ROUNDNESS = _roundness()
