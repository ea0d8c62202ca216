"""Knots spread evenly over a horizon: the same curve from a later time on.

`bendtwin.interpolate` has the curve by frame; here times are any.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.simulation.interpolation import Interpolation

Array = npt.NDArray[np.float64]


def curve_matrix(times: npt.ArrayLike, knots: int, interpolation: Interpolation) -> Array:
    """The matrix [T, K] that turns knots into the points of the curve at `times` [T].

    Times are in units of knot spacing; before the first knot and after the last one the curve
    stays there. "cubic" is Catmull-Rom, continued in a straight line beyond the ends.
    """
    times = np.clip(np.asarray(times, dtype=np.float64), 0.0, knots - 1)
    matrix = np.zeros((len(times), knots))
    rows = np.arange(len(times))
    before = np.minimum(times.astype(np.int64), max(knots - 2, 0))
    t = times - before
    if knots == 1:
        matrix[:, 0] = 1.0
        return matrix
    if interpolation == "linear":
        matrix[rows, before] += 1.0 - t
        matrix[rows, before + 1] += t
        return matrix
    if interpolation == "zero":
        matrix[rows, np.floor(times).astype(np.int64)] = 1.0
        return matrix
    weights = (
        (before - 1, 0.5 * (-t + 2 * t**2 - t**3)),
        (before, 1.0 - 2.5 * t**2 + 1.5 * t**3),
        (before + 1, 0.5 * (t + 4 * t**2 - 3 * t**3)),
        (before + 2, 0.5 * (t**3 - t**2)),
    )
    for knot, weight in weights:
        # Beyond an end: 2 p[0] - p[1], or 2 p[K - 1] - p[K - 2].
        inside = (knot >= 0) & (knot < knots)
        matrix[rows[inside], knot[inside]] += weight[inside]
        for outside, end, next_to_it in (
            (knot < 0, 0, 1),
            (knot >= knots, knots - 1, knots - 2),
        ):
            matrix[rows[outside], end] += 2.0 * weight[outside]
            matrix[rows[outside], next_to_it] -= weight[outside]
    return matrix


def shifted(
    knots: npt.NDArray[Any], shift_frames: float, frames: int, interpolation: Interpolation
) -> Array:
    """The knots [K, D] of the same curve from `shift_frames` on; at its end it stands still."""
    count = len(knots)
    spacing = frames / (count - 1)
    times = np.arange(count) + shift_frames / spacing
    return np.asarray(curve_matrix(times, count, interpolation) @ knots)
