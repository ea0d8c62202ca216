"""Surface of a twin: triangles that the nodes carry, or tubes along cables, to be looked at."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.skin import Skin
from bendtwin.tensors import unpack
from bendtwin.v1 import twin_pb2

FloatArray = npt.NDArray[np.floating[Any]]
IndexArray = npt.NDArray[np.uint32]


@dataclass(frozen=True)
class Tube:
    """A tube along nodes."""

    #: Nodes, at least two; of a closed tube the last is the first.
    nodes: IndexArray
    #: Metres.
    radius: float


@dataclass(frozen=True)
class Surface:
    """A closed mesh of V vertices around the object, or tubes along its cables."""

    #: The vertices, carried as points of the skin are: `carriers.positions(nodes)` is [..., V, 3].
    carriers: Skin
    #: Corners of the triangles, counter-clockwise seen from outside [F, 3].
    triangles: IndexArray
    #: Colours as in images (sRGB) [V, 3]; None: unknown.
    colors: npt.NDArray[np.uint8] | None
    #: Tubes, in a twin of a cable.
    tubes: list[Tube]

    def positions(self, nodes: npt.ArrayLike) -> FloatArray:
        """Places the vertices of the mesh [..., V, 3] where nodes are at [..., N, 3], metres."""
        return self.carriers.positions(nodes)

    @classmethod
    def from_proto(cls, message: twin_pb2.TwinSurface) -> Surface:
        """Reads the wire form."""

        def array(tensor: Any, empty: npt.NDArray[Any]) -> Any:
            value = unpack(tensor)
            return empty if value is None else value

        none = np.zeros(0, np.uint32)
        colors = array(message.colors, np.zeros((0, 3), np.uint8))
        starts, nodes = array(message.tube_starts, none), array(message.tube_nodes, none)
        radii = array(message.tube_radii, none.astype(np.float32))
        along = [nodes[a:b] for a, b in pairwise(starts)]
        return cls(
            carriers=Skin.from_proto(message.carriers),
            triangles=array(message.triangles, none.reshape(0, 3)),
            colors=None if colors.size == 0 else colors,
            tubes=[Tube(n, float(radius)) for n, radius in zip(along, radii, strict=True)],
        )
