"""The surroundings of an object in a rollout: ground, gravity, colliders, grasps, and parameters.

Shapes are in metres, in the coordinates of their carrier; poses are x, y, z and a quaternion
x, y, z, w.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bendtwin.tensors import pack_floats, pack_indices
from bendtwin.v1 import rollout_pb2, tensor_pb2, world_pb2

Statistic = Literal["mean", "worst", "cvar", "mean_prediction"]

_STATISTICS: dict[str, rollout_pb2.Ensemble.Statistic.ValueType] = {
    "mean": rollout_pb2.Ensemble.MEAN,
    "worst": rollout_pb2.Ensemble.WORST,
    "cvar": rollout_pb2.Ensemble.CVAR,
    "mean_prediction": rollout_pb2.Ensemble.MEAN_PREDICTION,
}
_ATTACHMENTS: dict[str, world_pb2.Grasp.Attachment.ValueType] = {
    "pin": world_pb2.Grasp.PIN,
    "springs": world_pb2.Grasp.SPRINGS,
}


@dataclass(frozen=True)
class Sphere:
    """A ball, as a collider or as the region of a grasp."""

    radius_m: float
    center: npt.ArrayLike = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Capsule:
    """Points nearer than the radius to the segment between two points [3]."""

    start: npt.ArrayLike
    end: npt.ArrayLike
    radius_m: float


@dataclass(frozen=True)
class Cuboid:
    """An axis-aligned box, from its lowest to its highest corner [3]."""

    low: npt.ArrayLike
    high: npt.ArrayLike

    def to_proto(self) -> world_pb2.Cuboid:
        """Makes the wire form."""
        low, high = numbers("low", self.low, 3), numbers("high", self.high, 3)
        return world_pb2.Cuboid(low=low, high=high)


@dataclass(frozen=True)
class ConvexMesh:
    """The convex hull of points [M, 3]; it has at most 128 faces."""

    points: npt.ArrayLike


Shape = Sphere | Capsule | Cuboid | ConvexMesh


@dataclass(frozen=True, kw_only=True)
class Collider:
    """A rigid obstacle that nodes cannot enter. It is static, unless a gripper carries it or it
    follows a path."""

    shape: Shape
    #: Coulomb friction, 0..2, and restitution, 0..1.
    friction: float = 0.5
    restitution: float = 0.0
    #: Distance that nodes keep: about the radius of a cable, or half the node spacing.
    margin_m: float = 0.0
    #: The gripper that carries it, by its number in the poses.
    gripper: int | None = None
    #: Poses at the knots of the actions, [K, 7], for all instances.
    path: npt.ArrayLike | None = None
    #: Pose of the shape on its carrier, [7].
    pose: npt.ArrayLike | None = None
    #: Name in results; empty means `collider{index}`.
    name: str = ""

    def to_proto(self) -> world_pb2.Collider:
        """Makes the wire form."""
        message = world_pb2.Collider(
            name=self.name,
            friction=self.friction,
            restitution=self.restitution,
            margin_m=self.margin_m,
        )
        shape = self.shape
        if isinstance(shape, Sphere):
            message.sphere.CopyFrom(_sphere(shape))
        elif isinstance(shape, Capsule):
            start, end = numbers("start", shape.start, 3), numbers("end", shape.end, 3)
            # `from` is a word of Python.
            capsule = world_pb2.Capsule(to=end, radius_m=shape.radius_m)
            getattr(capsule, "from").extend(start)
            message.capsule.CopyFrom(capsule)
        elif isinstance(shape, Cuboid):
            message.cuboid.CopyFrom(shape.to_proto())
        else:
            points = pack_floats("points", shape.points, (None, 3))
            message.convex_mesh.points.CopyFrom(points)
        if self.gripper is not None and self.path is not None:
            raise ValueError("give a collider either a gripper or a path, not both")
        if self.gripper is not None:
            message.gripper = self.gripper
        if self.path is not None:
            message.path.CopyFrom(pack_floats("path", self.path, (None, 7)))
        if self.pose is not None:
            message.pose.extend(numbers("pose", self.pose, 7))
        return message


@dataclass(frozen=True)
class Plane:
    """A ground: points with `normal . x >= offset_m` are above it."""

    offset_m: float = 0.0
    #: Unit normal, pointing away from the ground.
    normal: npt.ArrayLike = (0.0, 0.0, 1.0)

    def to_proto(self) -> world_pb2.Plane:
        """Makes the wire form."""
        normal = numbers("normal", self.normal, 3)
        return world_pb2.Plane(normal=normal, offset_m=self.offset_m)


@dataclass(frozen=True, kw_only=True)
class World:
    """Surroundings of the object. Fields that are left out are as in the twin."""

    colliders: Sequence[Collider] = ()
    #: [3], m/s².
    gravity: npt.ArrayLike | None = None
    #: A plane, "none", or None for the twin's ground.
    ground: Plane | Literal["none"] | None = None
    ground_friction: float | None = None
    ground_restitution: float | None = None

    def to_proto(self) -> world_pb2.World:
        """Makes the wire form."""
        message = world_pb2.World(
            colliders=[collider.to_proto() for collider in self.colliders],
            ground_friction=self.ground_friction,
            ground_restitution=self.ground_restitution,
        )
        if self.gravity is not None:
            message.gravity.extend(numbers("gravity", self.gravity, 3))
        if isinstance(self.ground, Plane):
            message.ground.CopyFrom(self.ground.to_proto())
        elif self.ground is not None:
            message.no_ground = True
        return message


@dataclass(frozen=True, kw_only=True)
class Grasp:
    """A hold of a gripper on the object: on what lies in a region when it closes, on nodes, or on
    the twin's own control points of a hand of its capture.

    Control points hold as they were fitted unless a grasp of their hand is open. To take hold
    elsewhere, add `Grasp(hand=0, closed=False)`.

    On a cable a grasp of two neighbouring nodes is a clamp: it gives the cable its direction
    there and turns it. The cable is twisted between the outermost two clamps; an end that nothing
    holds turns freely.
    """

    #: The gripper, by its number in the poses.
    gripper: int = 0
    #: In the coordinates of the gripper.
    region: Sphere | Cuboid | None = None
    nodes: npt.ArrayLike | None = None
    hand: int | None = None
    #: "pin": nodes move with the gripper exactly.
    attachment: Literal["pin", "springs"] = "pin"
    #: Of springs: newtons per metre and node; 0 chooses what the twin's substeps allow.
    stiffness: float = 0.0
    #: Newton seconds per metre; 0 chooses critical damping.
    damping: float = 0.0
    #: Whether it is closed from each knot of the actions on, [K] or [B, K], or from first to last.
    closed: npt.ArrayLike = True
    #: Mean force over a frame beyond which it lets go; None: never.
    max_force_n: float | None = None

    def to_proto(self) -> world_pb2.Grasp:
        """Makes the wire form."""
        message = world_pb2.Grasp(
            gripper=self.gripper,
            attachment=_ATTACHMENTS[self.attachment],
            stiffness=self.stiffness,
            damping=self.damping,
            max_force_n=self.max_force_n,
        )
        if sum(x is not None for x in (self.region, self.nodes, self.hand)) != 1:
            raise ValueError("give a grasp one of region, nodes and hand")
        if isinstance(self.region, Sphere):
            message.sphere.CopyFrom(_sphere(self.region))
        elif isinstance(self.region, Cuboid):
            message.cuboid.CopyFrom(self.region.to_proto())
        if self.nodes is not None:
            message.nodes.CopyFrom(pack_indices("nodes", self.nodes))
        if self.hand is not None:
            message.hand.hand = self.hand
        if self.closed is not True:
            message.closed.CopyFrom(_pack_closed(self.closed))
        return message


@dataclass(frozen=True, kw_only=True)
class Vary:
    """Parameters as factors of the twin's own: [B], or [E] with an ensemble. None: 1.

    An instance that is too stiff for the twin's substeps gets more, and takes as much longer.
    """

    #: Axial, 0.01..100.
    stiffness: npt.ArrayLike | None = None
    #: Of dashpots, drag, and damping of bending and twist, 0..100.
    damping: npt.ArrayLike | None = None
    #: Stiffness of bending and twist, 0..100.
    bending: npt.ArrayLike | None = None
    #: With ground, colliders and other nodes, 0..100.
    friction: npt.ArrayLike | None = None
    #: Of all nodes, 0.01..100.
    mass: npt.ArrayLike | None = None
    #: No factor: of the ground, 0..1, in the place of the twin's and the world's.
    ground_restitution: npt.ArrayLike | None = None
    #: No factor: between nodes, 0..1, in the place of the twin's.
    object_restitution: npt.ArrayLike | None = None
    #: Member e of the ensemble is simulated on fit e of the twin, 0 being the twin itself: at most
    #: `TwinGeometry.fits` of them.
    fits: bool = False

    @property
    def factors(self) -> dict[str, npt.NDArray[np.float64]]:
        """The factors that are given, by name."""
        given = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "fits"}
        return {name: np.asarray(v, dtype=np.float64) for name, v in given.items() if v is not None}

    @property
    def is_of_one(self) -> bool:
        """True if it has one factor a parameter, of the twin itself."""
        return not self.fits and all(factor.shape == (1,) for factor in self.factors.values())

    def of(self, rows: Sequence[int]) -> Vary:
        """The factors of some instances; a single one is that of all."""
        chosen: Any = {k: v[np.minimum(rows, len(v) - 1)] for k, v in self.factors.items()}
        return replace(self, **chosen)

    def to_proto(self) -> world_pb2.Vary:
        """Makes the wire form."""
        message = world_pb2.Vary(fits=self.fits)
        for name, values in self.factors.items():
            getattr(message, name).CopyFrom(pack_floats(name, values, (None,)))
        return message


@dataclass(frozen=True)
class Ensemble:
    """Simulates every action under the sets of parameters of a `Vary`; its cost is a statistic of
    theirs, or that of their mean motion."""

    members: int
    #: With "mean_prediction" costs, gradients and arrays are those of the mean motion of the
    #: members, one row for each action: members of `Vary(fits=True)` have the weight one over the
    #: square of the loss of their fits, others equal weights, and a member that diverges is left
    #: out.
    statistic: Statistic = "mean"
    #: Share of the worst members that "cvar" averages.
    share: float = 0.0

    def to_proto(self) -> rollout_pb2.Ensemble:
        """Makes the wire form."""
        return rollout_pb2.Ensemble(
            members=self.members, statistic=_STATISTICS[self.statistic], share=self.share
        )


@dataclass(frozen=True, kw_only=True)
class GradientOptions:
    """The reach of gradients, and the smoothing of contact."""

    #: Frames that a gradient reaches back; 0 for all. Where the object lies on something, 15 is a
    #: good start.
    reach_frames: int = 0
    #: Width of the layer in which ground and colliders act [m], in the gradients' simulation and
    #: the costs that come with them; 0 for impacts. 0.001 is a good start.
    smoothing_m: float = 0.0

    def to_proto(self) -> rollout_pb2.GradientOptions:
        """Makes the wire form."""
        return rollout_pb2.GradientOptions(
            reach_frames=self.reach_frames, smoothing_m=self.smoothing_m
        )


@dataclass(frozen=True, kw_only=True)
class Plausibility:
    """Limits beyond which instances are `RolloutResult.implausible`. None: the default."""

    #: Distance between the initial state's control points and row 0 of the actions; 0.005.
    start_gap_m: float | None = None
    #: Speed of the fastest control point; 5.
    control_speed_m_s: float | None = None
    #: Strain of the material; 1. Plans beyond it are worse than all within; `float("inf")` lifts
    #: it.
    strain: float | None = None
    #: Depth of control points and grasps in the ground or static colliders, for control points
    #: beyond their depth in the initial state; 0.005. Hands and grippers stop at this depth in the
    #: ground.
    control_depth_m: float | None = None
    #: Mean force of a grasp over a frame, newtons; per unit mass without a `mass_kg`. No limit by
    #: default. Plans beyond it are worse than all within.
    grasp_force_n: float | None = None
    #: Raises an error with the reason IMPLAUSIBLE_MOTION instead.
    refuse: bool = False

    def to_proto(self) -> rollout_pb2.Plausibility:
        """Makes the wire form."""
        return rollout_pb2.Plausibility(
            start_gap_m=self.start_gap_m,
            control_speed_m_s=self.control_speed_m_s,
            strain=self.strain,
            control_depth_m=self.control_depth_m,
            grasp_force_n=self.grasp_force_n,
            refuse=self.refuse,
        )


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """The parts of a request other than actions, state, costs and returns."""

    world: World | None = None
    grasps: Sequence[Grasp] = ()
    vary: Vary | None = None
    ensemble: Ensemble | None = None
    gradient: GradientOptions | None = None
    plausibility: Plausibility | None = None

    def add_to(self, request: rollout_pb2.RollOutRequest) -> None:
        """Sets the fields of a request."""
        if self.world is not None:
            request.world.CopyFrom(self.world.to_proto())
        request.grasps.extend(grasp.to_proto() for grasp in self.grasps)
        if self.vary is not None:
            request.vary.CopyFrom(self.vary.to_proto())
        if self.ensemble is not None:
            request.ensemble.CopyFrom(self.ensemble.to_proto())
        if self.gradient is not None:
            request.gradient.CopyFrom(self.gradient.to_proto())
        if self.plausibility is not None:
            request.plausibility.CopyFrom(self.plausibility.to_proto())


def _sphere(sphere: Sphere) -> world_pb2.Sphere:
    center = numbers("center", sphere.center, 3)
    return world_pb2.Sphere(center=center, radius_m=sphere.radius_m)


def numbers(name: str, values: npt.ArrayLike, count: int) -> list[float]:
    """A vector of `count` finite numbers in wire form."""
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (count,):
        raise ValueError(f"{name} has shape {array.shape}, not [{count}]")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} has values that are not finite: check the input for NaN")
    return [float(x) for x in array]


def _pack_closed(closed: npt.ArrayLike) -> tensor_pb2.Tensor:
    array = np.atleast_1d(closed)
    if array.ndim not in (1, 2) or not np.isin(array, (0, 1)).all():
        raise ValueError(f"closed has shape {array.shape}, not [K] or [B, K], or is not 0 or 1")
    data = array.astype("<u4").tobytes()
    return tensor_pb2.Tensor(dtype=tensor_pb2.Tensor.UINT32, shape=array.shape, data=data)
