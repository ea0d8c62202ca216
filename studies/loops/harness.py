"""The simulated real object, its sensor, the controller, and the episode around them."""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bendtwin import (
    BendTwinError,
    Client,
    Forces,
    Returns,
    Search,
    Session,
    Twin,
    Vary,
    interpolate_poses,
)
from studies.loops.loop import Loop, Move, Planned

#: What the controller knows of the object while it moves: 20 % of its skin with 3 mm of noise,
#: nothing, or the state itself, which tells errors of planning from errors of seeing.
Variant = Literal["corrected", "open_loop", "known"]

SEEN_SHARE = 0.2
#: Points that are seen at least: cables have few.
LEAST_SEEN = 6
NOISE_M = 0.003
#: Deviation that the controller expects of a point: noise, and the coarse skin.
EXPECTED_NOISE_M = 0.004


class Ended(Exception):
    """The end of an episode before its last step, with the reason."""


@dataclass
class Episode:
    """What happened in an episode."""

    loop: str
    variant: Variant
    seed: int
    success: bool = False
    error_mm: float = float("nan")
    also: dict[str, float] = field(default_factory=dict)
    largest_strain: float = 0.0
    largest_force_n: float = 0.0
    corrections: int = 0
    refused_corrections: int = 0
    #: The error after each step.
    errors_mm: list[float] = field(default_factory=list)
    #: Reason of the server, if it ended the episode.
    ended_by: str = ""
    #: Seconds of every step, by part.
    latencies_s: dict[str, list[float]] = field(
        default_factory=lambda: {"correct": [], "plan": [], "advance": []}
    )

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        """Adds the time of what is done within."""
        began = time.monotonic()
        try:
            yield
        finally:
            self.latencies_s[part].append(time.monotonic() - began)


def other_object(rng: np.random.Generator) -> Vary:
    """Parameters that make another object of a twin."""
    return Vary(
        stiffness=[rng.uniform(0.7, 1.3)],
        damping=[rng.uniform(0.6, 1.3)],
        bending=[rng.uniform(0.7, 1.3)],
        friction=[rng.uniform(0.7, 1.3)],
        mass=[rng.uniform(0.95, 1.3)],
    )


class RealObject:
    """The object of an episode: a twin with other parameters, and a camera that looks at it."""

    def __init__(self, twin: Twin, loop: Loop, vary: Vary, episode: Episode, seed: int) -> None:
        self.state = loop.start
        self._twin, self._vary, self._world, self._episode = twin, vary, loop.world, episode
        self._skin, self._sees_markers = twin.geometry().skin, loop.sees_markers
        self._rng = np.random.default_rng([seed, 1])

    def see(self) -> dict[str, Any]:
        """A fifth of the points of its skin, or of its markers, with noise: an observation."""
        positions = np.asarray(self.state.positions, dtype=float)
        surface = positions if self._sees_markers else self._skin.positions(positions)
        count = min(max(round(SEEN_SHARE * len(surface)), LEAST_SEEN), len(surface))
        chosen = self._rng.choice(len(surface), count, replace=False)
        points = surface[chosen] + self._rng.normal(0.0, NOISE_M, (count, 3))
        return {"points": points, **({"nodes": chosen} if self._sees_markers else {})}

    def execute(self, actions: dict[str, Any]) -> None:
        """Moves the grippers."""
        done = self._twin.rollout(
            **actions,
            initial=self.state,
            world=self._world,
            vary=self._vary,
            returns=Returns(final_state=True, diagnostics=True, forces=True),
        )
        if done.diverged:
            raise Ended("DIVERGED")
        self.state = done.state(0)
        episode = self._episode
        episode.largest_strain = max(episode.largest_strain, done.diagnostics[0].max_strain)
        episode.largest_force_n = max(episode.largest_force_n, _largest_force(done.forces))


