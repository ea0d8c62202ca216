"""The simulated real object, its sensor, and the episode around them and the controller."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import numpy as np

from bendtwin import BendTwinError, Client, Forces, Returns, Twin, Vary, World
from studies.loops.controller import Controller
from studies.loops.episode import Episode, Variant
from studies.loops.loop import Loop

SEEN_SHARE = 0.2
#: Points that are seen at least: cables have few.
LEAST_SEEN = 6
NOISE_M = 0.003


class Ended(Exception):
    """The end of an episode before its last step, with the reason."""


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
        episode.largest_force_n = max(
            episode.largest_force_n, _largest_force(done.forces, self._world)
        )


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
        variant: Knowledge of the controller.
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
                controller = Controller(session, loop, episode)
                for number in range(steps or kind.steps):
                    if variant == "known":
                        session.reset([0], real.state)
                    seen = real.see() if variant == "corrected" else None
                    real.execute(controller.step(number, seen))
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


def _largest_force(forces: Forces | None, world: World) -> float:
    """Largest force of a hand, a grasp or a collider that a gripper carries, newtons."""
    if forces is None:
        return 0.0
    carried = [i for i, collider in enumerate(world.colliders) if collider.gripper is not None]
    by = (
        forces.controls.sum(axis=2),
        forces.grasps[..., :3],
        forces.colliders[:, :, carried, :3],
    )
    return max(float(np.linalg.norm(force, axis=-1).max(initial=0.0)) for force in by)
