"""Skin of a twin: points of its surface, finer than its nodes, that the nodes carry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bendtwin.tensors import unpack
from bendtwin.v1 import rollout_pb2, twin_pb2

FloatArray = npt.NDArray[np.floating[Any]]
IndexArray = npt.NDArray[np.uint32]

PointSet = Literal["nodes", "skin"]

POINT_SETS: dict[str, rollout_pb2.PointSet.ValueType] = {
    "nodes": rollout_pb2.NODES,
    "skin": rollout_pb2.SKIN,
}

#: Marks a point that is no observed one, and one whose offset is along the axes of the world.
NONE = np.iinfo(np.uint32).max
#: Shorter edges, metres, give a frame no direction.
_LEAST_M = 1e-12
#: Sine of the angle between a frame's edges up to which its nodes span no triangle.
_LEAST_SINE = 1e-4


@dataclass(frozen=True)
class Skin:
    """M points, carried by nodes with K weights: those of a point follow one another."""

    #: Positions with the nodes at rest [M, 3], metres.
    rest_positions: FloatArray
    #: The capture's observed point for each skin point [M]; `NONE` for no point.
    observed_points: IndexArray
    #: Number of weights of each point [M].
    weight_counts: IndexArray
    #: [K].
    weight_nodes: IndexArray
    #: [K]; the weights of a point sum to 1.
    weights: FloatArray
    #: Nodes a, b, c of the frame of each point [M, 3]; `NONE`: the axes are those of the world.
    frames: IndexArray
    #: Offsets along the axes of the frames [M, 3], metres.
    offsets: FloatArray

    def __len__(self) -> int:
        return len(self.observed_points)

    def positions(self, nodes: npt.ArrayLike) -> FloatArray:
        """Places the points [..., M, 3] where nodes are at [..., N, 3], metres.

        A point is at the weighted sum of its nodes plus its offset along e1, e2 and e3: e1 along
        b - a, e3 along (b - a) x (c - a), e2 = e3 x e1. The offset counts as 0 if a, b, c
        span no triangle.
        """
        x = np.asarray(nodes, dtype=np.float64)
        if x.ndim < 2 or x.shape[-1] != 3:
            raise ValueError(f"nodes has shape {x.shape}, not [..., N, 3]")
        last = self.weight_nodes.max(initial=0)
        if len(self) and last >= x.shape[-2]:
            raise ValueError(f"nodes has {x.shape[-2]} nodes: node {last} carries the skin")
        placed = np.zeros((*x.shape[:-2], len(self), 3))
        if not len(self):
            return placed
        terms = x[..., self.weight_nodes, :] * self.weights[:, None].astype(np.float64)
        starts = np.concatenate([[0], np.cumsum(self.weight_counts)[:-1]]).astype(np.intp)
        placed += np.add.reduceat(terms, starts, axis=-2)
        offsets = self.offsets.astype(np.float64)
        has_offset = (offsets != 0).any(axis=-1)
        has_frame = self.frames[:, 0] != NONE
        placed += np.where((has_offset & ~has_frame)[:, None], offsets, 0.0)
        framed = np.flatnonzero(has_offset & has_frame)
        if framed.size:
            axes = _axes(x[..., self.frames[framed], :])
            placed[..., framed, :] += np.einsum("...mki,mk->...mi", axes, offsets[framed])
        return placed

    @classmethod
    def from_proto(cls, message: twin_pb2.TwinGeometry.Skin) -> Skin:
        """Reads the wire form."""

        def array(name: str, empty: npt.NDArray[Any]) -> Any:
            value = unpack(getattr(message, name))
            return empty if value is None else value

        indices, floats = np.zeros(0, np.uint32), np.zeros(0, np.float32)
        return cls(
            rest_positions=array("rest_positions", floats.reshape(0, 3)),
            observed_points=array("observed_points", indices),
            weight_counts=array("weight_counts", indices),
            weight_nodes=array("weight_nodes", indices),
            weights=array("weights", floats),
            frames=array("frames", indices.reshape(0, 3)),
            offsets=array("offsets", floats.reshape(0, 3)),
        )


def _axes(corners: FloatArray) -> FloatArray:
    """Axes [..., 3, 3] of frames of nodes a, b, c [..., 3, 3]; zeros where there are none."""
    along = corners[..., 1, :] - corners[..., 0, :]
    other = corners[..., 2, :] - corners[..., 0, :]
    normal = np.cross(along, other)
    lengths = [np.linalg.norm(v, axis=-1, keepdims=True) for v in (along, normal, other)]
    is_frame = (lengths[0] > _LEAST_M) & (lengths[1] > _LEAST_SINE * lengths[0] * lengths[2])
    with np.errstate(divide="ignore", invalid="ignore"):
        e1, e3 = along / lengths[0], normal / lengths[1]
        axes = np.stack([e1, np.cross(e3, e1), e3], axis=-2)
    return np.where(is_frame[..., None], axes, 0.0)
