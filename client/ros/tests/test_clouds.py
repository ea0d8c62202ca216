"""Clouds of any layout."""

from __future__ import annotations

import numpy as np
import pytest

from bendtwin_ros.clouds import CloudFault, cloud_of, positions, thinned
from bendtwin_ros.messages.basic import Header, PointCloud2, PointField

POINTS = np.random.default_rng(0).uniform(-1, 1, (12, 3)).astype("f4")


def laid_out(order, kind, *, before=0, step=None, pad=0, rows=1, big=False):
    """The points, with fields in an order, `before` bytes in front of each point and `pad` bytes
    behind each row."""
    size = np.dtype(kind).itemsize
    step = step or before + 3 * size
    offsets = {axis: before + size * i for i, axis in enumerate(order)}
    names = ["x", "y", "z"]
    dtype = np.dtype(
        {
            "names": names,
            "formats": [(">" if big else "<") + kind] * 3,
            "offsets": [offsets[name] for name in names],
            "itemsize": step,
        }
    )
    table = np.zeros(len(POINTS), dtype)
    for i, name in enumerate(names):
        table[name] = POINTS[:, i]
    width = len(POINTS) // rows
    lines = [table[r * width : (r + 1) * width].tobytes() + b"\xff" * pad for r in range(rows)]
    fields = [PointField(name, offsets[name], {"f4": 7, "f8": 8}[kind], 1) for name in order]
    fields.insert(1, PointField("rgb", 0, 7, 1))
    return PointCloud2(
        Header(), rows, width, fields, big, step, width * step + pad, b"".join(lines)
    )


@pytest.mark.parametrize(
    "cloud",
    [
        laid_out("xyz", "f4"),
        laid_out("zxy", "f4", before=4, step=32),
        laid_out("xyz", "f8", before=1, step=27),
        laid_out("yzx", "f4", rows=3, pad=5, big=True),
        laid_out("xyz", "f8", rows=4, pad=16, big=True),
    ],
    ids=["plain", "other order", "unaligned doubles", "padded, big-endian", "rows of doubles"],
)
def test_every_layout_has_the_same_points(cloud):
    np.testing.assert_array_equal(positions(cloud), POINTS)


def test_points_that_are_no_numbers_or_far_away_are_left_out():
    cloud = laid_out("xyz", "f4")
    data = np.frombuffer(cloud.data, "<f4").reshape(-1, 3).copy()
    data[2, 1], data[5, 0], data[7, 2] = np.nan, -np.inf, 1e9
    cloud.data = data.tobytes()
    np.testing.assert_array_equal(positions(cloud), np.delete(POINTS, [2, 5, 7], axis=0))
    assert positions(PointCloud2()).shape == (0, 3)


def changed(**fields):
    cloud = laid_out("xyz", "f4", rows=2)
    for name, value in fields.items():
        setattr(cloud, name, value)
    return cloud


@pytest.mark.parametrize(
    ("cloud", "said"),
    [
        (changed(data=b"\0" * 20), "20 bytes of"),
        (changed(width=2**31, height=2**31), "points"),
        (changed(row_step=3), "row_step is 3"),
        (changed(point_step=8), "ends at byte 12 of 8"),
        (changed(fields=[PointField("x", 0, 7, 1)]), "0 fields `y`"),
        (changed(fields=[PointField(a, 0, 2, 1) for a in "xyz"]), "datatype 2"),
        (changed(fields=[PointField(a, 2**32 - 1, 7, 1) for a in "xyz"]), "ends at byte"),
        (changed(fields=[PointField(a, 0, 7, 1) for a in "xxyz"]), "2 fields `x`"),
    ],
)
def test_a_layout_that_contradicts_itself_is_named(cloud, said):
    with pytest.raises(CloudFault, match=said):
        positions(cloud)


def test_a_cloud_comes_back_as_it_was_written():
    np.testing.assert_array_equal(positions(cloud_of(POINTS, Header())), POINTS)
    assert len(positions(cloud_of(POINTS[:0], Header()))) == 0


def test_a_cell_has_one_point_its_mean():
    near = np.array([[0.0, 0, 0], [0.001, 0, 0], [0.5, 0.5, 0.5], [0.0, 0, 0.003]])
    thin = thinned(near, 0.01, 100)
    expected = {(0.0003, 0.0, 0.001), (0.5, 0.5, 0.5)}
    assert {tuple(point) for point in thin.round(4).tolist()} == expected
    assert len(thinned(POINTS.astype(float), 0.0005, 5)) == 5
    spread = np.random.default_rng(1).uniform(-100, 100, (500, 3))
    assert len(thinned(spread, 1e-9, 1000)) == 500
