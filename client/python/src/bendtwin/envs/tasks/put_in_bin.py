"""Put an object into a bin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bendtwin.envs.body import Array, Body
from bendtwin.envs.tasks.task import (
    Draw,
    Judgement,
    Task,
    View,
    Waypoint,
    distance,
    flags,
    stay,
    upright,
)
from bendtwin.simulation.world import Collider, Cuboid

#: Nodes that are judged.
_NODES = 24


class PutInBin(Task):
    """A gripper takes the object by its middle, lifts it over the walls and drops it."""

    name = "PutInBin"
    goal_size = 3
    horizon_s = 8.0

    def __init__(
        self, body: Body, *, width: float = 1.3, walls: float = 0.15, distance: float = 1.3
    ) -> None:
        """The width of the bin inside, the height of its walls and its distance from where the
        object lies, in lengths of the object."""
        super().__init__(body)
        length = body.length_m
        self.half_m, self.walls_m = 0.5 * width * length, walls * length
        self.center: Array = body.middle + np.array([distance * length, 0.0, 0.0])
        self.colliders = _walls(self.center, self.half_m, self.walls_m, 0.5 * body.spacing_m)
        self.track("all", body.spread(_NODES))
        self.track("place", body.place(0.5))

    @property
    def instruction(self) -> str:
        """The task as a sentence."""
        return "Put the object into the bin and release it."

    @property
    def scene(self) -> tuple[Array, float]:
        """The object and the bin."""
        between = 0.5 * (self.body.middle + self.center)
        return between, 0.5 * float(distance(self.center, self.body.middle)) + 1.3 * self.half_m

    def draw(self, random: np.random.Generator) -> Draw:
        """The bin stands still; the object is moved and turned."""
        return self.drawn(random, self.center)

    def places(self, points: Array) -> Array:
        """The middle of the object."""
        return self.middle(points, "place")[:, None]

    def judge(self, view: View) -> Judgement:
        """All nodes are within the walls, not much higher than these, and the gripper is open."""
        nodes, length = self.points(view.points, "all"), self.body.length_m
        beside = np.abs(nodes[..., :2] - view.goals[:, None, :2]) - self.half_m
        highest = self.walls_m + max(self.body.height_m, 0.2 * length)
        above = nodes[..., 2] - (view.goals[:, None, 2] + highest)
        outside = np.maximum(np.maximum(beside.max(axis=-1), above), 0.0)
        left = distance(nodes.mean(axis=1), view.goals)
        success = (outside.max(axis=1) <= 0.0) & ~view.closed.any(axis=1)
        cost = self.shaped(self.reach_m(view), 0.5 * left + 0.5 * outside.mean(axis=1))
        return Judgement(cost, success)

    def script(self, view: View) -> Sequence[Waypoint]:
        """Over the wall by half the object's length, since its ends may hang."""
        places, length = self.places(view.points), self.body.length_m
        lift = 0.45 * length + self.walls_m
        over = (view.goals + np.array([0.0, 0.0, lift]))[:, None]
        up = view.grippers[..., :3].copy()
        up[..., 2] = view.goals[:, None, 2] + lift
        high = self.walls_m + 0.5 * self.body.height_m
        low = (view.goals + np.array([0.0, 0.0, high]))[:, None]
        return [
            Waypoint(self.above(places, 0.1), flags(False)),
            Waypoint(upright(places), flags(False)),
            Waypoint(stay(view.grippers), flags(True)),
            Waypoint(upright(up), flags(True)),
            Waypoint(upright(over), flags(True)),
            Waypoint(upright(low), flags(True)),
            Waypoint(stay(view.grippers), flags(False)),
        ]


def _walls(center: Array, half: float, height: float, thick: float) -> list[Collider]:
    """Four walls around a square."""
    x, y, z = (float(c) for c in center)
    sides = {
        "left": ([-half - thick, -half - thick], [-half, half + thick]),
        "right": ([half, -half - thick], [half + thick, half + thick]),
        "front": ([-half, -half - thick], [half, -half]),
        "back": ([-half, half], [half, half + thick]),
    }
    return [
        Collider(
            shape=Cuboid(
                [x + low[0], y + low[1], z - thick], [x + high[0], y + high[1], z + height]
            ),
            name=f"bin_{name}",
        )
        for name, (low, high) in sides.items()
    ]
