"""A toy that nobody holds, pushed to a goal by a sphere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bendtwin import Collider, Grasp, Keypoints, Returns, Sphere, State, World
from studies.loops.loop import Array, Loop, Outcome, Planned, care, search

LIMIT_MM = 25.0
FRAMES = 24
#: Time in which the toy is to get there.
PUSHING_S = 3.0
RADIUS = 0.05
HEIGHT = 0.05
AWAY = 0.18


class Push(Loop):
    """The sphere pushes between two limbs, where it has a hold."""

    name = "push"
    title = "pushing with a sphere"
    scene = "toy"
    mass_kg = 0.25
    steps = 60
    target = f"nodes within {LIMIT_MM:.0f} mm of their places on average"

    def surroundings(self) -> World:
        """A sphere on gripper 1; gripper 0 is the hand of the recording, which is open."""
        pusher = Collider(shape=Sphere(RADIUS), gripper=1, friction=0.5, name="sphere")
        return World(colliders=[pusher])

    def prepare(self) -> None:
        """The goal is where the twin gets when the sphere moves straight on."""
        self.grasps = [Grasp(gripper=0, hand=0)]
        self.lying = np.asarray(self.believed.positions, dtype=float)
        sphere = np.zeros((1, 7))
        sphere[0, :3], sphere[0, 6] = self._behind(), 1.0
        self.grippers = np.concatenate([self.grippers, sphere])
        self.lowest_m = self.grippers[:, 2].copy()
        pushed = self.grippers.copy()
        pushed[1, :2] += [AWAY + self.rng.uniform(-0.02, 0.02), self.rng.uniform(-0.02, 0.02)]
        reached = self.twin.rollout(
            poses=[np.stack([self.grippers, pushed])],
            gripper_of_control=self.geometry.hands,
            grasps=[replace(grasp, closed=[0, 0]) for grasp in self.grasps],
            frames=60,
            initial=self.believed,
            world=self.world,
            returns=Returns(final_state=True),
        )
        self.goal = np.asarray(reached.final_positions[0], dtype=float)

    def _behind(self) -> Array:
        """The place of the sphere before it touches: on the line of the middle, at -x."""
        place = np.array([0.0, 0.0, HEIGHT])
        for x in np.arange(-0.3, 0.0, 0.002):
            place[0] = x
            if np.linalg.norm(self.lying - place, axis=1).min() < RADIUS + 0.006:
                break
        return place

    def move(self, step: int, believed: State) -> Planned:
        """Moves the sphere over the table."""
        # A goal that moves on slowly: the distance to a far one is shortened by pushing askew, too.
        share = np.clip(self.times_s(step, FRAMES) / PUSHING_S, 0.0, 1.0)[:, None, None]
        way = Keypoints(
            nodes=np.arange(len(self.goal)),
            targets=(1.0 - share) * self.lying + share * self.goal,
            when="every_frame",
            weight=1.0 / FRAMES,
        )
        sigma = [0.0, 0.0, 0.0, 0.03, 0.03, 0.0]
        found = search(sigma, seed=1000 * self.seed + step, samples=48, speed_m_s=0.3)
        return Planned(costs=[way, *care(FRAMES)], search=found, frames=FRAMES, closed=[0])

    def outcome(self, state: State) -> Outcome:
        """The mean distance of the nodes from their places."""
        apart = np.linalg.norm(np.asarray(state.positions) - self.goal, axis=-1)
        error_mm = 1e3 * float(apart.mean())
        return Outcome(error_mm <= LIMIT_MM, error_mm)
