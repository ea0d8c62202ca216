"""A toy over a box, held by its head, and laid down behind it."""

from __future__ import annotations

import numpy as np

from bendtwin import Clearance, Collider, Cost, Cuboid, State, World
from studies.loops.loop import (
    Loop,
    Outcome,
    Path,
    Planned,
    care,
    follow,
    reach,
    search,
    up,
)

LIMIT_MM = 25.0
FRAMES = 15
#: From where the toy lies, metres along y.
BOX_FROM, BOX_TO, GOAL = 0.17, 0.25, 0.42
BOX_HEIGHT = 0.1
#: Height that the head needs so that what hangs from it passes over the box.
OVER = 0.30


class Box(Loop):
    """Up, over the box, down and laid on the table as it lay before."""

    name = "box"
    title = "toy over a box"
    scene = "toy"
    mass_kg = 0.25
    steps = 70
    target = f"nodes within {LIMIT_MM:.0f} mm of their places on average, strain below 1.5"

    def surroundings(self) -> World:
        """A box of 100 mm."""
        shape = Cuboid([-0.3, BOX_FROM, 0.0], [0.3, BOX_TO, BOX_HEIGHT])
        return World(colliders=[Collider(shape=shape, margin_m=0.005, name="box")])

    def prepare(self) -> None:
        """The goal is the pose of the toy at rest behind the box."""
        self.head = self.held_nodes()
        self.lying = np.asarray(self.believed.positions, dtype=float)
        end = np.array([0.0, GOAL, 0.0]) + self.rng.uniform(-0.02, 0.02, 3) * [1, 1, 0]
        self.goal = self.lying + end
        # It comes down hanging, and is drawn out over the table.
        behind = end - [0.16, 0.0, 0.0]
        way = [up(0.0), up(OVER), behind + up(OVER), behind + up(0.16), end]
        self.way = Path(np.stack(way), 0.45)

    def move(self, step: int, believed: State) -> Planned:
        """Follows the way of the head, and towards its end brings the whole toy to the goal."""
        times = self.times_s(step, FRAMES)
        costs: list[Cost] = [
            *care(FRAMES),
            Clearance(collider=0, margin_m=0.01, when="every_frame", weight=1e3 / FRAMES),
        ]
        if times[0] < self.way.duration_s:
            costs.append(follow(self.head, self.lying[self.head], self.way.at(times), 1.0))
        if times[-1] > 0.8 * self.way.duration_s:
            costs += reach(np.arange(len(self.goal)), self.goal, 1.0, FRAMES)
        return Planned(costs=costs, search=search(0.06, seed=1000 * self.seed + step))

    def outcome(self, state: State) -> Outcome:
        """The mean distance of the nodes from their places."""
        apart = np.linalg.norm(np.asarray(state.positions) - self.goal, axis=-1)
        error_mm = 1e3 * float(apart.mean())
        return Outcome(error_mm <= LIMIT_MM, error_mm)
