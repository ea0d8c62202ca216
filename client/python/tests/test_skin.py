"""The skin of a twin: placed here and by a server, and named by requests."""

import numpy as np
import pytest
from server import make_rope, needs_server, running

from bendtwin import BendTwinError, Client, Keypoints, Returns, Skin, TargetCloud
from bendtwin.skin import NONE
from bendtwin.tensors import pack_floats, pack_indices, pack_integers
from bendtwin.v1 import rollout_pb2, twin_pb2

NODES = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


def skin():
    """A node, a mean with an offset along the world's axes, and one with a frame."""
    return Skin(
        rest_positions=np.zeros((3, 3), np.float32),
        observed_points=np.array([4, 5, NONE], np.uint32),
        weight_counts=np.array([1, 2, 3], np.uint32),
        weight_nodes=np.array([3, 0, 1, 0, 1, 2], np.uint32),
        weights=np.array([1, 0.5, 0.5, 0.5, 0.25, 0.25], np.float32),
        frames=np.array([[NONE] * 3, [NONE] * 3, [0, 1, 2]], np.uint32),
        offsets=np.array([[0, 0, 0], [0, 0, 0.5], [0.125, 0.25, 0.5]], np.float32),
    )


def test_points_are_where_their_nodes_carry_them():
    expected = [[0, 0, 1], [0.5, 0, 0.5], [0.375, 0.5, 0.5]]
    np.testing.assert_allclose(skin().positions(NODES), expected, atol=1e-12)


def test_frames_turn_with_their_nodes():
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = np.stack([NODES, NODES @ turn.T + [1, 2, 3]])
    placed = skin().positions(moved[:, None])
    assert placed.shape == (2, 1, 3, 3)
    np.testing.assert_allclose(placed[1, 0, 2], turn @ placed[0, 0, 2] + [1, 2, 3], atol=1e-12)
    # Offsets along the axes of the world do not.
    np.testing.assert_allclose(placed[1, 0, 1], [1, 2.5, 3.5], atol=1e-12)


def test_a_frame_that_collapsed_has_no_offset():
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 0, 1]])
    np.testing.assert_allclose(skin().positions(line)[2], [0.75, 0, 0], atol=1e-12)


def test_other_nodes_are_refused():
    with pytest.raises(ValueError, match="node 3 carries the skin"):
        skin().positions(NODES[:3])
    with pytest.raises(ValueError, match=r"not \[\.\.\., N, 3\]"):
        skin().positions(NODES[:, :2])


def test_a_skin_is_read_from_the_wire():
    own = skin()
    message = twin_pb2.TwinGeometry.Skin(
        rest_positions=pack_floats("rest", own.rest_positions, (None, 3)),
        observed_points=pack_indices("observed", own.observed_points),
        weight_counts=pack_indices("counts", own.weight_counts),
        weight_nodes=pack_indices("nodes", own.weight_nodes),
        weights=pack_floats("weights", own.weights, (None,)),
        frames=pack_integers("frames", own.frames, (None, 3)),
        offsets=pack_floats("offsets", own.offsets, (None, 3)),
    )
    read = Skin.from_proto(message)
    assert len(read) == 3
    np.testing.assert_array_equal(read.positions(NODES), own.positions(NODES))
    none = Skin.from_proto(twin_pb2.TwinGeometry.Skin())
    assert none.positions(NODES).shape == (0, 3)


