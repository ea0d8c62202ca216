"""Policies without learning: random actions, and the scripts of tasks."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from bendtwin.envs.body import Array
from bendtwin.envs.observations import Observed
from bendtwin.envs.vector_env import TwinVectorEnv

#: Steps after which a script continues although a waypoint is not reached.
_PATIENCE = 12
#: Steps that a gripper waits where it closes or opens.
_WAIT = 1


class Policy(Protocol):
    """What chooses actions."""

    def __call__(self, observed: Observed) -> npt.ArrayLike:
        """Actions [B, A] for a batch of observations."""


class RandomPolicy:
    """Evenly distributed actions."""

    def __init__(self, env: TwinVectorEnv, seed: int = 0) -> None:
        self._shape = (env.num_envs, *env.single_action_space.shape)
        self._random = np.random.default_rng(seed)

    def __call__(self, observed: Observed) -> npt.NDArray[np.float32]:
        """Actions [B, A]."""
        return self._random.uniform(-1.0, 1.0, self._shape).astype(np.float32)


class ScriptedPolicy:
    """The script of the environment's task, which sees the state and not the observation.

    Demonstrations that are to show the way back to the script need disturbances: `noise` is their
    standard deviation in parts of the largest coordinate of a gripper's change, so that they are
    small where precision matters. Openings are not disturbed.
    """

    def __init__(self, env: TwinVectorEnv, *, noise: float = 0.0, seed: int = 0) -> None:
        self._env, self._noise = env, noise
        self._random = np.random.default_rng(seed)
        slots, grippers = env.num_envs, env.task_on_body.grippers
        self._stage = np.full(slots, -1)
        self._since = np.zeros(slots, np.int64)
        self._goals = np.zeros((slots, grippers, 7))

    def __call__(self, observed: Observed) -> npt.NDArray[np.float32]:
        """Actions [B, A]; those without noise are `clean`."""
        env = self._env
        view = env.view
        way = env.task_on_body.script(view)
        begun = (env.steps == 0) & (self._since > 0)
        self._stage[begun | (self._stage < 0)] = -1
        done = self._done(view.grippers)
        nexts = np.minimum(self._stage + 1, len(way) - 1)
        moving = (self._stage < 0) | (done & (self._stage < len(way) - 1))
        stays = np.array([bool(np.isnan(point.poses).all()) for point in way])
        near = np.array([point.near for point in way])
        for slot in np.flatnonzero(moving).tolist():
            self._stage[slot] = nexts[slot]
            self._since[slot] = 0
            poses = np.broadcast_to(way[nexts[slot]].poses, self._goals.shape)[slot]
            self._goals[slot] = np.where(np.isnan(poses), view.grippers[slot], poses)
        closed = np.array([way[stage].closed for stage in self._stage])
        self._since += 1
        self._stays, self._near = stays[self._stage], near[self._stage]
        self.clean: npt.NDArray[np.float32] = env.actions_towards(self._goals, closed)
        if not self._noise:
            return self.clean
        changes = self.clean.reshape(len(self.clean), -1, 7).copy()
        noise = self._random.normal(0.0, self._noise, (*changes.shape[:2], 6))
        changes[..., :6] += noise * np.abs(changes[..., :6]).max(axis=-1, keepdims=True)
        return np.clip(changes, -1.0, 1.0).reshape(self.clean.shape)

    def _done(self, poses: Array) -> npt.NDArray[np.bool_]:
        """Slots that have reached their waypoints."""
        if not self._since.any():
            return np.zeros(len(poses), bool)
        largest = self._env.largest_step
        apart = np.abs(poses[..., :3] - self._goals[..., :3]).max(axis=(1, 2)) / largest[0]
        facing = np.abs((poses[..., 3:] * self._goals[..., 3:]).sum(axis=-1)).min(axis=1)
        turned = 2.0 * np.arccos(np.clip(facing, 0.0, 1.0)) / largest[3]
        near = (apart < self._near) & (turned < 2 * self._near)
        waited = np.where(self._stays, self._since >= _WAIT, near)
        return np.asarray(waited | (self._since >= _PATIENCE))
