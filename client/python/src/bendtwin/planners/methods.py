"""Four ways to propose plans and to learn from their costs."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from bendtwin.planners.knots import Array
from bendtwin.planners.noise import sample_scales
from bendtwin.planners.planner import Planner
from bendtwin.planners.task import Evaluation, Problem


class _Sampling(Planner):
    """Samples around a mean, which is simulated as well, and at first the plan to stay still."""

    _center: Array

    def _begin(self, nominal: Array) -> None:
        self._center = nominal
        self._spread = self.sigma
        self._is_new = False

    def _propose(self, iteration: int) -> Array:
        # In iteration 0 the mean is the nominal plan, which is added to what is proposed, and a
        # nominal plan that leads astray competes with one that ends the motion.
        count = max(self.samples - (2 if iteration == 0 else 1), 1)
        scales = sample_scales(count, self.finest)[:, None, None]
        samples = self._center + scales * self._spread * self._noise(count)
        if iteration == 0:
            still = np.broadcast_to(self._center[:1], self._center.shape)
            return np.concatenate([still[None], samples])
        if not self._is_new:
            return np.asarray(samples)
        self._is_new = False
        return np.concatenate([self._center[None], samples])

    def _mean(self) -> Array | None:
        return self._center if self._is_new else None

    def _move(self, center: Array) -> None:
        self._center, self._is_new = center, True


class Mppi(_Sampling):
    """Model-predictive path integral control: the mean of all samples, weighted by their costs."""

    _finest: ClassVar[float] = 0.03

    def __init__(self, problem: Problem, *, temperature: float = 0.1, **settings: Any) -> None:
        """Takes the settings of `Planner`.

        Args:
            problem: Task to minimize.
            temperature: As a share of the costs' spread: small ones follow the best sample, large
                ones average.
            settings: Those of `Planner`.
        """
        super().__init__(problem, **settings)
        if not temperature > 0:
            raise ValueError("the temperature must be above 0")
        self.temperature = temperature

    def _learn(
        self, candidates: Array, evaluation: Evaluation, best: Array, best_cost: float
    ) -> None:
        plans = np.concatenate([best[None], candidates])
        costs = np.concatenate([[best_cost], evaluation.costs])
        self._move(np.tensordot(path_integral_weights(costs, self.temperature), plans, axes=1))


class Cem(_Sampling):
    """Cross-entropy method: mean and spread of the best samples, iteration by iteration."""

    def __init__(
        self,
        problem: Problem,
        *,
        elites: int = 8,
        memory: float = 0.1,
        smallest: float = 0.05,
        **settings: Any,
    ) -> None:
        """Takes the settings of `Planner`; it needs several iterations to be worth it.

        Args:
            problem: Task to minimize.
            elites: Number of best samples that the next iteration is made from.
            memory: Share of the old mean and spread in the new ones.
            smallest: Spread below which it does not shrink, as a share of sigma.
            settings: Those of `Planner`.
        """
        super().__init__(problem, **settings)
        if elites < 1 or not 0.0 <= memory < 1.0 or smallest < 0.0:
            raise ValueError("give one elite or more, and a memory of 0 or more and less than 1")
        self.elites: int = elites
        self.memory: float = memory
        self.smallest: float = smallest

    def _learn(
        self, candidates: Array, evaluation: Evaluation, best: Array, best_cost: float
    ) -> None:
        plans = np.concatenate([best[None], candidates])
        costs = np.concatenate([[best_cost], evaluation.costs])
        order = np.argsort(costs, kind="stable")
        chosen = plans[order[: self.elites][np.isfinite(costs[order[: self.elites]])]]
        keep = self.memory
        self._move(keep * self._center + (1.0 - keep) * chosen.mean(axis=0))
        spread = keep * self._spread + (1.0 - keep) * chosen.std(axis=0)
        self._spread = np.maximum(spread, self.smallest * self.sigma)


class PredictiveSampling(_Sampling):
    """The best sample around the best plan so far: the simplest method, and a strong one."""

    _finest: ClassVar[float] = 0.03

    def _learn(
        self, candidates: Array, evaluation: Evaluation, best: Array, best_cost: float
    ) -> None:
        self._center = best


class GradientDescent(Planner):
    """Adam along the gradient of the cost, from the nominal plan and `samples - 1` others.

    Gradients through contacts with friction can point anywhere: what comes back is the best that
    was simulated, so a step that leads astray costs time and nothing else.
    """

    _gradients: ClassVar[bool] = True

    def __init__(
        self,
        problem: Problem,
        *,
        rate: npt.ArrayLike = 0.005,
        samples: int = 1,
        iterations: int = 20,
        **settings: Any,
    ) -> None:
        """Takes the settings of `Planner`.

        Args:
            problem: Task to minimize.
            rate: Largest step of an iteration, a number or by coordinate [D]: metres, radians.
            samples: Plans that are followed together; the others begin sigma away.
            iterations: Of one call of `plan`.
            settings: Those of `Planner`.
        """
        super().__init__(problem, samples=samples, iterations=iterations, **settings)
        self.rate: Array = np.broadcast_to(np.asarray(rate, dtype=np.float64), (problem.dims,))

    def _begin(self, nominal: Array) -> None:
        others = self.sigma * self._noise(self.samples - 1)
        self._plans = np.concatenate([nominal[None], self._bounded(nominal + others)])
        self._first = np.zeros_like(self._plans)
        self._second = np.zeros_like(self._plans)
        # What plans were when they kept the limit of the strain last, and whether they ever did.
        self._kept = self._plans.copy()
        self._has_kept = np.zeros(len(self._plans), dtype=bool)
        self._steps = 0

    def _propose(self, iteration: int) -> Array:
        return self._plans[1:] if iteration == 0 else self._plans

    def _learn(
        self, candidates: Array, evaluation: Evaluation, best: Array, best_cost: float
    ) -> None:
        if evaluation.gradients is None:
            raise ValueError("the problem has no gradients: choose another method")
        excess = np.zeros(len(candidates)) if evaluation.excess is None else evaluation.excess
        keeps, beyond = excess == 0.0, (excess > 0.0) & np.isfinite(excess)
        gradients = evaluation.gradients.copy()
        gradients[:, 0] = 0.0
        whole = np.isfinite(gradients).all(axis=(1, 2)) & keeps
        gradients[~whole] = 0.0
        # A plan that diverged continues from the best one.
        plans = np.where(whole[:, None, None], candidates, best)
        # One beyond the limit, where the gradient of the cost says nothing of how to keep it, goes
        # half the way back to where it kept it last, to the best one if that keeps it, or to
        # staying still, and begins anew there.
        self._kept[keeps], self._has_kept = candidates[keeps], self._has_kept | keeps
        still = np.repeat(candidates[:, :1], self.knots, axis=1)
        otherwise = best if self._has_kept.any() else still
        safe = np.where(self._has_kept[:, None, None], self._kept, otherwise)
        plans[beyond] = 0.5 * (candidates + safe)[beyond]
        self._first[beyond] = self._second[beyond] = 0.0
        self._steps += 1
        self._first = 0.9 * self._first + 0.1 * gradients
        self._second = 0.99 * self._second + 0.01 * gradients**2
        first = self._first / (1.0 - 0.9**self._steps)
        second = np.sqrt(self._second / (1.0 - 0.99**self._steps))
        scale = np.where(second > 0.0, second, 1.0)
        self._plans = self._bounded(plans - self.rate * first / scale)

    def _mean(self) -> Array | None:
        return None


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