def test_requests_say_which_points_they_mean():
    cloud = TargetCloud(points=[[0, 0, 0]]).to_proto()
    assert cloud.target_cloud.point_set == rollout_pb2.SKIN
    cloud = TargetCloud(points=[[0, 0, 0]], point_set="nodes").to_proto()
    assert cloud.target_cloud.point_set == rollout_pb2.NODES
    keypoints = Keypoints(skin_points=[7], targets=[[0, 0, 0]]).to_proto().keypoints
    assert list(keypoints.skin_points.shape) == [1]
    assert not keypoints.HasField("nodes")
    assert Returns().to_proto().point_set == rollout_pb2.NODES
    returns = Returns(every_frames=1, point_set="skin", skin_points=[1, 2]).to_proto()
    assert returns.point_set == rollout_pb2.SKIN
    assert list(returns.skin_points.shape) == [2]
    for wrong in ({}, {"nodes": [0], "skin_points": [0]}):
        with pytest.raises(ValueError, match="either nodes or skin_points"):
            Keypoints(targets=[[0, 0, 0]], **wrong).to_proto()


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    folder = tmp_path_factory.mktemp("skin")
    make_rope(folder / "rope.zip")
    settings = {
        "graph": {"max_nodes": 30},
        "search": {"generations": 3, "population": 6},
        "refine": {"passes": 1},
    }
    with running(folder) as address, Client(address) as client:
        capture = client.wait_for_capture(client.upload_capture(folder / "rope.zip"))
        yield client.twin(client.wait(client.fit(capture.name, settings), timeout_s=120).twin)


@needs_server
def test_the_returned_skin_is_where_the_nodes_carry_it(twin):
    skin = twin.geometry().skin
    assert len(skin) > 0
    actions = np.tile(twin.geometry().controls, (2, 13, 1, 1))
    actions[1, :, :, 1] += np.linspace(0, 0.05, 13)[:, None]
    request = {"trajectories": actions}
    nodes = twin.rollout(**request, returns=Returns(every_frames=3)).positions
    placed = skin.positions(nodes)
    costs = [
        TargetCloud(points=placed[0, -1, ::2], name="cloud"),
        Keypoints(skin_points=[0], targets=[[0, 0, 1]], name="point"),
    ]
    whole = Returns(every_frames=3, point_set="skin", velocities=True)
    result = twin.rollout(**request, costs=costs, returns=whole)
    np.testing.assert_allclose(result.positions, placed, atol=1e-6)
    assert result.velocities.shape == placed.shape
    cloud, point = result.cost_terms.T
    np.testing.assert_allclose(cloud[0], 0, atol=1e-9)
    distances = np.linalg.norm(placed[:, -1, 0] - [0, 0, 1], axis=-1)
    np.testing.assert_allclose(point, distances, rtol=1e-4)
    last = len(skin) - 1
    some = Returns(every_frames=3, point_set="skin", skin_points=[last, 0])
    parts = list(twin.stream_rollout(**request, returns=some, part_frames=6))
    joined = np.concatenate([part.positions for part in parts], axis=1)
    np.testing.assert_array_equal(joined, result.positions[:, :, [last, 0]])
    beyond = Returns(every_frames=3, point_set="skin", skin_points=[last + 1])
    with pytest.raises(BendTwinError, match=f"skin point {last + 1}"):
        twin.rollout(**request, returns=beyond)
    np.testing.assert_allclose(
        skin.positions(twin.geometry().rest_positions), skin.rest_positions, atol=1e-6
    )


@needs_server
def test_a_surface_lies_around_the_skin(twin):
    surface, rest = twin.surface(), twin.geometry().rest_positions
    assert twin.surface() is surface
    placed = surface.positions(rest)
    np.testing.assert_allclose(placed, surface.carriers.rest_positions, atol=1e-6)
    assert len(surface.triangles) > 0
    assert surface.triangles.max() < len(placed)
    # Closed: each edge belongs to two triangles, once in each direction.
    edges = np.concatenate([surface.triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(e) for e in edges.tolist()} == {tuple(e) for e in edges[:, ::-1].tolist()}
    assert surface.colors is None or surface.colors.shape == placed.shape
    skin = twin.geometry().skin.rest_positions
    margin = twin.geometry().spacing_m
    assert (placed.min(axis=0) < skin.min(axis=0) + margin).all()
    assert (placed.max(axis=0) > skin.max(axis=0) - margin).all()
