"""Results of a rollout, and the request for them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bendtwin.state import Grasping, State, state_of
from bendtwin.tensors import pack_indices, unpack
from bendtwin.v1 import rollout_pb2

Fidelity = Literal["exact", "fast"]

FloatArray = npt.NDArray[np.floating[Any]]
IndexArray = npt.NDArray[np.uint32]

_ENCODINGS: dict[str, rollout_pb2.Returns.Encoding] = {
    "float32": rollout_pb2.Returns.FLOAT32,
    "int16": rollout_pb2.Returns.INT16,
}


FIDELITIES: dict[str, rollout_pb2.Fidelity] = {
    "exact": rollout_pb2.EXACT,
    "fast": rollout_pb2.FAST,
}


@dataclass(frozen=True)
class Returns:
    """Arrays that a rollout returns. The default is costs alone: the least to transfer."""

    #: Record the positions of every k-th frame; 0 records none.
    every_frames: int = 0
    #: Indices of the nodes to record; None means all.
    nodes: npt.ArrayLike | None = None
    #: int16 halves the size of positions at an error below 1/65535 of the extent.
    encoding: Literal["float32", "int16"] = "float32"
    #: Positions, final states and gradients of only the best k instances by cost; 0 means all.
    best: int = 0
    final_state: bool = False
    diagnostics: bool = False
    #: d cost / d control positions, dense.
    control_gradients: bool = False
    #: d cost / d what was given as actions: knots or poses, in their shape.
    action_gradients: bool = False

    def to_proto(self) -> rollout_pb2.Returns:
        """Makes the wire form."""
        message = rollout_pb2.Returns(
            every_frames=self.every_frames,
            encoding=_ENCODINGS[self.encoding],
            best=self.best,
            final_state=self.final_state,
            diagnostics=self.diagnostics,
            control_gradients=self.control_gradients,
            action_gradients=self.action_gradients,
        )
        if self.nodes is not None:
            message.nodes.CopyFrom(pack_indices("nodes", self.nodes))
        return message


@dataclass(frozen=True)
class Diagnostics:
    """Diagnostics of an instance over the whole rollout."""

    max_strain: float
    max_speed_m_s: float
    kinetic_energy: float
    elastic_energy: float
    ground_contacts: int


@dataclass(frozen=True)
class Divergence:
    """Frame and node in which an instance diverged."""

    instance: int
    #: 1-based.
    frame: int
    node: int


@dataclass(frozen=True)
class Timing:
    """Time spent at the worker."""

    queue_s: float
    compute_s: float


@dataclass(frozen=True)
class Deviation:
    """Between a twin's fast variant and the exact twin when both follow the twin's own capture."""

    #: Between a node here and there, mean over nodes and frames, metres.
    mean_m: float
    max_m: float
    #: To compare with: of the exact twin's nodes from where they started, mean, metres.
    mean_travel_m: float
    #: Frames of each recording, at most.
    frames: int


@dataclass(frozen=True)
class RolloutResult:
    """The answer to a rollout: B instances, R of which are returned in detail.

    Arrays are read-only views of the received bytes; those not asked for are None.
    """

    #: The first instance that this part covers; 0 unless streamed.
    first_instance: int
    #: Weighted sums [B], +inf where an instance diverged.
    costs: FloatArray
    #: Names of the terms.
    cost_names: list[str]
    #: Weighted terms [B, terms].
    cost_terms: FloatArray | None
    #: The instances [R] that positions, final states and gradients are of.
    instances: IndexArray | None
    #: Recorded frames [T], 1-based.
    frames: IndexArray | None
    #: Recorded positions [R, T, K, 3], metres.
    positions: FloatArray | None
    #: Final positions [R, N, 3], metres.
    final_positions: FloatArray | None
    #: Final velocities [R, N, 3], metres per second.
    final_velocities: FloatArray | None
    #: Final twists of rods [R, rods], radians; None if the twin has none.
    final_twists: FloatArray | None
    #: d cost / d control positions [R, F + 1, C, 3].
    control_gradients: FloatArray | None
    #: d cost / d actions in their shape, [R, K, C, 3] or [R, K, G, 7]; d cost / d quaternion along
    #: the sphere of unit quaternions.
    action_gradients: FloatArray | None = None
    #: Final control points [R, C, 3], metres.
    final_controls: FloatArray | None = None
    #: What grasps hold in the final states; None without grasps.
    final_grasping: Grasping | None = None
    #: Mass of the object; None: not known, and forces are per unit mass.
    mass_kg: float | None = None
    diagnostics: list[Diagnostics] = field(default_factory=list)
    diverged: list[Divergence] = field(default_factory=list)
    timing: Timing | None = None
    #: workers/{uuid} that answered.
    worker: str = ""
    #: What answered.
    fidelity: Fidelity = "exact"
    #: Substeps per frame that were simulated.
    substeps: int = 0
    #: How far the fast variant strays; None unless it answered.
    deviation: Deviation | None = None

    def state(self, row: int) -> State:
        """The final state of one of `instances`, to go on from: `twin.rollout(initial=...)`."""
        return state_of(self.states(), row)

    def states(self) -> State:
        """The final states of all of `instances`, to go on from with as many instances."""
        if self.final_positions is None:
            raise ValueError("ask for final states: Returns(final_state=True)")
        return State(
            positions=self.final_positions,
            velocities=self.final_velocities,
            twists=self.final_twists,
            controls=self.final_controls,
            grasping=self.final_grasping,
        )

    @classmethod
    def from_proto(cls, message: rollout_pb2.RollOutResponse) -> RolloutResult:
        """Reads the wire form."""
        costs: Any = unpack(message.costs)
        timing = message.timing
        arrays: dict[str, Any] = {
            name: unpack(getattr(message, name))
            for name in (
                "cost_terms",
                "instances",
                "frames",
                "positions",
                "final_positions",
                "final_velocities",
                "final_twists",
                "control_gradients",
                "action_gradients",
                "final_controls",
            )
        }
        return cls(
            first_instance=message.first_instance,
            costs=np.zeros(0) if costs is None else costs,
            cost_names=list(message.cost_names),
            diagnostics=[
                Diagnostics(
                    d.max_strain,
                    d.max_speed_m_s,
                    d.kinetic_energy,
                    d.elastic_energy,
                    d.ground_contacts,
                )
                for d in message.diagnostics
            ],
            diverged=[Divergence(d.instance, d.frame, d.node) for d in message.diverged],
            timing=Timing(timing.queue_s, timing.compute_s) if message.HasField("timing") else None,
            worker=message.worker,
            fidelity="fast" if message.fidelity == rollout_pb2.FAST else "exact",
            substeps=message.substeps,
            deviation=(
                Deviation(
                    message.deviation.mean_m,
                    message.deviation.max_m,
                    message.deviation.mean_travel_m,
                    message.deviation.frames,
                )
                if message.HasField("deviation")
                else None
            ),
            final_grasping=(
                Grasping.from_proto(message.final_grasping)
                if message.HasField("final_grasping")
                else None
            ),
            mass_kg=message.mass_kg if message.HasField("mass_kg") else None,
            **arrays,
        )
