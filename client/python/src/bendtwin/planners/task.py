"""What a planner minimizes: the cost of knots, as a twin simulates them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from bendtwin.actions import InitialState, Interpolation, Rest
from bendtwin.costs import Cost
from bendtwin.planners.knots import Array, curve_matrix, frame_times
from bendtwin.planners.spaces import ActionSpace, Grippers
from bendtwin.rollout import Fidelity, Returns
from bendtwin.twin import Twin


@dataclass(frozen=True)
class Evaluation:
    """What a simulation says about a batch of plans."""

    #: [B]; +inf where an instance diverged.
    costs: npt.NDArray[np.float64]
    #: d cost / d knots [B, K, D], if asked for.
    gradients: Array | None = None


class Problem(Protocol):
    """The cost of knots; `Task` is one that asks a twin."""

    #: Horizon [frames].
    frames: int
    interpolation: Interpolation

    @property
    def dims(self) -> int:
        """Number of coordinates D of a knot."""

    @property
    def frame_s(self) -> float:
        """Seconds from frame to frame."""

    def evaluate(
        self,
        knots: Array,
        initial: InitialState | None,
        *,
        gradients: bool = False,
        timeout_s: float | None = None,
    ) -> Evaluation:
        """Simulates knots [B, K, D] from a state."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """Costs of a twin's motion over a horizon, as a function of knots in an action space."""

    twin: Twin
    costs: Sequence[Cost]
    #: Coordinates of the knots.
    space: ActionSpace
    #: Horizon [frames].
    frames: int
    interpolation: Interpolation = "linear"
    fidelity: Fidelity = "exact"

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise ValueError("the horizon must be one frame or more")

    @property
    def dims(self) -> int:
        """Number of coordinates D of a knot."""
        return self.space.dims

    @property
    def frame_s(self) -> float:
        """Seconds from frame to frame of the twin."""
        return 1.0 / self.twin.info.fps if self.twin.info.fps else 1.0

    def evaluate(
        self,
        knots: Array,
        initial: InitialState | None,
        *,
        gradients: bool = False,
        timeout_s: float | None = None,
    ) -> Evaluation:
        """Simulates knots [B, K, D] from a state, in one call; None is the twin's rest."""
        if gradients and isinstance(self.space, Grippers):
            raise ValueError(
                "a gradient by the rotation of grippers is not to be had: plan with another "
                "method, or in Together, PerHand or Points"
            )
        result = self.twin.rollout(
            **self.space.actions(knots),
            frames=self.frames,
            interpolation=self.interpolation,
            initial=Rest() if initial is None else initial,
            costs=self.costs,
            returns=Returns(control_gradients=gradients),
            fidelity=self.fidelity,
            timeout_s=timeout_s,
        )
        costs = np.where(np.isnan(result.costs), np.inf, result.costs)
        if not gradients:
            return Evaluation(costs)
        by_frame = result.control_gradients
        if by_frame is None:
            raise ValueError("the server returned no gradients: is it older than this client?")
        count = knots.shape[1]
        curve = curve_matrix(frame_times(self.frames, count), count, self.interpolation)
        by_knot = np.einsum("fk,bf...->bk...", curve, by_frame.astype(np.float64))
        return Evaluation(costs, self.space.gradients(knots, by_knot))

    def actions(self, knots: Array, frames: int | None = None) -> dict[str, Any]:
        """Arguments of `Twin.rollout` that execute knots [K, D]: all of them, or the first frames,
        then with an action for every frame, so that they are the very motion that was planned."""
        if frames is None:
            named = self.space.actions(knots[None])
            return {**named, "frames": self.frames, "interpolation": self.interpolation}
        if not 1 <= frames <= self.frames:
            raise ValueError(f"the plan has {self.frames} frames: give 1..{self.frames}")
        path = self.path(knots)[: frames + 1]
        return {**self.space.actions(path[None]), "frames": frames}

    def path(self, knots: Array) -> Array:
        """The coordinates in every frame, [F + 1, D]."""
        return self.space.path(knots, frame_times(self.frames, len(knots)), self.interpolation)
