"""A twin as a vector environment of Gymnasium: all environments are one batch.

from bendtwin.planners.gymnasium import TwinVectorEnv

task = Task(twin=twin, costs=costs, space=space, frames=6, initial=state)
env = TwinVectorEnv(task, num_envs=16, nodes=[tip], episode_frames=60)
observation, info = env.reset(seed=0)
observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from bendtwin.planners.task import Task
from bendtwin.simulation.rollout import Returns
from bendtwin.simulation.state import Grasping, State

#: Whether each of the states [B] is a success, [B].
Success = Callable[[State], npt.ArrayLike]
_Mask = npt.NDArray[np.bool_]


class TwinVectorEnv(VectorEnv):
    """An action is the change of the task's coordinates in one step, [D], of `task.frames` frames.

    Episodes begin in the initial state of the task, with its paths and closings, and zeros as
    coordinates. Observations are positions and velocities of nodes and the coordinates, [6 M + D].
    The reward is the negative cost of the step.

    An episode is truncated after `episode_frames`. It terminates where it succeeds, and where an
    instance diverges, or is implausible and the task refuses that. To diverge is the worst outcome:
    the step costs `diverged_cost`, and so does each that the episode would still have had, while no
    other step costs more. With NEXT_STEP the step after the last one begins another episode and
    ignores its action; with SAME_STEP the last one does, and `info` has `final_info` and the last
    observation, `final_obs`.

    `info` has `is_success`, `diverged` and `strain`, the largest of a spring in this step.
    """

    def __init__(
        self,
        task: Task,
        *,
        num_envs: int,
        nodes: npt.ArrayLike,
        episode_frames: int,
        largest_step: npt.ArrayLike = 0.01,
        success: Success | None = None,
        diverged_cost: float = 100.0,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
    ) -> None:
        """Makes environments of a task, whose initial state is that of all episodes.

        Args:
            task: `vary` may have a factor for each environment.
            num_envs: Number of environments.
            nodes: Nodes that are observed, [M].
            episode_frames: Length of an episode.
            largest_step: Bounds of actions, a number or by coordinate [D].
            success: Says of states with [num_envs] in front which ones are a success.
            diverged_cost: Cost of a step that diverges.
            autoreset_mode: NEXT_STEP or SAME_STEP.
        """
        if autoreset_mode not in (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP):
            raise ValueError("episodes begin again with NEXT_STEP or SAME_STEP")
        if task.ensemble is not None:
            raise ValueError("an environment is one object: vary the task by environment instead")
        self.metadata: dict[str, Any] = {"autoreset_mode": autoreset_mode}
        self.task: Task = task
        self.num_envs: int = num_envs
        self._is_same_step = autoreset_mode is AutoresetMode.SAME_STEP
        self._nodes = np.asarray(nodes)
        self._start = _start(task, num_envs)
        self._episode_frames, self._diverged_cost = episode_frames, diverged_cost
        self._success = success
        largest = np.broadcast_to(np.asarray(largest_step, np.float32), (task.dims,))
        size = 6 * len(self._nodes) + task.dims
        self.single_action_space: spaces.Box = spaces.Box(-largest, largest, dtype=np.float32)
        self.single_observation_space: spaces.Box = spaces.Box(
            -np.inf, np.inf, (size,), dtype=np.float32
        )
        self.action_space: spaces.Space[Any] = batch_space(self.single_action_space, num_envs)
        self.observation_space: spaces.Space[Any] = batch_space(
            self.single_observation_space, num_envs
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.float32], dict[str, Any]]:
        """Starts all episodes anew."""
        super().reset(seed=seed, options=options)
        self._state = self._start
        self._coordinates = np.zeros((self.num_envs, self.task.dims))
        self._frames = np.zeros(self.num_envs, np.int64)
        self._ended = np.zeros(self.num_envs, bool)
        nothing = {"is_success": self._ended, "diverged": self._ended, "strain": 0.0 * self._ended}
        return self._observed(), _info(nothing, ~self._ended)

    def step(self, actions: npt.ArrayLike) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Simulates one step of all environments, in one call."""
        task, restarted = self.task, self._ended
        self._restart(restarted)
        space = self.single_action_space
        changes = np.clip(np.asarray(actions, np.float64), space.low, space.high)
        after = self._coordinates + np.where(restarted[:, None], 0.0, changes)
        result = replace(task, since=self._frames + np.asarray(task.since)).rollout(
            np.stack([self._coordinates, after], axis=1),
            self._state,
            returns=Returns(final_state=True, diagnostics=True),
        )
        diverged = ~np.isfinite(result.costs) & ~restarted
        moved = ~restarted & ~diverged
        self._state = _chosen(moved, result.states(), self._state)
        self._coordinates[moved] = after[moved]
        steps_left = -((self._frames - self._episode_frames) // task.frames)
        self._frames[~restarted] += task.frames
        cost = np.minimum(result.costs, self._diverged_cost)
        reward = -np.where(moved, cost, diverged * self._diverged_cost * steps_left)
        success = np.zeros(self.num_envs, bool)
        if self._success is not None:
            success = moved & np.asarray(self._success(self._state), bool)
        terminated = diverged | success
        truncated = (self._frames >= self._episode_frames) & ~terminated
        values = {
            "is_success": success,
            "diverged": diverged,
            "strain": np.where(restarted, 0.0, [d.max_strain for d in result.diagnostics]),
        }
        self._ended = terminated | truncated
        observed, info = self._observed(), _info(values, np.ones_like(self._ended))
        if self._is_same_step and self._ended.any():
            info = _last(observed, values, self._ended)
            self._restart(self._ended)
            self._ended = np.zeros_like(self._ended)
            observed = self._observed()
        return observed, reward, terminated, truncated, info

    def close_extras(self, **_: Any) -> None:
        """The client of the twin stays open."""

    def _restart(self, which: _Mask) -> None:
        self._state = _chosen(which, self._start, self._state)
        self._coordinates[which] = 0.0
        self._frames[which] = 0

    def _observed(self) -> npt.NDArray[np.float32]:
        rows = (self._state.positions, self._state.velocities)
        parts = [np.asarray(r)[:, self._nodes].reshape(self.num_envs, -1) for r in rows]
        return np.concatenate([*parts, self._coordinates], axis=1).astype(np.float32)


def _info(values: dict[str, npt.NDArray[Any]], which: _Mask) -> dict[str, Any]:
    """Values of the environments in a mask, beside which Gymnasium wants it."""
    chosen = {name: np.where(which, v, np.zeros_like(v)) for name, v in values.items()}
    return chosen | {f"_{name}": which.copy() for name in values}


def _last(
    observed: npt.NDArray[np.float32], values: dict[str, npt.NDArray[Any]], ended: _Mask
) -> dict[str, Any]:
    """Values of a step in which some episodes ended and others began in their places."""
    final = np.full(len(ended), None, object)
    for i in np.flatnonzero(ended):
        final[i] = observed[i]
    return {
        **_info(values, ~ended),
        **{f"_{name}": np.ones_like(ended) for name in values},
        "final_obs": final,
        "_final_obs": ended,
        "final_info": _info(values, ended),
        "_final_info": ended,
    }


def _start(task: Task, count: int) -> State:
    """The initial state of a task with all its parts, repeated for each environment."""
    state, geometry = task.initial, task.twin.geometry()
    if not isinstance(state, State) or state.controls is None or np.ndim(state.positions) != 2:
        raise ValueError(
            "the initial state of the task must be one state with control points, as "
            "RolloutResult.state and Session.states have"
        )
    nodes, rods = np.shape(state.positions), len(geometry.rods)
    twists = np.zeros(rods) if state.twists is None and rods else state.twists
    grasping = state.grasping
    if grasping is None and task.grasps:
        # What it stands for: hands of the capture hold, grippers are open.
        phases = np.array([grasp.hand is not None for grasp in task.grasps], np.uint32)
        grasping = Grasping(phases, np.zeros(nodes[0], np.uint32), np.zeros(nodes, np.float32))

    def tiled(array: npt.ArrayLike | None) -> Any:
        return None if array is None else np.repeat(np.asarray(array)[None], count, axis=0)

    return State(
        tiled(state.positions),
        tiled(np.zeros(nodes) if state.velocities is None else state.velocities),
        tiled(twists),
        tiled(state.controls),
        None
        if grasping is None
        else Grasping(*map(tiled, (grasping.phases, grasping.holders, grasping.places))),
        tiled(state.controls if state.commanded_controls is None else state.commanded_controls),
    )


def _chosen(which: _Mask, new: State, old: State) -> State:
    """States [B], of which those in a mask are new."""

    def rows(new: npt.ArrayLike | None, old: npt.ArrayLike | None) -> Any:
        if new is None or old is None:
            return None
        mask = which.reshape(-1, *[1] * (np.ndim(new) - 1))
        return np.where(mask, new, old)

    grasping = None
    if new.grasping is not None and old.grasping is not None:
        a, b = new.grasping, old.grasping
        grasping = Grasping(
            rows(a.phases, b.phases), rows(a.holders, b.holders), rows(a.places, b.places)
        )
    return State(
        rows(new.positions, old.positions),
        rows(new.velocities, old.velocities),
        rows(new.twists, old.twists),
        rows(new.controls, old.controls),
        grasping,
        rows(new.commanded_controls, old.commanded_controls),
    )
