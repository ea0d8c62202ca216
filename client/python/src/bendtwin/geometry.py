"""Geometry of a twin: the points that the arrays of its rollouts refer to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.simulation.state import State
from bendtwin.simulation.world import Grasp
from bendtwin.skin import Skin
from bendtwin.tensors import unpack
from bendtwin.v1 import twin_pb2

FloatArray = npt.NDArray[np.floating[Any]]
IndexArray = npt.NDArray[np.uint32]


@dataclass(frozen=True)
class Ground:
    """Points with normal . x >= offset_m are above the ground."""

    normal: FloatArray
    offset_m: float
    friction: float
    restitution: float


@dataclass(frozen=True)
class Geometry:
    """Nodes, springs, control points and surroundings of a twin; N nodes, C control points."""

    #: The rest shape [N, 3], metres.
    rest_positions: FloatArray
    #: 0 observed surface, 1 completed surface, 2 interior, [N]. Surface nodes come first.
    kinds: npt.NDArray[np.uint8]
    #: Springs between endpoints [E, 2]; from N on these are control points.
    edges: IndexArray
    #: [E], metres.
    rest_lengths: FloatArray
    #: Bending triplets [T, 3], the centre in the middle.
    triplets: IndexArray
    #: Stiffness [E], newtons per unit strain if `mass_kg` is known, otherwise per unit mass.
    spring_stiffness: FloatArray
    #: Bending stiffness [T], newton metres per radian, or per unit mass.
    bend_stiffness: FloatArray
    #: Masses [N], kilograms if `mass_kg` is known, otherwise relative to one node.
    masses: FloatArray
    #: Control points at rest [C, 3], metres.
    controls: FloatArray
    #: The capture's hand of each control point [C].
    hands: IndexArray
    #: Nodes pinned to control points, as pairs of node and control point [P, 2].
    pins: IndexArray
    #: Nodes of each rod.
    rods: list[IndexArray]
    #: Nodes 0..surface_count are surface.
    surface_count: int
    #: Frames per second.
    fps: float
    #: Substeps per frame.
    substeps: int
    #: Gravity [3], metres per square second.
    gravity: FloatArray
    #: The ground; None: no ground.
    ground: Ground | None
    #: Mass of the object; None: unknown, and forces are per unit mass.
    mass_kg: float | None
    #: Mean length of springs between nodes, metres.
    spacing_m: float
    #: Points of the surface that the nodes carry.
    skin: Skin
    #: Number of fits: the twin and its members (`Vary(fits=True)`).
    fits: int = 1
    #: The region of each node, as index into the regions of `Twin.identifiability` [N]; None
    #: without such a report.
    node_regions: npt.NDArray[np.uint8] | None = None
    #: Standard deviation of each skin point that the recordings leave [M], metres, over the motions
    #: of that report; None without one.
    skin_sd: FloatArray | None = None

    @property
    def hand_count(self) -> int:
        """Number of hands."""
        return int(self.hands.max()) + 1 if self.hands.size else 0

    def released(self, state: State | None = None) -> dict[str, Any]:
        """Arguments of a rollout in which nothing holds the object, so that it drops: from a state,
        or [B] of them, or by default from the rollout's initial state.

        `twin.rollout(**geometry.released(state), frames=30)`
        """
        is_batch = state is not None and np.ndim(state.positions) == 3
        count = len(np.asarray(state.positions)) if state is not None and is_batch else 1
        poses = np.tile(np.array([0, 0, 0, 0, 0, 0, 1], np.float32), (count, 2, 1, 1))
        hands = [Grasp(hand=hand, closed=False) for hand in range(self.hand_count)]
        start = {} if state is None else {"initial": replace(state, grasping=None)}
        return {"poses": poses, "grasps": hands, **start}

    @classmethod
    def from_proto(cls, message: twin_pb2.TwinGeometry) -> Geometry:
        """Reads the wire form."""
        starts, nodes = _array(message.rod_starts), _array(message.rod_nodes)
        ground = None
        if message.HasField("ground"):
            ground = Ground(
                normal=np.array(message.ground.normal or (0.0, 0.0, 1.0)),
                offset_m=message.ground.offset_m,
                friction=message.ground_friction,
                restitution=message.ground_restitution,
            )
        names = (
            "rest_positions",
            "kinds",
            "edges",
            "rest_lengths",
            "triplets",
            "spring_stiffness",
            "bend_stiffness",
            "masses",
            "controls",
            "hands",
            "pins",
        )
        return cls(
            **{name: _array(getattr(message, name)) for name in names},
            rods=[nodes[a:b] for a, b in pairwise(starts)],
            surface_count=message.surface_count,
            fps=message.fps,
            substeps=message.substeps,
            gravity=np.array(message.gravity),
            ground=ground,
            mass_kg=message.mass_kg if message.HasField("mass_kg") else None,
            spacing_m=message.spacing_m,
            skin=Skin.from_proto(message.skin),
            fits=max(message.fits, 1),
            node_regions=_array_or_none(message.node_regions),
            skin_sd=_array_or_none(message.skin_sd),
        )


def _array_or_none(tensor: Any) -> Any:
    array = unpack(tensor)
    return None if array is None or array.size == 0 else array


def _array(tensor: Any) -> Any:
    array = unpack(tensor)
    return np.zeros(0, np.uint32) if array is None else array
