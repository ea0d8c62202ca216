"""A plush toy into a bin: carried over its wall, lowered, and released."""

from __future__ import annotations

import numpy as np

from bendtwin import Clearance, Collider, Cost, Cuboid, Grasp, State, World
from studies.loops.loop import (
    Array,
    Loop,
    Move,
    Outcome,
    Path,
    Planned,
    Scripted,
    care,
    follow,
    near,
    reach,
    search,
    up,
)

FRAMES = 15
#: From the origin, metres: the middle of the bin, half of its inner side, walls.
MIDDLE = np.array([0.0, 0.42])
HALF = 0.15
WALL, HEIGHT = 0.02, 0.12
OVER = 0.36
#: Height of the head above the floor when the toy is released.
RELEASED = 0.16
FALL_STEPS = 12


class Bin(Loop):
    """The hand opens when all nodes are above the bin."""

    name = "bin"
    title = "plush into a bin"
    scene = "toy"
    mass_kg = 0.25
    steps = 45
    target = "all nodes within the walls, at rest"

    def surroundings(self) -> World:
        """Four walls on the ground."""
        (x, y), out = MIDDLE, HALF + WALL
        corners = [
            ([x - out, y - out], [x - HALF, y + out]),
            ([x + HALF, y - out], [x + out, y + out]),
            ([x - HALF, y - out], [x + HALF, y - HALF]),
            ([x - HALF, y + HALF], [x + HALF, y + out]),
        ]
        walls = [Cuboid([*low, 0.0], [*high, HEIGHT]) for low, high in corners]
        return World(colliders=[Collider(shape=wall, margin_m=0.005) for wall in walls])

    def prepare(self) -> None:
        """The way leads up, over the middle of the bin, and down."""
        self.grasps = [Grasp(gripper=0, hand=0)]
        self.head = self.held_nodes()
        self.lying = np.asarray(self.believed.positions, dtype=float)
        head = self.lying[self.head].mean(axis=0)
        over = np.array([*(MIDDLE + self.rng.uniform(-0.02, 0.02, 2) - head[:2]), OVER])
        low = np.array([*over[:2], RELEASED - head[2]])
        self.way = Path(np.stack([up(0.0), up(OVER), over, low]), 0.45)
        self.belly = near(self.lying, [self.lying.mean(axis=0)], 0.04)
        self.open_since: int | None = None

    def move(self, step: int, believed: State) -> Move:
        """Follows the way; opens once the toy is above the bin, at the latest in time to fall."""
        times = self.times_s(step, FRAMES)
        is_late = step >= self.steps - FALL_STEPS
        arrived = times[0] > self.way.duration_s and self.outside_m(believed).max() <= 0.0
        if self.open_since is None and (arrived or is_late):
            self.open_since = step
        if self.open_since is not None:
            return Scripted(poses=self.grippers, closed=[0])
        believed_positions = np.asarray(believed.positions, dtype=float)
        costs: list[Cost] = [
            follow(self.head, self.lying[self.head], self.way.at(times), 1.0),
            *care(FRAMES),
            *(
                Clearance(collider=wall, margin_m=0.01, when="every_frame", weight=1e3 / FRAMES)
                for wall in range(4)
            ),
        ]
        if times[-1] > 0.7 * self.way.duration_s:
            # What hangs from the hand, above the middle.
            below = np.array([*MIDDLE, float(believed_positions[self.belly, 2].mean())])
            costs += reach(self.belly, np.repeat(below[None], len(self.belly), axis=0), 1.0, FRAMES)
        return Planned(costs=costs, search=search(0.06, seed=1000 * self.seed + step))

    def outside_m(self, state: State) -> Array:
        """Horizontal distance of nodes outside of the walls [N]."""
        apart = np.abs(np.asarray(state.positions, dtype=float)[:, :2] - MIDDLE) - HALF
        return np.asarray(np.maximum(apart, 0.0).max(axis=1))

    def outcome(self, state: State) -> Outcome:
        """Success if all lies in the bin; the error is the distance of the middles."""
        positions = np.asarray(state.positions, dtype=float)
        off = positions[:, :2].mean(axis=0) - MIDDLE
        inside = float((self.outside_m(state) <= 0.0).mean())
        is_low = positions[:, 2].max() < HEIGHT + 0.05
        also = {"inside_share": inside}
        return Outcome(inside == 1.0 and is_low, 1e3 * float(np.linalg.norm(off)), also)
