"""A rope around a peg: its held end is led around, until the rope lies in a U."""

from __future__ import annotations

import numpy as np
from bendtwin import Capsule, Collider, Cost, State, World

from studies.loops.loop import (
    Array,
    Loop,
    Outcome,
    Path,
    Planned,
    follow,
    reach,
    search,
    unbroken,
    up,
)

LEAST_WINDING_DEG = 270.0
FRAMES = 15
PEG = np.array([0.15, 0.065])
PEG_RADIUS = 0.025
ROPE_RADIUS = 0.0125
#: Of the middle of the rope around the peg.
TURN = PEG_RADIUS + ROPE_RADIUS + 0.008
#: Length of the rope beyond the turn on the side of the hand.
LEG = 0.13
#: Height of the hand on its way.
LIFT = 0.03


class Peg(Loop):
    """A straight rope that passes the peg winds about it by less than 180 degrees."""

    name = "peg"
    title = "rope around a peg"
    scene = "rope"
    mass_kg = 0.12
    steps = 45
    target = f"winds about the peg by {LEAST_WINDING_DEG:.0f} degrees or more"

    def surroundings(self) -> World:
        """A peg that stands beside the rope."""
        peg = Capsule([*PEG, -0.05], [*PEG, 0.25], PEG_RADIUS)
        shape = Collider(shape=peg, margin_m=0.01, friction=0.2, name="peg")
        return World(colliders=[shape])

    def prepare(self) -> None:
        """The goal is a U around the peg, by the length along the rope."""
        self.lying = np.asarray(self.believed.positions, dtype=float)
        along = self.geometry.rest_positions[:, 0]
        self.along = along - along.min()
        self.order = np.argsort(self.along)
        self.hand = self.held_nodes()
        self.goal = self._laid()
        grip = self.goal[self.hand].mean(axis=0) - self.lying[self.hand].mean(axis=0)
        centre = self.lying[self.hand].mean(axis=0)
        # Around the peg at a distance that leaves the rope room to turn.
        angles = np.deg2rad([200.0, 160.0, 120.0, 90.0])
        circle = PEG + (TURN + 0.04) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        over = [np.array([*(p - centre[:2]), LIFT]) for p in circle]
        ends = [grip + up(LIFT), grip]
        self.way = Path(np.stack([up(0.0), up(LIFT), *over, *ends]), 0.2)

    def _laid(self) -> Array:
        """Places of all nodes when the rope lies in the U [N, 3]."""
        s, turn = self.along, np.pi * TURN
        angle = np.clip((s - LEG) / TURN, 0.0, np.pi)
        middle = PEG + TURN * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        before, after = np.maximum(LEG - s, 0.0), np.maximum(s - LEG - turn, 0.0)
        middle[:, 0] += before + after
        # What lies beside the middle of the straight rope does so in the turn.
        beside = self.lying[:, 1] - self.lying[:, 1].mean()
        normal = np.stack([np.sin(angle), -np.cos(angle)], axis=1)
        placed = middle + beside[:, None] * normal
        return np.column_stack([placed, self.lying[:, 2]])

    def move(self, step: int, believed: State) -> Planned:
        """Leads the hand around the peg, then lays the rope."""
        times = self.times_s(step, FRAMES)
        costs: list[Cost] = [unbroken(FRAMES)]
        if times[0] < self.way.duration_s:
            costs.append(follow(self.hand, self.lying[self.hand], self.way.at(times), 1.0))
        if times[-1] > 0.8 * self.way.duration_s:
            costs += reach(np.arange(len(self.goal)), self.goal, 0.5, FRAMES)
        return Planned(costs=costs, search=search(0.04, seed=1000 * self.seed + step))

    def outcome(self, state: State) -> Outcome:
        """The angle by which the rope winds about the peg, from its held end to the free one."""
        positions = np.asarray(state.positions, dtype=float)
        winding = self.winding_deg(positions)
        apart = np.linalg.norm((positions - self.goal)[:, :2], axis=-1)
        error_mm = 1e3 * float(apart.mean())
        also = {"winding_deg": winding}
        return Outcome(winding >= LEAST_WINDING_DEG, error_mm, also)

    def winding_deg(self, positions: Array) -> float:
        """The angle about the peg from the held end to the free one, counter-clockwise."""
        parts = np.array_split(self.order, 16)
        middle = np.stack([positions[part, :2].mean(axis=0) for part in parts]) - PEG
        angles = np.arctan2(middle[:, 1], middle[:, 0])
        return float(np.rad2deg(np.unwrap(angles)[-1] - np.unwrap(angles)[0]))
