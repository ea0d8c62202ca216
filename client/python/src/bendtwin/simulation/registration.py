"""Registration: finds the state of a twin from observed points of its object."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

from bendtwin.calls import Call
from bendtwin.messages import FromMessage
from bendtwin.simulation.state import InitialState, State
from bendtwin.simulation.world import World
from bendtwin.tensors import pack_floats, pack_indices
from bendtwin.v1 import registration_pb2, session_pb2


class ObservationArguments(TypedDict, total=False):
    """Further facts about the observed points, [M, 3]. Points that are not finite are unseen: they
    are left out, with everything that belongs to them."""

    #: Nodes of the twin at the points [M]. Without these and `places` the points are a cloud, which
    #: is matched to the surface.
    nodes: npt.ArrayLike | None
    #: Positions of the points at one time [M, 3], for tracked points between nodes.
    places: npt.ArrayLike | None
    #: Positions of the nodes at the time of `places` [N, 3]; at rest by default.
    node_positions: npt.ArrayLike | None
    #: Weights, 0 or more, [M]; equal by default.
    weights: npt.ArrayLike | None
    #: Velocities, metres per second, [M, 3]. Only corrections by nodes or places use them.
    velocities: npt.ArrayLike | None
    #: Positions of the cameras that saw the points [K, 3], which determine the visible part of the
    #: surface. By default all of it is visible.
    cameras: npt.ArrayLike | None


class RegisterArguments(ObservationArguments, total=False):
    """Arguments of a registration; all have a default."""

    #: Shape to start from; the rest shape by default.
    initial: InitialState
    #: Positions of the control points [C, 3], if known, for example from the gripper. By default
    #: they follow the nodes that they hold.
    controls: npt.ArrayLike | None
    #: Gravity, ground and colliders, where they differ from those of the twin. The state is outside
    #: of ground and colliders, except nodes held by control points; a collider on a path is at its
    #: first pose.
    world: World | None
    #: Poses of the grippers that carry colliders of the world [G, 7]: x, y, z in metres, quaternion
    #: x, y, z, w. Colliders of other grippers are left out.
    grippers: npt.ArrayLike | None
    #: True if the object is near the shape to start from, so that no other pose is tried.
    near: bool
    #: Standard deviation of a point from the surface, metres; 0.004 by default.
    noise_m: float | None
    #: Standard deviation of a spring's relative length; 0.1 by default.
    give: float | None
    #: Frames of physics under the pull of the points; 12 by default.
    settle_frames: int | None
    #: Median distance of the points above which the registration is refused, metres.
    max_residual_m: float | None
    #: Smallest share of the points that must be explained; 0.5 by default.
    least_explained: float | None


class CorrectArguments(ObservationArguments, total=False):
    """Arguments of a correction; all have a default."""

    #: Standard deviation of a point from its place, metres; 0.005 by default.
    noise_m: float | None
    #: Standard deviation of a spring's relative length; 0.03 by default.
    give: float | None
    #: Standard deviation of an observed velocity, metres per second; 0.2 by default.
    velocity_noise_m_s: float | None
    #: Share of the displacement that is added to the velocity, per second; 0 by default.
    velocity_gain_per_s: float | None
    #: Largest increase of the strain of a spring; 0.5 by default.
    most_added_strain: float | None
    #: Median distance of the points above which the correction is refused, metres.
    max_residual_m: float | None
    #: Share of the correction that the rest shape of the slot takes over, 0..1, so that the slot
    #: does not spring back; 1 by default. With 0 only the state is corrected.
    carry: float | None
    #: Current surroundings. By default those at the end of the slot's last `advance`, or before the
    #: first one those of the session, with paths at their first pose and without carried colliders.
    world: World | None
    #: Current poses of the first grippers [G, 7], where they differ from the last `advance` or are
    #: unknown: x, y, z in metres, quaternion x, y, z, w.
    grippers: npt.ArrayLike | None
    #: True to register a lost slot with these points: from its current state, or else from the rest
    #: shape in any pose, keeping nodes held by control points and grasps in place.
    register_if_lost: bool
    #: True to leave the states out of the reply.
    omit_state: bool


_REGISTER_OPTIONS = (
    "near",
    "noise_m",
    "give",
    "settle_frames",
    "max_residual_m",
    "least_explained",
)
_CORRECT_OPTIONS = (
    "noise_m",
    "give",
    "velocity_noise_m_s",
    "velocity_gain_per_s",
    "most_added_strain",
    "max_residual_m",
    "carry",
    "register_if_lost",
    "omit_state",
)


@dataclass(frozen=True)
class Residual(FromMessage):
    """Distances between points and the twin, millimetres: from nodes and places to the points, from
    a cloud to the surface."""

    median_mm: float
    mean_mm: float
    #: 95th percentile.
    p95_mm: float


@dataclass(frozen=True)
class Registration:
    """Result of a registration. Its `state` can be the `initial` of a rollout or a session."""

    #: At rest, with its control points.
    state: State
    #: Distances of the points from the shape to start from, and from the registered state.
    before: Residual
    after: Residual
    #: Share of the points that are within reach of the twin, 0..1.
    explained_points: float
    #: Share of the visible surface that has a point within reach, 0..1.
    explained_surface: float
    #: The reach, millimetres.
    within_mm: float
    #: The rigid part of the motion from the shape to start from, about the origin [7]: x, y, z in
    #: metres, quaternion x, y, z, w.
    motion: npt.NDArray[np.float64]
    #: Mean distance by which nodes move in a frame once the points stop pulling: a measure of how
    #: far the state is from equilibrium.
    drift_mm: float
    #: workers/{uuid}.
    worker: str

    @classmethod
    def from_proto(cls, message: registration_pb2.RegisteredState) -> Registration:
        """Reads the wire form."""
        explained = message.explained
        return cls(
            state=State.from_proto(message.state),
            before=Residual.from_proto(message.before),
            after=Residual.from_proto(message.after),
            explained_points=explained.points,
            explained_surface=explained.surface,
            within_mm=explained.within_mm,
            motion=np.array(message.motion),
            drift_mm=message.drift_mm,
            worker=message.worker,
        )


@dataclass(frozen=True)
class Tracking(FromMessage):
    """Record of how well a slot has explained its observations, refused ones included, since its
    state was last set or registered.

    The misfit of an observation is the larger of two ratios: the median distance of its points
    after the correction over a length, which is the largest of half the node spacing, 5 mm and
    `noise_m`; and the share of the points that are farther away than that length and than three
    `noise_m`, over 1/2. Up to a misfit of 1 the observation is explained.
    """

    #: True if the slot no longer follows its object: the last three observations in a row are not
    #: explained, or the mean misfit is above 1.
    lost: bool
    #: Weighted mean of the misfits, each counted as at most 1.5 and with 3/4 of the weight of the
    #: next.
    misfit: float
    #: Number of latest observations in a row that are not explained.
    unexplained: int


@dataclass(frozen=True)
class Correction(FromMessage):
    """A correction of a slot of a session."""

    slot: int
    #: Distances of the points before and after.
    before: Residual
    after: Residual
    #: Largest displacement of a node.
    moved_mm: float
    #: The corrected state, unless `omit_state` was set. It can be the initial state of any call;
    #: the rest shape of the slot stays in the session.
    state: State | None
    #: Tracking record of the slot, these points included.
    tracking: Tracking
    #: True if the slot was lost and has been registered with these points: it is then at rest, with
    #: the rest shape of the twin.
    registered: bool

    @property
    def lost(self) -> bool:
        """True if the slot no longer follows its object."""
        return self.tracking.lost


def register_state(
    twin: str, points: npt.ArrayLike, given: RegisterArguments
) -> Call[Registration]:
    """Registers a twin to points."""
    _refuse_unknown("registration", given, RegisterArguments.__optional_keys__)
    request = registration_pb2.RegisterStateRequest(
        twin=twin,
        observation=_observation(points, given),
        options=registration_pb2.RegisterOptions(**_options(given, _REGISTER_OPTIONS)),
    )
    if "initial" in given:
        request.initial.CopyFrom(given["initial"].to_proto())
    controls = given.get("controls")
    if controls is not None:
        request.controls.CopyFrom(pack_floats("controls", controls, (None, 3)))
    _add_surroundings(request, given)
    return Call(lambda s: s.registrations.RegisterState, request, Registration.from_proto)


def correct_session(
    name: str, slots: Sequence[int], points: npt.ArrayLike, given: CorrectArguments
) -> Call[list[Correction]]:
    """Corrects slots of a session by points."""
    _refuse_unknown("correction", given, CorrectArguments.__optional_keys__)
    request = session_pb2.CorrectSessionRequest(
        name=name,
        slots=slots,
        observation=_observation(points, given),
        options=correct_options(given),
    )
    return Call(lambda s: s.sessions.CorrectSession, request, _read_corrections)


def correct_options(given: CorrectArguments) -> registration_pb2.CorrectOptions:
    """Makes the wire form of the options among the arguments of a correction."""
    options = registration_pb2.CorrectOptions(**_options(given, _CORRECT_OPTIONS))
    _add_surroundings(options, given)
    return options


def _read_corrections(reply: session_pb2.CorrectedSession) -> list[Correction]:
    return [Correction.from_proto(one) for one in reply.corrections]


def _add_surroundings(
    message: registration_pb2.RegisterStateRequest | registration_pb2.CorrectOptions,
    given: RegisterArguments | CorrectArguments,
) -> None:
    world, grippers = given.get("world"), given.get("grippers")
    if world is not None:
        message.world.CopyFrom(world.to_proto())
    if grippers is not None:
        message.grippers.CopyFrom(pack_floats("grippers", grippers, (None, 7)))


def _observation(
    points: npt.ArrayLike, given: ObservationArguments
) -> registration_pb2.Observation:
    array = np.asarray(points, dtype=np.float32)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"points has shape {array.shape}, not [any, 3]")
    seen = np.isfinite(array).all(axis=1)
    count = len(array)

    def rows(name: str, values: npt.ArrayLike) -> npt.NDArray[Any]:
        of_points = np.asarray(values)
        if of_points.ndim == 0 or len(of_points) != count:
            raise ValueError(f"{name} has shape {of_points.shape} for {count} points")
        return np.asarray(of_points[seen])

    nodes, places = given.get("nodes"), given.get("places")
    if nodes is not None and places is not None:
        raise ValueError("give either nodes or places")
    message = registration_pb2.Observation(points=pack_floats("points", array[seen], (None, 3)))
    if nodes is not None:
        message.nodes.CopyFrom(pack_indices("nodes", rows("nodes", nodes)))
    if places is not None:
        bound = pack_floats("places", rows("places", places), (None, 3))
        message.places.points.CopyFrom(bound)
    _add_optional(message, given, rows)
    return message


def _add_optional(
    message: registration_pb2.Observation, given: ObservationArguments, rows: Any
) -> None:
    positions = given.get("node_positions")
    if positions is not None:
        if not message.HasField("places"):
            raise ValueError("node_positions goes with places")
        packed = pack_floats("node_positions", positions, (None, 3))
        message.places.node_positions.CopyFrom(packed)
    weights, velocities = given.get("weights"), given.get("velocities")
    if weights is not None:
        message.weights.CopyFrom(pack_floats("weights", rows("weights", weights), (None,)))
    if velocities is not None:
        packed = pack_floats("velocities", rows("velocities", velocities), (None, 3))
        message.velocities.CopyFrom(packed)
    cameras = given.get("cameras")
    if cameras is not None:
        message.cameras.CopyFrom(pack_floats("cameras", cameras, (None, 3)))


def _options(given: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    return {name: given[name] for name in names if given.get(name) is not None}


def _refuse_unknown(what: str, given: Mapping[str, Any], known: frozenset[str]) -> None:
    unknown = sorted(given.keys() - known)
    if unknown:
        names = ", ".join(sorted(known))
        raise TypeError(f"a {what} has no argument {unknown[0]!r}; it has {names}")
