"""The object of a twin as tasks see it: its size, its ends, and places to grasp it.

Tasks are made for any twin, so they ask here for "the tip" or "the middle" in place of node
numbers, and measure in lengths of the object in place of metres.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.geometry import Geometry
from bendtwin.simulation.rollout import Returns
from bendtwin.simulation.state import State
from bendtwin.simulation.world import Plane, World
from bendtwin.twin import Twin

Array = npt.NDArray[np.floating[Any]]
Indices = npt.NDArray[np.int64]

#: Speed of the fastest node below which an object is at rest, metres per second.
_REST_M_S = 0.01
#: Frames of a settling object that are simulated between two looks at it, and in total, seconds.
_LOOK_S, _LONGEST_S = 1.0, 12.0
#: Cosine of the slope up to which a ground is level.
_LEVEL = 0.9999
#: Ratio of length to width from which an object is elongated.
_ELONGATED = 2.5
#: Stretches by whose means the line of an object is found.
_STRETCHES = 8


@dataclass(frozen=True)
class Body:
    """An object at rest on the ground, held by nothing.

    Places along the object are numbers from 0, its tip, to 1, its other end. The ends are the two
    nodes farthest apart along its springs; the tip is the one farther from the recorded hands.
    """

    geometry: Geometry
    #: At rest, without velocities.
    state: State
    #: Height of the ground below the object, metres.
    ground_m: float
    #: True if the ground is level, so that the object may be turned and moved on it.
    is_level: bool

    @classmethod
    def of(cls, twin: Twin) -> Body:
        """The object of a twin, after it has dropped from its rest shape and lies still.

        A twin without a ground gets a level one below its lowest node.

        Raises:
            ValueError: If the object does not come to rest.
        """
        geometry = twin.geometry()
        world = world_of(geometry)
        frames = max(1, round(_LOOK_S * geometry.fps))
        state: State | None = None
        for _ in range(round(_LONGEST_S / _LOOK_S)):
            result = twin.rollout(
                **geometry.released(state),
                frames=frames,
                world=world,
                returns=Returns(final_state=True),
            )
            state = result.state(0)
            if np.linalg.norm(np.asarray(state.velocities), axis=1).max() < _REST_M_S:
                return cls.at_rest(geometry, state)
        raise ValueError(
            f"the object moves {_LONGEST_S:.0f} s after it was dropped: give `body`, made with "
            "`Body.at_rest` from a state in which it lies still"
        )

    @classmethod
    def at_rest(cls, geometry: Geometry, state: State) -> Body:
        """The object in a state, whose velocities are set to 0."""
        positions = np.asarray(state.positions, np.float32)
        lying = State(
            positions=positions,
            velocities=np.zeros_like(positions),
            twists=None if state.twists is None else np.asarray(state.twists, np.float32),
            controls=np.asarray(geometry.controls, np.float32),
        )
        ground = geometry.ground
        if ground is None:
            return cls(geometry, lying, float(geometry.rest_positions[:, 2].min()), True)
        normal = np.asarray(ground.normal, float)
        middle = positions.mean(axis=0)
        below = (ground.offset_m - normal[:2] @ middle[:2]) / normal[2]
        return cls(geometry, lying, float(below), bool(normal[2] >= _LEVEL))

    @cached_property
    def positions(self) -> Array:
        """Nodes at rest [N, 3], metres."""
        return np.asarray(self.state.positions, np.float64)

    @cached_property
    def middle(self) -> Array:
        """The mean of the nodes on the ground [3], metres."""
        return np.array([*self.positions[:, :2].mean(axis=0), self.ground_m])

    @cached_property
    def is_cable(self) -> bool:
        """True if the object is a cable."""
        return bool(self.geometry.rods)

    @cached_property
    def spacing_m(self) -> float:
        """Mean length of the springs between nodes, metres."""
        return float(self.geometry.spacing_m)

    @cached_property
    def _paths(self) -> tuple[Array, Array]:
        """Distances of the nodes from the tip and from the other end along springs [N], metres."""
        if self.is_cable:
            rod = np.asarray(self.geometry.rods[0], np.int64)
            ends = (int(rod[0]), int(rod[-1]))
        else:
            some = int(self._apart(0).argmax())
            ends = (some, int(self._apart(some).argmax()))
        hands = np.asarray(self.geometry.controls, float)
        if len(hands):
            rest = np.asarray(self.geometry.rest_positions, float)
            near = [np.linalg.norm(hands - rest[end], axis=1).min() for end in ends]
            if near[1] > near[0]:
                ends = ends[::-1]
        return self._apart(ends[0]), self._apart(ends[1])

    @cached_property
    def length_m(self) -> float:
        """Distance of the ends along the object, metres."""
        return float(self._paths[1][self._paths[0].argmin()])

    @cached_property
    def along(self) -> Array:
        """Place of each node along the object [N], 0..1."""
        from_tip, from_end = self._paths
        return from_tip / np.maximum(from_tip + from_end, 1e-9)

    @cached_property
    def is_elongated(self) -> bool:
        """True if the object is much longer than it is wide: a rope, a cable or a bar."""
        if self.is_cable:
            return True
        width = 2.0 * np.sqrt(np.mean(self._width() ** 2))
        return bool(self.length_m > _ELONGATED * width)

    @cached_property
    def height_m(self) -> float:
        """Height of the highest node above the ground, metres."""
        return float(self.positions[:, 2].max() - self.ground_m)

    @cached_property
    def grasp_radius_m(self) -> float:
        """Radius of a gripper's reach: it takes the nodes of one place, of a cable two."""
        return (0.65 if self.is_cable else 1.25) * self.spacing_m

    def place(self, at: float) -> Indices:
        """The nodes of a place along the object, by which a gripper takes it."""
        from_here = np.abs(self.along - at) * self.length_m
        if self.is_cable:
            count = len(self.along)
            first = int(np.clip(round(at * (count - 1) - 0.5), 0, count - 2))
            return np.sort(np.argsort(self.along, kind="stable")[first : first + 2])
        near = np.flatnonzero(from_here <= max(0.6 * self.spacing_m, float(from_here.min())))
        center = self.positions[near].mean(axis=0)
        apart = np.linalg.norm(self.positions - center, axis=1)
        return np.flatnonzero(apart <= max(0.8 * self.grasp_radius_m, float(apart.min())))

    def end(self, tip: bool = True) -> Indices:
        """The nodes of an end, whose mean is where the end is: it does not move as they roll."""
        apart = self._paths[0 if tip else 1]
        return np.flatnonzero(apart <= max(0.06 * self.length_m, 0.8 * self.spacing_m))

    def spread(self, count: int) -> Indices:
        """Nodes [count] far from one another, the tip first; all nodes where there are fewer."""
        return farthest(self.positions, count, int(self.along.argmin()))

    def placed(self, offset_m: npt.ArrayLike, yaw: npt.ArrayLike) -> State:
        """The object moved on the ground by offsets [R, 2], metres, and turned about its middle by
        angles [R], radians: states [R] at rest."""
        offset, turn = np.atleast_2d(np.asarray(offset_m, float)), np.atleast_1d(yaw)
        rows = len(offset)
        moved = np.repeat(self.positions[None], rows, axis=0)
        if self.is_level:
            arms = moved[..., :2] - self.middle[:2]
            cos, sin = np.cos(turn)[:, None], np.sin(turn)[:, None]
            moved[..., 0] = self.middle[0] + cos * arms[..., 0] - sin * arms[..., 1]
            moved[..., 1] = self.middle[1] + sin * arms[..., 0] + cos * arms[..., 1]
            moved[..., :2] += offset[:, None]
        state = self.state

        def tiled(array: Any) -> Any:
            return None if array is None else np.repeat(np.asarray(array)[None], rows, axis=0)

        return State(
            positions=moved.astype(np.float32),
            velocities=tiled(state.velocities),
            twists=tiled(state.twists),
            controls=tiled(state.controls),
        )

    @cached_property
    def _line(self) -> tuple[Indices, Array]:
        """The stretch of the object of each node [N], and the means of stretches [S, 3]."""
        stretch = np.clip((self.along * _STRETCHES).astype(int), 0, _STRETCHES - 1)
        filled = np.unique(stretch)
        means = np.array([self.positions[stretch == one].mean(axis=0) for one in filled])
        return np.searchsorted(filled, stretch), means

    def _width(self) -> Array:
        """Distances [N] of the nodes from the object's own line, through means of its stretches,
        metres."""
        row, means = self._line
        if len(means) < 2:
            return np.asarray(np.linalg.norm(self.positions - means[0], axis=1))
        ways = np.gradient(means, axis=0)
        ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-9)
        arms = self.positions - means[row]
        beside = arms - np.einsum("ni,ni->n", arms, ways[row])[:, None] * ways[row]
        return np.asarray(np.linalg.norm(beside, axis=1))

    def _apart(self, source: int) -> Array:
        """Distances from a node along springs [N], metres; straight ones to other parts."""
        rest = np.asarray(self.geometry.rest_positions, float)
        distances = np.full(len(rest), np.inf)
        distances[source] = 0.0
        queue = [(0.0, source)]
        while queue:
            so_far, node = heapq.heappop(queue)
            if so_far > distances[node]:
                continue
            for other, length in self._neighbours[node]:
                if so_far + length < distances[other]:
                    distances[other] = so_far + length
                    heapq.heappush(queue, (so_far + length, other))
        straight = np.linalg.norm(rest - rest[source], axis=1)
        return np.where(np.isfinite(distances), distances, straight)

    @cached_property
    def _neighbours(self) -> list[list[tuple[int, float]]]:
        nodes = len(self.geometry.rest_positions)
        neighbours: list[list[tuple[int, float]]] = [[] for _ in range(nodes)]
        lengths = np.asarray(self.geometry.rest_lengths, float)
        for (a, b), length in zip(self.geometry.edges.tolist(), lengths.tolist(), strict=True):
            if a < nodes and b < nodes:
                neighbours[a].append((b, length))
                neighbours[b].append((a, length))
        return neighbours


def world_of(geometry: Geometry, **options: Any) -> World:
    """A world in which the object of a twin has a ground, with options of `World`."""
    if geometry.ground is None:
        options = {"ground": Plane(float(geometry.rest_positions[:, 2].min())), **options}
    return World(**options)


def farthest(points: Array, count: int, first: int) -> Indices:
    """Indices [count] of points [N, 3], each the farthest from those before; at most N."""
    chosen = [first]
    apart = np.linalg.norm(points - points[first], axis=1)
    for _ in range(min(count, len(points)) - 1):
        chosen.append(int(apart.argmax()))
        apart = np.minimum(apart, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen, np.int64)
