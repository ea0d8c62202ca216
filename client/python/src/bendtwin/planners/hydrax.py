"""Controllers of hydrax, with a twin as the model: one call for all samples of an iteration.

The hydrax of the registry of Python packages is another one: install vincekurtz/hydrax from its
repository. Any of its controllers becomes one of a twin with `TwinRollouts` in front:

from hydrax.algs import MPPI
from bendtwin.planners.hydrax import TwinRollouts, TwinTask

class TwinMppi(TwinRollouts, MPPI): ...

goal = TwinTask(task, fastest=0.5)
controller = TwinMppi(goal, num_samples=48, noise_level=0.2, temperature=0.1,
                      plan_horizon=task.frames * task.frame_s, spline_type="linear", num_knots=4)
params = controller.init_params()
goal.initial = state
params, rollouts = jax.jit(controller.optimize)(goal.at(coordinates, time_s), params)
velocity = controller.get_action(params, time_s)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import numpy.typing as npt
from hydrax.alg_base import SamplingBasedController, Trajectory
from hydrax.task_base import Task as HydraxTask
from jax.experimental import io_callback
from mujoco import mjx

from bendtwin.planners.task import Task
from bendtwin.planners.velocity import model_xml, simulate
from bendtwin.simulation.state import InitialState


class TwinTask(HydraxTask):
    """A task of hydrax: controls are velocities of the coordinates [D] of a task's action space;
    costs are those of the task."""

    def __init__(self, task: Task, *, fastest: npt.ArrayLike, nodes: Sequence[int] = ()) -> None:
        """Makes the task.

        Args:
            task: Twin, costs and action space; its horizon is left to the controller.
            fastest: Limits of the velocities: a number or [D], metres or radians per second.
            nodes: Nodes whose ways are traced.
        """
        self.task: Task = task
        self.nodes: list[int] = list(nodes)
        #: Where the object is; None is the task's own state.
        self.initial: InitialState | None = None
        xml = model_xml(task.dims, task.frame_s, fastest, self.nodes)
        sites = [f"node_{node}" for node in self.nodes]
        super().__init__(mujoco.MjModel.from_xml_string(xml), trace_sites=sites)

    def at(self, coordinates: npt.ArrayLike, time_s: float) -> mjx.Data:
        """The controller's state where the coordinates are these."""
        return self.make_data().replace(
            qpos=jnp.asarray(coordinates, dtype=jnp.float32), time=jnp.float32(time_s)
        )

    def running_cost(self, state: mjx.Data, control: jax.Array) -> jax.Array:
        """Not used: costs come with the twin's motion."""
        raise NotImplementedError("put TwinRollouts in front of the controller's class")

    def terminal_cost(self, state: mjx.Data) -> jax.Array:
        """Not used: costs come with the twin's motion."""
        raise NotImplementedError("put TwinRollouts in front of the controller's class")


class TwinRollouts(SamplingBasedController):
    """Rollouts of a twin instead of MuJoCo's, for any controller of hydrax.

    Other parameters of the object are left to an ensemble of the task's costs: hydrax's
    randomizations are of MuJoCo's models.
    """

    def rollout_with_randomizations(
        self, state: mjx.Data, tk: jax.Array, knots: jax.Array, rng: jax.Array
    ) -> Trajectory:
        """Costs [n, H + 1] of velocity knots [n, K, D] at times tk [K] from a state."""
        if self.num_randomizations > 1:
            raise ValueError("a twin has one set of parameters here: set num_randomizations to 1")
        # The velocity of a frame is that in its middle.
        times = tk[0] + self.dt * (jnp.arange(self.ctrl_steps) + 0.5)
        controls = self.interp_func(times, tk, knots)
        count, frames = controls.shape[:2]
        shapes = (
            jax.ShapeDtypeStruct((count, frames + 1), jnp.float32),
            jax.ShapeDtypeStruct((count, frames + 1, len(self.task.nodes), 3), jnp.float32),
        )
        # Not a pure callback: it reads where the object is now.
        costs, sites = io_callback(self._simulate, shapes, state.qpos, controls)
        return Trajectory(controls=controls, knots=knots, costs=costs, trace_sites=sites)

    def _simulate(self, now: Any, controls: Any) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        task: TwinTask = self.task
        motion = simulate(
            task.task, np.asarray(now), np.asarray(controls), task.initial, task.nodes
        )
        # Weights are exponentials of costs: infinity would make them NaN where all diverge.
        costs = np.minimum(motion.costs, 1e30).astype(np.float32)
        sites = motion.nodes.astype(np.float32)
        # hydrax has a terminal cost and place after the last frame: costs at the end are in the
        # last frame's already.
        return (
            np.concatenate([costs, np.zeros_like(costs[:, :1])], axis=1),
            np.concatenate([sites, sites[:, -1:]], axis=1),
        )
