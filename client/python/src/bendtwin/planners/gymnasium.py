"""A twin as a vector environment of Gymnasium: all environments are one batch.

from bendtwin.planners.gymnasium import TwinVectorEnv

env = TwinVectorEnv(task, num_envs=16, nodes=[tip], initial=state, episode_frames=60)
observation, info = env.reset(seed=0)
observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from bendtwin.planners.task import Task
from bendtwin.rollout import Returns
from bendtwin.state import InitialState, State


class TwinVectorEnv(VectorEnv):
    """An action is the change of the task's coordinates in one step, [D], of `task.frames` frames.

    Observations are positions and velocities of nodes and the coordinates, [6 M + D]. The reward is
    the negative cost of the step. An episode ends after `episode_frames`, or where an instance
    diverges; the step after that starts it anew and ignores its action (NEXT_STEP).
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        task: Task,
        *,
        num_envs: int,
        nodes: npt.ArrayLike,
        initial: State,
        episode_frames: int,
        largest_step: npt.ArrayLike = 0.01,
    ) -> None:
        """`initial` is one state, of all episodes; `largest_step` bounds actions, by coordinate."""
        self.task, self.num_envs = task, num_envs
        self._nodes = np.asarray(nodes)
        self._start, self._episode_frames = initial, episode_frames
        largest = np.broadcast_to(np.asarray(largest_step, np.float32), (task.dims,))
        size = 6 * len(self._nodes) + task.dims
        self.single_action_space = spaces.Box(-largest, largest, dtype=np.float32)
        self.single_observation_space = spaces.Box(-np.inf, np.inf, (size,), dtype=np.float32)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.float32], dict[str, Any]]:
        """Starts all episodes anew."""
        super().reset(seed=seed, options=options)
        everywhere = np.ones(self.num_envs, bool)
        shape = np.asarray(self._start.positions).shape
        self._positions = np.zeros((self.num_envs, *shape), np.float32)
        self._velocities = np.zeros_like(self._positions)
        twists = self._start.twists
        self._twists = None if twists is None else np.tile(np.asarray(twists), (self.num_envs, 1))
        self._coordinates = np.zeros((self.num_envs, self.task.dims))
        self._frames = np.zeros(self.num_envs, np.int64)
        self._restart(everywhere)
        self._ended = ~everywhere
        return self._observed(), {}

    def step(self, actions: npt.ArrayLike) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Simulates one step of all environments, in one call."""
        restarted = self._ended.copy()
        self._restart(restarted)
        space = self.single_action_space
        changes = np.clip(np.asarray(actions, np.float64), space.low, space.high)
        after = self._coordinates + np.where(restarted[:, None], 0.0, changes)
        knots = np.stack([self._coordinates, after], axis=1)
        result = self.task.twin.rollout(
            **self.task.space.actions(knots),
            frames=self.task.frames,
            initial=self._state(knots),
            costs=self.task.costs,
            returns=Returns(final_state=True),
            fidelity=self.task.fidelity,
        )
        if result.final_positions is None or result.final_velocities is None:
            raise ValueError("the server returned no final states")
        diverged = ~np.isfinite(result.costs)
        moved = ~restarted & ~diverged
        self._positions[moved] = result.final_positions[moved]
        self._velocities[moved] = result.final_velocities[moved]
        if self._twists is not None and result.final_twists is not None:
            self._twists[moved] = result.final_twists[moved]
        self._coordinates[moved] = after[moved]
        self._frames[~restarted] += self.task.frames
        terminated = diverged & ~restarted
        truncated = (self._frames >= self._episode_frames) & ~terminated & ~restarted
        self._ended = terminated | truncated
        reward = np.where(moved, -np.where(diverged, 0.0, result.costs), 0.0)
        return self._observed(), reward, terminated, truncated, {}

    def close_extras(self, **_: Any) -> None:
        """The client of the twin stays open."""

    def _restart(self, which: npt.NDArray[np.bool_]) -> None:
        self._positions[which] = np.asarray(self._start.positions)
        velocities = self._start.velocities
        self._velocities[which] = 0.0 if velocities is None else np.asarray(velocities)
        if self._twists is not None:
            self._twists[which] = np.asarray(self._start.twists)
        self._coordinates[which] = 0.0
        self._frames[which] = 0

    def _state(self, knots: npt.NDArray[np.float64]) -> InitialState:
        actions = self.task.space.actions(knots)
        controls = actions["trajectories"][:, 0] if "trajectories" in actions else None
        return State(self._positions, self._velocities, self._twists, controls)

    def _observed(self) -> npt.NDArray[np.float32]:
        rows = (self._positions[:, self._nodes], self._velocities[:, self._nodes])
        parts = [row.reshape(self.num_envs, -1) for row in rows]
        return np.concatenate([*parts, self._coordinates], axis=1).astype(np.float32)
