"""Fold an object: bring its tip to its other end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bendtwin import rotations
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
    """A gripper takes the tip and lays it on the other end, which another gripper may hold."""

    name = "Fold"
    grippers = 2
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
        self.track("held", body.place(1.0))

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
        """The nodes around both ends."""
        return np.stack([self.middle(points, "place"), self.middle(points, "held")], axis=1)

    def judge(self, view: View) -> Judgement:
        """The ends are together where the other end lay."""
        tip, end = self.middle(view.points, "tip"), self.middle(view.points, "end")
        apart, moved = distance(tip, end), distance(end, view.goals)
        success = (apart <= self.tolerance_m) & (moved <= self.tolerance_m)
        left = np.maximum(apart, moved)
        return Judgement(self.shaped(self.reach_m(view), left), success)

    def script(self, view: View) -> Sequence[Waypoint]:
        """In an arc over the middle, turning with the object, while the other end is held."""
        places, length = self.places(view.points), self.body.length_m
        tip, end = self.middle(view.points, "tip"), self.middle(view.points, "end")
        level = (end - tip) * [1.0, 1.0, 0.0]
        level /= np.maximum(np.sqrt((level**2).sum(axis=-1, keepdims=True)), 1e-9)
        across = np.stack([-level[:, 1], level[:, 0], np.zeros(len(level))], axis=-1)
        grip = view.grippers[:, 0]
        arm = rotations.rotated(rotations.conjugate(grip[:, 3:]), grip[:, :3] - tip)
        middle = 0.5 * (self.middle(view.points, "place") + end)
        middle[:, 2] = self.body.ground_m

        def over(place: Array, height: float, angle: float) -> Array:
            turn = rotations.exponential(angle * across)
            at = place + rotations.rotated(turn, arm) + [0.0, 0.0, height]
            poses: Array = stay(view.grippers)
            poses[:, 0] = np.concatenate([at, turn], axis=-1)
            return poses

        down = stay(view.grippers)
        down[:, 0] = grip
        down[:, 0, 2] -= 0.3 * length
        return [
            Waypoint(self.above(places, 0.1), flags(False, False)),
            Waypoint(upright(places), flags(False, False)),
            Waypoint(stay(view.grippers), flags(True, True)),
            Waypoint(over(tip, 0.15 * length, 0.25 * np.pi), flags(True, True)),
            Waypoint(over(middle, 0.4 * length, 0.5 * np.pi), flags(True, True)),
            Waypoint(over(end, 0.2 * length, np.pi), flags(True, True)),
            Waypoint(down, flags(True, True)),
        ]

    def markers(self) -> Sequence[Marker]:
        """A ball where the other end lay."""
        return [Marker(Sphere(0.1 * self.tolerance_m), pose=upright)]
