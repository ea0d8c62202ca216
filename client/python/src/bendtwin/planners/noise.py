"""Random changes of a plan."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def deviations(sigma: npt.ArrayLike, knots: int, dims: int) -> npt.NDArray[np.float64]:
    """Standard deviations [K, D]: 0 in row 0, where things are; `sigma` is a number, [D] or
    [K, D] or any shape that broadcasts to that."""
    array = np.asarray(sigma, dtype=np.float64)
    try:
        full = np.broadcast_to(array, (knots, dims)).copy()
    except ValueError:
        shape = array.shape
        raise ValueError(
            f"sigma has shape {shape}: give a number, [{dims}] or [{knots}, {dims}]"
        ) from None
    if not np.isfinite(full).all() or (full < 0).any():
        raise ValueError("sigma must be finite and not negative")
    full[0] = 0.0
    return full


def sample_scales(count: int, finest: float) -> npt.NDArray[np.float64]:
    """Factors [count] of sigma: 1 for the first sample, `finest` for the last."""
    return np.asarray(np.geomspace(1.0, finest, count) if count > 1 else np.ones(count))


def correlated(
    random: np.random.Generator, count: int, knots: int, dims: int, correlation: float
) -> npt.NDArray[np.float64]:
    """Standard normal numbers [count, K, D]; neighbouring knots have the correlation (0..1).

    Each knot keeps a variance of 1: e[k] = r e[k - 1] + sqrt(1 - r²) n[k].
    """
    noise = random.standard_normal((count, knots, dims))
    if correlation:
        fresh = np.sqrt(1.0 - correlation**2)
        for k in range(2, knots):  # Row 0 does not move, so the first that counts is row 1.
            noise[:, k] = correlation * noise[:, k - 1] + fresh * noise[:, k]
    return noise
