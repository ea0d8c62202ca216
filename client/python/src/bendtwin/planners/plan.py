"""Results of planners."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bendtwin.planners.knots import Array
from bendtwin.planners.task import Problem, Task

Origin = Literal["nominal", "mean", "sample"]


@dataclass(frozen=True, kw_only=True)
class Planned:
    """The best of all simulated knots, never worse than the nominal ones."""

    #: Knots [K, D] in the coordinates of the action space.
    knots: Array
    #: Cost of exactly these knots, as simulated.
    cost: float
    #: The nominal plan, the mean that the method arrived at, or one of its samples.
    origin: Origin
    nominal_cost: float
    #: Iterations that were finished.
    iterations: int
    time_s: float
    #: "deadline" if there was no time for all iterations.
    stopped: Literal["iterations", "deadline"]
    problem: Problem | Task = field(repr=False)
    #: Sum of the excess of strain and of the forces of grasps over the limits of `Plausibility`, as
    #: shares of the limits, and of a machine over its own (`MachineSpace.excess`): 0, unless every
    #: plan was beyond one. Plans beyond a limit are worse than all within, regardless of cost.
    excess: float = 0.0
    #: Number of the simulated plans that did not diverge and were beyond a limit.
    overstrained: int = 0

    def actions(self, frames: int | None = None) -> dict[str, Any]:
        """Arguments of `Twin.rollout` that execute the plan: all of it, or its first frames."""
        if not isinstance(self.problem, Task):
            raise TypeError("only a plan for a twin has actions")
        return self.problem.actions(self.knots, frames)


@dataclass(frozen=True, kw_only=True)
class Plan(Planned):
    """A plan that a planner of this package made."""

    #: Best of the samples, and its cost; the nominal plan where no sample was simulated.
    best_sample: Array
    best_sample_cost: float
    #: Costs of all that was simulated, an array for each call; +inf for what diverged.
    costs: list[npt.NDArray[np.float64]]

    @property
    def diverged(self) -> int:
        """Number of the simulated plans that diverged."""
        return int(sum(np.isinf(costs).sum() for costs in self.costs))


@dataclass(frozen=True, kw_only=True)
class ServerPlan(Planned):
    """A plan that the server made."""

    #: Weighted terms of the cost by name.
    cost_terms: dict[str, float]
    #: Number of the simulated plans, and of those of them that diverged.
    simulated: int
    diverged: int
    #: With a grasp search: the place of the plan, and the cost of the best plan of each place [P].
    grasp: int | None = None
    grasp_costs: npt.NDArray[np.float64] | None = None
    #: Largest mean force of a grasp over a frame, newtons, if there is a limit or a grasp search.
    grasp_force_n: float | None = None
