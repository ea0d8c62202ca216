"""Move the tip of an object to a place in the air or on the ground."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bendtwin.envs.body import Array, Body
from bendtwin.envs.props import Marker
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
from bendtwin.simulation.world import Sphere


class MoveTip(Task):
    """A gripper takes the tip and brings it to a place."""

    name = "MoveTip"
    goal_size = 3
    horizon_s = 5.0

    def __init__(self, body: Body, *, tolerance: float = 0.06) -> None:
        """`tolerance`: largest distance of a success, in lengths of the object."""
        super().__init__(body)
        self.tolerance_m: float = tolerance * body.length_m
        self.track("tip", body.end())
        self.track("place", body.place(0.0))

    @property
    def instruction(self) -> str:
        """The task as a sentence."""
        return "Move the tip of the object to the green ball."

    def draw(self, random: np.random.Generator) -> Draw:
        """Goals are within half a length of the object, up to 0.3 lengths high."""
        length, body = self.body.length_m, self.body
        way, angle = random.uniform(0.1, 0.5) * length, random.uniform(-np.pi, np.pi)
        height = body.ground_m + 0.5 * body.height_m + random.uniform(0.05, 0.3) * length
        goal = [
            body.middle[0] + way * np.cos(angle),
            body.middle[1] + way * np.sin(angle),
            height,
        ]
        return self.drawn(random, goal)

    def places(self, points: Array) -> Array:
        """The nodes around the tip."""
        return self.middle(points, "place")[:, None]

    def judge(self, view: View) -> Judgement:
        """The distance of the tip from its goal."""
        left = distance(self.middle(view.points, "tip"), view.goals)
        return Judgement(self.shaped(self.reach_m(view), left), left <= self.tolerance_m)

    def script(self, view: View) -> Sequence[Waypoint]:
        """Down to the tip, and to where the tip is at the goal."""
        places = self.places(view.points)
        arm = view.grippers[:, 0, :3] - self.middle(view.points, "tip")
        return [
            Waypoint(self.above(places, 0.1), flags(False)),
            Waypoint(upright(places), flags(False)),
            Waypoint(stay(view.grippers), flags(True)),
            Waypoint(upright((view.goals + arm)[:, None]), flags(True)),
        ]

    def markers(self) -> Sequence[Marker]:
        """A ball at the goal."""
        return [Marker(Sphere(0.5 * self.tolerance_m), pose=upright)]
