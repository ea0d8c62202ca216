"""Rotation vectors [rad] and quaternions x, y, z, w."""

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


def quaternion(matrix: npt.NDArray[Any]) -> Array:
    """The quaternion [4] of a rotation matrix [3, 3], whose columns are the turned axes."""
    # The eigenvector of the largest eigenvalue is right for all angles.
    m = np.asarray(matrix, np.float64)
    skew = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    form = np.zeros((4, 4))
    form[:3, :3] = m + m.T - np.trace(m) * np.eye(3)
    form[:3, 3] = form[3, :3] = skew
    form[3, 3] = np.trace(m)
    found = np.linalg.eigh(form)[1][:, -1]
    return np.asarray(found if found[3] >= 0.0 else -found)


def rotated(quaternions: npt.NDArray[Any], vectors: npt.NDArray[Any]) -> Array:
    """Vectors [..., 3] turned by unit quaternions [..., 4]."""
    axis, scalar = quaternions[..., :3], quaternions[..., 3:]
    twice = 2.0 * np.cross(axis, vectors)
    return np.asarray(vectors + scalar * twice + np.cross(axis, twice))


def _half_sine(angle: npt.NDArray[Any]) -> Array:
    """sin(angle / 2) / angle."""
    return np.asarray(0.5 * np.sinc(angle / (2.0 * np.pi)))
