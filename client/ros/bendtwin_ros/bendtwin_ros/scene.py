"""Obstacles of MoveIt as colliders of a rollout.

Boxes and spheres stay what they are; cylinders and cones become prisms and pyramids around them; of
a mesh each connected part becomes its convex hull. A plane that lies below becomes the ground, any
other one a thick box behind it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from bendtwin import Collider, ConvexMesh, Cuboid, Plane, Sphere, World
from bendtwin.rotations import matrices, quaternions
from bendtwin_ros import hulls
from bendtwin_ros.frames import Frames
from bendtwin_ros.messages.basic import Pose
from bendtwin_ros.messages.scene import CollisionObject, Mesh, PlanningScene, SolidPrimitive
from bendtwin_ros.poses import IDENTITY, Array, applied, of_pose, points_of, product

_Shape = TypeVar("_Shape")

#: Sides of a prism for a cylinder: its hull has 92 triangles of at most 128.
_SIDES = 24
#: Half the width and the depth of a box for a plane, metres.
_WIDE_M, _DEEP_M = 20.0, 2.0
#: Cosine of the slope up to which a plane is a ground.
_LEVEL = 0.7
_MOST_OBJECTS = 1000
_NUMBERS = {
    SolidPrimitive.BOX: 3,
    SolidPrimitive.SPHERE: 1,
    SolidPrimitive.CYLINDER: 2,
    SolidPrimitive.CONE: 2,
}


class SceneFault(ValueError):
    """A scene that cannot be used; the message names the object and what is wrong with it."""


class Obstacles:
    """The objects of a scene, by their names, as scenes and their changes come."""

    def __init__(self, objects: Iterable[CollisionObject] = ()) -> None:
        self._objects = {one.id: one for one in objects}

    def update(self, scene: PlanningScene) -> None:
        """Takes a scene, or a change of it.

        Raises:
            SceneFault: If there are too many objects, or one is moved that is not there.
        """
        if not scene.is_diff:
            self._objects.clear()
        for one in scene.world.collision_objects:
            self._change(one)
        if len(self._objects) > _MOST_OBJECTS:
            self._objects.clear()
            raise SceneFault(f"the scene has more than {_MOST_OBJECTS} objects, and is left out")

    def _change(self, one: CollisionObject) -> None:
        known = self._objects.get(one.id)
        if one.operation == CollisionObject.REMOVE:
            if one.id:
                self._objects.pop(one.id, None)
            else:
                self._objects.clear()
        elif one.operation == CollisionObject.MOVE:
            if known is None:
                raise SceneFault(f"object {one.id!r} is moved, but was never added")
            self._objects[one.id] = _moved(known, one)
        elif one.operation == CollisionObject.APPEND and known is not None:
            self._objects[one.id] = replace(
                known,
                primitives=known.primitives + one.primitives,
                primitive_poses=known.primitive_poses + one.primitive_poses,
                meshes=known.meshes + one.meshes,
                mesh_poses=known.mesh_poses + one.mesh_poses,
                planes=known.planes + one.planes,
                plane_poses=known.plane_poses + one.plane_poses,
            )
        else:
            self._objects[one.id] = one

    def and_of(self, scene: PlanningScene) -> Obstacles:
        """These objects, and those of a scene, which replaces them unless it is a change."""
        both = Obstacles(self._objects.values())
        if scene.is_diff or scene.world.collision_objects:
            both.update(scene)
        return both

    def world(self, frame: str, frames: Frames, *, friction: float, margin_m: float) -> World:
        """The objects as the world of a rollout, in a frame.

        Raises:
            SceneFault: If a shape is invalid.
            MissingTransform: If TF does not know the frame of an object.
        """
        colliders: list[Collider] = []
        ground: Plane | None = None
        for one in self._objects.values():
            base = product(frames.pose(frame, one.header.frame_id, 0), _pose(one, one.pose))
            for shape, pose, margin in _solids(one):
                collider = Collider(
                    shape=shape,
                    pose=product(base, pose),
                    name=f"{one.id}:{len(colliders)}",
                    friction=friction,
                    margin_m=margin_m + margin,
                )
                colliders.append(collider)
            for normal, at in _planes(one, base):
                if ground is None and normal[2] >= _LEVEL:
                    ground = Plane(float(normal @ at), normal)
                else:
                    name = f"{one.id}:{len(colliders)}"
                    colliders.append(_behind(normal, at, name, friction, margin_m))
        return World(
            colliders=colliders,
            ground=ground,
            ground_friction=None if ground is None else friction,
        )


def _moved(known: CollisionObject, to: CollisionObject) -> CollisionObject:
    """An object with new poses; a message without poses of shapes moves the whole."""
    new = replace(known, header=to.header, pose=to.pose)
    for name in ("primitive_poses", "mesh_poses", "plane_poses"):
        if len(getattr(to, name)) == len(getattr(known, name)):
            new = replace(new, **{name: getattr(to, name)})
    return new


def _solids(one: CollisionObject) -> Iterator[tuple[Sphere | Cuboid | ConvexMesh, Array, float]]:
    """The shapes of an object with their poses in it, and how far each sticks out of its form."""
    for solid, pose in _pairs(one, one.primitives, one.primitive_poses):
        yield _solid(one, solid), pose, 0.0
    for mesh, pose in _pairs(one, one.meshes, one.mesh_poses):
        for part in _parts(one, mesh):
            points, beyond_m = hulls.few(part)
            yield ConvexMesh(points), pose, beyond_m


def _pairs(
    one: CollisionObject, shapes: Sequence[_Shape], poses: Sequence[Pose]
) -> Iterator[tuple[_Shape, Array]]:
    """Shapes with their poses in the object; without poses they are at its origin."""
    if poses and len(poses) != len(shapes):
        raise SceneFault(f"object {one.id!r} has {len(shapes)} shapes and {len(poses)} poses")
    for i, shape in enumerate(shapes):
        yield shape, _pose(one, poses[i]) if poses else IDENTITY


def _pose(one: CollisionObject, message: Pose) -> Array:
    pose = of_pose(message)
    if pose is None:
        raise SceneFault(f"object {one.id!r} has an invalid pose: check its quaternion")
    return pose


def _solid(one: CollisionObject, solid: SolidPrimitive) -> Sphere | Cuboid | ConvexMesh:
    wanted = _NUMBERS.get(solid.type)
    if wanted is None:
        raise SceneFault(
            f"object {one.id!r} has a shape of type {solid.type}: "
            "boxes, spheres, cylinders, cones and meshes are known"
        )
    sizes = np.asarray(solid.dimensions[:wanted], dtype=np.float64)
    if len(sizes) != wanted or not (np.isfinite(sizes) & (sizes > 0.0)).all():
        raise SceneFault(f"object {one.id!r} has the dimensions {list(solid.dimensions)}")
    if solid.type == SolidPrimitive.BOX:
        return Cuboid(-sizes / 2.0, sizes / 2.0)
    if solid.type == SolidPrimitive.SPHERE:
        return Sphere(float(sizes[0]))
    height, radius = sizes
    angles = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    # Around the circle, which the sides touch.
    ring = radius / np.cos(np.pi / _SIDES) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    low = np.column_stack([ring, np.full(_SIDES, -height / 2.0)])
    if solid.type == SolidPrimitive.CONE:
        return ConvexMesh(np.concatenate([low, [[0.0, 0.0, height / 2.0]]]))
    return ConvexMesh(np.concatenate([low, low + np.array([0.0, 0.0, height])]))


def _parts(one: CollisionObject, mesh: Mesh) -> list[Array]:
    """Vertices of each connected part of a mesh."""
    vertices = points_of(mesh.vertices)
    corners = np.array([list(t.vertex_indices) for t in mesh.triangles], dtype=np.int64)
    corners = corners.reshape(-1, 3)
    if not len(corners) or not np.isfinite(vertices).all():
        raise SceneFault(f"object {one.id!r} has a mesh without triangles, or with NaN in it")
    if corners.min() < 0 or corners.max() >= len(vertices):
        raise SceneFault(f"object {one.id!r} has triangles of vertices that it does not have")
    return hulls.parts(vertices, corners)


def _planes(one: CollisionObject, base: Array) -> Iterator[tuple[Array, Array]]:
    """Unit normals and points of the planes of an object."""
    for plane, pose in _pairs(one, one.planes, one.plane_poses):
        coefficients = np.asarray(plane.coef, dtype=np.float64)
        length = np.linalg.norm(coefficients[:3])
        if coefficients.shape != (4,) or not np.isfinite(coefficients).all() or length < 1e-9:
            raise SceneFault(f"object {one.id!r} has the plane {list(plane.coef)}")
        normal = coefficients[:3] / length
        placed = product(base, pose)
        yield matrices(placed[3:]) @ normal, applied(placed, -coefficients[3] / length * normal)


def _behind(normal: Array, at: Array, name: str, friction: float, margin_m: float) -> Collider:
    """A box behind a plane."""
    other = np.eye(3)[np.abs(normal).argmin()]
    side = np.cross(normal, other)
    side /= np.linalg.norm(side)
    return Collider(
        shape=Cuboid([-_WIDE_M, -_WIDE_M, -_DEEP_M], [_WIDE_M, _WIDE_M, 0.0]),
        pose=np.concatenate([at, quaternions(np.stack([side, np.cross(normal, side), normal], 1))]),
        name=name,
        friction=friction,
        margin_m=margin_m,
    )
