"""A cable laid along a line on the table, with a regrasp.

The gripper of one end releases it, takes the cable in its middle, lays that, and comes back for
the end.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bendtwin import Bounds, Cost, Force, Grasp, State
from studies.loops.loop import Array, Loop, Move, Outcome, Planned, Scripted, reach, search, up

LIMIT_MM = 15.0
#: Horizon of half a second.
FRAMES = 50
LINE_Y, LINE_FROM = 0.3, -0.42
#: Height of a gripper that lays the cable on the table, and that moves above it.
LAID, ABOVE = 0.012, 0.12
#: Of the grippers on their way, metres per second.
SPEED = 0.4
#: Distance from its place at which a gripper is there, metres.
NEAR = 0.01
#: Part of its length that the cable is given on the line, and the pull at which it is not taut. One
#: that is stretched by a hundredth springs off the line when its gripper opens.
SLACK, PULL_N = 0.998, 0.3
#: The place of the regrasp, as a share of the length.
MIDDLE = 0.55


@dataclass(frozen=True)
class Phase:
    """A part of the way, until the grippers are there."""

    #: Whether the grasps are closed: hand 0, hand 1, gripper 1 in the middle, and at the end.
    closed: tuple[int, int, int, int]
    #: Place of gripper 1: a point, or the first of two nodes whose middle it goes to, and a height
    #: above that.
    to: Array | int
    above: float = 0.0
    #: Nodes that this lays along the line, by planning.
    lays: int = 0
    #: Steps after which the next phase begins even if it is not there.
    most_steps: int = 25


class Cable(Loop):
    """Grippers 0 and 1 begin with the clamps of the recording."""

    name = "cable"
    title = "cable along a line, with a regrasp"
    scene = "cable"
    mass_kg = 0.08
    steps = 110
    target = f"nodes within {LIMIT_MM:.0f} mm of the line on average, with open grippers"
    sees_markers = True

    def prepare(self) -> None:
        """The phases; the first gripper stays at the beginning of the line."""
        # Without load: at rest it hangs, and is longer.
        self.along = np.concatenate([[0.0], SLACK * np.cumsum(self.geometry.rest_lengths)])
        self.line_y = LINE_Y + self.rng.uniform(-0.02, 0.02)
        self.goal = np.stack([self.on_line(s) for s in self.along])
        count = len(self.along)
        middle, end = int(np.searchsorted(self.along, MIDDLE * self.along[-1])), count - 2
        # Two neighbours are a clamp, which gives the cable its direction.
        self.grasps = [
            Grasp(gripper=0, hand=0),
            Grasp(gripper=1, hand=1),
            Grasp(gripper=1, nodes=[middle, middle + 1]),
            Grasp(gripper=1, nodes=[end, end + 1]),
        ]
        slack = self.on_line(0.7 * self.along[-1])
        self.phases = [
            Phase((1, 1, 0, 0), slack + up(0.1)),
            Phase((1, 1, 0, 0), slack),
            Phase((1, 0, 0, 0), slack + up(ABOVE)),
            *self._taken(middle, (1, 0, 1, 0)),
            *self._taken(end, (1, 0, 0, 1)),
            Phase((0, 0, 0, 0), self.on_line(self.along[end]) + up(ABOVE)),
        ]
        self.lowest_m = [LAID, LAID]
        self.phase, self.phase_steps = 0, 0
        # The clamps turn until they lie along the line.
        rest = self.geometry.rest_positions
        self.turns = np.stack([turned(rest[1] - rest[0]), turned(rest[-1] - rest[-2])])

    def on_line(self, along: float) -> Array:
        """The place on the line for a length along the cable."""
        return np.array([LINE_FROM + along, self.line_y, LAID])

    def _taken(self, node: int, closed: tuple[int, int, int, int]) -> list[Phase]:
        """Takes the cable at a node and its neighbour, lays it, and releases it."""
        place = self.on_line(self.along[node : node + 2].mean())
        return [
            Phase((1, 0, 0, 0), node, ABOVE),
            Phase((1, 0, 0, 0), node),
            Phase(closed, place, lays=node + 2),
            Phase((1, 0, 0, 0), place + up(ABOVE)),
        ]

    def move(self, step: int, believed: State) -> Move:
        """The next part of the way."""
        nodes = np.asarray(believed.positions, dtype=float)
        phase = self.phases[self.phase]
        place = phase.to
        if isinstance(place, int):
            # The gripper's x axis takes the direction of the cable, and later that of the line.
            pair = nodes[place : place + 2]
            place = pair.mean(axis=0) + up(phase.above)
            self.turns[1] = turned((pair[1] - pair[0]) * [1.0, 1.0, 0.0]) * [-1, -1, -1, 1]
        poses = self.grippers.copy()
        self._go(poses[0], self.on_line(self.along[:2].mean()), self.turns[0])
        left_m = self._go(poses[1], place, self.turns[1])
        self.phase_steps += 1
        is_last = self.phase == len(self.phases) - 1
        if not is_last and (left_m < NEAR or self.phase_steps >= phase.most_steps):
            self.phase, self.phase_steps = self.phase + 1, 0
        if phase.lays:
            return self._laying(phase, step)
        return Scripted(poses=poses, closed=phase.closed)

    def _go(self, pose: Array, place: Array, orientation: Array) -> float:
        """Moves a pose [7] on for a step; the distance that it had left."""
        way = place - pose[:3]
        left_m = float(np.linalg.norm(way))
        share = min(1.0, SPEED * 0.1 / max(left_m, 1e-9))
        pose[:3] += share * way
        mixed = (1.0 - share) * pose[3:] + share * orientation
        pose[3:] = mixed / np.linalg.norm(mixed)
        return left_m

    def _laying(self, phase: Phase, step: int) -> Planned:
        nodes = np.arange(phase.lays)
        pull = Force(
            by=("grasp", phase.closed.index(1, 1)),
            limit_n=PULL_N,
            when="every_frame",
            weight=0.03 / FRAMES,
            name="pull",
        )
        costs: list[Cost] = [*reach(nodes, self.goal[nodes], 1.0, FRAMES), pull]
        # Gripper 1 moves, and turns about z.
        sigma = [*[0.0] * 6, 0.05, 0.05, 0.02, 0.0, 0.0, 0.3]
        found = search(sigma, seed=1000 * self.seed + step, samples=48)
        found = replace(found, bounds=Bounds(speed=[*[0.8] * 3, *[4.0] * 3] * 2))
        return Planned(costs=costs, search=found, space="rigid", frames=FRAMES, closed=phase.closed)

    def outcome(self, state: State) -> Outcome:
        """The mean distance from the line."""
        nodes = np.asarray(state.positions, dtype=float)
        off = np.hypot(nodes[:, 1] - self.line_y, np.maximum(nodes[:, 2] - LAID, 0.0))
        error_mm = 1e3 * float(off.mean())
        is_done = self.phase == len(self.phases) - 1
        return Outcome(is_done and error_mm <= LIMIT_MM, error_mm, {"phase": float(self.phase)})


def turned(direction: Array) -> Array:
    """The quaternion [4] that turns a direction to that of the line, +x."""
    unit = direction / np.linalg.norm(direction)
    axis = np.cross(unit, [1.0, 0.0, 0.0])
    quaternion = np.array([*axis, 1.0 + unit[0]])
    return np.asarray(quaternion / np.linalg.norm(quaternion))