class Controller:
    """A session of the twin that plans, and the nominal plan."""

    def __init__(self, session: Session, loop: Loop, variant: Variant, episode: Episode) -> None:
        self._session, self._loop, self._episode = session, loop, episode
        self._variant = variant
        self._poses = loop.grippers
        self._nominal: npt.NDArray[Any] | None = None

    def step(self, number: int, real: RealObject) -> dict[str, Any]:
        """Corrects, plans and advances; returns the actions that the robot executes."""
        self._look(real)
        (believed,) = self._session.states([0])
        move = self._loop.move(number, believed)
        frames = self._loop.step_frames
        if isinstance(move, Planned):
            path = self._plan(move)[:, : frames + 1]
        else:
            self._nominal = None
            ends = np.stack([self._poses, np.asarray(move.poses, dtype=float)])[None]
            path = interpolate_poses(ends, frames)
        actions = self._actions(path, move)
        with self._episode.timed("advance"):
            self._session.advance(**actions)
        self._poses = path[0, -1].astype(float)
        return actions

    def _actions(self, poses: npt.NDArray[Any], move: Move) -> dict[str, Any]:
        """Poses [1, K, G, 7] and what the grippers hold meanwhile, as arguments of a rollout."""
        grasps = self._loop.grasps
        closed = [1] * len(grasps) if move.closed is None else move.closed
        knots = poses.shape[1]
        return {
            "poses": poses,
            "gripper_of_control": self._loop.geometry.hands,
            "grasps": [
                replace(grasp, closed=[is_closed] * knots)
                for grasp, is_closed in zip(grasps, closed, strict=True)
            ],
        }

    def _look(self, real: RealObject) -> None:
        """Brings the session closer to what is seen."""
        if self._variant == "known":
            self._session.reset([0], real.state)
        if self._variant != "corrected":
            return
        seen = real.see()
        self._episode.corrections += 1
        try:
            with self._episode.timed("correct"):
                self._session.correct(**seen, noise_m=EXPECTED_NOISE_M)
        except BendTwinError as error:
            if error.reason != "OBSERVATION_NOT_EXPLAINED":
                raise
            self._episode.refused_corrections += 1

    def _plan(self, move: Planned) -> npt.NDArray[np.float32]:
        """Poses of the grippers in every frame of the horizon [1, F + 1, G, 7]."""
        nominal = self._nominal
        if nominal is None:
            nominal = np.stack([self._poses] * move.knots)[None]
        with self._episode.timed("plan"):
            update = self._session.plan(
                **self._actions(nominal, move),
                world=self._loop.world,
                frames=move.frames,
                costs=move.costs,
                search=self._above_the_table(move),
                space=move.space,
            )
        path = interpolate_poses(update.knots, move.frames)
        # The next plan begins with the rest of this one, at whose end the grippers stay.
        later = self._loop.step_frames + np.linspace(0, move.frames, move.knots).round().astype(int)
        self._nominal = path[:, np.minimum(later, move.frames)]
        return path

    def _above_the_table(self, move: Planned) -> Search:
        """The search with bounds, which count from where the grippers are, for their heights."""
        low = np.full((len(self._poses), 3 if move.space == "translation" else 6), -np.inf)
        low[:, 2] = np.minimum(self._loop.lowest_m - self._poses[:, 2], 0.0)
        bounds = replace(move.search.bounds, low=low.reshape(-1))
        return replace(move.search, bounds=bounds)


def run_episode(
    client: Client,
    kind: type[Loop],
    twins: tuple[Twin, Twin],
    variant: Variant,
    seed: int,
    steps: int | None = None,
) -> Episode:
    """Runs a loop once.

    Args:
        client: The server.
        kind: The loop.
        twins: The twin that plans, and the one that stands for the real object.
        variant: What the controller knows.
        seed: Seed of the real object's parameters, of the goal, the noise and the plans.
        steps: The number of steps; as many as the loop has by default.
    """
    twin, real_twin = twins
    vary = other_object(np.random.default_rng([seed, 0]))
    episode = Episode(kind.name, variant, seed)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="implausible motion")
        loop = kind(twin, real_twin, vary, seed)
        real = RealObject(real_twin, loop, vary, episode, seed)
        try:
            with client.open_session(
                twin, initial=loop.believed, world=loop.world, grasps=loop.grasps
            ) as session:
                controller = Controller(session, loop, variant, episode)
                for number in range(steps or kind.steps):
                    real.execute(controller.step(number, real))
                    episode.errors_mm.append(loop.outcome(real.state).error_mm)
        except Ended as end:
            episode.ended_by = str(end)
        except BendTwinError as error:
            episode.ended_by = error.reason
            print(f"{kind.name}, {variant}, seed {seed}: {error}", file=sys.stderr)
        outcome = loop.outcome(real.state)
    episode.error_mm, episode.also = outcome.error_mm, outcome.also
    episode.success = outcome.success and not episode.ended_by
    return episode


def _largest_force(forces: Forces | None) -> float:
    """Largest force of a hand or a grasp over a frame, newtons."""
    if forces is None:
        return 0.0
    by_hands = np.linalg.norm(forces.controls.sum(axis=2), axis=-1)
    by_grasps = np.linalg.norm(forces.grasps[..., :3], axis=-1)
    return float(max(by_hands.max(initial=0.0), by_grasps.max(initial=0.0)))
