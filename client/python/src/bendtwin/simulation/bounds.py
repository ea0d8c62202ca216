"""Limits of what a plan may do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True)
class Bounds:
    """Limits by coordinate, each a number or [D]; None limits nothing.

    They hold at the knots, and between them as well with linear interpolation. Row 0 of a plan is
    the current position and is not changed.
    """

    #: Smallest and largest value of a coordinate: metres or radians from the start of the space.
    low: npt.ArrayLike | None = None
    high: npt.ArrayLike | None = None
    #: Highest rate of change of a coordinate [m/s or rad/s].
    speed: npt.ArrayLike | None = None

    def within(self, other: Bounds) -> Bounds:
        """The limits that keep both."""

        def tighter(a: Any, b: Any, choose: Any) -> Any:
            return b if a is None else a if b is None else choose(a, b)

        return Bounds(
            low=tighter(self.low, other.low, np.maximum),
            high=tighter(self.high, other.high, np.minimum),
            speed=tighter(self.speed, other.speed, np.minimum),
        )

    def project(self, knots: npt.NDArray[Any], knot_s: float) -> npt.NDArray[np.float64]:
        """The plans [..., K, D] within the limits, with knots `knot_s` seconds apart.

        Knots are moved one after the other: the speed limit has priority, so a plan that begins
        outside of `low` and `high` may need several knots to return.
        """
        knots = np.array(knots, dtype=np.float64)
        dims = knots.shape[-1]
        low = -np.inf if self.low is None else _by_coordinate("low", self.low, dims)
        high = np.inf if self.high is None else _by_coordinate("high", self.high, dims)
        if np.any(np.asarray(low) > np.asarray(high)):
            raise ValueError("low lies above high: swap them")
        step: Any = np.inf
        if self.speed is not None:
            step = _by_coordinate("speed", self.speed, dims) * knot_s
            if np.any(step < 0):
                raise ValueError("speed must not be negative")
        for k in range(1, knots.shape[-2]):
            last = knots[..., k - 1, :]
            inside = np.clip(knots[..., k, :], low, high)
            knots[..., k, :] = np.clip(inside, last - step, last + step)
        return knots


def _by_coordinate(name: str, values: npt.ArrayLike, dims: int) -> npt.NDArray[np.float64]:
    array = np.asarray(values, dtype=np.float64)
    if array.shape not in ((), (dims,)):
        raise ValueError(f"{name} has shape {array.shape}: give a number or [{dims}]")
    return array
