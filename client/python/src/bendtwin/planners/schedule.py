"""Surroundings of a plan that change with time: closings of grasps, and paths of colliders.

A request has them by the knots of its actions. A task has them by frame, so that they are the same
for any number of knots and continue while a loop shifts its plan.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.simulation.interpolation import Interpolation, interpolate_poses
from bendtwin.simulation.world import Grasp, World


class Schedule:
    """World and grasps over a horizon of F frames."""

    def __init__(
        self,
        world: World | None,
        grasps: Sequence[Grasp],
        frames: int,
        since: npt.ArrayLike = 0.0,
    ) -> None:
        """The horizon begins `since` frames after the first row, [] or [B]; last rows hold on."""
        self._world, self._grasps = world, grasps
        self.frames: int = frames
        times = np.asarray(since, dtype=np.float64)[..., None] + np.arange(frames + 1)
        self._times = np.floor(times).astype(np.int64)
        #: Whether a grasp is closed at each frame boundary, [F + 1] or [B, F + 1], by its number.
        self._closed = {
            i: self._at(grasp.closed, self._times)
            for i, grasp in enumerate(grasps)
            if np.ndim(grasp.closed)
        }
        #: Poses of a collider at each frame boundary, [F + 1, 7], by its number.
        self._paths = {
            i: self._at(collider.path, self._shared())
            for i, collider in enumerate(world.colliders if world else ())
            if collider.path is not None
        }

    def has_knots(self, knots: int, interpolation: Interpolation) -> bool:
        """True if nothing changes but at this number of knots: rows there say all."""
        if not self._closed and not self._paths:
            return True
        first = _first_frames(knots, self.frames)
        # The knot at or before each frame boundary.
        before = np.arange(self.frames + 1) * (knots - 1) // self.frames
        closed = all(np.array_equal(c[..., first[before]], c) for c in self._closed.values())
        if not closed or not self._paths:
            return closed
        paths = np.stack(list(self._paths.values()), axis=1)[None]
        curves = interpolate_poses(paths[:, first], self.frames, interpolation=interpolation)
        return bool(np.allclose(curves, paths, atol=1e-6))

    def at(self, knots: int, frames: int) -> dict[str, Any]:
        """The arguments `world` and `grasps` of a rollout of the first frames, with a row for each
        knot of its actions."""
        first = _first_frames(knots, frames)
        grasps: list[Grasp] = list(self._grasps)
        for i, closed in self._closed.items():
            grasps[i] = replace(grasps[i], closed=closed[..., first])
        named: dict[str, Any] = {"grasps": grasps} if grasps else {}
        if self._world is not None:
            colliders = list(self._world.colliders)
            for i, path in self._paths.items():
                colliders[i] = replace(colliders[i], path=path[first])
            named["world"] = replace(self._world, colliders=colliders)
        return named

    def _shared(self) -> npt.NDArray[np.int64]:
        """Frames that are the same for all instances."""
        times = self._times.reshape(-1, self.frames + 1)
        if (times != times[0]).any():
            raise ValueError("colliders with a path are where they are for all instances alike")
        return np.asarray(times[0])

    @staticmethod
    def _at(rows: npt.ArrayLike | None, times: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
        array = np.asarray(rows)
        return np.asarray(array[np.minimum(times, len(array) - 1)])


def check_rows(world: World | None, grasps: Sequence[Grasp], frames: int) -> None:
    """Refuses rows that are not by frame.

    Raises:
        ValueError: If something changes over rows that are fewer than the frame boundaries.
    """
    given = [(f"grasps[{i}].closed", grasp.closed, 1) for i, grasp in enumerate(grasps)]
    for i, collider in enumerate(world.colliders if world else ()):
        if collider.path is not None:
            given.append((f"world.colliders[{i}].path", collider.path, 2))
    for name, rows, dimensions in given:
        array = np.asarray(rows)
        if not array.ndim:
            continue
        changes = array.ndim != dimensions or (array != array[:1]).any()
        if array.ndim != dimensions or not len(array) or (changes and len(array) <= frames):
            raise ValueError(
                f"{name} has shape {array.shape}: a task has a row for each frame boundary, "
                f"{frames + 1} or more, of which the last holds on"
            )


def _first_frames(knots: int, frames: int) -> npt.NDArray[np.int64]:
    """The first frame boundary at or after each knot, [K]."""
    return -(-np.arange(knots, dtype=np.int64) * frames // (knots - 1))
