"""The free end of a rope to a place on the table, by the hand at its other end."""

from __future__ import annotations

import numpy as np

from bendtwin import Returns, State, interpolate
from studies.loops.loop import Loop, Outcome, Planned, care, near, reach, search

LIMIT_MM = 5.0
#: Length of the part that is the tip, metres. Its nodes go around the rope when that rolls, so
#: their middle is to be at the goal, and their heights do not count.
TIP_M = 0.025
FRAMES = 15


class RopeTip(Loop):
    """The hand does not touch the end: it drags and swings the rope."""

    name = "rope_tip"
    title = "rope tip to a goal"
    scene = "rope"
    mass_kg = 0.12
    steps = 35
    target = f"tip within {LIMIT_MM:.0f} mm of its place on the table"

    def prepare(self) -> None:
        """The goal is where the real rope's tip gets when its hand moves by about 15 cm."""
        controls, rest = self.geometry.controls, self.geometry.rest_positions
        apart = np.linalg.norm(rest[:, None] - controls[None], axis=-1).min(axis=1)
        self.tip = near(rest, rest[apart.argmax()][None], TIP_M)
        offset = np.array([0.12, 0.06, 0.06]) + self.rng.uniform(-0.02, 0.02, 3)
        reached = self.real.rollout(
            trajectories=interpolate([[controls, controls + offset]], 60),
            initial=self.start,
            vary=self.vary,
            returns=Returns(final_state=True),
        )
        self.goal = reached.final_positions[0, self.tip, :2].mean(axis=0)

    def move(self, step: int, believed: State) -> Planned:
        """Brings the tip to the goal."""
        tip = np.asarray(believed.positions, dtype=float)[self.tip]
        beside = tip[:, :2] - tip[:, :2].mean(axis=0)
        places = np.column_stack([self.goal + beside, tip[:, 2]])
        costs = [*reach(self.tip, places, 1.0, FRAMES), *care(FRAMES, motion=0.03)]
        return Planned(costs=costs, search=search(0.05, seed=1000 * self.seed + step, samples=48))

    def outcome(self, state: State) -> Outcome:
        """The distance of the tip."""
        tip = np.asarray(state.positions, dtype=float)[self.tip, :2].mean(axis=0)
        error_mm = 1e3 * float(np.linalg.norm(tip - self.goal))
        return Outcome(error_mm <= LIMIT_MM, error_mm)
