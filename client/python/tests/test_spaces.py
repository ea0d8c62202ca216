"""Curves between knots, action spaces, and gradients through both."""

import numpy as np
import pytest

from bendtwin import interpolate
from bendtwin.planners import Grippers, PerHand, Points, Together
from bendtwin.planners.knots import curve_matrix, shifted
from bendtwin.rotations import exponential, product

CONTROLS = np.array([[0.0, 0.0, 0.1], [0.2, 0.0, 0.1], [0.3, 0.1, 0.1]])
SPACES = [
    Together(CONTROLS),
    PerHand(CONTROLS, [0, 1, 1]),
    Points(CONTROLS),
    Grippers.around(CONTROLS, [0, 1, 1]),
    Grippers(start=[[0.1, 0.0, 0.2, 0.0, 0.6, 0.0, 0.8]]),
]


@pytest.mark.parametrize("count", [2, 3, 5])
@pytest.mark.parametrize("interpolation", ["linear", "cubic", "zero"])
def test_curves_are_those_of_the_server(count, interpolation):
    knots = np.random.default_rng(0).normal(size=(count, 1)).astype(np.float32)
    times = np.arange(13) * (count - 1) / 12
    by_frame = interpolate(knots[None], 12, interpolation=interpolation)[0]
    curve = curve_matrix(times, count, interpolation) @ knots
    np.testing.assert_allclose(curve, by_frame, atol=1e-6)


@pytest.mark.parametrize("interpolation", ["linear", "cubic", "zero"])
def test_a_shift_by_whole_knots_drops_them(interpolation):
    knots = np.random.default_rng(1).normal(size=(5, 2))
    moved = shifted(knots, 6, 12, interpolation)
    np.testing.assert_allclose(moved, knots[[2, 3, 4, 4, 4]], atol=1e-12)
    np.testing.assert_allclose(shifted(knots, 100, 12, interpolation), np.tile(knots[4], (5, 1)))


@pytest.mark.parametrize("space", SPACES, ids=lambda s: f"{type(s).__name__} {s.dims}")
def test_zeros_stay_at_the_start(space):
    actions = space.actions(np.zeros((2, 3, space.dims)))
    if isinstance(space, Grippers):
        start = np.broadcast_to(space.start, actions["poses"].shape)
        np.testing.assert_allclose(actions["poses"], start, atol=1e-7)
    else:
        still = np.broadcast_to(CONTROLS, (2, 3, 3, 3))
        np.testing.assert_allclose(actions["trajectories"], still, atol=1e-7)


@pytest.mark.parametrize("space", SPACES, ids=lambda s: f"{type(s).__name__} {s.dims}")
def test_gradients_by_knots_agree_with_finite_differences(space):
    random = np.random.default_rng(2)
    knots = random.normal(0.0, 0.3, (1, 3, space.dims))

    def arrays(knots):
        return next(v for k, v in space.actions(knots).items() if k != "gripper_of_control")

    # float32 actions: steps must not be small.
    weights = random.normal(size=arrays(knots).shape)
    gradient = space.gradients(knots, weights)
    step = 1e-3
    for k in range(3):
        for d in range(space.dims):
            unit = np.zeros_like(knots)
            unit[0, k, d] = step
            there, back = arrays(knots + unit), arrays(knots - unit)
            slope = ((there.astype(float) - back) * weights).sum() / (2 * step)
            assert gradient[0, k, d] == pytest.approx(slope, rel=2e-3, abs=2e-3)


def test_hands_move_apart():
    knots = np.array([[[1.0, 0, 0, 0, 0, 2.0]]])
    moved = PerHand(CONTROLS, [0, 1, 1]).actions(knots)["trajectories"][0, 0]
    np.testing.assert_allclose(moved - CONTROLS, [[1, 0, 0], [0, 0, 2], [0, 0, 2]], atol=1e-6)


def test_a_gripper_turns_about_the_middle_of_what_it_holds():
    space = Grippers.around(CONTROLS[:2])
    pose = space.actions(np.array([[[0, 0, 0.5, 0, 0, np.pi / 2]]]))["poses"][0, 0, 0]
    np.testing.assert_allclose(pose, [0.1, 0, 0.6, 0, 0, 0.5**0.5, 0.5**0.5], atol=1e-6)


def test_rotations_are_unit_and_add_up():
    vectors = np.random.default_rng(3).normal(0.0, 1.0, (50, 3))
    vectors[0] = 0.0
    vectors[1] = 1e-9
    np.testing.assert_allclose(np.linalg.norm(exponential(vectors), axis=-1), 1.0, atol=1e-12)
    turn = exponential(np.array([0.0, 0.0, 0.3]))
    twice = exponential(np.array([0.0, 0.0, 0.6]))
    np.testing.assert_allclose(product(turn, turn), twice, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "fault"),
    [
        (lambda: Together([0.0, 0.0, 0.0]), "control points"),
        (lambda: Together([[0.0, 0.0, np.nan]]), "finite"),
        (lambda: PerHand(CONTROLS, [0, 1]), "hand_of_control"),
        (lambda: Grippers(start=[[0.0] * 7]), "quaternion of zeros"),
        (lambda: Grippers(start=[[0.0] * 6]), "poses"),
    ],
)
def test_wrong_starts_are_refused(make, fault):
    with pytest.raises(ValueError, match=fault):
        make()
