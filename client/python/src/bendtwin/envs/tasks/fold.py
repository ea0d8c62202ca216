"""Fold an object: bring its tip to its other end."""

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


class Fold(Task):
    """A gripper takes the tip, lifts it over the object and lays it on the other end."""

    name = "Fold"
    #: Where the other end lay at first.
    goal_size = 3
    horizon_s = 6.0

    def __init__(self, body: Body, *, tolerance: float = 0.18) -> None:
        """`tolerance`: largest distance of the ends, and of the other end from where it lay, in
        lengths of the object."""
        super().__init__(body)
        self.tolerance_m: float = max(tolerance * body.length_m, body.height_m)
        self.track("tip", body.end())
        self.track("end", body.end(tip=False))
        self.track("place", body.place(0.0))

    @property
    def instruction(self) -> str:
        """The task as a sentence."""
        return "Fold the object: lay its tip on its other end, which stays at the green ball."

    def draw(self, random: np.random.Generator) -> Draw:
        """The object is moved and turned; the goal moves along."""
        drawn = self.drawn(random, np.zeros(3))
        state = self.body.placed(drawn.offset_m, drawn.yaw)
        nodes = np.asarray(state.positions, np.float64)[0, self.body.end(tip=False)]
        return Draw(drawn.offset_m, drawn.yaw, nodes.mean(axis=0), drawn.grippers)

    def places(self, points: Array) -> Array:
        """The nodes around the tip."""
        return self.middle(points, "place")[:, None]

    def judge(self, view: View) -> Judgement:
        """The ends are together where the other end lay."""
        tip, end = self.middle(view.points, "tip"), self.middle(view.points, "end")
        apart, moved = distance(tip, end), distance(end, view.goals)
        success = (apart <= self.tolerance_m) & (moved <= self.tolerance_m)
        left = np.maximum(apart, moved)
        return Judgement(self.shaped(self.reach_m(view), left), success)

    def script(self, view: View) -> Sequence[Waypoint]:
        """In an arc over the middle."""
        places, length = self.places(view.points), self.body.length_m
        arm = view.grippers[:, 0, :3] - self.middle(view.points, "tip")
        end = self.middle(view.points, "end")
        lift = np.array([0.0, 0.0, 0.35 * length])
        down = np.array([0.0, 0.0, 0.5 * self.body.height_m])
        half = view.grippers[:, 0, :3] + 0.5 * (end - self.middle(view.points, "tip"))
        half[:, 2] = self.body.ground_m + lift[2]
        return [
            Waypoint(self.above(places, 0.1), flags(False)),
            Waypoint(upright(places), flags(False)),
            Waypoint(stay(view.grippers), flags(True)),
            Waypoint(self.above(view.grippers[..., :3], 0.2), flags(True)),
            Waypoint(upright(half[:, None]), flags(True)),
            Waypoint(upright((end + arm + lift)[:, None]), flags(True)),
            Waypoint(upright((end + arm + down)[:, None]), flags(True)),
        ]

    def markers(self) -> Sequence[Marker]:
        """A ball where the other end lay."""
        return [Marker(Sphere(0.1 * self.tolerance_m), pose=upright)]
