"""Geoms of a MuJoCo model as colliders of a twin's world.

Shapes keep their size, but for three that a twin does not have: a cylinder becomes a prism of 24
sides around it, an ellipsoid a polyhedron of 66 corners around it, and a mesh the hull of at most
66 of its vertices, which has no more faces than a collider may have.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from bendtwin.coupling.gripper import find
from bendtwin.simulation.world import Capsule, ConvexMesh, Cuboid, Plane, Shape, Sphere

FloatArray = npt.NDArray[np.float64]

_SIDES = 24
#: A hull of V points has at most 2 V - 4 faces, and that of a collider at most 128.
_MOST_POINTS = 66


def colliding(model: Any, names: Sequence[str] | None) -> list[int]:
    """Numbers of the geoms of these names, or of the bodies of these names; None: of all geoms
    that collide in the model.

    Raises:
        ValueError: If the model has neither a geom nor a body of a name.
    """
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    if names is None:
        return [int(geom) for geom in np.flatnonzero(collides)]
    chosen: dict[int, None] = {}
    for name in names:
        geom, body = find(model, "geom", name), find(model, "body", name)
        if geom >= 0:
            chosen[geom] = None
        elif body >= 0:
            chosen.update(dict.fromkeys(np.flatnonzero(collides & (model.geom_bodyid == body))))
        else:
            raise ValueError(f"the model has neither a geom nor a body {name!r}")
    return [int(geom) for geom in chosen]


def name_of(model: Any, geom: int) -> str:
    """The name of a geom, or its number."""
    return mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, geom) or f"geom{geom}"


def is_plane(model: Any, geom: int) -> bool:
    """True for a plane, which becomes the ground."""
    return bool(model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE)


def plane(position: FloatArray, rotation: FloatArray) -> Plane:
    """The ground that a plane at a pose is, its normal the third axis of the rotation [3, 3]."""
    normal = rotation[:, 2]
    return Plane(offset_m=float(normal @ position), normal=normal)


def shape(model: Any, geom: int) -> Shape:
    """The shape of a geom in its own coordinates.

    Raises:
        ValueError: If a twin's world has nothing like it.
    """
    kind = mujoco.mjtGeom(int(model.geom_type[geom]))
    make = _SHAPES.get(kind)
    if make is None:
        raise ValueError(
            f"geom {name_of(model, geom)!r} is of type {kind.name}, which no collider can be: "
            "leave it out by naming others with colliders="
        )
    return make(model, geom)


def _sphere(model: Any, geom: int) -> Shape:
    return Sphere(float(model.geom_size[geom][0]))


def _capsule(model: Any, geom: int) -> Shape:
    radius, half, _ = model.geom_size[geom]
    return Capsule([0.0, 0.0, -half], [0.0, 0.0, half], float(radius))


def _box(model: Any, geom: int) -> Shape:
    half = model.geom_size[geom].copy()
    return Cuboid(-half, half)


def _cylinder(model: Any, geom: int) -> Shape:
    radius, half, _ = model.geom_size[geom]
    angles = 2 * np.pi * np.arange(_SIDES) / _SIDES
    # Sides that touch the cylinder.
    corners = radius / np.cos(np.pi / _SIDES) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    ends = [np.column_stack([corners, np.full(_SIDES, z)]) for z in (-half, half)]
    return ConvexMesh(np.concatenate(ends))


def _ellipsoid(model: Any, geom: int) -> Shape:
    corners = directions(_MOST_POINTS)
    # The ball inside the corners: the least of their extents over all directions.
    inner = (directions(5000) @ corners.T).max(axis=1).min()
    return ConvexMesh(corners / inner * model.geom_size[geom])


def _mesh(model: Any, geom: int) -> Shape:
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    vertices = np.asarray(model.mesh_vert[first : first + count], np.float64)
    extent = np.ptp(vertices, axis=0)
    scale = np.where(extent > 0, extent, 1.0)
    # The outermost vertex in each of many directions, of the mesh made as wide as high.
    chosen = np.unique(np.argmax(directions(_MOST_POINTS) @ (vertices / scale).T, axis=1))
    return ConvexMesh(vertices[chosen])


def directions(count: int) -> FloatArray:
    """Unit vectors [count, 3] spread evenly over the sphere, along a spiral."""
    steps = np.arange(count) + 0.5
    z, turn = 1 - 2 * steps / count, np.pi * (1 + np.sqrt(5)) * steps
    around = np.sqrt(1 - z * z)
    return np.stack([around * np.cos(turn), around * np.sin(turn), z], axis=1)


_SHAPES: dict[Any, Callable[[Any, int], Shape]] = {
    mujoco.mjtGeom.mjGEOM_SPHERE: _sphere,
    mujoco.mjtGeom.mjGEOM_CAPSULE: _capsule,
    mujoco.mjtGeom.mjGEOM_BOX: _box,
    mujoco.mjtGeom.mjGEOM_CYLINDER: _cylinder,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: _ellipsoid,
    mujoco.mjtGeom.mjGEOM_MESH: _mesh,
}
