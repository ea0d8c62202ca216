"""Collision meshes as convex hulls with few faces that contain them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.robots.description import MeshFile, RobotError
from bendtwin.robots.transforms import Array

#: Most faces of a hull. The server accepts 128; each costs time for every node of the object.
MOST_FACES = 48
#: Points of which any hull has at most 128 faces, since triangles are at most 2 M - 4.
FEW_POINTS = 66
_LARGEST_BYTES = 200 << 20
_FARTHEST_M = 1000.0
_FORMATS = (".stl", ".obj", ".ply", ".off", ".dae", ".glb")
#: Thickness of a flat mesh [m].
_THINNEST_M = 1e-3
_INSTALL = "pip install 'bendtwin[robots]'"


@dataclass(frozen=True)
class Hull:
    """A convex body."""

    #: Corners [M, 3], metres.
    points: Array
    #: Middles of its faces, or of triangles of them, [P, 3].
    middles: Array


def read_hull(mesh: MeshFile, what: str) -> Hull:
    """The hull of a mesh in a file, which a link (`what`) names.

    Raises:
        RobotError: If there is no such file, or no mesh in it.
    """
    path = next((p for p in mesh.candidates if p.is_file()), None)
    if path is None:
        looked = ", ".join(map(str, mesh.candidates)) or "nowhere"
        raise RobotError(
            f"{what} has the mesh {mesh.name!r}, which was not found at {looked}: name the folders "
            "of its package, package_dirs=..., or leave the link out, links=..."
        )
    points = _points(path, what) * mesh.scale
    if len(points) < 3 or not (np.abs(points) <= _FARTHEST_M).all():
        raise RobotError(
            f"{what} has the mesh {path}, which is empty or larger than {_FARTHEST_M:g} m: the "
            "unit is metres, see its scale"
        )
    return hull_of(points)


def hull_of(points: npt.NDArray[Any]) -> Hull:
    """A convex body that contains points [M, 3]: their hull, or a polytope around it with the
    planes of `MOST_FACES` of its faces."""
    convex = _hull(points)
    if convex is None:
        return hull_of(_thickened(points))
    planes = _planes(convex.equations)
    if len(planes) > MOST_FACES:
        corners = _around(points[convex.vertices], planes)
        convex = _hull(corners)
        points = corners
    assert convex is not None, "a polytope around a body has a volume"
    middles = points[convex.simplices].mean(axis=1)
    return Hull(np.asarray(points[convex.vertices]), np.asarray(middles))


def hull_planes(points: npt.NDArray[Any]) -> Array:
    """Outward normals and offsets [F, 4] of the faces of the hull of points [M, 3]: `n . x + d` is
    above 0 outside.

    Raises:
        RobotError: If the points lie in a plane.
    """
    convex = _hull(points)
    if convex is None:
        raise RobotError("the points of a convex mesh lie in a plane")
    return np.asarray(convex.equations)


def _points(path: Path, what: str) -> Array:
    """Vertices [M, 3] of a mesh, metres without its scale."""
    try:
        import trimesh
    except ModuleNotFoundError:
        raise RobotError(f"{what} has the mesh {path}; to read meshes: {_INSTALL}") from None
    kind = path.suffix.lower()
    if kind not in _FORMATS:
        raise RobotError(f"{what} has the mesh {path}: use one of {', '.join(_FORMATS)}")
    if path.stat().st_size > _LARGEST_BYTES:
        raise RobotError(f"{what} has the mesh {path}, larger than {_LARGEST_BYTES} bytes")
    if kind == ".dae" and b"<!DOCTYPE" in path.read_bytes().upper():
        raise RobotError(f"{what} has the mesh {path} with a DOCTYPE: remove it")
    try:
        with path.open("rb") as file:
            scene = trimesh.load_scene(file, file_type=kind[1:])
        if kind == ".dae":
            scene = scene.convert_units("meters")
        vertices = [np.asarray(part.vertices, np.float64) for part in scene.dump()]
    except Exception as error:  # Its readers raise many kinds.
        raise RobotError(f"{what} has the mesh {path}, which cannot be read: {error}") from error
    joined = np.concatenate([np.zeros((0, 3)), *vertices])
    return np.asarray(np.unique(joined[np.isfinite(joined).all(axis=1)], axis=0))


def _hull(points: npt.NDArray[Any]) -> Any:
    """Qhull's hull; None if the points lie in a plane."""
    try:
        from scipy.spatial import ConvexHull, QhullError
    except ModuleNotFoundError:
        raise RobotError(f"to make hulls of many points: {_INSTALL}") from None
    try:
        return ConvexHull(points)
    except (QhullError, ValueError):
        return None


def _planes(equations: npt.NDArray[Any]) -> Array:
    """The planes of faces [F, 4], once for the triangles of a face."""
    return np.asarray(np.unique(np.round(equations, 6), axis=0))


def _around(corners: npt.NDArray[Any], planes: Array) -> Array:
    """Corners of a polytope around a body: of its box, cut by faces of the body where the polytope
    sticks out farthest."""
    from scipy.spatial import HalfspaceIntersection

    inside = corners.mean(axis=0)
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    chosen = np.column_stack([normals, -(corners @ normals.T).max(axis=0)])
    while True:
        polytope: Array = HalfspaceIntersection(chosen, inside).intersections
        room = MOST_FACES - len(chosen)
        beyond = polytope @ planes[:, :3].T + planes[:, 3]
        worst = np.argsort(-beyond.max(axis=1), kind="stable")
        # Corners near each other are cut by one plane; a few at a time, so that each counts.
        cuts = list(dict.fromkeys(int(i) for i in beyond[worst].argmax(axis=1)))
        cuts = cuts[: min(room, 6)]
        if not cuts or beyond.max() <= 1e-6:
            return polytope
        # Rounding of the planes must not cut the body.
        offsets = -(corners @ planes[cuts, :3].T).max(axis=0)
        chosen = np.concatenate([chosen, np.column_stack([planes[cuts, :3], offsets])])


def _thickened(points: npt.NDArray[Any]) -> Array:
    """Corners of a box around points that lie in a plane, on a line or in one place."""
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    axes = axes if len(axes) == 3 else np.eye(3)
    along = (points - middle) @ axes.T
    low = along.min(axis=0) - 0.5 * _THINNEST_M
    high = along.max(axis=0) + 0.5 * _THINNEST_M
    corners = np.stack(np.meshgrid(*np.stack([low, high], axis=1), indexing="ij"), axis=-1)
    return np.asarray(middle + corners.reshape(-1, 3) @ axes)
