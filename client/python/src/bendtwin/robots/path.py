"""Joint paths with times, for a robot's controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bendtwin.robots.robot import Robot
from bendtwin.robots.transforms import Array

#: Share of a limit within which it counts as kept: rounding.
_TOLERANCE = 1e-6


@dataclass(frozen=True)
class JointPath:
    """Joints of a robot at every frame boundary, F + 1 of them; J joints.

    A controller interpolates linearly between them: it then moves as the plan was simulated.
    """

    #: Names of the joints [J].
    names: tuple[str, ...]
    #: Seconds from the start [F + 1].
    times_s: Array
    #: Radians, or metres [F + 1, J].
    positions: Array

    @property
    def velocities(self) -> Array:
        """Mean velocities around each time [F + 1, J], standing still before the first and after
        the last: what a trajectory controller takes beside positions."""
        rates = np.diff(self.positions, axis=0) / np.diff(self.times_s)[:, None]
        still = np.zeros((1, len(self.names)))
        return np.asarray(0.5 * (np.vstack([still, rates]) + np.vstack([rates, still])))

    def faults(self, robot: Robot) -> list[str]:
        """Sentences about limits of the robot that the path exceeds; none: it keeps all."""
        found = []
        rates = np.abs(np.diff(self.positions, axis=0)) / np.diff(self.times_s)[:, None]
        for j, joint in enumerate(robot.joints):
            limits, row = joint.limits, self.positions[:, j]
            slack = _TOLERANCE * max(
                1.0, limits.high - limits.low if np.isfinite(limits.high - limits.low) else 1.0
            )
            beyond = np.maximum(limits.low - row, row - limits.high)
            if beyond.max() > slack:
                at = int(beyond.argmax())
                found.append(
                    f"{joint.name} is at {row[at]:.4g} after {self.times_s[at]:.3g} s, its limits "
                    f"are {limits.low:.4g} and {limits.high:.4g}"
                )
            if rates[:, j].max() > limits.speed * (1.0 + 1e-4):
                at = int(rates[:, j].argmax())
                found.append(
                    f"{joint.name} moves by {rates[at, j]:.4g} a second after "
                    f"{self.times_s[at]:.3g} s, its limit is {limits.speed:.4g}"
                )
        return found
