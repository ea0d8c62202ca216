"""Model-predictive path integral control on top of batched rollouts.

One iteration is one rollout call: the samples are the batch, the costs come back as [B].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.costs import Cost
from bendtwin.interpolate import Interpolation
from bendtwin.rollout import Fidelity
from bendtwin.state import InitialState, Rest
from bendtwin.twin import Twin

Knots = npt.NDArray[np.float32]


@dataclass
class Mppi:
    """Plans control-point motions that lower a cost.

    Every sample moves all control points by the same smooth offset, as one gripper that
    holds them would; row 0, where the object is now, stays.
    """

    twin: Twin
    costs: Sequence[Cost]
    #: Horizon [frames].
    frames: int
    samples: int = 64
    #: Standard deviation of an offset [m].
    sigma_m: float = 0.02
    #: Small temperatures follow the best sample, large ones average.
    temperature: float = 0.1
    interpolation: Interpolation = "cubic"
    fidelity: Fidelity = "exact"
    seed: int = 0
    _random: np.random.Generator = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._random = np.random.default_rng(self.seed)

    def step(self, nominal: npt.ArrayLike, initial: InitialState | None = None) -> Knots:
        """One iteration: a better plan than `nominal`, knots [K, C, 3] in metres."""
        knots = np.asarray(nominal, dtype=np.float32)
        offsets = self._random.normal(0.0, self.sigma_m, (self.samples, len(knots), 1, 3))
        offsets[:, 0] = 0.0
        # The nominal plan itself is sample 0: an iteration never has to get worse.
        offsets[0] = 0.0
        batch = knots[None] + offsets.astype(np.float32)
        result = self.twin.rollout(
            trajectories=batch,
            frames=self.frames,
            interpolation=self.interpolation,
            initial=Rest() if initial is None else initial,
            costs=self.costs,
            fidelity=self.fidelity,
        )
        weights = path_integral_weights(result.costs, self.temperature)
        return np.tensordot(weights, batch, axes=1).astype(np.float32)

    def plan(
        self, nominal: npt.ArrayLike, iterations: int = 10, initial: InitialState | None = None
    ) -> Knots:
        """Several iterations."""
        knots = np.asarray(nominal, dtype=np.float32)
        for _ in range(iterations):
            knots = self.step(knots, initial)
        return knots


def path_integral_weights(
    costs: npt.NDArray[np.floating[Any]], temperature: float
) -> npt.NDArray[np.float64]:
    """Softmax of -cost [B], scaled by the costs' spread; diverged instances weigh nothing."""
    finite = np.isfinite(costs)
    if not finite.any():
        raise ValueError("every instance diverged: shorten the horizon or move less")
    low = costs[finite].min()
    spread = max(float(costs[finite].max() - low), np.finfo(float).tiny)
    weights = np.where(
        finite, np.exp(-(np.where(finite, costs, low) - low) / spread / temperature), 0
    )
    return np.asarray(weights / weights.sum(), dtype=np.float64)
