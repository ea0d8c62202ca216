"""A closed loop as a benchmark: its scene, what is asked of each step, and when it has succeeded.

A loop says what to do in a step; how that is planned, executed and timed is in `harness`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from bendtwin import (
    Bounds,
    ControlPath,
    Cost,
    Geometry,
    Grasp,
    Keypoints,
    Search,
    State,
    Strain,
    Twin,
    Vary,
    World,
)
from studies.lab import at_rest

Array = npt.NDArray[np.float64]

#: Period of a loop: the object is seen, a plan is made and its first frames are executed.
PERIOD_S = 0.1


@dataclass(frozen=True, kw_only=True)
class Planned:
    """A step whose motion is planned."""

    costs: Sequence[Cost]
    search: Search
    #: Coordinates of the plan: "translation" of the grippers, or "rigid" motion.
    space: Literal["translation", "rigid"] = "translation"
    #: Horizon, and knots over it.
    frames: int = 15
    knots: int = 4
    #: Whether each grasp of the loop is closed meanwhile; all by default.
    closed: Sequence[int] | None = None


@dataclass(frozen=True, kw_only=True)
class Scripted:
    """A step whose motion is given: poses of the grippers at its end [G, 7]."""

    poses: npt.ArrayLike
    #: Whether each grasp of the loop is closed meanwhile; all by default.
    closed: Sequence[int] | None = None


Move = Planned | Scripted


@dataclass(frozen=True)
class Outcome:
    """The end of an episode."""

    success: bool
    #: Distance from what was asked for, as the loop defines it.
    error_mm: float
    #: Other figures that the loop judges by.
    also: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Path:
    """A way through points [P, D], metres, with a speed along it."""

    points: npt.ArrayLike
    speed_m_s: float

    def at(self, times_s: npt.ArrayLike) -> Array:
        """Places [T, D] at times since the beginning; it stays at its ends."""
        points = np.asarray(self.points, dtype=float)
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        reached = np.concatenate([[0.0], np.cumsum(steps)]) / self.speed_m_s
        times = np.asarray(times_s, dtype=float)
        return np.stack([np.interp(times, reached, axis) for axis in points.T], axis=1)

    @property
    def duration_s(self) -> float:
        """Time to its end."""
        steps = np.diff(np.asarray(self.points, dtype=float), axis=0)
        return float(np.linalg.norm(steps, axis=1).sum()) / self.speed_m_s


class Loop(ABC):
    """One episode of a closed loop, made for a twin that plans and a real object."""

    #: Its name on the command line, and in words.
    name: ClassVar[str]
    title: ClassVar[str]
    #: The made scene that the object is of, and its mass.
    scene: ClassVar[str]
    mass_kg: ClassVar[float]
    #: Steps of an episode.
    steps: ClassVar[int]
    #: Success in words.
    target: ClassVar[str]
    #: True if it is known which nodes the points are that are seen: markers.
    sees_markers: ClassVar[bool] = False

    def __init__(self, twin: Twin, real: Twin, vary: Vary, seed: int) -> None:
        """Sets the scene.

        Args:
            twin: The twin that plans.
            real: The twin that stands for the real object.
            vary: Parameters that make another object of it.
            seed: Seed of the goal and of the plans.
        """
        self.twin, self.real, self.vary, self.seed = twin, real, vary, seed
        self.geometry: Geometry = twin.geometry()
        self.fps = self.geometry.fps
        self.step_frames = round(PERIOD_S * self.fps)
        #: Poses of the grippers now [G, 7]; the hands of the recording have the first ones.
        self.grippers = around_hands(self.geometry)
        #: Lowest heights of the grippers [G]: where they are when the object lies on the table.
        self.lowest_m: npt.ArrayLike = self.grippers[:, 2].copy()
        #: Holds of the grippers; without any the hands of the recording hold.
        self.grasps: Sequence[Grasp] = ()
        #: Surroundings of the object.
        self.world = self.surroundings()
        #: Where the real object is, and where the controller takes it to be, at the beginning.
        still = replace(
            self.world, colliders=[c for c in self.world.colliders if c.gripper is None]
        )
        self.start: State = at_rest(real, world=still, vary=vary)
        self.believed: State = at_rest(twin, world=still)
        self.rng = np.random.default_rng([seed, 2])
        self.prepare()

    def surroundings(self) -> World:
        """The world; that of the twin by default."""
        return World()

    def prepare(self) -> None:  # noqa: B027
        """Chooses the goal and what else an episode needs."""

    @abstractmethod
    def move(self, step: int, believed: State) -> Move:
        """The motion of a step; `believed` is where the session has the object."""

    @abstractmethod
    def outcome(self, state: State) -> Outcome:
        """The verdict on the real object's last state."""

    def times_s(self, step: int, frames: int) -> Array:
        """Times of the frames of a plan since the beginning of the episode [F]."""
        return np.asarray((step * self.step_frames + 1 + np.arange(frames)) / self.fps)

    def held_nodes(self, within_m: float = 0.03) -> npt.NDArray[np.intp]:
        """Nodes near the control points at rest."""
        return near(self.geometry.rest_positions, self.geometry.controls, within_m)


