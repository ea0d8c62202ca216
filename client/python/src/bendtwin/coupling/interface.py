"""The fixed point of a frame: wrenches that, applied to the model, come back from the twin.

Implicit coupling repeats a frame until the residual `r = H(w) - w` is small, H being the wrenches
that come back. How small is a matter of motion: wrenches are measured by the displacement that
they cause within the frame, so that a residual that ends the iteration on a heavy arm does not on a
light plug. Guesses follow Broyden's first method, whose estimate of the inverse Jacobian is kept
from frame to frame: an object that moves smoothly needs few evaluations.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

#: Largest change of displacements by an iteration, metres: an estimate from a slack cable says
#: little about a taut one.
_LARGEST_M = 0.05
#: Displacement of a unit of a wrench that moves nothing, in the place of 0.
_LEAST = 1e-12


class FixedPoint:
    """Guesses of the wrenches of a frame, [6 n] for n bodies."""

    def __init__(self, size: int, relaxation: float) -> None:
        #: Estimate of the inverse of d residual / d wrench, both as displacements; a new one as if
        #: the twin did not react.
        self.inverse: FloatArray = -relaxation * np.eye(size)
        self._units = np.ones(size)
        self._last: tuple[FloatArray, FloatArray] | None = None

    def begin(self, units: FloatArray) -> None:
        """Starts a frame with the displacements [6 n] of a unit of each part of the wrenches."""
        self._units, self._last = np.maximum(units, _LEAST), None

    def displacement_m(self, wrenches: FloatArray) -> float:
        """The largest displacement of a body by a change of the wrenches."""
        of_bodies = np.linalg.norm((self._units * wrenches).reshape(-1, 6), axis=1)
        return float(of_bodies.max(initial=0.0))

    def next(self, guess: FloatArray, response: FloatArray) -> FloatArray:
        """The next guess after an evaluation."""
        residual = self._units * (response - guess)
        if self._last is not None:
            moved = self._units * (guess - self._last[0])
            self._learn(moved, residual - self._last[1])
        self._last = (guess, residual)
        step = -self.inverse @ residual
        step *= min(1.0, _LARGEST_M / max(float(np.linalg.norm(step)), _LARGEST_M))
        following: FloatArray = guess + step / self._units
        return following

    def _learn(self, moved: FloatArray, changed: FloatArray) -> None:
        """Changes the estimate as little as an evaluation demands (Sherman-Morrison)."""
        expected = self.inverse @ changed
        scale = float(moved @ expected)
        if abs(scale) > 1e-12 * float(moved @ moved):
            update = np.outer(moved - expected, moved @ self.inverse) / scale
            # A new matrix: snapshots have the old one.
            self.inverse = self.inverse + update
