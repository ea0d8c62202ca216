"""Costs that the server computes for every instance of a rollout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy.typing as npt

from bendtwin.tensors import pack_floats, pack_indices
from bendtwin.v1 import rollout_pb2

When = Literal["last_frame", "every_frame"]

_WHEN = {
    "last_frame": rollout_pb2.Cost.LAST_FRAME,
    "every_frame": rollout_pb2.Cost.EVERY_FRAME,
}


@dataclass(frozen=True, kw_only=True)
class _Term:
    #: Factor of this term in the sum.
    weight: float = 1.0
    #: After the last frame, or summed over all frames.
    when: When = "last_frame"
    #: Reported under this name; empty means `cost{index}`.
    name: str = ""

    def _base(self) -> rollout_pb2.Cost:
        return rollout_pb2.Cost(name=self.name, weight=self.weight, when=_WHEN[self.when])


@dataclass(frozen=True, kw_only=True)
class TargetCloud(_Term):
    """Mean squared distance [m²] of target points [M, 3] to the nearest surface node."""

    points: npt.ArrayLike

    def to_proto(self) -> rollout_pb2.Cost:
        """Makes the wire form."""
        cost = self._base()
        cost.target_cloud.points.CopyFrom(pack_floats("points", self.points, (None, 3)))
        return cost


@dataclass(frozen=True, kw_only=True)
class Keypoints(_Term):
    """Mean distance [m] between nodes [M] and their targets [M, 3], squared [m²] if asked."""

    nodes: npt.ArrayLike
    targets: npt.ArrayLike
    squared: bool = False

    def to_proto(self) -> rollout_pb2.Cost:
        """Makes the wire form."""
        cost = self._base()
        cost.keypoints.nodes.CopyFrom(pack_indices("nodes", self.nodes))
        cost.keypoints.targets.CopyFrom(pack_floats("targets", self.targets, (None, 3)))
        cost.keypoints.squared = self.squared
        return cost


@dataclass(frozen=True, kw_only=True)
class Smoothness(_Term):
    """Mean squared second difference of node positions over three frames [m²]."""

    def to_proto(self) -> rollout_pb2.Cost:
        """Makes the wire form."""
        cost = self._base()
        cost.smoothness.SetInParent()
        return cost


Cost = TargetCloud | Keypoints | Smoothness
