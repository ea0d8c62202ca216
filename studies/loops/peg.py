"""A rope around a peg: one end is clamped to the table, the other is led around the peg, until the
rope lies in a U.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bendtwin import Bounds, Capsule, Collider, Cost, Grasp, Keypoints, State, World
from studies.loops.loop import (
    Array,
    Loop,
    Outcome,
    Path,
    Planned,
    care,
    reach,
    search,
)

LEAST_WINDING_DEG = 250.0
FRAMES = 15
PEG_RADIUS = 0.03
ROPE_RADIUS = 0.0125
#: Of the middle of the rope around the peg.
TURN = PEG_RADIUS + ROPE_RADIUS + 0.008
#: Length of the rope between the clamp and the turn.
TAIL = 0.12
#: Height of the hand on its way.
LIFT = 0.01
#: Way of the hand that takes as long as turning by a radian.
YAW_M = 0.05


class Peg(Loop):
    """A straight rope that passes the peg winds about it by less than 180 degrees."""

    name = "peg"
    title = "rope around a peg"
    scene = "rope"
    mass_kg = 0.12
    steps = 50
    target = f"winds about the peg by {LEAST_WINDING_DEG:.0f} degrees or more"

    def surroundings(self) -> World:
        """A peg that stands beside the rope."""
        self.length = float(np.ptp(self.geometry.rest_positions[:, 0]))
        self.peg = np.array([self.geometry.rest_positions[:, 0].max() - TAIL, TURN])
        peg = Capsule([*self.peg, -0.05], [*self.peg, 0.25], PEG_RADIUS)
        shape = Collider(shape=peg, margin_m=0.01, friction=0.2, name="peg")
        return World(colliders=[shape])

    def prepare(self) -> None:
        """The goal is a U around the peg, by the length along the rope."""
        self.lying = np.asarray(self.believed.positions, dtype=float)
        along = self.geometry.rest_positions[:, 0]
        self.along = along - along.min()
        self.order = np.argsort(self.along)
        self.leg = self.length - TAIL - np.pi * TURN
        self.goal = self._laid()
        self.hand = self.held_nodes()
        end = np.flatnonzero(self.along > self.length - 0.04)
        self.grasps = [Grasp(gripper=0, hand=0), Grasp(gripper=1, nodes=end)]
        clamp = np.array([[*self.lying[end].mean(axis=0), 0.0, 0.0, 0.0, 1.0]])
        self.grippers = np.concatenate([self.grippers, clamp])
        self.lowest_m = self.grippers[:, 2].copy()
        self.centre = self.lying[self.hand].mean(axis=0)
        self.way = self._around()

    def _around(self) -> Path:
        """The way of the hand: the involute that the end of a taut rope follows, and its yaw."""
        angle = np.linspace(0.0, np.pi, 13)
        tangent = np.stack([-np.sin(angle), -np.cos(angle)], axis=1)
        away = np.stack([-np.cos(angle), np.sin(angle)], axis=1)
        reach_m = self.peg[0] - self.centre[0] - TURN * angle
        places = self.peg + TURN * tangent + reach_m[:, None] * away
        heights = LIFT * np.minimum(np.arange(13), 1) * np.ones(13)
        moved = np.column_stack([places - self.centre[:2], heights, -YAW_M * angle])
        laid = moved[-1] * [1.0, 1.0, 0.0, 1.0]
        return Path(np.concatenate([moved, [laid]]), 0.2)

    def _laid(self) -> Array:
        """Places of all nodes when the rope lies in the U [N, 3]."""
        s, turn = self.along, np.pi * TURN
        angle = np.clip((s - self.leg) / TURN, 0.0, np.pi)
        middle = self.peg + TURN * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        middle[:, 0] += np.maximum(self.leg - s, 0.0) + np.maximum(s - self.leg - turn, 0.0)
        # What lies beside the middle of the straight rope does so in the turn.
        beside = self.lying[:, 1] - self.lying[:, 1].mean()
        normal = np.stack([np.sin(angle), -np.cos(angle)], axis=1)
        placed = middle + beside[:, None] * normal
        return np.column_stack([placed, self.lying[:, 2]])

    def move(self, step: int, believed: State) -> Planned:
        """Leads the hand around the peg, then lays the rope."""
        times = self.times_s(step, FRAMES)
        costs: list[Cost] = [*care(FRAMES, motion=0.03)]
        if times[0] < self.way.duration_s:
            costs.append(self._led(self.way.at(times)))
        if times[-1] > 0.8 * self.way.duration_s:
            costs += reach(np.arange(len(self.goal)), self.goal, 0.5, FRAMES)
        sigma = [*[0.03] * 3, 0.0, 0.0, 0.3, *[0.0] * 6]
        found = search(sigma, seed=1000 * self.seed + step, samples=24)
        found = replace(found, bounds=Bounds(speed=[*[0.8] * 3, *[4.0] * 3] * 2))
        return Planned(costs=costs, search=found, space="rigid")

    def _led(self, way: Array) -> Cost:
        """The cost of the held end beside its way, which has a place and a yaw by frame [F, 4]."""
        yaw, beside = way[:, 3] / YAW_M, self.lying[self.hand] - self.centre
        cos, sin = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
        x, y, z = beside.T
        turned = np.stack([cos * x - sin * y, sin * x + cos * y, z + 0 * cos], axis=-1)
        targets = self.centre + turned + way[:, None, :3]
        return Keypoints(
            nodes=self.hand,
            targets=targets,
            when="every_frame",
            weight=1.0 / len(way),
            name="way",
        )

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
        middle = np.stack([positions[part, :2].mean(axis=0) for part in parts]) - self.peg
        angles = np.arctan2(middle[:, 1], middle[:, 0])
        return float(np.rad2deg(np.unwrap(angles)[-1] - np.unwrap(angles)[0]))
