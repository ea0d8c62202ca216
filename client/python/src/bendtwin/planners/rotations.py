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
    return np.concatenate([vector, scalar], axis=-1)


def _half_sine(angle: npt.NDArray[Any]) -> Array:
    """sin(angle / 2) / angle."""
    return np.asarray(0.5 * np.sinc(angle / (2.0 * np.pi)))
