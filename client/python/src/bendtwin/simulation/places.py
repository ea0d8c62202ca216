"""Places to grasp, proposed by the shape of an object alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bendtwin.geometry import Geometry
from bendtwin.rotations import quaternions
from bendtwin.simulation.plan import GraspSearch
from bendtwin.simulation.state import State

Array = npt.NDArray[np.float64]

#: Nodes as far as this from the next along a chain are neighbours, in mean spring lengths.
_NEIGHBOURS = 2.5
#: Share of the variance of neighbours beside their main direction below which they lie on a line.
_LINE = 0.1


@dataclass(frozen=True)
class GraspPlaces:
    """P places to grasp, as poses of one gripper."""

    #: Poses [P, 1, 7]: x, y, z in metres, quaternion x, y, z, w. The z axis of the gripper points
    #: along the approach, its x axis is the direction in which the fingers close.
    poses: npt.NDArray[np.float32]
    #: The node at each place [P].
    nodes: npt.NDArray[np.uint32]

    def search(self, gripper: int = 0) -> GraspSearch:
        """The search of these places for a gripper."""
        return GraspSearch(self.poses, (gripper,))


def grasp_places(
    geometry: Geometry,
    state: State | None = None,
    *,
    count: int,
    approach: npt.ArrayLike = (0.0, 0.0, -1.0),
    distance_m: float = 0.0,
    closing: npt.ArrayLike | None = None,
    among: npt.ArrayLike | None = None,
) -> GraspPlaces:
    """Proposes places that are spread evenly over the surface of an object, or along a cable from
    end to end. The same object, state and arguments give the same places.

    On a surface each further place is the one farthest from those before, along the material.

    Args:
        geometry: Geometry of the twin.
        state: Where the object is, [N, 3]; None: at rest.
        count: Number of places P.
        approach: Direction in which the gripper approaches [3]: its z axis.
        distance_m: Distance of the gripper's origin from the node, against the approach.
        closing: Direction in which the fingers close [3], made perpendicular to the approach: the x
            axis of the gripper. None: across the cable, and where the object is not thin, across
            its longest direction.
        among: Nodes to choose from; None: those of the surface.

    Raises:
        ValueError: If there are too few nodes, or a direction or a state cannot be used.
    """
    rest = np.asarray(geometry.rest_positions, np.float64)
    now = rest if state is None else np.asarray(state.positions, np.float64)
    if now.shape != rest.shape or not np.isfinite(now).all():
        raise ValueError(f"the state has positions {now.shape}: give finite ones {rest.shape}")
    down = _unit("approach", approach)
    if among is None:
        allowed = np.arange(geometry.surface_count)
    else:
        allowed = np.unique(np.asarray(among, np.int64))
        if allowed.size and (allowed[0] < 0 or allowed[-1] >= len(rest)):
            raise ValueError(f"among has nodes that are not in 0..{len(rest)}")
    if not 1 <= count <= len(allowed):
        raise ValueError(f"count is {count}: there are {len(allowed)} nodes to choose from")
    graph = _Graph(geometry, rest)
    nodes = graph.spread(allowed, count, is_chain=len(geometry.rods) > 0)
    poses = np.zeros((count, 1, 7), np.float32)
    longest = _main_direction(now, down)
    for i, node in enumerate(nodes):
        if closing is None:
            along = graph.line_at(node, now)
            fingers = np.cross(longest if along is None else along, down)
            if np.linalg.norm(fingers) < 0.1:
                fingers = np.cross(longest, down)
        else:
            fingers = _unit("closing", closing)
        fingers = fingers - (fingers @ down) * down
        if np.linalg.norm(fingers) < 1e-3:
            raise ValueError("closing is parallel to the approach")
        poses[i, 0, :3] = now[node] - distance_m * down
        poses[i, 0, 3:] = _quaternion(fingers / np.linalg.norm(fingers), down)
    return GraspPlaces(poses, nodes.astype(np.uint32))


class _Graph:
    """Springs between nodes, as a graph of distances along the material at rest."""

    def __init__(self, geometry: Geometry, rest: Array) -> None:
        edges = np.asarray(geometry.edges, np.int64).reshape(-1, 2)
        edges = edges[(edges < len(rest)).all(axis=1)]
        self.ends: npt.NDArray[np.int64] = np.concatenate([edges, edges[:, ::-1]])
        self.lengths: Array = np.linalg.norm(np.subtract(*rest[self.ends.T]), axis=-1)
        self.rest = rest
        self.reach_m = _NEIGHBOURS * geometry.spacing_m

    def spread(
        self, allowed: npt.NDArray[np.int64], count: int, *, is_chain: bool
    ) -> npt.NDArray[np.int64]:
        """Nodes among the allowed ones, evenly along a chain, or by farthest points."""
        first = allowed[self._farthest(self._from(allowed[0])[allowed])]
        distances = self._from(first)
        order = allowed[np.argsort(distances[allowed], kind="stable")]
        steps = np.linalg.norm(np.diff(self.rest[order], axis=0), axis=1)
        if is_chain and np.isfinite(distances[order]).all() and (steps <= self.reach_m).all():
            along = distances[order]
            wanted = np.linspace(along[0], along[-1], count)
            chosen = np.abs(along[None] - wanted[:, None]).argmin(axis=1)
            if len(np.unique(chosen)) == count:
                return np.asarray(order[chosen])
        nodes = [first]
        while len(nodes) < count:
            nodes.append(allowed[self._farthest(distances[allowed])])
            distances[nodes[-1]] = 0.0
            distances = self._relaxed(distances)
        return np.array(nodes)

    def line_at(self, node: int, now: Array) -> Array | None:
        """Direction of the line that a node and its neighbours lie on; None where they do not."""
        near = np.unique(self.ends[self.ends[:, 0] == node, 1])
        near = np.unique(self.ends[np.isin(self.ends[:, 0], near), 1])
        if len(near) < 3:
            return None
        _, sizes, axes = np.linalg.svd(now[near] - now[near].mean(axis=0), full_matrices=False)
        is_line = sizes[1] ** 2 < _LINE * sizes[0] ** 2
        return _signed(axes[0]) if is_line else None

    def _from(self, node: int) -> Array:
        distances = np.full(len(self.rest), np.inf)
        distances[node] = 0.0
        return self._relaxed(distances)

    def _relaxed(self, distances: Array) -> Array:
        """Shortest distances, from upper bounds of them."""
        while True:
            shorter = distances.copy()
            np.minimum.at(shorter, self.ends[:, 1], distances[self.ends[:, 0]] + self.lengths)
            if not (shorter < distances).any():
                return shorter
            distances = shorter

    @staticmethod
    def _farthest(distances: Array) -> int:
        return int(np.argmax(distances))


def _main_direction(points: Array, down: Array) -> Array:
    """The direction perpendicular to another one in which points extend most."""
    flat = points - points.mean(axis=0)
    flat = flat - np.outer(flat @ down, down)
    _, sizes, axes = np.linalg.svd(flat, full_matrices=False)
    axis = axes[0] - (axes[0] @ down) * down
    if len(sizes) and sizes[0] > 1e-9 and np.linalg.norm(axis) > 0.5:
        return _signed(axis / np.linalg.norm(axis))
    # All points are on one line along it: any perpendicular direction does.
    least = np.eye(3)[np.abs(down).argmin()]
    across = np.cross(down, least)
    return np.asarray(across / np.linalg.norm(across))


def _signed(axis: Array) -> Array:
    """The same axis, with its largest component positive."""
    return np.asarray(axis * np.sign(axis[np.abs(axis).argmax()]))


def _unit(name: str, direction: npt.ArrayLike) -> Array:
    array = np.asarray(direction, np.float64)
    if array.shape != (3,) or not np.isfinite(array).all() or not np.linalg.norm(array) > 1e-9:
        raise ValueError(f"{name} must be a direction of three finite numbers")
    return np.asarray(array / np.linalg.norm(array))


def _quaternion(x: Array, z: Array) -> Array:
    """Quaternion x, y, z, w of the rotation that brings the axes x and z to these."""
    m = np.stack([x, np.cross(z, x), z], axis=1)
    return _signed(quaternions(m))
