"""Attributes of single environments, which loops such as LeRobot's ask a vector environment for."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.envs.tasks.task import Task


class Slot:
    """An environment of a vector environment, which can be asked, but not stepped."""

    def __init__(self, env: Any, number: int) -> None:
        self._env, self._number = env, number

    @property
    def task(self) -> str:
        """Name of the task."""
        return str(self._env.task_on_body.name)

    @property
    def task_description(self) -> str:
        """The task as a sentence."""
        return str(self._env.task_on_body.instruction)

    @property
    def _max_episode_steps(self) -> int:
        return int(self._env.horizon)

    @property
    def unwrapped(self) -> Slot:
        """Itself."""
        return self

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The picture of this environment."""
        drawn = self._env.render_slots(np.array([self._number]))
        return None if drawn is None else np.asarray(drawn[0])

    def __getattr__(self, name: str) -> Any:
        return getattr(self._env, name)


class Slots:
    """`envs`, `call` and `get_attr`, as Gymnasium's own vector environments have them."""

    num_envs: int
    task_on_body: Task

    @property
    def envs(self) -> list[Slot]:
        """The environments one by one."""
        return [Slot(self, number) for number in range(self.num_envs)]

    def call(self, name: str, *arguments: Any, **named: Any) -> tuple[Any, ...]:
        """The results of a method of every environment, or the values of an attribute."""
        if name == "render":
            frames = self.render()
            return (None,) * self.num_envs if frames is None else frames
        found = [getattr(slot, name) for slot in self.envs]
        return tuple(one(*arguments, **named) if callable(one) else one for one in found)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """The values of an attribute of every environment."""
        return tuple(getattr(slot, name) for slot in self.envs)

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """Pictures of all environments."""
        raise NotImplementedError
