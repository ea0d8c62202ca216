"""Joint paths with times, for a robot's controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bendtwin.robots.robot import Robot
from bendtwin.robots.transforms import Array

#: Distance beyond a limit that is rounding [rad or m].
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
        """Velocities at each time [F + 1, J], means of those before and after it, as if the robot
        stood still beforehand and afterwards: for trajectory controllers that take them."""
        rates = np.diff(self.positions, axis=0) / np.diff(self.times_s)[:, None]
        still = np.zeros((1, len(self.names)))
        return np.asarray(0.5 * (np.vstack([still, rates]) + np.vstack([rates, still])))

    def faults(self, robot: Robot) -> list[str]:
        """Sentences about limits of the robot that the path exceeds; none: it keeps all."""
        found = []
        rates = np.abs(np.diff(self.positions, axis=0)) / np.diff(self.times_s)[:, None]
        for j, joint in enumerate(robot.joints):
            limits, row = joint.limits, self.positions[:, j]
            beyond = np.maximum(limits.low - row, row - limits.high)
            if beyond.max() > _TOLERANCE:
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
