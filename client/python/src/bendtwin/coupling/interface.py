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
#: Shorter differences of residuals are noise.
_LEAST_N = 1e-6
#: Share of a difference that must point elsewhere than newer ones.
_LEAST_SHARE = 0.5


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
        v, w = self._independent()
        shares = np.linalg.lstsq(v, -residual, rcond=None)[0]
        # What no difference explains is relaxed, as in a first step.
        explained = residual + v @ shares
        following: FloatArray = response + w @ shares - (1 - self._relaxation) * explained
        return following

    def _independent(self) -> tuple[FloatArray, FloatArray]:
        """Differences of residuals and responses as columns, the newest and those of older ones
        that point elsewhere: where a cable gets taut, the older ones of its direction are wrong."""
        count = len(self._last[0]) if self._last is not None else 0
        basis = np.zeros((count, 0))
        columns: list[tuple[FloatArray, FloatArray]] = []
        for v, w in (pair for frame in self.differences for pair in frame):
            size = float(np.linalg.norm(v))
            if size < _LEAST_N:
                continue
            rest = v / size - basis @ (basis.T @ v) / size
            if float(np.linalg.norm(rest)) < _LEAST_SHARE:
                continue
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
            columns.append((v / size, w / size))
            if len(columns) == count:
                break
        parts = [np.array([pair[i] for pair in columns]).reshape(-1, count).T for i in (0, 1)]
        return parts[0], parts[1]
