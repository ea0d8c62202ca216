"""Costs that the server computes for every instance of a rollout."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from bendtwin.simulation.world import Cuboid, Plane
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

    def to_proto(self) -> rollout_pb2.Cost:
        """Makes the wire form."""
        cost = rollout_pb2.Cost(
            name=self.name,
            weight=self.weight,
            when=_WHEN[self.when],
            temperature=self.temperature,
        )
        self._describe(cost)
        return cost

    @abstractmethod
    def _describe(self, cost: rollout_pb2.Cost) -> None:
        """Writes what is measured."""


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
        if (self.nodes is None) == (self.skin_points is None):
            raise ValueError("give keypoints either nodes or skin_points")
        if self.nodes is not None:
            cost.keypoints.nodes.CopyFrom(pack_indices("nodes", self.nodes))
        if self.skin_points is not None:
            points = pack_indices("skin_points", self.skin_points)
            cost.keypoints.skin_points.CopyFrom(points)
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
