"""Planners on costs that are known in closed form."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from bendtwin import BendTwinError, Category
from bendtwin.planners import (
    Bounds,
    Cem,
    Evaluation,
    EveryPlanDiverged,
    GradientDescent,
    Mppi,
    PredictiveSampling,
)
from bendtwin.planners.methods import path_integral_weights
from bendtwin.planners.noise import correlated

GOAL = np.array([0.3, -0.2])


@dataclass
class Bowl:
    """Squared distance of all knots but the first from a goal; infinite beyond `wall` in x, and not
    to be beyond `limit` there."""

    frames: int = 12
    interpolation: str = "linear"
    dims: int = 2
    frame_s: float = 0.1
    wall: float = np.inf
    limit: float = np.inf
    batches: list = field(default_factory=list)
    takes_s: float = 0.0
    frame: float = 0.0

    def at(self, frame):
        self.frame = frame
        return self

    def evaluate(self, knots, initial, *, gradients=False, timeout_s=None):
        self.batches.append(knots)
        apart = knots[:, 1:] - GOAL
        costs = (apart**2).sum(axis=(1, 2))
        costs = np.where((knots[:, :, 0] > self.wall).any(axis=1), np.inf, costs)
        slopes = np.concatenate([np.zeros_like(knots[:, :1]), 2.0 * apart], axis=1)
        return Evaluation(costs, slopes if gradients else None, self.excess(knots))

    def excess(self, knots):
        return np.maximum(knots[:, :, 0] - self.limit, 0.0).max(axis=1)


METHODS = [
    pytest.param(lambda p, **s: Mppi(p, **s), id="mppi"),
    pytest.param(lambda p, **s: Cem(p, **s), id="cem"),
    pytest.param(lambda p, **s: PredictiveSampling(p, **s), id="predictive sampling"),
    pytest.param(lambda p, **s: GradientDescent(p, rate=0.05, **s), id="gradient"),
]


@pytest.mark.parametrize("method", METHODS)
def test_every_method_walks_downhill_and_keeps_row_0(method):
    bowl = Bowl()
    plan = method(bowl, knots=4, samples=64, iterations=40, sigma=0.1).plan()
    assert plan.nominal_cost == pytest.approx(3 * (GOAL**2).sum())
    assert plan.cost < 0.05 * plan.nominal_cost
    assert plan.iterations == 40
    assert plan.stopped == "iterations"
    np.testing.assert_array_equal(plan.knots[0], 0.0)
    assert all(len(batch) <= 64 for batch in bowl.batches)


@pytest.mark.parametrize("method", METHODS)
def test_the_cost_is_that_of_the_very_knots(method):
    bowl = Bowl()
    plan = method(bowl, knots=4, samples=8, iterations=3, sigma=0.2).plan()
    assert bowl.evaluate(plan.knots[None], None).costs[0] == plan.cost
    assert plan.cost == min(costs.min() for costs in plan.costs)
    assert bowl.evaluate(plan.best_sample[None], None).costs[0] == plan.best_sample_cost


@pytest.mark.parametrize("method", METHODS)
def test_a_plan_is_never_worse_than_the_nominal_one(method):
    best = np.tile(GOAL, (4, 1))
    for seed in range(10):
        plan = method(Bowl(), knots=4, samples=4, sigma=0.5, iterations=2, seed=seed).plan(
            nominal=best
        )
        assert plan.cost <= plan.nominal_cost == 0.0
        assert plan.origin == "nominal"


@pytest.mark.parametrize("method", METHODS)
def test_what_is_beyond_the_limit_is_worse_than_all_that_keeps_it(method):
    """The goal is at 0.3 in x: without the limit every method ends there."""
    bowl = Bowl(limit=0.2)
    plan = method(bowl, knots=4, samples=64, iterations=40, sigma=0.1).plan()
    assert (plan.excess, bowl.excess(plan.knots[None])[0]) == (0.0, 0.0)
    assert plan.cost < 0.2 * plan.nominal_cost
    assert plan.overstrained > 0
    assert min(costs.min() for costs in plan.costs) < plan.cost, "none was beyond"


@pytest.mark.parametrize("method", METHODS)
def test_a_search_that_begins_beyond_the_limit_comes_back(method):
    beyond = np.array([[0.0, 0.0], [0.6, -0.2], [0.7, -0.2], [0.6, -0.2]])
    planner = method(Bowl(limit=0.2), knots=4, samples=8, iterations=40, sigma=0.1)
    plan = planner.plan(nominal=beyond)
    assert plan.excess == 0.0
    assert plan.cost < 0.25 < plan.nominal_cost
    nowhere = Bowl(limit=-1.0)
    plan = method(nowhere, knots=4, samples=8, iterations=3, sigma=0.1).plan(nominal=beyond)
    least = min(nowhere.excess(batch).min() for batch in nowhere.batches)
    assert plan.excess == least
    assert plan.overstrained == sum(len(batch) for batch in nowhere.batches)


def test_a_mean_that_is_worse_than_its_samples_is_not_taken():
    class Ring(Bowl):
        """Good on a circle, bad in the middle: where the mean of good samples lies."""

        def evaluate(self, knots, initial, *, gradients=False, timeout_s=None):
            radius = np.linalg.norm(knots[:, 1:], axis=-1)
            return Evaluation(((radius - 0.3) ** 2).sum(axis=1))

    for seed in range(5):
        planner = Mppi(Ring(), knots=2, samples=256, sigma=0.3, temperature=10.0, seed=seed)
        plan = planner.plan()
        assert plan.costs[-1].shape == (1,), "the mean was simulated"
        assert plan.cost == plan.best_sample_cost < plan.costs[-1][0]
        assert plan.origin == "sample"


@pytest.mark.parametrize("method", METHODS[:3])
def test_to_stay_still_competes_with_a_plan_that_leads_astray(method):
    astray = np.linspace(GOAL, GOAL + 1.0, 4)
    plan = method(Bowl(), knots=4, samples=8, sigma=1e-6).plan(nominal=astray)
    np.testing.assert_array_equal(plan.knots, np.tile(GOAL, (4, 1)))
    assert plan.cost == 0.0 < plan.nominal_cost


def test_samples_are_coarse_and_fine():
    bowl = Bowl()
    Mppi(bowl, knots=64, samples=34, sigma=0.5, finest=0.01).plan()
    nominal, still, *samples = bowl.batches[0]
    assert not nominal.any()
    assert not still.any()
    spreads = np.std(np.array(samples)[:, 1:], axis=(1, 2))
    np.testing.assert_allclose(spreads, 0.5 * np.geomspace(1.0, 0.01, 32), rtol=0.3)


@pytest.mark.parametrize("method", METHODS)
def test_all_that_is_simulated_keeps_the_bounds(method):
    bowl = Bowl()
    bounds = Bounds(low=[-0.1, -0.15], high=0.25, speed=[0.2, 10.0])
    plan = method(
        bowl, knots=4, samples=16, iterations=30, sigma=0.3, bounds=bounds, correlation=0.5
    ).plan()
    knots = np.concatenate(bowl.batches)
    assert (knots >= [-0.1, -0.15]).all()
    assert knots.max() <= 0.25
    # Knots are 4 frames of 0.1 s apart.
    assert np.abs(np.diff(knots[..., 0], axis=1)).max() <= 0.2 * 0.4 + 1e-12
    np.testing.assert_allclose(plan.knots[1:, 0], [0.08, 0.16, 0.24], atol=0.02)


@pytest.mark.parametrize("method", METHODS)
def test_the_same_seed_gives_the_same_plans(method):
    def plans(seed):
        planner = method(Bowl(), samples=8, iterations=2, sigma=0.1, seed=seed)
        return np.concatenate([planner.plan().knots, planner.plan().knots])

    np.testing.assert_array_equal(plans(3), plans(3))
    assert (plans(3) != plans(4)).any()


def test_the_next_plan_begins_with_the_shifted_one():
    planner = PredictiveSampling(Bowl(frames=12), knots=4, samples=32, sigma=0.2)
    first = planner.plan()
    planner.shift(frames=6)
    half = 0.5 * (first.knots[1:-1] + first.knots[2:])
    expected = [half[0], half[1], first.knots[3], first.knots[3]]
    np.testing.assert_allclose(planner.nominal, expected, atol=1e-12)
    again = planner.plan()
    np.testing.assert_allclose(again.knots[0], half[0], atol=1e-12)
    planner.shift(frames=3)
    planner.plan()
    assert planner.problem.frame == 9, "surroundings move on with the plan"
    planner.reset()
    np.testing.assert_array_equal(planner.nominal, 0.0)
    planner.plan()
    assert planner.problem.frame == 0


def test_sigma_is_by_coordinate_and_by_knot():
    bowl = Bowl()
    sigma = np.array([[0.0, 0.0], [0.1, 0.0], [0.2, 0.01], [0.3, 0.0]])
    Mppi(bowl, knots=4, samples=4000, sigma=sigma, finest=1.0).plan()
    samples = bowl.batches[0][1:]
    np.testing.assert_allclose(samples.std(axis=0), sigma, rtol=0.1)
    with pytest.raises(ValueError, match="sigma has shape"):
        Mppi(bowl, knots=4, sigma=[0.1, 0.1, 0.1])


def test_neighbouring_knots_have_the_correlation_that_is_asked_for():
    noise = correlated(np.random.default_rng(0), 20_000, 4, 1, 0.8)[..., 0]
    np.testing.assert_allclose(noise[:, 1:].std(axis=0), 1.0, atol=0.03)
    found = np.corrcoef(noise[:, 1:].T)
    np.testing.assert_allclose(found[0], [1.0, 0.8, 0.64], atol=0.03)


class Slow(Bowl):
    """Takes time by a clock of its own, and refuses a call that cannot be done in its time."""

    now: float = 0.0

    def evaluate(self, knots, initial, *, gradients=False, timeout_s=None):
        if timeout_s is not None and timeout_s < self.takes_s:
            self.now += timeout_s
            raise BendTwinError(Category.DEADLINE_EXCEEDED, "DEADLINE_EXCEEDED", "too late")
        self.now += self.takes_s
        return super().evaluate(knots, initial, gradients=gradients)


@pytest.mark.parametrize("method", METHODS)
def test_at_the_deadline_there_is_the_best_so_far(method, monkeypatch):
    slow = Slow(takes_s=1.0)
    monkeypatch.setattr("bendtwin.planners.planner.time.monotonic", lambda: slow.now)
    planner = method(slow, samples=16, iterations=100, sigma=0.1)
    plan = planner.plan(deadline_s=4.5)
    assert plan.stopped == "deadline"
    assert plan.iterations == 4
    assert plan.cost < plan.nominal_cost
    assert slow.now <= 4.5
    # The first iteration is always finished.
    assert planner.plan(deadline_s=0.1).iterations == 1


def test_a_call_that_is_late_ends_the_plan(monkeypatch):
    slow = Slow(takes_s=1.0)
    monkeypatch.setattr("bendtwin.planners.planner.time.monotonic", lambda: slow.now)
    planner = Mppi(slow, samples=16, iterations=100, sigma=0.1, deadline_s=2.5)

    def slower(*_):
        slow.takes_s = 2.0
        return original(*_)

    original, planner._learn = planner._learn, slower
    plan = planner.plan()
    assert (plan.iterations, plan.stopped) == (1, "deadline")
    assert np.isfinite(plan.cost)


@pytest.mark.parametrize("method", METHODS)
def test_diverged_plans_count_for_nothing(method):
    bowl = Bowl(wall=0.2)
    plan = method(bowl, knots=3, samples=32, iterations=20, sigma=0.15).plan()
    assert np.isfinite(plan.cost)
    assert plan.knots[:, 0].max() <= 0.2
    assert plan.diverged > 0


def test_where_everything_diverges_it_is_said():
    with pytest.raises(EveryPlanDiverged, match="start of the action space"):
        Mppi(Bowl(wall=-1.0)).plan()
    with pytest.raises(ValueError, match="diverged"):
        path_integral_weights(np.array([np.inf]), 0.1)


def test_diverged_instances_weigh_nothing():
    weights = path_integral_weights(np.array([1.0, np.inf, 1.0]), 0.1)
    np.testing.assert_allclose(weights, [0.5, 0.0, 0.5])


@pytest.mark.parametrize(
    ("settings", "fault"),
    [
        ({"knots": 1}, "two knots"),
        ({"correlation": 1.0}, "correlation"),
        ({"sigma": -1.0}, "sigma"),
        ({"temperature": 0.0}, "temperature"),
        ({"bounds": Bounds(low=1.0, high=0.0)}, "above high"),
        ({"bounds": Bounds(speed=[1, 2, 3])}, "speed has shape"),
    ],
)
def test_wrong_settings_are_refused(settings, fault):
    with pytest.raises(ValueError, match=fault):
        Mppi(Bowl(), **settings).plan()
    with pytest.raises(ValueError, match="nominal has shape"):
        Mppi(Bowl()).plan(nominal=np.zeros((2, 2)))
