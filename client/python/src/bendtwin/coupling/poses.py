"""Poses x, y, z, quaternion x, y, z, w, and the change between the worlds of model and twin."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
#: Order x, y, z, w of a quaternion that MuJoCo has as w, x, y, z.
XYZW = [1, 2, 3, 0]
_WXYZ = [3, 0, 1, 2]


class Change:
    """From coordinates of the model's world to those of the twin."""

    def __init__(self, world_in_twin: npt.ArrayLike) -> None:
        pose = np.asarray(world_in_twin, np.float64)
        if pose.shape != (7,) or not np.isfinite(pose).all() or not pose[3:].any():
            raise ValueError("world_in_twin is a pose: x, y, z, quaternion x, y, z, w")
        self._origin = pose[:3]
        self._quaternion = pose[3:][_WXYZ] / np.linalg.norm(pose[3:])
        self._rotation = matrix(self._quaternion)

    def pose(self, position: FloatArray, quaternion: FloatArray) -> FloatArray:
        """The pose [7] of a frame of the model with a quaternion w, x, y, z."""
        turned = np.empty(4)
        mujoco.mju_mulQuat(turned, self._quaternion, quaternion)
        return np.concatenate([self.point(position), turned[XYZW]])

    def point(self, position: FloatArray) -> FloatArray:
        """A point."""
        return self._origin + self._rotation @ position

    def vector(self, vector: FloatArray) -> FloatArray:
        """A direction, a force or gravity."""
        return np.asarray(self._rotation @ vector, np.float64)

    def rotation(self, rotation: FloatArray) -> FloatArray:
        """Axes [3, 3]."""
        return np.asarray(self._rotation @ rotation, np.float64)

    def points_back(self, points: npt.ArrayLike) -> FloatArray:
        """Points [N, 3] of the twin in the model's world."""
        return (np.asarray(points, np.float64) - self._origin) @ self._rotation

    def vectors_back(self, vectors: FloatArray) -> FloatArray:
        """Vectors [..., 3] of the twin along the axes of the model's world."""
        return vectors @ self._rotation


def matrix(quaternion: FloatArray) -> FloatArray:
    """The rotation [3, 3] of a quaternion w, x, y, z."""
    flat = np.empty(9)
    mujoco.mju_quat2Mat(flat, np.asarray(quaternion, np.float64))
    return flat.reshape(3, 3)
