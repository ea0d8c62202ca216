"""The loop that all planners share: propose, simulate, keep the best, learn.

One iteration is one rollout: the samples are its batch. A planner never returns knots that were
not simulated, hence never a plan that is worse than the one that it began with: the mean of good
samples can be bad.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from dataclasses import replace
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from bendtwin.errors import BendTwinError, Category
from bendtwin.planners.knots import Array, shifted
from bendtwin.planners.noise import correlated, deviations
from bendtwin.planners.plan import Origin, Plan
from bendtwin.planners.task import NO_PLACES, Evaluation, Problem, Task
from bendtwin.simulation.bounds import Bounds
from bendtwin.simulation.state import InitialState

_NO_BOUNDS = Bounds()


class EveryPlanDiverged(RuntimeError):
    """No plan of an iteration could be simulated to its end."""

    def __init__(self) -> None:
        super().__init__(
            "every plan diverged: lower sigma, set bounds on the speed, or shorten the horizon; "
            "and see that the start of the action space is where the control points are"
        )


class Planner(ABC):
    """A planner with a warm start: each plan starts from the previous one.

    After executing some frames call `shift` with their number, then `plan` with the new state.
    """

    #: True if the method needs gradients of the cost.
    _gradients: ClassVar[bool] = False
    #: Default of `finest`.
    _finest: ClassVar[float] = 1.0

    def __init__(
        self,
        problem: Problem,
        *,
        knots: int = 5,
        samples: int = 64,
        iterations: int = 1,
        sigma: npt.ArrayLike = 0.02,
        correlation: float = 0.0,
        finest: float | None = None,
        bounds: Bounds = _NO_BOUNDS,
        deadline_s: float | None = None,
        seed: int = 0,
    ) -> None:
        """Sets what all methods have in common.

        Args:
            problem: Task to minimize: a `Task` for a twin.
            knots: Number of knots K; row 0 is the current position.
            samples: Plans simulated in an iteration.
            iterations: Of one call of `plan`.
            sigma: Standard deviation of samples: a number, one by coordinate [D], or by knot and
                coordinate [K, D]; metres, radians for rotations.
            correlation: Correlation of neighbouring knots of a sample, 0..1: larger is smoother.
            finest: Samples have sigma times a factor, evenly spread in its logarithm from 1 to
                this, 0..1: large ones find ways, small ones the goal. None: 0.03, and 1 for methods
                that shrink their samples themselves.
            bounds: Limits that every plan keeps, beside those of a task.
            deadline_s: Time for one call of `plan`, which then returns the best so far. The first
                iteration is always finished.
            seed: The same seed gives the same plans.
        """
        if getattr(problem, "grasp_search", None) is not None:
            raise ValueError(NO_PLACES)
        if knots < 2 or samples < 1 or iterations < 1:
            raise ValueError("a planner needs two knots, one sample and one iteration, or more")
        if not 0.0 <= correlation < 1.0:
            raise ValueError("the correlation must be 0 or more, and less than 1")
        self.problem: Problem = problem
        self.knots: int = knots
        self.samples: int = samples
        self.iterations: int = iterations
        self.sigma: Array = deviations(sigma, knots, problem.dims)
        self.correlation: float = correlation
        self.bounds: Bounds = bounds.within(problem.bounds) if isinstance(problem, Task) else bounds
        self.deadline_s: float | None = deadline_s
        self.finest: float = self._finest if finest is None else finest
        if not 0.0 < self.finest <= 1.0:
            raise ValueError("finest must be above 0, and 1 or less")
        self._random = np.random.default_rng(seed)
        #: Frames that were executed since the start, or since `reset`.
        self._frame = 0.0
        #: The plan that the next call begins with.
        self.nominal: Array = np.zeros((knots, problem.dims))

    def plan(
        self,
        initial: InitialState | None = None,
        *,
        nominal: npt.ArrayLike | None = None,
        iterations: int | None = None,
        deadline_s: float | None = None,
    ) -> Plan:
        """Lowers the cost of the nominal plan from a state; None is the task's own.

        The nominal plan is that of the call before, shifted, unless one is given: knots [K, D].
        Outside of the bounds it is moved inside first.

        Raises:
            EveryPlanDiverged: If no plan of the first iteration could be simulated.
            BendTwinError: If the server refuses; see docs/use/errors.md.
        """
        began = time.monotonic()
        search = _Search(
            self, initial, began, self.deadline_s if deadline_s is None else deadline_s
        )
        start = self._checked(self.nominal if nominal is None else nominal)
        self._begin(start)
        iterations = self.iterations if iterations is None else iterations
        for i in range(iterations):
            candidates = self._bounded(self._propose(i))
            if i == 0:
                candidates = np.concatenate([start[None], candidates])
            evaluation = search.simulate(candidates)
            if evaluation is None:
                break
            search.finished += 1
            self._learn(candidates, *search.worth(evaluation))
        mean = self._mean()
        if mean is not None and search.finished == iterations:
            search.simulate(self._bounded(mean[None]), is_mean=True)
        plan = search.ended(iterations)
        self.nominal = plan.knots
        return plan

    def shift(self, frames: float) -> None:
        """Moves the nominal plan on by frames that were executed, at its end it stands still, and
        the problem with it."""
        problem = self.problem
        self.nominal = shifted(self.nominal, frames, problem.frames, problem.interpolation)
        self._frame += frames

    def reset(self, nominal: npt.ArrayLike | None = None) -> None:
        """Forgets the plan before: the next one begins with these knots, or with staying still at
        the start of the action space."""
        shape = (self.knots, self.problem.dims)
        self.nominal = np.zeros(shape) if nominal is None else self._checked(nominal)
        self._frame = 0.0

    # Methods

    @abstractmethod
    def _begin(self, nominal: Array) -> None:
        """Starts anew from a nominal plan [K, D]."""

    @abstractmethod
    def _propose(self, iteration: int) -> Array:
        """Plans to simulate [S, K, D]; the nominal one is added in iteration 0."""

    @abstractmethod
    def _learn(
        self, candidates: Array, evaluation: Evaluation, best: Array, best_cost: float
    ) -> None:
        """Takes in what an iteration found; `best` is the best of all iterations. Costs are +inf
        beyond the limit of the strain or, while no plan keeps it, how far plans are beyond it; the
        excess of what diverged is +inf."""

    def _mean(self) -> Array | None:
        """A plan that the method arrived at and that was not simulated yet."""
        return None

    def _noise(self, count: int) -> Array:
        """Standard normal noise [count, K, D], correlated in time."""
        shape = (self.knots, self.problem.dims)
        return correlated(self._random, count, *shape, self.correlation)

    def _bounded(self, knots: Array) -> Array:
        spacing = self.problem.frames / (self.knots - 1)
        return self.bounds.project(knots, spacing * self.problem.frame_s)

    def _checked(self, nominal: npt.ArrayLike) -> Array:
        array = np.array(nominal, dtype=np.float64)
        shape = (self.knots, self.problem.dims)
        if array.shape != shape or not np.isfinite(array).all():
            raise ValueError(f"nominal has shape {array.shape}: give finite knots {list(shape)}")
        return self._bounded(array)


class _Search:
    """Record of one call of `plan`."""

    def __init__(
        self,
        planner: Planner,
        initial: InitialState | None,
        began: float,
        deadline_s: float | None,
    ) -> None:
        self._problem = planner.problem.at(planner._frame)
        self._initial, self._began = initial, began
        self._gradients = planner._gradients
        self._deadline_s = deadline_s
        self._longest_s = 0.0
        self.finished = 0
        self.costs: list[npt.NDArray[np.float64]] = []
        self.best: Array = np.zeros((0, 0))
        self.best_cost = np.inf
        #: How far the best is beyond the limits; +inf if it diverged.
        self._best_excess = np.inf
        self._overstrained = 0
        self._origin: Origin = "nominal"
        self._nominal_cost = np.inf
        #: The best sample, how far it is beyond the limits, and its cost.
        self._sample: tuple[Array, tuple[float, float]] | None = None

    def simulate(self, knots: Array, *, is_mean: bool = False) -> Evaluation | None:
        """Simulates plans [B, K, D] and keeps the best; None if there is no time for it."""
        left = None
        if self.costs and self._deadline_s is not None:
            left = self._deadline_s - (time.monotonic() - self._began)
            if left <= (0.0 if is_mean else self._longest_s):
                return None
        started = time.monotonic()
        try:
            evaluation = self._problem.evaluate(
                knots, self._initial, gradients=self._gradients, timeout_s=left
            )
        except BendTwinError as error:
            if left is not None and error.category is Category.DEADLINE_EXCEEDED:
                return None
            raise
        self._longest_s = max(self._longest_s, time.monotonic() - started)
        self._note(knots, evaluation, is_mean)
        return evaluation

    def worth(self, evaluation: Evaluation) -> tuple[Evaluation, Array, float]:
        """An evaluation as methods learn from it, the best plan, and its cost in the same terms."""
        excess = _excess(evaluation)
        if self._best_excess > 0.0:
            return replace(evaluation, costs=excess, excess=excess), self.best, self._best_excess
        costs = np.where(excess > 0.0, np.inf, evaluation.costs)
        return replace(evaluation, costs=costs, excess=excess), self.best, self.best_cost

    def _note(self, knots: Array, evaluation: Evaluation, is_mean: bool) -> None:
        is_first = not self.costs
        costs, excess = evaluation.costs, _excess(evaluation)
        self.costs.append(costs)
        self._overstrained += int(((excess > 0.0) & np.isfinite(excess)).sum())
        if is_first:
            self._nominal_cost = float(costs[0])
            self._take(knots[0], costs[0], excess[0])
        # What keeps the limits comes first, then what is least beyond them, then what costs least.
        order = np.lexsort((costs, excess))
        samples = [] if is_mean else [i for i in order if i or not is_first]
        if samples:
            i = samples[0]
            rank = (float(excess[i]), float(costs[i]))
            if self._sample is None or rank < self._sample[1]:
                self._sample = (knots[i], rank)
        i = order[0]
        if (excess[i], costs[i]) < (self._best_excess, self.best_cost):
            self._take(knots[i], costs[i], excess[i])
            self._origin = "mean" if is_mean else "sample"
        if not np.isfinite(self._best_excess):
            raise EveryPlanDiverged

    def _take(self, knots: Array, cost: float, excess: float) -> None:
        self.best, self.best_cost, self._best_excess = knots, float(cost), float(excess)

    def ended(self, iterations: int) -> Plan:
        nothing = (self.best, (self._best_excess, self.best_cost))
        sample, (_, sample_cost) = self._sample or nothing
        return Plan(
            knots=self.best,
            cost=self.best_cost,
            origin=self._origin,
            nominal_cost=self._nominal_cost,
            best_sample=sample,
            best_sample_cost=sample_cost,
            costs=self.costs,
            iterations=self.finished,
            time_s=time.monotonic() - self._began,
            stopped="iterations" if self.finished == iterations else "deadline",
            problem=self._problem,
            excess=self._best_excess,
            overstrained=self._overstrained,
        )


def _excess(evaluation: Evaluation) -> npt.NDArray[np.float64]:
    """Excess of each plan [B] over the limits; +inf for one that diverged."""
    beyond = 0.0 if evaluation.excess is None else evaluation.excess
    return np.where(np.isfinite(evaluation.costs), beyond, np.inf)
