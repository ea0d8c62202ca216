import numpy as np
import pytest

from bendtwin.tensors import pack_floats, pack_indices, unpack
from bendtwin.v1 import tensor_pb2


def test_floats_survive_the_wire():
    values = np.arange(24, dtype=np.float64).reshape(2, 4, 3)
    array = unpack(pack_floats("points", values, (None, None, 3)))
    assert array.dtype == np.float32
    np.testing.assert_array_equal(array, values)


def test_reading_makes_no_copy():
    data = np.arange(6, dtype="<f4").tobytes()
    array = unpack(tensor_pb2.Tensor(dtype=tensor_pb2.Tensor.FLOAT32, shape=[2, 3], data=data))
    assert not array.flags.owndata
    assert not array.flags.writeable


def test_arrays_of_any_layout_are_packed_in_row_major_order():
    values = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    np.testing.assert_array_equal(unpack(pack_floats("x", values, (None, 3))), values)


def test_scaled_integers_become_metres():
    tensor = tensor_pb2.Tensor(
        dtype=tensor_pb2.Tensor.INT16_SCALED,
        shape=[2],
        data=np.array([-100, 200], "<i2").tobytes(),
        scale=0.01,
        offset=1.0,
    )
    np.testing.assert_allclose(unpack(tensor), [0.0, 3.0], atol=1e-6)


def test_a_field_left_out_is_none():
    assert unpack(tensor_pb2.Tensor()) is None


@pytest.mark.parametrize(
    "tensor",
    [
        tensor_pb2.Tensor(dtype=tensor_pb2.Tensor.FLOAT32, shape=[3], data=b"1234"),
        tensor_pb2.Tensor(dtype=99, shape=[1], data=b"1234"),
        tensor_pb2.Tensor(dtype=tensor_pb2.Tensor.FLOAT32, shape=[2**60, 2**60], data=b""),
    ],
)
def test_contradictory_tensors_are_refused(tensor):
    with pytest.raises(ValueError, match="tensor of"):
        unpack(tensor)


@pytest.mark.parametrize(
    ("values", "fault"),
    [
        ([[1.0, 2.0]], "has shape"),
        ([[1.0, 2.0, np.nan]], "not finite"),
        ([1.0, 2.0, 3.0], "has shape"),
    ],
)
def test_wrong_points_are_refused_before_sending(values, fault):
    with pytest.raises(ValueError, match=fault):
        pack_floats("points", values, (None, 3))


@pytest.mark.parametrize("values", [[-1], [2**32], [0.5], [[1]]])
def test_wrong_indices_are_refused_before_sending(values):
    with pytest.raises(ValueError, match="nodes"):
        pack_indices("nodes", values)
