"""The free end of a rope to a goal, by the hand at its other end."""

from __future__ import annotations

import numpy as np

from bendtwin import Returns, State, interpolate
from studies.loops.loop import Loop, Outcome, Planned, care, reach, search

LIMIT_MM = 5.0
FRAMES = 15


class RopeTip(Loop):
    """The hand does not touch the end: it drags and swings the rope."""

    name = "rope_tip"
    title = "rope tip to a goal"
    scene = "rope"
    mass_kg = 0.12
    steps = 35
    target = f"tip within {LIMIT_MM:.0f} mm of the goal"

    def prepare(self) -> None:
        """The goal is where the real rope's tip gets when its hand moves by about 15 cm."""
        controls = self.geometry.controls
        apart = np.linalg.norm(self.geometry.rest_positions[:, None] - controls[None], axis=-1).min(
            axis=1
        )
        self.tip = np.array([apart.argmax()])
        offset = np.array([0.12, 0.06, 0.06]) + self.rng.uniform(-0.02, 0.02, 3)
        reached = self.real.rollout(
            trajectories=interpolate([[controls, controls + offset]], 60),
            initial=self.start,
            vary=self.vary,
            returns=Returns(final_state=True),
        )
        self.goal = reached.final_positions[0, self.tip]

    def move(self, step: int, believed: State) -> Planned:
        """Brings the tip to the goal."""
        costs = [*reach(self.tip, self.goal, 1.0, FRAMES), *care(FRAMES, motion=0.03)]
        return Planned(costs=costs, search=search(0.05, seed=1000 * self.seed + step, samples=24))

    def outcome(self, state: State) -> Outcome:
        """The distance of the tip."""
        error = np.linalg.norm(np.asarray(state.positions)[self.tip] - self.goal)
        error_mm = 1e3 * float(error)
        return Outcome(error_mm <= LIMIT_MM, error_mm)
