"""Lay an elongated object along a line on the ground."""

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
    Unsuitable,
    View,
    Waypoint,
    flags,
    stay,
    upright,
)
from bendtwin.simulation.world import Sphere

#: Nodes that are judged, and balls that show the line.
_NODES, _BALLS = 16, 7


class LayAlong(Task):
    """Two grippers take both ends and lay the object along a line, stretched out."""

    name = "LayAlong"
    grippers = 2
    #: The line's point for the tip, and that for the other end.
    goal_size = 6
    horizon_s = 6.0

    def __init__(self, body: Body, *, tolerance: float = 0.08) -> None:
        """`tolerance`: mean distance of the nodes from their places on the line that is a success,
        in lengths of the object.

        Raises:
            Unsuitable: If the object is not elongated.
        """
        if not body.is_elongated:
            raise Unsuitable("LayAlong needs a long object: a rope, a cable or a bar")
        super().__init__(body)
        self.tolerance_m: float = tolerance * body.length_m
        nodes = body.spread(_NODES)
        self._at = body.along[nodes]
        self.track("all", nodes)
        self.track("tip", body.place(0.0))
        self.track("end", body.place(1.0))
        self._taken = [float(body.along[body.place(at)].mean()) for at in (0.0, 1.0)]

    @property
    def instruction(self) -> str:
        """The task as a sentence."""
        return "Lay the object along the green line, stretched out, and release it."

    def draw(self, random: np.random.Generator) -> Draw:
        """A line of the object's length, turned by up to 60 degrees from where the object lies."""
        length, middle = self.body.length_m, self.body.middle
        at = middle[:2] + random.uniform(-0.25, 0.25, 2) * length
        yaw = random.uniform(-np.pi, np.pi)
        chord = self.body.positions[self.body.place(0.0)].mean(axis=0)
        chord = (chord - self.body.positions[self.body.place(1.0)].mean(axis=0))[:2]
        angle = np.arctan2(chord[1], chord[0]) + yaw + random.uniform(-1.0, 1.0)
        half = 0.5 * length * np.array([np.cos(angle), np.sin(angle)])
        height = [self.body.ground_m + 0.5 * self.body.height_m]
        drawn = self.drawn(random, np.concatenate([at + half, height, at - half, height]))
        return Draw(drawn.offset_m, float(yaw), drawn.goal, drawn.grippers)

    def places(self, points: Array) -> Array:
        """Both ends."""
        return np.stack([self.middle(points, "tip"), self.middle(points, "end")], axis=1)

    def judge(self, view: View) -> Judgement:
        """The mean distance of the nodes from their places on the line, level."""
        nodes = self.points(view.points, "all")
        apart = nodes - _on(view.goals, self._at)
        left = np.sqrt((apart**2).sum(axis=-1)).mean(axis=1)
        success = (left <= self.tolerance_m) & ~view.closed.any(axis=1)
        return Judgement(self.shaped(self.reach_m(view), left), success)

    def script(self, view: View) -> Sequence[Waypoint]:
        """Both ends up, apart along the line, and down."""
        places = self.places(view.points)
        goals = _on(view.goals, np.array(self._taken))
        goals = goals.copy()
        goals[..., 2] = np.maximum(goals[..., 2], self.body.ground_m + 0.5 * self.body.height_m)
        # Grippers turn with the object, which would twist otherwise.
        chord, line = places[:, 0] - places[:, 1], view.goals[:, :3] - view.goals[:, 3:]
        angle = np.arctan2(line[:, 1], line[:, 0]) - np.arctan2(chord[:, 1], chord[:, 0])
        spin = np.zeros((len(angle), 1, 3))
        spin[:, 0, 2] = (angle + np.pi) % (2.0 * np.pi) - np.pi
        turned = rotations.product(rotations.exponential(spin), view.grippers[..., 3:])
        high, low = self.above(goals, 0.12), upright(goals)
        high[..., 3:], low[..., 3:] = turned, turned
        return [
            Waypoint(self.above(places, 0.1), flags(False, False)),
            # A grasp beside its place would stretch the object, which then springs off the line.
            Waypoint(upright(places), flags(False, False), near=0.1),
            Waypoint(stay(view.grippers), flags(True, True)),
            Waypoint(high, flags(True, True)),
            Waypoint(low, flags(True, True), near=0.1),
            Waypoint(stay(view.grippers), flags(False, False)),
        ]

    def markers(self) -> Sequence[Marker]:
        """Balls along the line."""
        ball = Sphere(0.15 * self.tolerance_m)

        def marker(at: float) -> Marker:
            return Marker(ball, pose=lambda goals: upright(_on(goals, np.array([at]))[:, 0]))

        return [marker(at) for at in np.linspace(0.0, 1.0, _BALLS).tolist()]


def _on(goals: Array, at: Array) -> Array:
    """Points [B, M, 3] of lines [B, 6] at shares [M] of their length."""
    first, last = goals[:, None, :3], goals[:, None, 3:]
    return np.asarray(first + at[:, None] * (last - first))
