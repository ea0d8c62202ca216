"""Rotation vectors [rad], unit quaternions x, y, z, w, and poses x, y, z [m] with one of these."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def exponential(vectors: npt.NDArray[Any]) -> Array:
    """Quaternions [..., 4] of rotation vectors [..., 3]."""
    angle = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.concatenate([_half_sine(angle) * vectors, np.cos(0.5 * angle)], axis=-1)


def exponential_jacobian(vectors: npt.NDArray[Any]) -> Array:
    """d quaternion / d rotation vector, [..., 4, 3]."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    s = _half_sine(angle)
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    slope = np.where(small, -1.0 / 24.0, (0.5 * np.cos(0.5 * safe) - s) / safe**2)
    outer = vectors[..., :, None] * vectors[..., None, :]
    vector_part = s * np.eye(3) + slope * outer
    return np.concatenate([vector_part, -0.5 * s * vectors[..., None, :]], axis=-2)


def product(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> Array:
    """The rotation b followed by a, [..., 4]."""
    av, aw, bv, bw = a[..., :3], a[..., 3:], b[..., :3], b[..., 3:]
    vector = aw * bv + bw * av + np.cross(av, bv)
    scalar = aw * bw - (av * bv).sum(-1, keepdims=True)
    return np.asarray(np.concatenate([vector, scalar], axis=-1), np.float64)


def conjugate(quaternions: npt.NDArray[Any]) -> Array:
    """The rotations back, [..., 4]."""
    return np.asarray(quaternions * np.array([-1.0, -1.0, -1.0, 1.0]), np.float64)


def logarithm(quaternions: npt.NDArray[Any]) -> Array:
    """Rotation vectors [..., 3] of unit quaternions [..., 4], of angles up to pi."""
    short = np.where(quaternions[..., 3:] < 0.0, -1.0, 1.0) * quaternions
    sine = np.linalg.norm(short[..., :3], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, short[..., 3:])
    return np.asarray(short[..., :3] / _half_sine(angle))


def quaternions(matrices: npt.NDArray[Any]) -> Array:
    """Quaternions [..., 4] of rotation matrices [..., 3, 3], whose columns are the turned axes."""
    # The eigenvector of the largest eigenvalue of a symmetric matrix is right for all angles
    # (Bar-Itzhack 2000).
    m = np.asarray(matrices, np.float64)
    trace = np.trace(m, axis1=-2, axis2=-1)[..., None, None]
    form = np.empty((*m.shape[:-2], 4, 4))
    form[..., :3, :3] = m + np.swapaxes(m, -1, -2) - trace * np.eye(3)
    skew = (m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1])
    form[..., :3, 3] = form[..., 3, :3] = np.stack(skew, axis=-1)
    form[..., 3:, 3:] = trace
    found = np.linalg.eigh(form)[1][..., -1]
    return np.where(found[..., 3:] < 0.0, -found, found)


def of_angles(angles: npt.ArrayLike) -> Array:
    """Quaternions [..., 4] of roll, pitch and yaw [..., 3], about the fixed axes x, y and z in
    turn."""
    half = 0.5 * np.asarray(angles, dtype=np.float64)
    turns = np.zeros((*half.shape, 4))
    turns[..., np.arange(3), np.arange(3)] = np.sin(half)
    turns[..., 3] = np.cos(half)
    roll, pitch, yaw = np.moveaxis(turns, -2, 0)
    return product(yaw, product(pitch, roll))


def rotated(quaternions: npt.NDArray[Any], vectors: npt.NDArray[Any]) -> Array:
    """Vectors [..., 3] turned by unit quaternions [..., 4]."""
    axis, scalar = quaternions[..., :3], quaternions[..., 3:]
    twice = 2.0 * np.cross(axis, vectors)
    return np.asarray(vectors + scalar * twice + np.cross(axis, twice))


def matrices(quaternions: npt.NDArray[Any]) -> Array:
    """Rotation matrices [..., 3, 3] of unit quaternions [..., 4]."""
    axes = (np.broadcast_to(unit, quaternions[..., :3].shape) for unit in np.eye(3))
    return np.stack([rotated(quaternions, axis) for axis in axes], axis=-1)


def compose(outer: npt.NDArray[Any], inner: npt.NDArray[Any]) -> Array:
    """Poses [..., 7] `inner`, given in the coordinates of `outer`, in the coordinates of the
    latter."""
    positions = outer[..., :3] + rotated(outer[..., 3:], inner[..., :3])
    return np.concatenate([positions, product(outer[..., 3:], inner[..., 3:])], axis=-1)


def _half_sine(angle: npt.NDArray[Any]) -> Array:
    """sin(angle / 2) / angle."""
    return np.asarray(0.5 * np.sinc(angle / (2.0 * np.pi)))
