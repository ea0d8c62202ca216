"""A single environment of Gymnasium: a vector environment of one slot."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode

from bendtwin.envs.observations import Observed
from bendtwin.envs.tasks.task import Task
from bendtwin.envs.vector_env import TwinVectorEnv
from bendtwin.twin import Twin


class TwinEnv(gymnasium.Env):
    """A task on a twin. Its arguments are those of `TwinVectorEnv`."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012

    def __init__(self, twin: Twin | str, task: type[Task], **options: Any) -> None:
        options = {**options, "num_envs": 1, "autoreset_mode": AutoresetMode.DISABLED}
        #: The vector environment.
        self.vector: TwinVectorEnv = TwinVectorEnv(twin, task, **options)
        self.metadata = {k: v for k, v in self.vector.metadata.items() if k != "autoreset_mode"}
        self.render_mode = self.vector.render_mode
        self.action_space = self.vector.single_action_space
        self.observation_space = self.vector.single_observation_space

    @property
    def task(self) -> str:
        """Name of the task."""
        return self.vector.envs[0].task

    @property
    def task_description(self) -> str:
        """The task as a sentence."""
        return self.vector.envs[0].task_description

    @property
    def _max_episode_steps(self) -> int:
        return self.vector.horizon

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observed, dict[str, Any]]:
        """Begins an episode."""
        super().reset(seed=seed)
        observed, info = self.vector.reset(seed=seed)
        return _first(observed), _first_info(info)

    def step(self, action: npt.ArrayLike) -> tuple[Observed, float, bool, bool, dict[str, Any]]:
        """Moves the object."""
        observed, reward, terminated, truncated, info = self.vector.step(np.asarray(action)[None])
        ends = bool(terminated[0]), bool(truncated[0])
        return _first(observed), float(reward[0]), *ends, _first_info(info)

    def render(self) -> npt.NDArray[np.uint8] | None:
        """A picture [height, width, 3]."""
        drawn = self.vector.render()
        return None if drawn is None else np.asarray(drawn[0])

    def close(self) -> None:
        """Ends the session."""
        self.vector.close()


def _first(observed: Observed) -> Observed:
    return {
        name: _first(part) if isinstance(part, dict) else part[0] for name, part in observed.items()
    }


def _first_info(info: dict[str, Any]) -> dict[str, Any]:
    return {name: bool(value[0]) for name, value in info.items() if not name.startswith("_")}
