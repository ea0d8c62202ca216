"""Rigid transforms: poses [..., 7] as x, y, z [m] and a unit quaternion x, y, z, w."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.rotations import conjugate, product, rotated

Array = npt.NDArray[np.float64]

IDENTITY: Array = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])


def relative(outer: npt.NDArray[Any], poses: npt.NDArray[Any]) -> Array:
    """Poses in the coordinates of `outer`."""
    back = conjugate(outer[..., 3:])
    positions = rotated(back, poses[..., :3] - outer[..., :3])
    return np.concatenate([positions, product(back, poses[..., 3:])], axis=-1)


def placed(pose: npt.NDArray[Any], points: npt.NDArray[Any]) -> Array:
    """Points [M, 3] of one pose's coordinates."""
    return np.asarray(pose[:3] + rotated(pose[3:], points))


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
