"""A toy that nobody holds, pushed to a goal by a sphere."""

from __future__ import annotations

import numpy as np
from bendtwin import Collider, Cost, Grasp, Sphere, State, World

from studies.loops.loop import Array, Loop, Outcome, Planned, reach, search, unbroken

LIMIT_MM = 20.0
FRAMES = 15
RADIUS = 0.035
HEIGHT = 0.04
AWAY = 0.12


class Push(Loop):
    """The sphere pushes between two limbs, where it has a hold."""

    name = "push"
    title = "pushing with a sphere"
    scene = "toy"
    mass_kg = 0.25
    steps = 40
    target = f"nodes within {LIMIT_MM:.0f} mm of their places on average"

    def surroundings(self) -> World:
        """A sphere on gripper 1; gripper 0 is the hand of the recording, which is open."""
        pusher = Collider(shape=Sphere(RADIUS), gripper=1, friction=0.5, name="sphere")
        return World(colliders=[pusher])

    def prepare(self) -> None:
        """The goal is the toy at rest, farther along y."""
        self.grasps = [Grasp(gripper=0, hand=0)]
        self.lying = np.asarray(self.believed.positions, dtype=float)
        offset = np.array([*self.rng.uniform(-0.02, 0.02, 1), AWAY, 0.0])
        offset[1] += self.rng.uniform(-0.02, 0.02)
        self.goal = self.lying + offset
        sphere = np.zeros((1, 7))
        sphere[0, :3], sphere[0, 6] = self._behind(), 1.0
        self.grippers = np.concatenate([self.grippers, sphere])

    def _behind(self) -> Array:
        """The place of the sphere before it touches: on the line of the middle, at -y."""
        place = np.array([self.lying[:, 0].mean(), 0.0, HEIGHT])
        for y in np.arange(-0.3, 0.0, 0.002):
            place[1] = y
            if np.linalg.norm(self.lying - place, axis=1).min() < RADIUS + 0.006:
                break
        return place

    def move(self, step: int, believed: State) -> Planned:
        """Moves the sphere over the table."""
        costs: list[Cost] = [
            *reach(np.arange(len(self.goal)), self.goal, 1.0, FRAMES),
            unbroken(FRAMES),
        ]
        sigma = [0.0, 0.0, 0.0, 0.03, 0.03, 0.0]
        found = search(sigma, seed=1000 * self.seed + step, speed_m_s=0.4)
        return Planned(costs=costs, search=found, closed=[0])

    def outcome(self, state: State) -> Outcome:
        """The mean distance of the nodes from their places."""
        apart = np.linalg.norm(np.asarray(state.positions) - self.goal, axis=-1)
        error_mm = 1e3 * float(apart.mean())
        return Outcome(error_mm <= LIMIT_MM, error_mm)
