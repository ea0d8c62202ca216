"""Controllers of judo, with a twin as the model: one call for all samples of an iteration.

from judo.controller import Controller, ControllerConfig
from judo.optimizers.mppi import MPPI, MPPIConfig
from bendtwin.planners.judo import TwinBackend, TwinTask

goal = TwinTask(task, fastest=0.5, nodes=[tip])
settings = ControllerConfig(horizon=task.frames * task.frame_s)
optimizer = MPPI(MPPIConfig(num_rollouts=48, sigma=0.2), goal.nu)
controller = Controller(settings, goal, optimizer, rollout_backend=TwinBackend(goal, 48))
goal.initial = state
controller.current_state = goal.state(coordinates)
controller.update_action()
velocity = controller.action(controller.time)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
from judo.tasks.base import Task as JudoTask
from judo.tasks.base import TaskConfig
from judo.utils.rollout_backend import RolloutBackend

from bendtwin.planners.knots import Array
from bendtwin.planners.task import Task
from bendtwin.planners.velocity import model_xml, simulate
from bendtwin.simulation.state import InitialState


@dataclass
class TwinTaskConfig(TaskConfig):
    """No settings: costs are those of the twin's task."""


class TwinTask(JudoTask[TwinTaskConfig]):
    """A task of judo: controls are velocities of the coordinates [D] of a task's action space,
    states are coordinates and velocities [2 D], its sensors the positions of nodes [3 M] and the
    cost of the frame. Override `reward` for another one of these.
    """

    config_t = TwinTaskConfig

    def __init__(self, task: Task, *, fastest: npt.ArrayLike, nodes: Sequence[int] = ()) -> None:
        """Makes the task.

        Args:
            task: Twin, costs and action space; its horizon is left to the controller.
            fastest: Limits of the velocities: a number or [D], metres or radians per second.
            nodes: Nodes that are observed, and whose ways judo draws.
        """
        # What the base class does would look for its own models on the network.
        self.task: Task = task
        self.nodes: list[int] = list(nodes)
        #: Where the object is; None is the task's own state.
        self.initial: InitialState | None = None
        self.config: TwinTaskConfig = TwinTaskConfig()
        xml = model_xml(task.dims, task.frame_s, fastest, self.nodes, has_sensors=True)
        self.spec: mujoco.MjSpec = mujoco.MjSpec.from_string(xml)
        self.model: mujoco.MjModel = self.spec.compile()
        self.sim_model: mujoco.MjModel = self.model
        self.data: mujoco.MjData = mujoco.MjData(self.model)
        self.model_path: str = ""

    def state(self, coordinates: npt.ArrayLike) -> Array:
        """The controller's state [2 D] where the coordinates are these."""
        now = np.asarray(coordinates, dtype=np.float64)
        return np.concatenate([now, np.zeros_like(now)])

    def reward(
        self,
        states: npt.NDArray[Any],
        sensors: npt.NDArray[Any],
        controls: npt.NDArray[Any],
        system_metadata: dict[str, Any] | None = None,
    ) -> Array:
        """The negative costs [N] of sensors [N, T, 3 M + 1]."""
        return np.asarray(-sensors[..., -1].sum(axis=1))


class TwinBackend(RolloutBackend):
    """Rollouts of a twin, for `judo.controller.Controller`."""

    def __init__(self, task: TwinTask, num_threads: int) -> None:
        """`num_threads` is what judo calls the number of samples."""
        self.task: TwinTask = task
        self.num_threads: int = num_threads

    def rollout(
        self, x0: npt.NDArray[Any], controls: npt.NDArray[Any], last_policy_output: Any = None
    ) -> tuple[Array, Array, None]:
        """States [N, T, 2 D] and sensors [N, T, 3 M + 1] of controls [N, T, D] from a state."""
        task = self.task.task
        now = np.asarray(x0)[..., : task.dims]
        motion = simulate(task, now, controls, self.task.initial, self.task.nodes)
        # Weights are exponentials of costs: infinity would make them NaN where all diverge.
        costs = np.minimum(motion.costs, np.finfo(np.float32).max)
        places = motion.nodes.reshape(*costs.shape, -1)
        states = np.concatenate([motion.coordinates, controls], axis=2)
        return states, np.concatenate([places, costs[..., None]], axis=2), None

    def update(self, num_threads: int) -> None:
        """Takes another number of samples."""
        self.num_threads = num_threads
