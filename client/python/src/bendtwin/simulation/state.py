"""Initial states of a rollout, and the state that it ends in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.tensors import pack_floats, pack_integers, unpack
from bendtwin.v1 import rollout_pb2, world_pb2


@dataclass(frozen=True)
class Rest:
    """The twin's rest shape, at rest."""

    def to_proto(self) -> rollout_pb2.InitialState:
        """Makes the wire form."""
        return rollout_pb2.InitialState(rest=rollout_pb2.InitialState.Rest())


@dataclass(frozen=True)
class Settled:
    """The twin's shape after it has come to rest in the rollout's or session's world, held by its
    control points at rest; colliders carried by grippers are absent."""

    def to_proto(self) -> rollout_pb2.InitialState:
        """Makes the wire form."""
        return rollout_pb2.InitialState(settled=rollout_pb2.InitialState.Settled())


@dataclass(frozen=True)
class CaptureFrame:
    """The twin's state after following its capture's own controls up to a frame."""

    frame: int
    sequence: int = 0
    #: captures/{uuid}; empty means the twin's own capture.
    capture: str = ""

    def to_proto(self) -> rollout_pb2.InitialState:
        """Makes the wire form."""
        return rollout_pb2.InitialState(
            capture_frame=rollout_pb2.InitialState.CaptureFrame(
                capture=self.capture, sequence=self.sequence, frame=self.frame
            )
        )


@dataclass(frozen=True)
class Grasping:
    """What G grasps hold of N nodes, for one state, or with [B] in front."""

    #: 0 open, 1 closed, 2 slipped, [G].
    phases: npt.ArrayLike
    #: g + 1 for a node that grasp g holds, 0 for none, [N].
    holders: npt.ArrayLike
    #: Positions of held nodes in the coordinates of their gripper, metres, [N, 3].
    places: npt.ArrayLike

    def to_proto(self) -> world_pb2.Grasping:
        """Makes the wire form."""
        batch = (None,) * (np.ndim(self.phases) - 1)
        return world_pb2.Grasping(
            phases=pack_integers("grasp phases", self.phases, (*batch, None)),
            holders=pack_integers("grasp holders", self.holders, (*batch, None)),
            places=pack_floats("grasp places", self.places, (*batch, None, 3)),
        )

    @classmethod
    def from_proto(cls, message: world_pb2.Grasping) -> Grasping:
        """Reads the wire form."""
        phases, holders, places = (
            unpack(getattr(message, name)) for name in ("phases", "holders", "places")
        )
        if phases is None or holders is None or places is None:
            raise ValueError("a state of grasps without phases, holders or places")
        return cls(phases, holders, places)

    def row(self, row: int) -> Grasping:
        """A single state of a batch."""
        phases, holders, places = (
            np.asarray(array)[row] for array in (self.phases, self.holders, self.places)
        )
        return Grasping(phases, holders, places)


@dataclass(frozen=True)
class State:
    """A state of the twin, for all instances or with [B] in front, as `RolloutResult.state` returns
    it. A rollout that starts from the final state of another one continues it exactly. Lists of
    numbers may be given in place of arrays.
    """

    #: Metres, [N, 3].
    positions: npt.NDArray[Any]
    #: Metres per second, [N, 3]; None means at rest.
    velocities: npt.NDArray[Any] | None = None
    #: Radians, [rods]; None means that no rod is twisted.
    twists: npt.NDArray[Any] | None = None
    #: Positions of the control points, metres, [C, 3]. None: pinned ones at their nodes, others at
    #: rest, from where `poses` would carry them; so give them with `poses`.
    controls: npt.NDArray[Any] | None = None
    #: Held nodes; None: only those that grasps take at the start of the rollout.
    grasping: Grasping | None = None
    #: Control points as commanded, without the stop at the ground, metres, [C, 3]: `poses` carry
    #: them from there. None: equal to `controls`.
    commanded_controls: npt.NDArray[Any] | None = None

    def to_proto(self) -> rollout_pb2.InitialState:
        """Makes the wire form."""
        batch = (None,) if np.ndim(self.positions) == 3 else ()
        given = rollout_pb2.InitialState.GivenState(
            positions=pack_floats("initial positions", self.positions, (*batch, None, 3))
        )
        if self.velocities is not None:
            given.velocities.CopyFrom(
                pack_floats("initial velocities", self.velocities, (*batch, None, 3))
            )
        if self.twists is not None:
            given.twists.CopyFrom(pack_floats("initial twists", self.twists, (*batch, None)))
        if self.controls is not None:
            given.controls.CopyFrom(
                pack_floats("initial controls", self.controls, (*batch, None, 3))
            )
        if self.commanded_controls is not None:
            given.commanded_controls.CopyFrom(
                pack_floats("commanded controls", self.commanded_controls, (*batch, None, 3))
            )
        if self.grasping is not None:
            given.grasping.CopyFrom(self.grasping.to_proto())
        return rollout_pb2.InitialState(given=given)

    @classmethod
    def from_proto(cls, message: rollout_pb2.InitialState.GivenState) -> State:
        """Reads the wire form."""
        positions, velocities, twists, controls, commanded = (
            unpack(getattr(message, name))
            for name in ("positions", "velocities", "twists", "controls", "commanded_controls")
        )
        if positions is None:
            raise ValueError("a state without positions")
        grasping = Grasping.from_proto(message.grasping) if message.HasField("grasping") else None
        return cls(positions, velocities, twists, controls, grasping, commanded)


#: The name of a given state in the wire format.
GivenState = State


@dataclass(frozen=True)
class SessionSlots:
    """The states of slots of a session: see `Session.rollout`."""

    #: sessions/{uuid}.
    session: str
    #: Slot for all instances, or one for each; empty: slot 0 for all.
    slots: tuple[int, ...] = ()

    def to_proto(self) -> rollout_pb2.InitialState:
        """Makes the wire form."""
        slots = rollout_pb2.InitialState.SessionSlots(session=self.session, slots=self.slots)
        return rollout_pb2.InitialState(session=slots)


InitialState = Rest | Settled | CaptureFrame | State | SessionSlots


def state_of(states: State, row: int) -> State:
    """A single state of a batch of states."""

    def pick(array: npt.NDArray[Any] | None) -> npt.NDArray[Any] | None:
        return None if array is None else np.asarray(array)[row]

    return State(
        positions=np.asarray(states.positions)[row],
        velocities=pick(states.velocities),
        twists=pick(states.twists),
        controls=pick(states.controls),
        grasping=None if states.grasping is None else states.grasping.row(row),
        commanded_controls=pick(states.commanded_controls),
    )
