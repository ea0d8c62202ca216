"""Costs that the server computes for every instance of a rollout."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from bendtwin.simulation.world import Cuboid, Plane, numbers
from bendtwin.skin import POINT_SETS, PointSet
from bendtwin.tensors import pack_floats, pack_indices
from bendtwin.v1 import rollout_pb2, tensor_pb2

When = Literal["last_frame", "every_frame", "soft_min"]

_LEVEL = Plane()
_WHEN = {
    "last_frame": rollout_pb2.Cost.LAST_FRAME,
    "every_frame": rollout_pb2.Cost.EVERY_FRAME,
    "soft_min": rollout_pb2.Cost.SOFT_MIN,
}


@dataclass(frozen=True, kw_only=True)
class Cost(ABC):
    """A term of the sum that scores an instance."""

    #: Factor of this term in the sum; 0 switches it off, a negative factor rewards it.
    weight: float = 1.0
    #: Counted after the last frame, summed over all frames, or low if it is low in any frame.
    when: When = "last_frame"
    #: Temperature of "soft_min": the difference of costs, in their unit, at which a frame counts
    #: for clearly less.
    temperature: float = 0.0
    #: Name in results; empty means `cost{index}`.
    name: str = ""
    #: Condition of success: the value after the last frame, without the weight and regardless of
    #: `when`, is at most this. `RolloutResult.successes` has the instances that meet the conditions
    #: of all costs that have one. With `weight=0` a cost is only a condition. Not for `Force`,
    #: `Smoothness`, `ControlPath` and `ControlSpeed`.
    success_at_most: float | None = None

    def to_proto(self) -> rollout_pb2.Cost:
        """Makes the wire form."""
        cost = rollout_pb2.Cost(
            name=self.name,
            weight=self.weight,
            when=_WHEN[self.when],
            temperature=self.temperature,
            success_at_most=self.success_at_most,
        )
        self._describe(cost)
        return cost

    @abstractmethod
    def _describe(self, cost: rollout_pb2.Cost) -> None:
        """Writes what is measured."""


def _points(
    kind: rollout_pb2.Cost.Keypoints | rollout_pb2.Cost.Order | rollout_pb2.Cost.Winding,
    nodes: npt.ArrayLike | None,
    skin_points: npt.ArrayLike | None,
) -> None:
    """Writes the points that a cost names: nodes, or points of the skin."""
    if (nodes is None) == (skin_points is None):
        raise ValueError("give a cost of points either nodes or skin_points")
    if nodes is not None:
        kind.nodes.CopyFrom(pack_indices("nodes", nodes))
    if skin_points is not None:
        kind.skin_points.CopyFrom(pack_indices("skin_points", skin_points))


def _targets(name: str, values: npt.ArrayLike) -> tensor_pb2.Tensor:
    """Targets [M, 3] for all, [F, M, 3] by frame, [B, 1, M, 3] by instance or [B, F, M, 3]."""
    dimensions = np.ndim(values)
    if dimensions not in (2, 3, 4):
        raise ValueError(
            f"{name} has {dimensions} dimensions, not [M, 3], [F, M, 3], [B, 1, M, 3] "
            "or [B, F, M, 3]"
        )
    return pack_floats(name, values, (None,) * (dimensions - 1) + (3,))


@dataclass(frozen=True, kw_only=True)
class TargetCloud(Cost):
    """Mean squared distance [m²] of target points to the nearest point of the twin's surface.

    Points are [M, 3] for all instances and frames, [F, M, 3] by frame (with `when` "every_frame"
    or "soft_min"), or [B, 1, M, 3] or [B, F, M, 3] by instance.
    """

    points: npt.ArrayLike
    #: Points of the surface: the skin, or the surface nodes.
    point_set: PointSet = "skin"

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        cost.target_cloud.point_set = POINT_SETS[self.point_set]
        cost.target_cloud.points.CopyFrom(_targets("points", self.points))


@dataclass(frozen=True, kw_only=True)
class Keypoints(Cost):
    """Mean distance [m] between nodes [M], or points of the skin, and their targets, optionally
    squared [m²].

    Targets have a shape of `TargetCloud.points`.
    """

    #: Nodes; give these or `skin_points`.
    nodes: npt.ArrayLike | None = None
    targets: npt.ArrayLike
    squared: bool = False
    #: Points of the skin: `Geometry.skin`.
    skin_points: npt.ArrayLike | None = None

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        _points(cost.keypoints, self.nodes, self.skin_points)
        cost.keypoints.targets.CopyFrom(_targets("targets", self.targets))
        cost.keypoints.squared = self.squared


@dataclass(frozen=True, kw_only=True)
class Smoothness(Cost):
    """Mean squared second difference of node positions over three frames [m²]."""

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        cost.smoothness.SetInParent()


@dataclass(frozen=True, kw_only=True)
class Strain(Cost):
    """Mean over the springs of the material of max(0, |strain| - limit)²."""

    limit: float = 0.0

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        cost.strain.limit = self.limit
        cost.strain.SetInParent()


@dataclass(frozen=True, kw_only=True)
class Force(Cost):
    """max(0, |f| - limit)² [N²] of the mean force f on the object over a frame.

    Without the object's mass, forces are per unit mass: see `RolloutResult.mass_kg`.
    """

    #: All control points together, the ground, or ("control" | "grasp" | "collider", number).
    by: Literal["controls", "ground"] | tuple[Literal["control", "grasp", "collider"], int]
    limit_n: float = 0.0

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        cost.force.limit_n = self.limit_n
        if isinstance(self.by, str):
            getattr(cost.force, self.by).SetInParent()
        else:
            kind, number = self.by
            setattr(cost.force, kind, number)


@dataclass(frozen=True, kw_only=True)
class Height(Cost):
    """Mean over nodes of the squared depth [m²] below a plane; level by default."""

    #: The plane; nodes above it, on the side of its normal, cost nothing.
    plane: Plane = _LEVEL
    #: Indices [M]; None means all.
    nodes: npt.ArrayLike | None = None

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        cost.height.plane.CopyFrom(self.plane.to_proto())
        if self.nodes is not None:
            cost.height.nodes.CopyFrom(pack_indices("nodes", self.nodes))


@dataclass(frozen=True, kw_only=True)
class Within(Cost):
    """Mean over nodes of the squared distance [m²] to an axis-aligned box, zero inside."""

    cuboid: Cuboid
    #: Indices [M]; None means all.
    nodes: npt.ArrayLike | None = None

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        cost.within.cuboid.CopyFrom(self.cuboid.to_proto())
        if self.nodes is not None:
            cost.within.nodes.CopyFrom(pack_indices("nodes", self.nodes))


@dataclass(frozen=True, kw_only=True)
class Clearance(Cost):
    """Mean over nodes of max(0, margin - distance)² [m²] to a collider of the rollout's world."""

    collider: int
    margin_m: float

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        cost.clearance.collider = self.collider
        cost.clearance.margin_m = self.margin_m


