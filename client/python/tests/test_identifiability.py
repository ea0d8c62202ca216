"""The report of what recordings leave open, as clients read it."""

import json

import numpy as np

from bendtwin.geometry import Geometry
from bendtwin.resources import TwinInfo
from bendtwin.twin import TwinFacts
from bendtwin.v1 import tensor_pb2, twin_pb2


def test_a_report_is_part_of_a_twin() -> None:
    report = {"summary": ["The free end is open."], "groups": [], "motions": [], "next": []}
    message = twin_pb2.Twin(quality_json=json.dumps({"scores": [], "identifiability": report}))
    twin = TwinFacts(TwinInfo.from_proto(message), None)
    assert twin.identifiability == report
    bare = TwinFacts(TwinInfo.from_proto(twin_pb2.Twin(quality_json='{"scores": []}')), None)
    assert bare.identifiability is None


def test_a_geometry_has_it_by_node_and_by_point() -> None:
    message = twin_pb2.TwinGeometry(
        node_regions=tensor_pb2.Tensor(dtype="UINT8", shape=[2], data=bytes([0, 1])),
        skin_sd=tensor_pb2.Tensor(
            dtype="FLOAT32",
            shape=[3],
            data=np.array([0.001, 0.002, 0.004], "<f4").tobytes(),
        ),
    )
    geometry = Geometry.from_proto(message)
    assert geometry.node_regions is not None
    assert geometry.skin_sd is not None
    np.testing.assert_array_equal(geometry.node_regions, [0, 1])
    np.testing.assert_allclose(geometry.skin_sd, [0.001, 0.002, 0.004])
    bare = Geometry.from_proto(twin_pb2.TwinGeometry())
    assert bare.node_regions is None
    assert bare.skin_sd is None