def around_hands(geometry: Geometry) -> Array:
    """Poses of grippers in the middle of the control points of each hand [H, 7]."""
    poses = np.zeros((geometry.hand_count, 7))
    poses[:, 6] = 1.0
    for hand in range(geometry.hand_count):
        poses[hand, :3] = geometry.controls[geometry.hands == hand].mean(axis=0)
    return poses


def near(points: npt.ArrayLike, places: npt.ArrayLike, within_m: float) -> npt.NDArray[np.intp]:
    """Indices of the points [N, 3] near one of the places [M, 3]; the nearest one, if none is."""
    apart = np.asarray(points)[:, None] - np.asarray(places)[None]
    distance = np.linalg.norm(apart, axis=-1).min(axis=1)
    found = np.flatnonzero(distance < within_m)
    return found if found.size else distance.argmin()[None]


def up(height_m: float) -> Array:
    """An offset along z."""
    return np.array([0.0, 0.0, height_m])


def follow(
    nodes: npt.NDArray[Any], places: npt.ArrayLike, offsets: npt.ArrayLike, weight: float
) -> Keypoints:
    """A cost that has nodes at `places` [M, 3] + `offsets` [F, 3] in each frame."""
    targets = np.asarray(places)[None] + np.asarray(offsets)[:, None]
    return Keypoints(
        nodes=nodes,
        targets=targets,
        when="every_frame",
        weight=weight / len(targets),
        name="way",
    )


def reach(nodes: npt.NDArray[Any], places: npt.ArrayLike, weight: float, frames: int) -> list[Cost]:
    """Costs that bring nodes to places [M, 3]: on the way, and at the end of the horizon."""
    nodes_at: Any = {"nodes": nodes, "targets": places}
    return [
        Keypoints(**nodes_at, when="every_frame", weight=weight / frames, name="goal on the way"),
        Keypoints(**nodes_at, weight=weight, name="goal"),
    ]


def care(frames: int, motion: float = 0.05) -> list[Cost]:
    """Costs of strain beyond what soft material bears, and of motion that gains nothing: a hand
    that has brought the object to its goal stays there."""
    return [
        Strain(limit=0.5, when="every_frame", weight=10.0 / frames, name="strain"),
        ControlPath(weight=motion, name="motion"),
    ]


def search(sigma: npt.ArrayLike, *, seed: int, samples: int = 32, speed_m_s: float = 0.8) -> Search:
    """Path integral control with the settings that the loops share."""
    return Search(
        samples=samples,
        sigma=sigma,
        correlation=0.5,
        finest=0.03,
        bounds=Bounds(speed=speed_m_s),
        seed=seed,
    )
