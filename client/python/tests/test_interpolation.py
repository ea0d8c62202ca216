import numpy as np
import pytest

from bendtwin import interpolate, interpolate_poses

KNOTS = np.array([0.3, -1.0, 2.0, 0.5, 0.7]).reshape(1, 5, 1, 1)


def of(**options):
    return interpolate(KNOTS, 40, **options)[0, :, 0, 0]


def catmull_rom(a, b, c, d, t):
    q, r = a - 2.5 * b + 2.0 * c - 0.5 * d, 0.5 * (d - a) + 1.5 * (b - c)
    return b + t * (0.5 * (c - a) + t * (q + t * r))


def test_cubic_is_catmull_rom_for_even_knots():
    p = KNOTS.ravel()
    p = np.concatenate([[2 * p[0] - p[1]], p, [2 * p[-1] - p[-2]]])
    expected = [catmull_rom(*p[f // 10 : f // 10 + 4], f % 10 / 10) for f in range(40)]
    np.testing.assert_allclose(of(interpolation="cubic")[:40], expected, atol=1e-6)
    timed = of(interpolation="cubic", fps=10.0, at_s=[0, 1, 2, 3, 4])
    np.testing.assert_allclose(timed, of(interpolation="cubic"), atol=1e-6)


def test_knots_hold_and_the_last_to_the_end():
    held = of(interpolation="zero", fps=30.0, period_s=0.1)
    # Three frames, though 3 x 0.1 is not 0.3.
    np.testing.assert_array_equal(held[:7], np.float32([0.3] * 3 + [-1.0] * 3 + [2.0]))
    assert (held[12:] == np.float32(0.7)).all()


def test_linear_is_numpys():
    at = np.float32([0.0, 0.13, 0.5, 0.7, 1.1])
    found = of(fps=30.0, at_s=at)
    expected = np.interp(np.arange(41) / 30.0, at, KNOTS.ravel())
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_rotations_go_the_shorter_way():
    half = np.sqrt(0.5)
    poses = np.array([[0, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, -half, -half]]).reshape(1, 2, 1, 7)
    middle = interpolate_poses(poses, 2)[0, 1, 0]
    angle = np.pi / 8
    expected = [0.5, 0, 0, 0, 0, np.sin(angle), np.cos(angle)]
    np.testing.assert_allclose(middle, expected, atol=1e-6)


def test_wrong_times_are_refused():
    with pytest.raises(ValueError, match="fps"):
        of(at_s=[0, 1, 2, 3, 4])
    with pytest.raises(ValueError, match="either"):
        of(fps=30.0, at_s=[0, 1, 2, 3, 4], period_s=0.1)
    with pytest.raises(ValueError, match="knots"):
        of(fps=30.0, at_s=[0, 1])
