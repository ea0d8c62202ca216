"""Inverse kinematics: damped least squares with limits.

An iteration takes the step d with the least `|e - J d|² + damping |d|²` over the joints that are
free: one that is at a limit, and that the step would push beyond it, is held and the step is taken
again. The damping falls where a step helps and rises where it does not (Levenberg-Marquardt).
Everything is deterministic: starts other than the given one are drawn by seed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bendtwin.robots.transforms import Array

_LEAST_DAMPING, _MOST_DAMPING = 1e-9, 1e3
#: Largest change of a joint in an iteration [rad or m].
_LARGEST_STEP = 0.5

#: Errors [E] of joints [J], and their derivatives [E, J].
Errors = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Inverse:
    """Joints that bring tips to poses, as near as they can."""

    #: Joints in the shape of the poses [..., J].
    joints: Array
    #: Largest distance of a tip from its pose [...], metres, and largest angle, radians.
    position_error_m: Array
    rotation_error: Array
    #: False where a tip is farther from its pose than the tolerances allow: it cannot be reached.
    reached: npt.NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class Descent:
    """Settings of a search."""

    low: Array
    high: Array
    iterations: int
    is_near: Callable[[Array], bool]

    def from_start(self, start: Array, errors: Errors) -> Array:
        """Joints with the least errors that are found from a start [J]."""
        joints = np.clip(start, self.low, self.high)
        error, slope = errors(joints)
        damping = 1e-3
        for _ in range(self.iterations):
            if self.is_near(error) or damping > _MOST_DAMPING:
                break
            step = self._step(joints, error, slope, damping)
            following = np.clip(joints + step, self.low, self.high)
            after, slope_after = errors(following)
            gain = error @ error - after @ after
            if gain > 0.0:
                joints, error, slope = following, after, slope_after
                damping = max(0.2 * damping, _LEAST_DAMPING)
                if gain < 1e-15 and np.abs(step).max(initial=0.0) < 1e-9:
                    break
            else:
                damping *= 5.0
        return joints

    def _step(self, joints: Array, error: Array, slope: Array, damping: float) -> Array:
        free = np.ones(len(joints), bool)
        step = np.zeros(len(joints))
        for _ in range(len(joints)):
            columns = slope[:, free]
            square = columns.T @ columns + damping * np.eye(columns.shape[1])
            step[:] = 0.0
            step[free] = np.linalg.solve(square, columns.T @ error)
            beyond = ((joints <= self.low) & (step < 0.0)) | ((joints >= self.high) & (step > 0.0))
            if not (beyond & free).any():
                break
            free &= ~beyond
        largest = np.abs(step).max(initial=0.0)
        return step * min(1.0, _LARGEST_STEP / largest) if largest > 0.0 else step


def starts(start: Array, low: Array, high: Array, count: int, seed: int) -> list[Array]:
    """The start [J], and others between the limits; of a joint without limits, within half a turn
    of the start."""
    random = np.random.default_rng(seed)
    least = np.where(np.isfinite(low), low, start - np.pi)
    most = np.where(np.isfinite(high), high, start + np.pi)
    return [start, *(random.uniform(least, most) for _ in range(count))]
