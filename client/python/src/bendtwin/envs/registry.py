"""The tasks by name, and environments made of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium

from bendtwin.envs.tasks import Fold, InsertEnd, LayAlong, MoveTip, PutInBin, Task
from bendtwin.envs.vector_env import TwinVectorEnv
from bendtwin.twin import Twin

#: Namespace of the environments in Gymnasium's registry.
NAMESPACE = "BendTwin"

_tasks: dict[str, type[Task]] = {}


def register(task: type[Task]) -> type[Task]:
    """Adds a task under its name, here and as `BendTwin/{name}-v0` in Gymnasium's registry.

    Usable as a decorator. Another task of that name is replaced.
    """
    _tasks[task.name] = task
    gymnasium.register(
        f"{NAMESPACE}/{task.name}-v0",
        entry_point="bendtwin.envs.single_env:TwinEnv",
        vector_entry_point="bendtwin.envs.vector_env:TwinVectorEnv",
        kwargs={"task": task},
        disable_env_checker=True,
    )
    return task


def list_tasks() -> list[str]:
    """Names of the tasks."""
    return sorted(_tasks)


def make(
    task: str | type[Task],
    twin: Twin | str,
    num_envs: int = 1,
    *,
    task_options: Mapping[str, Any] | None = None,
    **options: Any,
) -> TwinVectorEnv:
    """Environments of a task on a twin, by the name of the task or its class.

    `options` are those of `TwinVectorEnv`, `task_options` those of the task.

    Raises:
        ValueError: If there is no task of this name, or if the object does not suit it.
    """
    if isinstance(task, str):
        if task not in _tasks:
            raise ValueError(f"there is no task {task!r}; there are {', '.join(list_tasks())}")
        task = _tasks[task]
    return TwinVectorEnv(twin, task, num_envs=num_envs, task_options=task_options, **options)


for _task in (Fold, InsertEnd, LayAlong, MoveTip, PutInBin):
    register(_task)
