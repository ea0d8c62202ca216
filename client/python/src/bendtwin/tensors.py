"""Tensors on the wire: little-endian, row-major bytes with a type and a shape.

Reading makes no copy: the array is a read-only view of the message's bytes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from bendtwin.v1 import tensor_pb2

_WIRE = tensor_pb2.Tensor
_NUMPY_OF_WIRE: dict[int, np.dtype[np.generic]] = {
    _WIRE.FLOAT32: np.dtype("<f4"),
    _WIRE.FLOAT64: np.dtype("<f8"),
    _WIRE.UINT32: np.dtype("<u4"),
    _WIRE.INT32: np.dtype("<i4"),
    _WIRE.UINT8: np.dtype("u1"),
    _WIRE.INT16_SCALED: np.dtype("<i2"),
}


def pack_floats(name: str, values: npt.ArrayLike, shape: Sequence[int | None]) -> tensor_pb2.Tensor:
    """Packs numbers as FLOAT32 after checking shape (None: any length) and finiteness."""
    array = np.asarray(values, dtype="<f4", order="C")
    _check_shape(name, array.shape, shape)
    if not np.isfinite(array).all():
        raise ValueError(f"{name} has values that are not finite: check the input for NaN")
    return _WIRE(dtype=_WIRE.FLOAT32, shape=array.shape, data=array.tobytes())


def pack_bytes(name: str, values: npt.ArrayLike) -> tensor_pb2.Tensor:
    """Packs whole numbers 0..255 as UINT8."""
    array = np.asarray(values)
    if array.dtype != np.uint8:
        if array.size and not np.issubdtype(array.dtype, np.integer):
            raise ValueError(f"{name} must be whole numbers 0..255, not {array.dtype}")
        if array.size and (array.min() < 0 or array.max() > 255):
            raise ValueError(f"{name} must lie in 0..255")
        array = array.astype(np.uint8)
    return _WIRE(dtype=_WIRE.UINT8, shape=array.shape, data=array.tobytes())


def pack_indices(name: str, values: npt.ArrayLike) -> tensor_pb2.Tensor:
    """Packs indices as UINT32 [K]."""
    return pack_integers(name, values, (None,))


def pack_integers(
    name: str, values: npt.ArrayLike, shape: Sequence[int | None]
) -> tensor_pb2.Tensor:
    """Packs whole numbers as UINT32 after checking their shape (None: any length)."""
    array = np.asarray(values)
    _check_shape(name, array.shape, shape)
    if array.size and not np.issubdtype(array.dtype, np.integer):
        raise ValueError(f"{name} must be integers, not {array.dtype}")
    if array.size and (array.min() < 0 or array.max() >= 2**32):
        raise ValueError(f"{name} must lie in 0..2**32")
    return _WIRE(dtype=_WIRE.UINT32, shape=array.shape, data=array.astype("<u4").tobytes())


def unpack(tensor: tensor_pb2.Tensor) -> npt.NDArray[np.generic] | None:
    """The tensor as a read-only array, or None where the field was left out.

    Raises ValueError if type, shape and bytes disagree.
    """
    if tensor.dtype == _WIRE.DTYPE_UNSPECIFIED and not tensor.shape:
        return None
    dtype = _NUMPY_OF_WIRE.get(tensor.dtype)
    if dtype is None:
        raise ValueError(f"tensor of unknown dtype {tensor.dtype}: update the bendtwin package")
    data, shape = tensor.data, tuple(tensor.shape)
    if math.prod(shape) * dtype.itemsize != len(data):
        raise ValueError(f"tensor of shape {shape} has {len(data)} bytes")
    array = np.frombuffer(data, dtype=dtype).reshape(shape)
    if tensor.dtype == _WIRE.INT16_SCALED:
        return array.astype(np.float32) * np.float32(tensor.scale) + np.float32(tensor.offset)
    return array


def _check_shape(name: str, given: Sequence[int], expected: Sequence[int | None]) -> None:
    fits = len(given) == len(expected) and all(
        e is None or g == e for g, e in zip(given, expected, strict=True)
    )
    if not fits:
        wanted = ", ".join("any" if e is None else str(e) for e in expected)
        raise ValueError(f"{name} has shape {tuple(given)}, not [{wanted}]")
