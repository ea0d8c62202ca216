"""Values between the knots of actions, as the server computes them.

With t_k the knots' times, i the last knot at or before t, h = t_(i+1) - t_i and s = (t - t_i) / h:

- linear: (1 - s) p_i + s p_(i+1).
- cubic: the Hermite cubic through the knots with slopes m_k = (p_(k+1) - p_(k-1)) / (t_(k+1) -
  t_(k-1)), at both ends that of the straight line to the neighbour: Catmull-Rom, for any times.
- zero: p_i. A jump is spread over the one frame in which it happens.

The last knot holds until the end. Knots less than a thousandth of a frame from a frame's boundary
are on it. Rotations are always interpolated spherically between two knots.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import numpy.typing as npt

Interpolation = Literal["linear", "cubic", "zero"]

_ON_FRAME = 1e-3
_NEARLY_EQUAL = 1.0 - 1e-9

_Doubles = npt.NDArray[np.float64]


def interpolate(
    knots: npt.ArrayLike,
    frames: int,
    *,
    interpolation: Interpolation = "linear",
    fps: float | None = None,
    at_s: npt.ArrayLike | None = None,
    period_s: float | None = None,
) -> npt.NDArray[np.float32]:
    """Positions at every frame boundary [B, F + 1, ..., n] between knots [B, K, ..., n]: what a
    rollout of these `trajectories` executes.

    Args:
        knots: Knots of any shape whose second dimension counts them.
        frames: Horizon F.
        interpolation: Curve between knots.
        fps: Frames per second of the twin (`twin.info.fps`), needed with times.
        at_s: Times of the knots [K], seconds; None: spread evenly, or `period_s`.
        period_s: Seconds from knot to knot.
    """
    given = np.asarray(knots, dtype=np.float32)
    knot, share, times = _places(given.shape[1], frames, interpolation, fps, at_s, period_s)
    weights = np.stack(
        [_weights(int(i), float(s), times, interpolation) for i, s in zip(knot, share, strict=True)]
    )
    flat = given.reshape(given.shape[0], given.shape[1], -1).astype(np.float64)
    made = np.einsum("fk,bkn->bfn", weights, flat).astype(np.float32)
    shaped: npt.NDArray[np.float32] = made.reshape(given.shape[0], frames + 1, *given.shape[2:])
    return shaped


def interpolate_poses(
    poses: npt.ArrayLike,
    frames: int,
    *,
    interpolation: Interpolation = "linear",
    fps: float | None = None,
    at_s: npt.ArrayLike | None = None,
    period_s: float | None = None,
) -> npt.NDArray[np.float32]:
    """Poses of grippers at every frame boundary [B, F + 1, G, 7] between knots [B, K, G, 7]."""
    given = np.asarray(poses, dtype=np.float32)
    options: Any = {"fps": fps, "at_s": at_s, "period_s": period_s}
    position = interpolate(given[..., :3], frames, interpolation=interpolation, **options)
    knot, share, _ = _places(given.shape[1], frames, interpolation, fps, at_s, period_s)
    raw = given[..., 3:].astype(np.float64)
    unit = raw / np.linalg.norm(raw, axis=-1, keepdims=True)
    start, end = unit[:, knot], unit[:, np.minimum(knot + 1, given.shape[1] - 1)]
    rotation = _slerp(start, end, share[None, :, None, None])
    return np.concatenate([position, rotation.astype(np.float32)], axis=-1)


def _places(
    count: int,
    frames: int,
    interpolation: Interpolation,
    fps: float | None,
    at_s: npt.ArrayLike | None,
    period_s: float | None,
) -> tuple[npt.NDArray[np.int64], _Doubles, _Doubles]:
    """The knot at or before each frame boundary, the share of the way to the next, and the knots'
    times."""
    if interpolation not in ("linear", "cubic", "zero"):
        raise ValueError(f"give linear, cubic or zero as interpolation, not {interpolation!r}")
    if at_s is not None and period_s is not None:
        raise ValueError("give either at_s or period_s")
    if at_s is None and period_s is None:
        scaled = np.arange(frames + 1, dtype=np.int64) * (count - 1)
        knot, share = scaled // frames, (scaled % frames) / frames
        times = np.arange(count, dtype=np.float64)
    else:
        if fps is None:
            raise ValueError("knots with times need fps: twin.info.fps")
        if at_s is not None:
            seconds = np.asarray(at_s, dtype=np.float32).astype(np.float64)
        else:
            seconds = np.arange(count, dtype=np.float64) * float(period_s or 0.0)
        if seconds.shape != (count,):
            raise ValueError(f"at_s has shape {seconds.shape}, there are {count} knots")
        exact: _Doubles = seconds * fps
        whole = np.round(exact)
        times = np.where(np.abs(exact - whole) < _ON_FRAME, whole, exact)
        now = np.arange(frames + 1, dtype=np.float64)
        knot = np.searchsorted(times, now, side="right") - 1
        after = np.minimum(knot + 1, count - 1)
        gap = np.where(after > knot, times[after] - times[knot], 1.0)
        share = np.where(after > knot, (now - times[knot]) / gap, 0.0)
    if interpolation == "zero":
        share = np.zeros_like(share, dtype=np.float64)
    return knot, np.asarray(share, dtype=np.float64), times


def _weights(i: int, s: float, times: _Doubles, interpolation: Interpolation) -> _Doubles:
    """Weights of all knots at a place."""
    weights = np.zeros(len(times))
    if s == 0.0:
        weights[i] = 1.0
        return weights
    if interpolation == "linear":
        weights[i : i + 2] = 1.0 - s, s
        return weights
    rise = s * s * (3.0 - 2.0 * s)
    weights[i : i + 2] = 1.0 - rise, rise
    ends = (max(i - 1, 0), i + 1), (i, min(i + 2, len(times) - 1))
    for (a, b), by in zip(ends, (s * (1.0 - s) ** 2, s * s * (s - 1.0)), strict=True):
        slope = by * (times[i + 1] - times[i]) / (times[b] - times[a])
        weights[a] -= slope
        weights[b] += slope
    return weights


def _slerp(start: _Doubles, end: _Doubles, share: _Doubles) -> _Doubles:
    cosine = np.sum(start * end, axis=-1, keepdims=True)
    end = np.where(cosine < 0.0, -end, end)
    cosine = np.minimum(np.abs(cosine), 1.0)
    chord = cosine > _NEARLY_EQUAL
    angle = np.arccos(np.where(chord, 0.0, cosine))
    sine = np.sin(angle)
    a = np.where(chord, 1.0 - share, np.sin((1.0 - share) * angle) / sine)
    b = np.where(chord, share, np.sin(share * angle) / sine)
    mixed = a * start + b * end
    made: _Doubles = mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)
    return made
