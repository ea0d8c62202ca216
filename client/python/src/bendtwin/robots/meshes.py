"""Collision meshes as convex hulls with few faces that contain them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.robots.description import MeshFile, RobotError
from bendtwin.robots.transforms import Array

#: Most faces of a hull. The server accepts 128; each costs time for every node of the object.
MOST_FACES = 32
_LARGEST_BYTES = 64 << 20
_FARTHEST_M = 1000.0
_FORMATS = (".stl", ".obj", ".ply", ".off", ".dae", ".glb")
#: Cosine of the least angle between the normals of a hull: 0.3 radians.
_COSINE = 0.955
#: Shortest edge of a hull, and least depth that is cut off, as shares of its largest side.
_SHORTEST = 0.02
_LEAST_CUT = 0.005
#: Distance within which a corner is nearly on a plane, as such a share; the server takes a corner
#: as on it at a tenth of that.
_ALMOST = 2e-4
#: Thickness that a flat mesh gets: metres, or if that is more a share of its largest side.
_THINNEST_M, _THINNEST = 1e-3, 5e-3
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
    path = next((p for p in mesh.candidates if os.path.isfile(p)), None)
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
    """A polytope around points [M, 3]: their box, cut along some faces of their hull.

    The server makes the hull of its corners again, in single precision. So that this is the same
    polytope, its planes meet at angles that are not small, and its edges are not short: a cut that
    would make one is left out. Every cut that is left out makes it larger, never smaller.
    """
    convex = _hull(points)
    extent = float(np.ptp(points, axis=0).max())
    thinnest = max(_THINNEST_M, _THINNEST * extent)
    if convex is None:
        return hull_of(_thickened(points, thinnest))
    corners = points[convex.vertices]
    box = _box(corners)
    if (-box[:3, 3] - box[3:, 3]).min() < 0.5 * thinnest:
        return hull_of(_thickened(points, thinnest))
    planes = np.concatenate([box, _cuts(corners, box, np.unique(convex.equations, axis=0), extent)])
    inside = corners.mean(axis=0)
    while True:
        polytope = _corners(planes, inside, extent)
        frail = np.flatnonzero(_frail(polytope, planes, extent))
        candidates = [int(i) for i in frail if i >= len(box)]
        if not candidates:
            break
        planes = np.delete(planes, _least(planes, candidates, inside, extent), axis=0)
    triangles = polytope[_hull(polytope).simplices]
    return Hull(polytope, np.asarray(triangles.mean(axis=1)))


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
        raise RobotError(f"to merge shapes, read meshes or avoid them: {_INSTALL}") from None
    try:
        return ConvexHull(points)
    except (QhullError, ValueError):
        return None


def _box(corners: Array) -> Array:
    """The six planes [6, 4] of the smaller of two boxes: along the axes, and along the principal
    ones."""
    _, _, principal = np.linalg.svd(corners - corners.mean(axis=0), full_matrices=False)
    boxes = []
    for axes in (np.eye(3), principal):
        normals = np.concatenate([axes, -axes])
        boxes.append(np.column_stack([normals, -(corners @ normals.T).max(axis=0)]))
    volumes = [np.prod(-box[:3, 3] - box[3:, 3]) for box in boxes]
    return boxes[int(volumes[1] < 0.98 * volumes[0])]


def _cuts(corners: Array, box: Array, faces: Array, extent: float) -> Array:
    """Planes of faces [F, 4] that cut off most where the polytope of all before sticks out
    farthest."""
    chosen = box
    while len(chosen) < MOST_FACES:
        apart = chosen[:, :3] @ faces[:, :3].T
        faces = faces[(apart < _COSINE).all(axis=0)]
        if not len(faces):
            break
        polytope = _corners(chosen, corners.mean(axis=0), extent)
        beyond = polytope @ faces[:, :3].T + faces[:, 3]
        if beyond.max() <= _LEAST_CUT * extent:
            break
        chosen = np.concatenate([chosen, faces[[beyond.max(axis=0).argmax()]]])
    return chosen[len(box) :]


def _corners(planes: Array, inside: Array, extent: float) -> Array:
    """Corners of the polytope within planes; those in one place count once."""
    from scipy.spatial import HalfspaceIntersection

    found = HalfspaceIntersection(planes, inside).intersections
    same = np.abs(found[:, None] - found).max(axis=-1) <= 1e-8 * extent
    return np.asarray(found[~np.tril(same, -1).any(axis=1)])


def _frail(polytope: Array, planes: Array, extent: float) -> npt.NDArray[np.bool_]:
    """The planes [F] at a place where single precision could find other faces: at the two corners
    nearest to each other, if they are near, or at a corner that is nearly on a plane."""
    distance = np.abs(polytope @ planes[:, :3].T + planes[:, 3])
    touched = distance <= 1e-7 * extent
    apart = np.linalg.norm(polytope[:, None] - polytope, axis=-1)
    apart[np.diag_indices(len(polytope))] = np.inf
    a, b = np.unravel_index(int(apart.argmin()), apart.shape)
    if apart[a, b] < _SHORTEST * extent:
        return np.asarray(touched[a] | touched[b])
    almost = np.argwhere(~touched & (distance < _ALMOST * extent))
    frail = np.zeros(len(planes), bool)
    if len(almost):
        corner, plane = almost[0]
        frail = touched[corner]
        frail[plane] = True
    return frail


def _least(planes: Array, candidates: list[int], inside: Array, extent: float) -> int:
    """The plane that cuts off least, of some."""
    depths = []
    for i in candidates:
        around = _corners(np.delete(planes, i, axis=0), inside, extent)
        depths.append(float((around @ planes[i, :3] + planes[i, 3]).max()))
    return candidates[int(np.argmin(depths))]


def _thickened(points: npt.NDArray[Any], by_m: float) -> Array:
    """Corners of a box around points that nearly lie in a plane, on a line or in one place."""
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    axes = axes if len(axes) == 3 else np.eye(3)
    along = (points - middle) @ axes.T
    low = along.min(axis=0) - 0.5 * by_m
    high = along.max(axis=0) + 0.5 * by_m
    corners = np.stack(np.meshgrid(*np.stack([low, high], axis=1), indexing="ij"), axis=-1)
    return np.asarray(middle + corners.reshape(-1, 3) @ axes)
