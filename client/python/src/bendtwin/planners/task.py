"""Tasks, which planners minimize: the cost of knots, as a twin simulates them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from bendtwin.costs import Cost
from bendtwin.interpolation import Interpolation, interpolate, interpolate_poses
from bendtwin.planners.knots import Array
from bendtwin.planners.spaces import ActionSpace
from bendtwin.rollout import Fidelity, Returns, RolloutResult
from bendtwin.state import InitialState, Rest
from bendtwin.twin import Twin


@dataclass(frozen=True)
class Evaluation:
    """Result of simulating a batch of plans."""

    #: [B]; +inf where an instance diverged.
    costs: npt.NDArray[np.float64]
    #: d cost / d knots [B, K, D], if asked for.
    gradients: Array | None = None
    #: How far the strain of the material is beyond the limit, 0 where it is not [B]: a plan beyond
    #: it is worse than all that keep it. None: all keep it.
    excess: npt.NDArray[np.float64] | None = None


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
        result = self.twin.rollout(
            **self.space.actions(knots),
            frames=self.frames,
            interpolation=self.interpolation,
            initial=Rest() if initial is None else initial,
            costs=self.costs,
            returns=Returns(action_gradients=gradients),
            fidelity=self.fidelity,
            timeout_s=timeout_s,
        )
        costs = np.where(np.isnan(result.costs), np.inf, result.costs)
        if not gradients:
            return Evaluation(costs, excess=_excess(result))
        by_actions = result.action_gradients
        if by_actions is None:
            raise ValueError("the server returned no gradients: is it older than this client?")
        gradients_by_knots = self.space.gradients(knots, by_actions.astype(np.float64))
        return Evaluation(costs, gradients_by_knots, _excess(result))

    def actions(self, knots: Array, frames: int | None = None) -> dict[str, Any]:
        """Arguments of `Twin.rollout` that execute knots [K, D]: all of them, or the first frames,
        then with an action for every frame, so that they are the very motion that was planned."""
        named = self.space.actions(knots[None])
        if frames is None:
            return {**named, "frames": self.frames, "interpolation": self.interpolation}
        if not 1 <= frames <= self.frames:
            raise ValueError(f"the plan has {self.frames} frames: give 1..{self.frames}")
        curves = {"trajectories": interpolate, "poses": interpolate_poses}
        for kind in curves.keys() & named.keys():
            dense = curves[kind](named[kind], self.frames, interpolation=self.interpolation)
            named[kind] = dense[:, : frames + 1]
        return {**named, "frames": frames}


def _excess(result: RolloutResult) -> npt.NDArray[np.float64]:
    """Excess of the strain of each action, with an ensemble of its members, over the limit."""
    members = 1 if result.member_costs is None else result.member_costs.shape[1]
    excess = np.zeros(len(result.costs))
    for found in result.implausible:
        if found.reason == "STRAIN":
            action = found.instance // members
            excess[action] = max(excess[action], found.found - found.limit)
    return excess
