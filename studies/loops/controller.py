"""The controller: in each step of a loop it corrects a session by what was seen, plans from there,
and advances the session by what the robot is about to do.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin import BendTwinError, Returns, Search, Session, interpolate_poses
from studies.loops.episode import Episode
from studies.loops.loop import Loop, Move, Planned, Scripted

#: Deviation that is expected of a point, noise and the coarse skin, and what to do without it.
CORRECTION: Any = {"noise_m": 0.004, "register_if_lost": True}
NOT_EXPLAINED = ("OBSERVATION_NOT_EXPLAINED", "OBJECT_LOST")


class Controller:
    """A session of the twin that plans, and the nominal plan."""

    def __init__(self, session: Session, loop: Loop, episode: Episode) -> None:
        self._session, self._loop, self._episode = session, loop, episode
        self._believed = loop.believed
        #: Knots that the next plan begins with [1, K, G, 7]; none after a motion that was given.
        self._nominal: npt.NDArray[Any] | None = None

    def step(self, number: int, seen: dict[str, Any] | None) -> dict[str, Any]:
        """Takes a step of the loop; returns the actions that the robot executes.

        Args:
            number: The step.
            seen: An observation, as arguments of a correction; None: nothing was seen.
        """
        move = self._loop.move(number, self._believed)
        if seen is not None:
            self._episode.corrections += 1
        with self._episode.timed("step"):
            if isinstance(move, Planned):
                path = self._planned(move, seen)
            else:
                path = self._scripted(move, seen)
        self._loop.grippers = path[0, -1].astype(float)
        return self._actions(path, move)

    def _planned(self, move: Planned, seen: dict[str, Any] | None) -> npt.NDArray[np.float32]:
        """Corrects, plans and advances by `session.step`; the poses of the grippers by frame."""
        observed = dict(seen or {})
        points = observed.pop("points", None)
        frames = self._loop.step_frames
        done = self._session.step(
            points,
            self._search(move),
            frames=frames,
            correct=None if points is None else {**observed, **CORRECTION},
        )
        self._believed = done.state
        self._episode.refused_corrections += done.refused is not None
        self._episode.lost += done.lost
        for part in ("correct", "plan", "advance"):
            if part != "correct" or points is not None:
                self._episode.latencies_s[part].append(getattr(done, f"{part}_s"))
        return self._keep(move, done.plan.knots)[:, : frames + 1]

    def _scripted(self, move: Scripted, seen: dict[str, Any] | None) -> npt.NDArray[np.float32]:
        """Corrects and advances, for a motion that is given."""
        if seen is not None:
            try:
                with self._episode.timed("correct"):
                    (correction,) = self._session.correct(**seen, **CORRECTION)
                self._episode.lost += correction.lost
            except BendTwinError as error:
                if error.reason not in NOT_EXPLAINED:
                    raise
                self._episode.refused_corrections += 1
        self._nominal = None
        ends = np.stack([self._loop.grippers, np.asarray(move.poses, dtype=float)])[None]
        path = interpolate_poses(ends, self._loop.step_frames)
        with self._episode.timed("advance"):
            done = self._session.advance(
                **self._actions(path, move), returns=Returns(final_state=True)
            )
        self._believed = done.state(0)
        return path

    def _search(self, move: Planned) -> Any:
        """Arguments of a plan."""
        nominal = self._nominal
        if nominal is None:
            nominal = np.stack([self._loop.grippers] * move.knots)[None]
        return {
            **self._actions(nominal, move),
            "world": self._loop.world,
            "frames": move.frames,
            "costs": move.costs,
            "search": self._above_the_table(move),
            "space": move.space,
        }

    def _keep(self, move: Planned, knots: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
        """Poses of the grippers in every frame of a plan [1, F + 1, G, 7].

        The next plan begins with what is left of it, at whose end the grippers stay.
        """
        path = interpolate_poses(knots, move.frames)
        later = self._loop.step_frames + np.linspace(0, move.frames, move.knots).round().astype(int)
        self._nominal = path[:, np.minimum(later, move.frames)]
        return path

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

    def _above_the_table(self, move: Planned) -> Search:
        """The search with bounds, which count from where the grippers are, for their heights."""
        low = np.full((len(self._loop.grippers), 3 if move.space == "translation" else 6), -np.inf)
        low[:, 2] = np.minimum(self._loop.lowest_m - self._loop.grippers[:, 2], 0.0)
        bounds = replace(move.search.bounds, low=low.reshape(-1))
        return replace(move.search, bounds=bounds)
