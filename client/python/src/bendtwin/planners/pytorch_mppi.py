"""MPPI of pytorch-mppi, with a twin as the model: one call for all samples of a command.

from bendtwin.planners.pytorch_mppi import TwinMppi

mppi = TwinMppi(task, noise_sigma=0.01 * torch.eye(3), num_samples=64)
mppi.initial = state
action = mppi.command(torch.zeros(3))  # Where the coordinates are now.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from pytorch_mppi import MPPI

from bendtwin.planners.task import Task
from bendtwin.simulation.state import InitialState


class TwinMppi(MPPI):
    """MPPI whose state is the coordinates [D] of the task's action space, whose actions are their
    changes from frame to frame, and whose horizon is the task's."""

    def __init__(self, task: Task, noise_sigma: torch.Tensor, **settings: Any) -> None:
        """`settings` are those of `pytorch_mppi.MPPI`."""
        self.task = task
        #: Where the object is; None is the task's own state.
        self.initial: InitialState | None = None
        super().__init__(
            lambda state, action: state + action,
            lambda state, action: torch.zeros(len(state), dtype=state.dtype),
            task.dims,
            noise_sigma,
            horizon=task.frames,
            **settings,
        )

    def _compute_rollout_costs(self, perturbed_actions: Any) -> Any:
        changes = (self.u_scale * perturbed_actions).detach().cpu().double().numpy()
        now = self.state.detach().cpu().double().numpy().reshape(-1, 1, self.task.dims)
        steps = np.concatenate([np.zeros_like(changes[:, :1]), changes], axis=1)
        costs = self.task.evaluate(now + steps.cumsum(axis=1), self.initial).costs
        # The weights are exponentials of costs: infinity would make them NaN where all diverge.
        costs = np.where(np.isfinite(costs), costs, np.finfo(np.float32).max / 4)
        return torch.as_tensor(costs).to(perturbed_actions), None, None
