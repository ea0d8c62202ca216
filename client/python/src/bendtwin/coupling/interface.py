"""The fixed point of a frame: wrenches that, applied to the model, come back from the twin.

Explicit coupling takes a step towards it once a frame. Implicit coupling repeats the frame until
the residual `H(w) - w` is small, H being the wrenches that come back. The interface quasi-Newton
method (inverse least squares: Degroote, Bathe, Vierendeels 2009) estimates the response from the
differences of evaluations, of this frame and of the last few.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

#: Length at which a torque counts as a force, metres.
ARM_M = 0.1
#: Directions below this share of the largest singular value are noise.
_LEAST = 1e-4


class FixedPoint:
    """Estimates of the wrenches of a frame; wrenches are flat, in newtons (`ARM_M` for torques)."""

    def __init__(self, relaxation: float, kept_frames: int) -> None:
        self._relaxation = relaxation
        self._kept_frames = kept_frames
        #: Differences of residuals and of responses, newest first, by frame.
        self.differences: list[list[tuple[FloatArray, FloatArray]]] = []
        self._last: tuple[FloatArray, FloatArray] | None = None

    def begin(self) -> None:
        """Starts a frame."""
        self.differences = [[], *self.differences[: self._kept_frames]]
        self._last = None

    def next(self, guess: FloatArray, response: FloatArray) -> FloatArray:
        """The next guess after an evaluation."""
        residual = response - guess
        if self._last is not None:
            before, answered = self._last
            self.differences[0].insert(0, (residual - before, response - answered))
        self._last = (residual, response)
        columns = [pair for frame in self.differences for pair in frame][: len(guess)]
        if not columns:
            return guess + self._relaxation * residual
        v = np.stack([a for a, _ in columns], axis=1)
        w = np.stack([b for _, b in columns], axis=1)
        # Columns of one length: those of a wide and a narrow step tell the same.
        sizes = np.maximum(np.linalg.norm(v, axis=0), 1e-12)
        shares = np.linalg.lstsq(v / sizes, -residual, rcond=_LEAST)[0]
        explained = residual + (v / sizes) @ shares
        step = response + (w / sizes) @ shares
        # What no difference explains is relaxed as before.
        relaxed: FloatArray = step - (1 - self._relaxation) * explained
        return relaxed
