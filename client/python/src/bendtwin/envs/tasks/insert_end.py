"""Insert the end of a cable into a tube."""

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
    distance,
    flags,
    stay,
    upright,
)
from bendtwin.simulation.world import Capsule, Collider, Sphere

#: Bars around the tube.
_BARS = 8
_AXIS = np.array([1.0, 0.0, 0.0])


class InsertEnd(Task):
    """A gripper takes a cable by its tip and brings the tip into a level tube."""

    name = "InsertEnd"
    goal_size = 3
    horizon_s = 8.0

    def __init__(self, body: Body, *, radius: float = 0.06, height: float = 0.25) -> None:
        """Radius of the tube inside and height of its axis, in lengths of the cable.

        Raises:
            Unsuitable: If the object is no cable.
        """
        if not body.is_cable:
            raise Unsuitable("InsertEnd needs a cable: a twin with rods")
        super().__init__(body)
        length, spacing = body.length_m, body.spacing_m
        self.radius_m = max(radius * length, 0.4 * spacing)
        self.depth_m = max(0.15 * length, 1.3 * spacing)
        #: The middle of the opening.
        self.opening: Array = body.middle + np.array([0.6 * length, 0.0, height * length])
        self.colliders = _tube(self.opening, self.radius_m, self.depth_m)
        order = np.argsort(body.along, kind="stable")
        self.track("tip", order[:1])
        self.track("place", order[:2])

    @property
    def instruction(self) -> str:
        """The task as a sentence."""
        return "Insert the tip of the cable into the tube."

    def draw(self, random: np.random.Generator) -> Draw:
        """The tube stands still; the tip points at it to within 40 degrees."""
        order = self.nodes
        tip, place = self.body.positions[order[0]], self.body.positions[order[-1]]
        lies = np.arctan2(tip[1] - place[1], tip[0] - place[0])
        drawn = self.drawn(random, self.opening + 0.5 * self.depth_m * _AXIS)
        return Draw(
            drawn.offset_m, float(random.uniform(-0.7, 0.7) - lies), drawn.goal, drawn.grippers
        )

    def places(self, points: Array) -> Array:
        """The two nodes at the tip."""
        return self.middle(points, "place")[:, None]

    def judge(self, view: View) -> Judgement:
        """The tip is within the tube, at least a third of its depth behind the opening."""
        tip = self.middle(view.points, "tip")
        arm = tip - self.opening
        beside = np.sqrt(arm[:, 1] ** 2 + arm[:, 2] ** 2)
        deep = arm[:, 0]
        success = (deep >= self.depth_m / 3) & (deep <= self.depth_m) & (beside < self.radius_m)
        return Judgement(self.shaped(self.reach_m(view), distance(tip, view.goals)), success)

    def script(self, view: View) -> Sequence[Waypoint]:
        """Up, in front of the opening with the tip along the axis, and in."""
        places = self.places(view.points)
        grip, turn = view.grippers[:, 0, :3], view.grippers[:, 0, 3:]
        arm = self.middle(view.points, "tip") - grip
        reach = np.sqrt((arm**2).sum(axis=-1, keepdims=True))
        turned = rotations.product(_between(arm / reach), turn)

        def with_tip(deep: float) -> Array:
            tip = self.opening + deep * _AXIS
            return np.concatenate([tip - reach * _AXIS, turned], axis=-1)[:, None]

        lift = view.grippers.copy()
        lift[..., 2] = self.opening[2]
        before = -0.25 * self.depth_m
        return [
            Waypoint(self.above(places, 0.1), flags(False)),
            Waypoint(upright(places), flags(False)),
            Waypoint(stay(view.grippers), flags(True)),
            Waypoint(lift, flags(True)),
            Waypoint(with_tip(before - 0.2 * self.body.length_m), flags(True)),
            Waypoint(with_tip(before), flags(True)),
            Waypoint(with_tip(before), flags(True)),
            Waypoint(with_tip(0.4 * self.depth_m), flags(True)),
        ]

    def markers(self) -> Sequence[Marker]:
        """A ball in the tube."""
        return [Marker(Sphere(0.2 * self.radius_m), pose=upright)]


def _between(ways: Array) -> Array:
    """Quaternions [B, 4] of the shortest turns of unit vectors [B, 3] to the axis."""
    axes = np.cross(ways, _AXIS)
    cosine = (ways * _AXIS).sum(axis=-1, keepdims=True)
    quaternions = np.concatenate([axes, 1.0 + cosine], axis=-1)
    return np.asarray(quaternions / np.sqrt((quaternions**2).sum(axis=-1, keepdims=True)))


def _tube(opening: Array, radius: float, depth: float) -> list[Collider]:
    """Bars along the axis, side by side in a circle around it."""
    bar = radius * np.sin(np.pi / _BARS) / (1.0 - np.sin(np.pi / _BARS))
    bars = []
    for i in range(_BARS):
        angle = 2.0 * np.pi * i / _BARS
        beside = (radius + bar) * np.array([0.0, np.cos(angle), np.sin(angle)])
        start = opening + beside + bar * _AXIS
        shape = Capsule(start, start + max(depth - 2.0 * bar, 1e-3) * _AXIS, bar)
        bars.append(Collider(shape=shape, friction=0.2, name=f"tube_{i}"))
    return bars
