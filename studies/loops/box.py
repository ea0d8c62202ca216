"""A toy over a box, held by its head, and laid down behind it."""

from __future__ import annotations

import numpy as np

from bendtwin import Clearance, Collider, Cost, Cuboid, State, World
from studies.loops.loop import (
    PERIOD_S,
    Array,
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
#: Of the head on its way, metres per second.
SPEED = 0.45
#: Steps in which the toy comes to rest, error at which it is taken up again, and how high, metres.
SETTLING, AGAIN_MM, AGAIN = 6, 18.0, 0.2
#: Steps that laying it down once more takes.
ONCE_MORE = 16


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
        self.down = [behind + up(0.16), end]
        way = [up(0.0), up(OVER), behind + up(OVER), *self.down]
        self.way, self.begun = Path(np.stack(way), SPEED), 0

    def move(self, step: int, believed: State) -> Planned:
        """Follows the way of the head, and towards its end brings the whole toy to the goal."""
        self._again(step, np.asarray(believed.positions, dtype=float))
        times = self.times_s(step - self.begun, FRAMES)
        costs: list[Cost] = [
            *care(FRAMES),
            Clearance(collider=0, margin_m=0.01, when="every_frame", weight=1e3 / FRAMES),
        ]
        if times[0] < self.way.duration_s:
            costs.append(follow(self.head, self.lying[self.head], self.way.at(times), 1.0))
        if times[-1] > 0.8 * self.way.duration_s:
            costs += reach(np.arange(len(self.goal)), self.goal, 1.0, FRAMES)
        found = search(0.06, seed=1000 * self.seed + step, samples=48)
        return Planned(costs=costs, search=found)

    def _again(self, step: int, nodes: Array) -> None:
        """Takes a toy up that lies folded, or beside its place, and begins to lay it once more."""
        laid = self.begun + round(self.way.duration_s / PERIOD_S) + SETTLING
        if not laid <= step <= self.steps - ONCE_MORE or self._error_mm(nodes) <= AGAIN_MM:
            return
        now = (nodes - self.lying)[self.head].mean(axis=0)
        way = [now, now + up(AGAIN), *self.down]
        self.way, self.begun = Path(np.stack(way), SPEED), step

    def outcome(self, state: State) -> Outcome:
        """The mean distance of the nodes from their places."""
        error_mm = self._error_mm(np.asarray(state.positions, dtype=float))
        return Outcome(error_mm <= LIMIT_MM, error_mm)

    def _error_mm(self, nodes: Array) -> float:
        return 1e3 * float(np.linalg.norm(nodes - self.goal, axis=-1).mean())
