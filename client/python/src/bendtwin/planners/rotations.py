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


def slerp(a: npt.NDArray[Any], b: npt.NDArray[Any], t: npt.NDArray[Any]) -> Array:
    """From a to b the short way round, [..., 4]; t [...] runs from 0 to 1."""
    cosine = (a * b).sum(-1, keepdims=True)
    b = np.where(cosine < 0, -b, b)
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    t = t[..., None]
    near = angle < 1e-6
    sine = np.where(near, 1.0, np.sin(angle))
    wa = np.where(near, 1.0 - t, np.sin((1.0 - t) * angle) / sine)
    wb = np.where(near, t, np.sin(t * angle) / sine)
    mixed = wa * a + wb * b
    return np.asarray(mixed / np.linalg.norm(mixed, axis=-1, keepdims=True))


def _half_sine(angle: npt.NDArray[Any]) -> Array:
    """sin(angle / 2) / angle."""
    return np.asarray(0.5 * np.sinc(angle / (2.0 * np.pi)))


def logarithm(quaternions: npt.NDArray[Any]) -> Array:
    """Rotation vectors [..., 3] of unit quaternions, of at most half a turn."""
    q = np.where(quaternions[..., 3:] < 0, -quaternions, quaternions)
    sine = np.linalg.norm(q[..., :3], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., 3:])
    near = sine < 1e-9
    factor = np.where(near, 2.0, angle / np.where(near, 1.0, sine))
    return np.asarray(factor * q[..., :3])
