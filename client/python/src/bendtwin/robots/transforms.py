"""Rigid transforms: poses [..., 7] as x, y, z [m] and a unit quaternion x, y, z, w."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.planners.rotations import product

Array = npt.NDArray[np.float64]

IDENTITY: Array = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])


def rotated(quaternions: npt.NDArray[Any], vectors: npt.NDArray[Any]) -> Array:
    """Vectors [..., 3] turned by quaternions [..., 4]."""
    axis, w = quaternions[..., :3], quaternions[..., 3:]
    twice = 2.0 * np.cross(axis, vectors)
    return np.asarray(vectors + w * twice + np.cross(axis, twice))


def conjugate(quaternions: npt.NDArray[Any]) -> Array:
    """The rotations back, [..., 4]."""
    return np.asarray(quaternions * np.array([-1.0, -1.0, -1.0, 1.0]))


def compose(outer: npt.NDArray[Any], inner: npt.NDArray[Any]) -> Array:
    """Poses `inner`, given in the coordinates of `outer`, in the coordinates of the latter."""
    positions = outer[..., :3] + rotated(outer[..., 3:], inner[..., :3])
    return np.concatenate([positions, product(outer[..., 3:], inner[..., 3:])], axis=-1)


def relative(outer: npt.NDArray[Any], poses: npt.NDArray[Any]) -> Array:
    """Poses in the coordinates of `outer`."""
    back = conjugate(outer[..., 3:])
    positions = rotated(back, poses[..., :3] - outer[..., :3])
    return np.concatenate([positions, product(back, poses[..., 3:])], axis=-1)


def placed(pose: npt.NDArray[Any], points: npt.NDArray[Any]) -> Array:
    """Points [M, 3] of one pose's coordinates."""
    return np.asarray(pose[:3] + rotated(pose[3:], points))


def from_rpy(angles: npt.ArrayLike) -> Array:
    """The quaternion [4] of roll, pitch and yaw [rad], about the fixed axes x, y and z in turn."""
    half = 0.5 * np.asarray(angles, dtype=np.float64)
    turns = np.zeros((3, 4))
    turns[np.arange(3), np.arange(3)] = np.sin(half)
    turns[:, 3] = np.cos(half)
    roll, pitch, yaw = turns
    return product(yaw, product(pitch, roll))


def matrices(quaternions: npt.NDArray[Any]) -> Array:
    """Rotation matrices [..., 3, 3] of quaternions [..., 4]."""
    columns = [
        rotated(quaternions, np.broadcast_to(unit, quaternions[..., :3].shape))
        for unit in np.eye(3)
    ]
    return np.stack(columns, axis=-1)


def vectors(quaternions: npt.NDArray[Any]) -> Array:
    """Rotation vectors [..., 3] of at most pi radians, of quaternions [..., 4]."""
    unit = np.where(quaternions[..., 3:] < 0.0, -quaternions, quaternions)
    sine = np.linalg.norm(unit[..., :3], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, unit[..., 3:])
    scale = np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)
    return np.asarray(scale * unit[..., :3])


def checked_poses(name: str, values: npt.ArrayLike, shape: tuple[int | None, ...]) -> Array:
    """Finite poses of a shape (None: any size) with unit quaternions.

    Raises:
        ValueError: If they are not.
    """
    array = np.array(values, dtype=np.float64)
    fits = array.ndim == len(shape) and all(
        wanted in (None, size) for wanted, size in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("any" if size is None else str(size) for size in shape)
        raise ValueError(f"{name} has shape {array.shape}: give poses [{wanted}]")
    norms = np.linalg.norm(array[..., 3:], axis=-1, keepdims=True)
    if not np.isfinite(array).all() or (norms < 1e-6).any():
        raise ValueError(f"{name} has values that are not finite, or a quaternion of zeros")
    array[..., 3:] /= norms
    return array