@dataclass(frozen=True, kw_only=True)
class ControlPath(Cost):
    """Path length [m] of the control points, mean over them; `when` has no effect."""

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        cost.control_path.SetInParent()


@dataclass(frozen=True, kw_only=True)
class ControlSpeed(Cost):
    """Mean over control points and frames of max(0, speed - limit)² [m²/s²]; `when` has no
    effect."""

    limit_m_s: float = 0.0

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        cost.control_speed.limit_m_s = self.limit_m_s
        cost.control_speed.SetInParent()


@dataclass(frozen=True, kw_only=True)
class Order(Cost):
    """Order of points along a direction, 0 if each is at least `gap_m` ahead of the one before it.

    Mean over neighbours in the list of max(0, gap - direction · (x(next) - x))² [m²].
    """

    #: Nodes [M] in their wanted order; give these or `skin_points`.
    nodes: npt.ArrayLike | None = None
    #: Unit vector [3].
    direction: npt.ArrayLike
    gap_m: float = 0.0
    #: Points of the skin: `Geometry.skin`.
    skin_points: npt.ArrayLike | None = None

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        _points(cost.order, self.nodes, self.skin_points)
        cost.order.direction.extend(numbers("direction", self.direction, 3))
        cost.order.gap_m = self.gap_m


@dataclass(frozen=True, kw_only=True)
class Winding(Cost):
    """(turns - wanted turns)² of a chain of points around a straight line.

    The turns are the sum of the angles from each point to the next as seen along the line, over 2π.
    Angles are within half a turn, so neighbours must not be farther apart around the line. The
    gradient turns the first and the last point around the line, and is zero between.
    """

    #: Nodes [M] in the order of the chain; give these or `skin_points`.
    nodes: npt.ArrayLike | None = None
    #: Wanted turns, -100..100; positive is counter-clockwise seen against the line's direction.
    turns: float
    #: The line: a point [3], metres, and a unit vector [3]. Give it or `collider`.
    axis: tuple[npt.ArrayLike, npt.ArrayLike] | None = None
    #: Number of a fixed capsule of the rollout's world: its axis, from its first end to its second.
    collider: int | None = None
    #: Points of the skin: `Geometry.skin`.
    skin_points: npt.ArrayLike | None = None

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        if (self.axis is None) == (self.collider is None):
            raise ValueError("give a winding either an axis or a collider")
        _points(cost.winding, self.nodes, self.skin_points)
        if self.axis is not None:
            point, direction = self.axis
            cost.winding.axis.point.extend(numbers("point", point, 3))
            cost.winding.axis.direction.extend(numbers("direction", direction, 3))
        if self.collider is not None:
            cost.winding.collider = self.collider
        cost.winding.turns = self.turns


@dataclass(frozen=True, kw_only=True)
class Coverage(Cost):
    """Uncovered share of points [M, 3], 0..1.

    Mean over the points of 1 - exp(-d² / (2 reach²)), with the distance d to the nearest point of
    the twin's surface.
    """

    points: npt.ArrayLike
    #: Distance at which a point counts as 39 % uncovered; about half the spacing of the surface's
    #: points, or more for a gradient from afar.
    reach_m: float
    #: Points of the surface: the skin, or the surface nodes.
    point_set: PointSet = "skin"

    def _describe(self, cost: rollout_pb2.Cost) -> None:
        cost.coverage.points.CopyFrom(pack_floats("points", self.points, (None, 3)))
        cost.coverage.reach_m = self.reach_m
        cost.coverage.point_set = POINT_SETS[self.point_set]
