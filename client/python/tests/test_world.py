import warnings

import numpy as np
import pytest
from fake import TWIN

from bendtwin import (
    Capsule,
    Collider,
    ConvexMesh,
    Cuboid,
    Ensemble,
    GradientOptions,
    Grasp,
    Plane,
    Plausibility,
    Returns,
    Sphere,
    Vary,
    World,
)
from bendtwin.v1 import rollout_pb2


@pytest.fixture
def twin(client):
    return client.twin(TWIN)


def poses(batch=1, knots=3):
    values = np.zeros((batch, knots, 1, 7))
    values[..., 6] = 1.0
    return values


def quiet(twin, **arguments):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return twin.rollout(**arguments)


def test_a_world_is_sent_as_it_was_described(twin, fake):
    path = np.tile([0.0, 0, 0, 0, 0, 0, 1], (3, 1))
    colliders = [
        Collider(shape=Sphere(0.1, center=[0, 0, 1]), friction=0.8, name="ball"),
        Collider(shape=Capsule([0, 0, 0], [1, 0, 0], radius_m=0.02), path=path),
        Collider(shape=Cuboid([0, 0, 0], [1, 1, 1]), pose=[0, 0, 1, 0, 0, 0, 1]),
        Collider(shape=ConvexMesh(np.eye(4)[:, :3]), gripper=0, margin_m=0.01),
    ]
    world = World(
        colliders=colliders, gravity=[0, 0, -1.6], ground=Plane(offset_m=0.2), ground_friction=1.0
    )
    quiet(twin, poses=poses(), world=world)
    sent = fake.rollout_request.world
    shapes = [c.WhichOneof("shape") for c in sent.colliders]
    assert shapes == ["sphere", "capsule", "cuboid", "convex_mesh"]
    carriers = [c.WhichOneof("carrier") for c in sent.colliders]
    assert carriers == [None, "path", None, "gripper"]
    assert sent.colliders[0].friction == pytest.approx(0.8)
    assert list(getattr(sent.colliders[1].capsule, "from")) == [0, 0, 0]
    assert list(sent.colliders[2].pose) == [0, 0, 1, 0, 0, 0, 1]
    assert list(sent.gravity) == pytest.approx([0, 0, -1.6])
    assert sent.ground.offset_m == pytest.approx(0.2)
    assert sent.ground_friction == 1.0
    assert not sent.HasField("ground_restitution")
    quiet(twin, poses=poses(), world=World(ground="none"))
    assert fake.rollout_request.world.no_ground


def test_grasps_open_and_close_by_knots(twin, fake):
    grasps = [
        Grasp(region=Sphere(0.03), closed=[0, 1, 0], max_force_n=2.0),
        Grasp(nodes=[0, 2], attachment="springs", stiffness=10.0),
        Grasp(hand=1, closed=np.zeros((2, 3), bool)),
        Grasp(hand=0, closed=False),
    ]
    quiet(twin, poses=poses(2), grasps=grasps)
    sent = fake.rollout_request.grasps
    assert [g.WhichOneof("region") for g in sent] == ["sphere", "nodes", "hand", "hand"]
    assert [list(g.closed.shape) for g in sent] == [[3], [], [2, 3], [1]]
    assert sent[0].max_force_n == 2.0
    assert not sent[1].HasField("max_force_n")
    assert (sent[1].stiffness, sent[2].hand.hand) == (10.0, 1)


def test_members_vary_and_their_costs_come_back(twin, fake):
    result = quiet(
        twin,
        poses=poses(2),
        vary=Vary(mass=[1.0, 2.0], stiffness=[1.0, 0.5], object_restitution=[0.0, 0.4]),
        ensemble=Ensemble(2, "cvar", share=0.5),
        gradient=GradientOptions(reach_frames=15, smoothing_m=0.001),
        plausibility=Plausibility(strain=0.5, refuse=True),
    )
    sent = fake.rollout_request
    assert list(sent.vary.mass.shape) == [2]
    assert list(sent.vary.object_restitution.shape) == [2]
    assert not sent.vary.HasField("damping")
    assert not sent.vary.HasField("ground_restitution")
    assert (sent.ensemble.members, sent.ensemble.share) == (2, 0.5)
    assert sent.gradient.reach_frames == 15
    assert sent.plausibility.refuse
    assert not sent.plausibility.HasField("start_gap_m")
    assert result.member_costs.shape == (2, 2)


def test_fits_and_their_spread_are_asked_for(fake, twin):
    quiet(
        twin,
        poses=poses(),
        vary=Vary(fits=True),
        ensemble=Ensemble(3, "worst"),
        returns=Returns(every_frames=1, spread=True),
    )
    sent = fake.rollout_request
    assert sent.vary.fits
    assert sent.returns.spread
    quiet(twin, poses=poses(), vary=Vary(fits=True), ensemble=Ensemble(3, "mean_prediction"))
    ensemble = fake.rollout_request.ensemble
    assert ensemble.statistic == rollout_pb2.Ensemble.MEAN_PREDICTION
    quiet(twin, poses=poses())
    assert not fake.rollout_request.returns.spread


def test_forces_come_back_in_newtons(twin):
    result = quiet(twin, poses=poses(), grasps=[Grasp(hand=0)], returns=Returns(forces=True))
    assert result.forces.controls.shape == (1, 2, 1, 3)
    assert result.forces.grasps.shape == (1, 2, 1, 6)
    assert result.forces.ground.shape == (1, 2, 3)
    assert quiet(twin, poses=poses()).forces is None


def test_implausible_instances_are_listed_and_warned_of_once(twin, fake):
    fake.implausible = [(0, "START_GAP", 0.05, 0.005), (1, "STRAIN", 7.0, 1.0)]
    with pytest.warns(RuntimeWarning, match="START_GAP, STRAIN") as caught:
        result = twin.rollout(poses=poses(2))
    assert len(caught) == 1
    fake.implausible = [(1, "STRAIN", 8.0, 1.0), (2, "START_GAP", 0.06, 0.005)]
    with pytest.warns(RuntimeWarning) as again:
        twin.rollout(poses=poses(2))
    assert str(again[0].message) == str(caught[0].message), "Python shows the same text once"
    assert [i.reason for i in result.implausible] == ["START_GAP", "STRAIN"]
    fake.implausible = []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        twin.rollout(poses=poses(2))


@pytest.mark.parametrize(
    "make",
    [
        lambda: World(gravity=[0, 0]),
        lambda: World(colliders=[Collider(shape=Sphere(0.1, center=[np.nan, 0, 0]))]),
        lambda: World(colliders=[Collider(shape=ConvexMesh(np.zeros(3)))]),
        lambda: World(colliders=[Collider(shape=Sphere(0.1), gripper=0, path=np.zeros((2, 7)))]),
        lambda: Grasp(),
        lambda: Grasp(region=Sphere(0.1), nodes=[1]),
        lambda: Grasp(hand=0, closed=[0, 2]),
        lambda: Vary(mass=[[1.0]]),
    ],
)
def test_what_cannot_be_sent_is_refused(make):
    with pytest.raises(ValueError, match=r"shape|finite|one of|either"):
        make().to_proto()
