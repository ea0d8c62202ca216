"""Messages of registrations and corrections, without a server."""

import numpy as np
import pytest

from bendtwin import Collider, Plane, Registration, Settled, Sphere, World
from bendtwin.simulation.registration import correct_session, register_state
from bendtwin.tensors import unpack
from bendtwin.v1 import registration_pb2, session_pb2

POINTS = np.array([[0, 0, 1], [np.nan, 0, 0], [0, 0.5, 1]])
BALL = Collider(shape=Sphere(0.05))


def test_what_was_not_seen_is_left_out_with_all_that_belongs_to_it():
    given = {"nodes": [4, 5, 6], "weights": [1.0, np.nan, 0.5], "velocities": POINTS}
    seen = correct_session("sessions/s", [1], POINTS, given).request.observation
    np.testing.assert_array_equal(unpack(seen.points), [[0, 0, 1], [0, 0.5, 1]])
    np.testing.assert_array_equal(unpack(seen.nodes), [4, 6])
    np.testing.assert_array_equal(unpack(seen.weights), [1, 0.5])
    assert unpack(seen.velocities).shape == (2, 3)
    assert unpack(seen.cameras) is None


def test_options_are_sent_only_where_they_are_given():
    given = {
        "initial": Settled(),
        "world": World(ground=Plane(offset_m=0.1), colliders=[BALL]),
        "grippers": [[0, 0, 0.5, 0, 0, 0, 1]],
        "controls": np.zeros((1, 3)),
        "near": True,
        "settle_frames": 0,
        "noise_m": None,
    }
    request = register_state("twins/t", POINTS[:1], given).request
    assert request.initial.HasField("settled")
    assert request.options.near
    assert request.options.HasField("settle_frames")
    assert request.options.settle_frames == 0
    assert not request.options.HasField("noise_m")
    assert not request.options.HasField("give")
    assert request.world.ground.offset_m == pytest.approx(0.1)
    assert request.world.colliders[0].sphere.radius_m == pytest.approx(0.05)
    assert unpack(request.grippers).shape == (1, 7)
    assert request.observation.WhichOneof("tracks") is None


@pytest.mark.parametrize(
    ("points", "given", "says"),
    [
        (np.zeros(3), {}, "points has shape"),
        (np.zeros((2, 2)), {}, "points has shape"),
        (POINTS, {"nodes": [1, 2]}, "for 3 points"),
        (POINTS, {"nodes": [1, 2, 3], "places": POINTS}, "either nodes or places"),
        (POINTS, {"node_positions": POINTS}, "goes with places"),
        (POINTS, {"nodes": [0.5, 1, 2]}, "integers"),
        (POINTS, {"cameras": np.full((1, 3), np.inf)}, "not finite"),
    ],
)
def test_what_cannot_be_sent_is_refused(points, given, says):
    with pytest.raises(ValueError, match=says):
        register_state("twins/t", points, given)


def test_unknown_arguments_are_refused():
    with pytest.raises(TypeError, match="a correction has no argument 'near'"):
        correct_session("sessions/s", [], POINTS, {"near": True})


def test_a_registration_is_read():
    message = registration_pb2.RegisteredState(
        motion=[0, 0, 0, 0, 0, 0, 1], drift_mm=0.5, worker="workers/w"
    )
    message.after.median_mm = 2.0
    message.explained.points = 0.9
    message.state.positions.CopyFrom(register_state("", POINTS[:1], {}).request.observation.points)
    found = Registration.from_proto(message)
    np.testing.assert_array_equal(found.state.positions, [[0, 0, 1]])
    assert found.state.controls is None
    assert found.after.median_mm == 2.0
    assert found.motion.shape == (7,)
    assert found.explained_points == 0.9


def test_a_correction_knows_its_surroundings_and_brings_the_state():
    given = {
        "world": World(colliders=[BALL]),
        "grippers": np.ones((2, 7)),
        "register_if_lost": True,
    }
    call = correct_session("sessions/s", [3], POINTS, given)
    options = call.request.options
    assert options.register_if_lost
    assert not options.omit_state
    assert len(options.world.colliders) == 1
    assert unpack(options.grippers).shape == (2, 7)
    assert not correct_session("sessions/s", [], POINTS, {}).request.options.HasField("world")

    reply = session_pb2.CorrectedSession()
    one = reply.corrections.add(slot=3, moved_mm=2.5, registered=True)
    one.tracking.misfit = 0.25
    [bare] = call.read(reply)
    assert bare.state is None
    assert not bare.lost
    one.state.positions.CopyFrom(call.request.observation.points)
    one.tracking.lost, one.tracking.unexplained = True, 3
    [correction] = call.read(reply)
    np.testing.assert_array_equal(correction.state.positions, [[0, 0, 1], [0, 0.5, 1]])
    assert correction.lost
    assert correction.registered
    assert correction.tracking.unexplained == 3
