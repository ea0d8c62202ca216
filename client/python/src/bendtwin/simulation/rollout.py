"""Results of a rollout, and the request for them."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bendtwin.messages import FromMessage
from bendtwin.simulation.state import Grasping, State, state_of
from bendtwin.skin import POINT_SETS, PointSet
from bendtwin.tensors import pack_indices
from bendtwin.v1 import rollout_pb2

Fidelity = Literal["exact", "fast", "planner"]

FloatArray = npt.NDArray[np.floating[Any]]
IndexArray = npt.NDArray[np.uint32]

_ENCODINGS: dict[str, rollout_pb2.Returns.Encoding.ValueType] = {
    "float32": rollout_pb2.Returns.FLOAT32,
    "int16": rollout_pb2.Returns.INT16,
}


FIDELITIES: dict[str, rollout_pb2.Fidelity.ValueType] = {
    "exact": rollout_pb2.EXACT,
    "fast": rollout_pb2.FAST,
    "planner": rollout_pb2.PLANNER,
}


@dataclass(frozen=True)
class Returns:
    """Arrays that a rollout returns. The default, only costs, transfers least."""

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
    #: d cost / d actions as given: knots or poses, in their shape.
    action_gradients: bool = False
    #: d cost / d initial positions and velocities.
    initial_gradients: bool = False
    #: Norm of d cost / d positions by frame.
    gradient_norms: bool = False
    #: Velocities where positions are recorded.
    velocities: bool = False
    #: Costs by frame and by term.
    frame_costs: bool = False
    #: Control positions as simulated, by frame.
    controls: bool = False
    #: Forces by frame.
    forces: bool = False
    #: Points whose positions and velocities are recorded; final states and gradients are for nodes.
    point_set: PointSet = "nodes"
    #: Indices of the points of the skin to record, with `point_set` "skin"; None means all.
    skin_points: npt.ArrayLike | None = None
    #: Spread of an ensemble's recorded points; the other arrays are then those of member 0 only, or
    #: of the mean with the statistic "mean_prediction".
    spread: bool = False

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
            initial_gradients=self.initial_gradients,
            gradient_norms=self.gradient_norms,
            velocities=self.velocities,
            frame_costs=self.frame_costs,
            controls=self.controls,
            forces=self.forces,
            point_set=POINT_SETS[self.point_set],
            spread=self.spread,
        )
        if self.nodes is not None:
            message.nodes.CopyFrom(pack_indices("nodes", self.nodes))
        if self.skin_points is not None:
            message.skin_points.CopyFrom(pack_indices("skin_points", self.skin_points))
        return message


@dataclass(frozen=True)
class Diagnostics(FromMessage):
    """Diagnostics of an instance over the whole rollout, or up to where it diverged."""

    #: Largest strain of springs between nodes.
    max_strain: float
    #: Highest speed of a node at the end of any frame.
    max_speed_m_s: float
    #: Energies at the end, joules; without a `mass_kg` as if a node weighed 1 kg. NaN if it
    #: diverged.
    kinetic_energy: float
    elastic_energy: float
    ground_contacts: int
    #: Largest strain of springs to control points.
    max_control_strain: float = 0.0
    #: Largest depth of a control point in the ground or a static collider, beyond its depth in the
    #: initial state, metres.
    control_depth_m: float = 0.0
    #: Largest distance by which a hand or gripper was held back at the ground, metres; or 0.
    stopped_hand_m: float = 0.0


@dataclass(frozen=True)
class Forces(FromMessage):
    """Mean forces on the object over each frame, newtons; per unit mass without a `mass_kg`."""

    #: Forces of control points [R, F, C, 3].
    controls: FloatArray
    #: Forces of grasps [R, F, G, 6]: force, then torque about the gripper's origin at the end of
    #: the frame (newton metres), along the world's axes.
    grasps: FloatArray
    #: Force of the ground [R, F, 3].
    ground: FloatArray
    #: Forces of colliders [R, F, K, 6], torque about their carrier.
    colliders: FloatArray


@dataclass(frozen=True)
class Implausible(FromMessage):
    """Motion of an instance that is beyond a limit."""

    instance: int
    #: START_GAP, CONTROL_SPEED, STRAIN, CONTROL_IN_OBSTACLE or GRASP_FORCE.
    reason: str
    #: Largest value found, in the unit of the limit.
    found: float
    limit: float
    #: Frame in which the value was found; 0 where unknown.
    frame: int
    #: With GRASP_FORCE: the grasp, by its place among those of the rollout.
    grasp: int | None = None

    @property
    def is_of_start(self) -> bool:
        """True if actions and initial state do not match at the start."""
        return self.reason == "START_GAP"


@dataclass(frozen=True)
class Divergence(FromMessage):
    """Frame and node in which an instance diverged."""

    instance: int
    #: 1-based.
    frame: int
    node: int


@dataclass(frozen=True)
class Timing(FromMessage):
    """Time spent at the worker."""

    queue_s: float
    compute_s: float


@dataclass(frozen=True)
class Deviation(FromMessage):
    """Deviation from the exact twin: of a fast variant, when both follow the twin's own capture, or
    of a planner's twin, when both follow the actions that measured it.

    The deviation in this rollout may be larger: with faster or larger motions, or other
    surroundings, 5 to 16 times as much was seen for fast variants.
    """

    #: Distance of a node (for a planner's twin, a skin point) in one from the same node in the
    #: other, mean over nodes and frames, metres.
    mean_m: float
    max_m: float
    #: For comparison: mean distance of the exact twin's nodes from their start, metres.
    mean_travel_m: float
    #: Largest number of frames of a recording.
    frames: int


def warned(result: RolloutResult) -> RolloutResult:
    """The same result, after one warning for all implausible instances."""
    if result.implausible:
        reasons = ", ".join(sorted({i.reason for i in result.implausible}))
        # Without numbers, so that a loop is not warned repeatedly.
        message = (
            f"implausible motion ({reasons}): RolloutResult.implausible has what was found, the "
            "limits and the instances"
        )
        warnings.warn(message, RuntimeWarning, stacklevel=5)
    return result


@dataclass(frozen=True)
class RolloutResult(FromMessage):
    """The result of a rollout: B instances, R of which are returned in detail.

    Arrays are read-only views of the received bytes; those not requested are None.
    """

    #: The first instance that this part covers; 0 unless streamed.
    first_instance: int
    #: Weighted sums [B], +inf where an instance diverged or is unfinished; with parts divided in
    #: time, only in the last part of an instance.
    costs: FloatArray
    #: Names of the terms.
    cost_names: list[str]
    #: Weighted terms [B, terms].
    cost_terms: FloatArray | None
    #: Instances [R] of the rows of positions, final states and gradients.
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
    #: d cost / d actions in their shape, [R, K, C, 3] or [R, K, G, 7]; d cost / d quaternion is
    #: tangent to the sphere of unit quaternions.
    action_gradients: FloatArray | None = None
    #: d cost / d initial positions and velocities, [R, N, 3]. All gradients of an instance that
    #: diverged are NaN.
    initial_position_gradients: FloatArray | None = None
    initial_velocity_gradients: FloatArray | None = None
    #: Norm of d cost / d positions [R, F + 1] by frame.
    gradient_norms: FloatArray | None = None
    #: 1 where a gradient [R] exploded on its way back and is of little use (docs/use/gradients.md).
    gradient_exploded: IndexArray | None = None
    #: Velocities [R, T, K, 3], metres per second.
    velocities: FloatArray | None = None
    #: Weighted terms by frame [R, F + 1, terms]; frame 0 is the start.
    frame_costs: FloatArray | None = None
    #: Control positions as simulated [R, F + 1, C, 3], metres.
    controls: FloatArray | None = None
    #: Final control points [R, C, 3], metres.
    final_controls: FloatArray | None = None
    #: Final control points as commanded, without the stop at the ground [R, C, 3]; with poses.
    final_commanded_controls: FloatArray | None = None
    #: What grasps hold in the final states; None without grasps.
    final_grasping: Grasping | None = None
    #: Costs of the members of an ensemble [B, E]; `costs` are a statistic of them, except for
    #: "mean_prediction".
    member_costs: FloatArray | None = None
    #: Conditions of success (`Cost.success_at_most`) [B]: 1 where all are met, otherwise 0; with an
    #: ensemble the share of members. None without conditions.
    successes: FloatArray | None = None
    #: Root mean square distance of the other members' points from those of member 0 [actions, T,
    #: K], metres. NaN where a member diverged.
    spread: FloatArray | None = None
    #: Forces, if requested.
    forces: Forces | None = None
    #: Implausible instances.
    implausible: list[Implausible] = field(default_factory=list)
    #: Mass of the object; None: unknown, and forces are per unit mass.
    mass_kg: float | None = None
    diagnostics: list[Diagnostics] = field(default_factory=list)
    diverged: list[Divergence] = field(default_factory=list)
    timing: Timing | None = None
    #: workers/{uuid} that computed the result.
    worker: str = ""
    #: Model that computed the result.
    fidelity: Fidelity = "exact"
    #: Simulated substeps per frame.
    substeps: int = 0
    #: Deviation of the fast variant or the planner's twin; None for the exact twin.
    deviation: Deviation | None = None
    #: First and last frame that this part covers, 1-based, with `part_frames`. Arrays by frame have
    #: rows of these frames; the start, frame 0, is in the first part.
    window: tuple[int, int] | None = None
    #: Instances that were not simulated within `time_limit_s`; None without one. Their costs are
    #: +inf, their arrays NaN.
    unfinished: IndexArray | None = None

    def state(self, row: int) -> State:
        """The final state of one of `instances`, from which `twin.rollout(initial=...)`
        continues."""
        return state_of(self.states(), row)

    def states(self) -> State:
        """The final states of all of `instances`, from which as many instances can continue."""
        if self.final_positions is None:
            raise ValueError("ask for final states: Returns(final_state=True)")
        return State(
            positions=self.final_positions,
            velocities=self.final_velocities,
            twists=self.final_twists,
            controls=self.final_controls,
            grasping=self.final_grasping,
            commanded_controls=self.final_commanded_controls,
        )
