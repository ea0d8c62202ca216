"""Observations of an environment: which parts, and what they are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from bendtwin import rotations
from bendtwin.envs.body import Array, Body, Indices, farthest
from bendtwin.envs.cameras import Camera
from bendtwin.envs.simulation import Mask

Observed = dict[str, Any]

#: Side of the cells in which a camera sees only what is nearest, in spacings of the points; and how
#: far behind it other points are still seen.
_CELL, _BEHIND = 1.5, 2.0


@dataclass(frozen=True, kw_only=True)
class PointCloud:
    """Points of the surface in observations, always as many."""

    count: int = 128
    #: Standard deviation of each coordinate, metres.
    noise_m: float = 0.0
    #: The name of a camera that must see a point, or a `Camera`; points that it does not see are
    #: replaced by others that it sees. None: all are seen.
    seen_by: str | Camera | None = None


@dataclass(frozen=True, kw_only=True)
class Observations:
    """The parts of an observation, a dict.

    `agent_pos` is always there: by gripper x, y, z [m], a quaternion x, y, z, w and its opening, 0
    or 1. The others, in metres and metres per second:
    """

    #: `keypoints` [M, 3]: number of nodes, spread over the object with the tip first; or the nodes
    #: [M]; 0 for none.
    keypoints: int | Sequence[int] = 12
    #: `velocities` [M, 3] of the keypoints.
    velocities: bool = False
    #: `goal`: the numbers of the task's goal.
    goal: bool = True
    #: In place of the last three one vector, `environment_state`, as policies of LeRobot read it.
    flat: bool = False
    #: `points` [count, 3].
    point_cloud: PointCloud | None = None
    #: `pixels`: pictures [height, width, 3], uint8, by the names of cameras: "front", "side",
    #: "top", "wrist", or `Camera`.
    cameras: Sequence[str | Camera] = ()
    #: Size of the pictures of cameras that are given by name.
    width: int = 96
    height: int = 96
    #: How the object looks: None chooses Gaussians if the twin has them.
    look: Literal["surface", "gaussians"] | None = None


class Observer:
    """Makes observations of the recorded points."""

    def __init__(
        self,
        settings: Observations,
        body: Body,
        grippers: int,
        goal_size: int,
        cameras: Sequence[Camera],
        cloud_camera: Camera | None,
    ) -> None:
        self.settings, self._body = settings, body
        given = settings.keypoints
        #: Nodes of the keypoints [M].
        self.nodes: Indices = (
            (body.spread(given) if given else np.zeros(0, np.int64))
            if isinstance(given, int)
            else np.asarray(given, np.int64)
        )
        nodes = len(body.positions)
        if self.nodes.size and (self.nodes.min() < 0 or self.nodes.max() >= nodes):
            raise ValueError(f"keypoints name nodes that the twin does not have: it has {nodes}")
        #: True if all nodes must be recorded.
        self.needs_all: bool = settings.point_cloud is not None
        self._camera = cloud_camera
        if settings.point_cloud is not None:
            rest = body.geometry.skin.positions(body.positions)
            if len(rest) < 3:
                rest = body.positions
            self._skin = len(body.geometry.skin) >= 3
            self._cloud = farthest(rest, settings.point_cloud.count, 0)
            apart = np.linalg.norm(rest[self._cloud, None] - rest[self._cloud], axis=-1)
            np.fill_diagonal(apart, np.inf)
            self._spacing_m = float(np.median(apart.min(axis=1))) if len(apart) > 1 else 1e-3
        self.space: spaces.Dict = self._space(grippers, goal_size, cameras)

    def states(
        self,
        positions: Array,
        velocities: Array | None,
        whole: Array | None,
        poses: Array,
        closed: Mask,
        goals: Array,
        randoms: Sequence[np.random.Generator],
    ) -> Observed:
        """The parts of R observations that need no pictures: of keypoints and their velocities
        [R, M, 3], of all nodes [R, N, 3] if they are needed, and of grippers and goals."""
        settings, rows = self.settings, len(poses)
        opening = np.where(closed, 0.0, 1.0)[..., None]
        agent = np.concatenate([poses, opening], axis=-1).reshape(rows, -1)
        observed: Observed = {"agent_pos": agent.astype(np.float32)}
        parts: Observed = {}
        if len(self.nodes):
            parts["keypoints"] = np.array(positions, np.float32)
            if settings.velocities and velocities is not None:
                parts["velocities"] = np.array(velocities, np.float32)
        if settings.goal:
            parts["goal"] = goals.astype(np.float32)
        if settings.flat:
            flat = [part.reshape(rows, -1) for part in parts.values()]
            observed["environment_state"] = np.concatenate(flat, axis=1)
        else:
            observed |= parts
        if settings.point_cloud is not None and whole is not None:
            observed["points"] = self._points(settings.point_cloud, whole, randoms)
        return observed

    def _points(
        self, cloud: PointCloud, whole: Array, randoms: Sequence[np.random.Generator]
    ) -> npt.NDArray[np.float32]:
        nodes = np.asarray(whole, np.float64)
        surface = self._body.geometry.skin.positions(nodes) if self._skin else nodes
        points = surface[:, self._cloud]
        if self._camera is not None:
            hidden = self._hidden(points, self._camera)
            order = np.argsort(hidden, axis=1, kind="stable")
            seen = np.maximum((~hidden).sum(axis=1, keepdims=True), 1)
            rows = np.arange(cloud.count)[None] % seen
            points = np.take_along_axis(points, np.take_along_axis(order, rows, 1)[..., None], 1)
        elif points.shape[1] < cloud.count:
            points = points[:, np.arange(cloud.count) % points.shape[1]]
        if cloud.noise_m:
            noise = [random.normal(0.0, cloud.noise_m, (cloud.count, 3)) for random in randoms]
            points = points + np.array(noise)
        return points.astype(np.float32)

    def _hidden(self, points: Array, camera: Camera) -> Mask:
        """Points [R, P] that are outside of a picture, or behind others."""
        pose = np.asarray(camera.pose, float)
        lens = np.asarray(camera.intrinsics, float)
        back = rotations.matrices(pose[3:]).T
        arms = points - pose[:3]
        local = (back[None, None] * arms[..., None, :]).sum(axis=-1)
        depth = local[..., 2]
        in_front = depth > 1e-6
        safe = np.where(in_front, depth, 1.0)
        pixels = local[..., :2] / safe[..., None] * lens[:2] + lens[2:]
        size = np.array([camera.width, camera.height])
        inside = in_front & ((pixels >= -0.5) & (pixels < size - 0.5)).all(axis=-1)
        # Cells as wide as the points are apart, seen from the camera.
        cell = np.maximum(_CELL * self._spacing_m * lens[:2] / np.median(safe), 1.0)
        grid = np.clip(((pixels + 0.5) / cell).astype(np.int64), 0, None)
        columns = int(np.ceil(size[0] / cell[0])) + 1
        lines = int(np.ceil(size[1] / cell[1])) + 1
        index = np.clip(grid[..., 1], 0, lines - 1) * columns + np.clip(
            grid[..., 0], 0, columns - 1
        )
        index += np.arange(len(points))[:, None] * (columns * lines)
        nearest = np.full(len(points) * columns * lines, np.inf)
        np.minimum.at(nearest, index[inside], depth[inside])
        return np.asarray(~inside | (depth > nearest[index] + _BEHIND * self._spacing_m))

    def _space(self, grippers: int, goal: int, cameras: Sequence[Camera]) -> spaces.Dict:
        settings, count = self.settings, len(self.nodes)
        parts: dict[str, spaces.Space[Any]] = {"agent_pos": _box(8 * grippers)}
        state: dict[str, spaces.Space[Any]] = {}
        if count:
            state["keypoints"] = _box(count, 3)
            if settings.velocities:
                state["velocities"] = _box(count, 3)
        if settings.goal:
            state["goal"] = _box(goal)
        if settings.flat:
            parts["environment_state"] = _box(
                sum(int(np.prod(s.shape or ())) for s in state.values())
            )
        else:
            parts |= state
        if settings.point_cloud is not None:
            parts["points"] = _box(settings.point_cloud.count, 3)
        if cameras:
            shots = {c.name: spaces.Box(0, 255, (c.height, c.width, 3), np.uint8) for c in cameras}
            parts["pixels"] = spaces.Dict(shots)
        return spaces.Dict(parts)


def _box(*shape: int) -> spaces.Box:
    return spaces.Box(-np.inf, np.inf, shape, np.float32)
