"""What a task is: a goal, a reward and a script for an object, in lengths of that object."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from bendtwin.envs.body import Array, Body, Indices
from bendtwin.envs.props import Marker
from bendtwin.simulation.world import Collider

Mask = npt.NDArray[np.bool_]

#: The pose of a gripper that does not turn.
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])


class Unsuitable(ValueError):
    """A task that this object cannot be used for."""


@dataclass(frozen=True)
class Draw:
    """What one episode begins with."""

    #: Displacement of the object on the ground, metres.
    offset_m: Array
    #: Turn of the object about its middle, radians.
    yaw: float
    #: The goal as the task's numbers.
    goal: Array
    #: Displacement of each gripper from above the place that it is to take, [G, 3], metres.
    grippers: Array


@dataclass(frozen=True)
class View:
    """What a task judges, of B slots."""

    #: Nodes of the task [B, M, 3], metres.
    points: Array
    #: Poses of the grippers [B, G, 7].
    grippers: Array
    #: Whether the grippers are closed, [B, G].
    closed: Mask
    #: Goals [B, D].
    goals: Array


@dataclass(frozen=True)
class Judgement:
    """How far slots are from their goals."""

    #: From 0 at the goal to 1, [B].
    cost: Array
    #: [B].
    success: Mask


@dataclass(frozen=True)
class Waypoint:
    """Where grippers go next in a script, of B slots."""

    #: Poses [B, G, 7]; NaN: the gripper stays where it is.
    poses: Array
    #: Whether the grippers are closed there, [G].
    closed: Mask
    #: Distance at which it is reached, in largest steps.
    near: float = 0.3


class Task(ABC):
    """A task on an object. Subclasses state their groups of nodes, goals, costs and a script.

    Grippers start open, above the places that they are to take.
    """

    #: Name in the registry.
    name: ClassVar[str]
    #: Number of grippers.
    grippers: ClassVar[int] = 1
    #: Numbers of a goal.
    goal_size: ClassVar[int]
    #: Time of an episode, seconds.
    horizon_s: ClassVar[float] = 6.0
    #: Obstacles, which pictures show.
    colliders: Sequence[Collider] = ()

    def __init__(self, body: Body) -> None:
        self.body = body
        self._slices: dict[str, slice] = {}
        self._nodes: list[Indices] = []

    @property
    @abstractmethod
    def instruction(self) -> str:
        """The task as a sentence for policies that follow language."""

    @property
    def nodes(self) -> Indices:
        """Nodes that the task judges [M]."""
        return np.concatenate(self._nodes)

    @abstractmethod
    def draw(self, random: np.random.Generator) -> Draw:
        """Draws an episode."""

    @abstractmethod
    def judge(self, view: View) -> Judgement:
        """How far slots are from their goals."""

    @abstractmethod
    def script(self, view: View) -> Sequence[Waypoint]:
        """The way of a simple controller: poses to be reached one after the other."""

    @abstractmethod
    def places(self, points: Array) -> Array:
        """Where grippers are to take the object [B, G, 3], of nodes [B, M, 3]."""

    @property
    def scene(self) -> tuple[Array, float]:
        """The middle and the radius of what cameras are to see, metres."""
        length = self.body.length_m
        return self.body.middle + np.array([0.0, 0.0, 0.1 * length]), 1.1 * length

    def markers(self) -> Sequence[Marker]:
        """What shows the goal in pictures."""
        return ()

    # For subclasses

    def track(self, name: str, nodes: npt.ArrayLike) -> None:
        """Adds a group of nodes that the task judges."""
        begin = sum(map(len, self._nodes))
        self._nodes.append(np.asarray(nodes, np.int64))
        self._slices[name] = slice(begin, begin + len(self._nodes[-1]))

    def points(self, points: Array, name: str) -> Array:
        """The nodes of a group [B, m, 3]."""
        return points[:, self._slices[name]]

    def middle(self, points: Array, name: str) -> Array:
        """The mean of a group [B, 3]."""
        return np.asarray(self.points(points, name).mean(axis=1), np.float64)

    def drawn(self, random: np.random.Generator, goal: npt.ArrayLike, turn: float = np.pi) -> Draw:
        """An episode with a goal: the object up to 0.15 lengths away from where it lay and turned
        by up to an angle, grippers up to 0.05 lengths off."""
        length = self.body.length_m
        return Draw(
            offset_m=random.uniform(-0.15, 0.15, 2) * length,
            yaw=float(random.uniform(-turn, turn)),
            goal=np.asarray(goal, np.float64),
            grippers=random.uniform(-0.05, 0.05, (self.grippers, 3)) * length,
        )

    def above(self, places: Array, height: float = 0.15) -> Array:
        """Poses [B, G, 7] of upright grippers above places [B, G, 3], by lengths of the object."""
        return upright(places + np.array([0.0, 0.0, height * self.body.length_m]))

    def shaped(self, reach_m: Array, left_m: Array) -> Array:
        """A dense cost: the distance of the grippers from the object [B], metres, and mostly what
        is left to do [B], metres; 1 from a length of the object on."""
        length = self.body.length_m
        reach, left = np.minimum(reach_m / length, 1.0), np.minimum(left_m / length, 1.0)
        return np.asarray(0.25 * reach + 0.75 * left)

    def reach_m(self, view: View) -> Array:
        """Mean distance of the grippers from the places that they are to take [B], metres."""
        apart = view.grippers[..., :3] - self.places(view.points)
        return np.asarray(np.sqrt((apart**2).sum(axis=-1)).mean(axis=1))


def upright(places: Array) -> Array:
    """Poses [..., 7] at places [..., 3], without a turn."""
    turn = np.broadcast_to(UPRIGHT, (*places.shape[:-1], 4))
    return np.concatenate([places, turn], axis=-1)


def distance(a: Array, b: Array) -> Array:
    """Distances of points [..., 3]."""
    return np.asarray(np.sqrt(((a - b) ** 2).sum(axis=-1)))


def flags(*closed: bool) -> Mask:
    """Whether grippers are closed, [G]."""
    return np.array(closed, bool)


def stay(like: Array) -> Any:
    """Poses of grippers that stay where they are, in the shape of others."""
    return np.full_like(like, np.nan)
