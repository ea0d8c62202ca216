"""Clouds: positions out of `PointCloud2` of any layout, and clouds out of positions."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin_ros.messages.basic import Header, PointCloud2, PointField
from bendtwin_ros.poses import Array

#: Types of numpy by the numbers of PointField: 8, 16 and 32 bits, with and without sign, and
#: floats of 32 and 64 bits.
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
_FLOAT32 = 7
#: Farther points are no object of a twin; and the cells of a grid of this size can be numbered.
_FARTHEST_M = 100.0
#: Smallest cells of such a grid.
LEAST_CELL_M = 0.0005
#: More points than any depth camera has.
_MOST_POINTS = 20_000_000


class CloudFault(ValueError):
    """A cloud whose layout contradicts itself or has no positions."""


def positions(cloud: PointCloud2) -> npt.NDArray[Any]:
    """The points of a cloud that are finite and within 100 m [M, 3], in its frame.

    Raises:
        CloudFault: If the layout is wrong; the message names what.
    """
    count = cloud.width * cloud.height
    if count == 0:
        return np.zeros((0, 3), np.float32)
    if not 0 < count <= _MOST_POINTS or cloud.width < 0:
        raise CloudFault(f"a cloud of {cloud.width} x {cloud.height} points")
    if cloud.point_step > len(cloud.data):
        raise CloudFault(f"point_step is {cloud.point_step}, and data has {len(cloud.data)} bytes")
    kind = np.dtype(
        {
            "names": ["x", "y", "z"],
            "formats": [_format(cloud, axis) for axis in "xyz"],
            "offsets": [_field(cloud, axis).offset for axis in "xyz"],
            "itemsize": _checked_step(cloud),
        }
    )
    # A cloud of one row may leave row_step at 0.
    row_step = cloud.row_step if cloud.height > 1 else cloud.width * cloud.point_step
    if row_step < cloud.width * cloud.point_step:
        raise CloudFault(f"row_step is {row_step}, but a row has {cloud.width} points")
    least = row_step * (cloud.height - 1) + cloud.width * cloud.point_step
    if len(cloud.data) < least:
        raise CloudFault(f"data has {len(cloud.data)} bytes of {least}")
    strides = (row_step, cloud.point_step)
    shape = (cloud.height, cloud.width)
    rows: Any = np.ndarray(shape, kind, buffer=cloud.data, strides=strides)
    points = np.stack([rows[axis].ravel() for axis in "xyz"], axis=1)
    with np.errstate(invalid="ignore"):
        near = (np.abs(points) <= _FARTHEST_M).all(axis=1)
    return np.asarray(points[near])


def _field(cloud: PointCloud2, name: str) -> PointField:
    found = [field for field in cloud.fields if field.name == name]
    if len(found) != 1:
        raise CloudFault(f"the cloud has {len(found)} fields `{name}`: it needs x, y and z")
    return found[0]


def _format(cloud: PointCloud2, axis: str) -> str:
    field = _field(cloud, axis)
    if field.datatype not in _TYPES or not _TYPES[field.datatype].startswith("f"):
        raise CloudFault(f"field `{axis}` has datatype {field.datatype}: FLOAT32 (7) is needed")
    return (">" if cloud.is_bigendian else "<") + _TYPES[field.datatype]


def _checked_step(cloud: PointCloud2) -> int:
    for axis in "xyz":
        field = _field(cloud, axis)
        end = field.offset + int(_TYPES[field.datatype][1])
        if field.offset < 0 or end > cloud.point_step:
            raise CloudFault(f"field `{axis}` ends at byte {end} of {cloud.point_step} of a point")
    return cloud.point_step


def cloud_of(points: npt.NDArray[Any], header: Header) -> PointCloud2:
    """A cloud of positions [M, 3]."""
    data = np.ascontiguousarray(points, dtype="<f4")
    step = 12
    return PointCloud2(
        header=header,
        height=1,
        width=len(data),
        fields=[PointField(axis, 4 * i, _FLOAT32, 1) for i, axis in enumerate("xyz")],
        point_step=step,
        row_step=step * len(data),
        data=data.tobytes(),
        is_dense=True,
    )


def thinned(points: Array, cell_m: float, most: int) -> Array:
    """The mean of the points of each cell of a grid, and of these at most `most`, evenly chosen.

    Cameras see near surfaces many times as densely as far ones; one point a cell counts all parts
    of the object alike.
    """
    if cell_m > 0.0 and len(points):
        cell_m = max(cell_m, LEAST_CELL_M)
        cells = np.floor((points - points.min(axis=0)) / cell_m).astype(np.int64)
        _, y, z = cells.max(axis=0) + 1
        # Cells by number: sorting rows of three takes several times as long.
        keys = cells @ np.array([y * z, z, 1])
        _, inverse, counts = np.unique(keys, return_inverse=True, return_counts=True)
        sums = np.stack([np.bincount(inverse, points[:, axis]) for axis in range(3)], axis=1)
        points = sums / counts[:, None]
    if len(points) > most:
        points = points[np.linspace(0, len(points) - 1, most).astype(np.int64)]
    return points
