"""Rollout costs as a PyTorch function: forward simulates, backward is the gradient by knots.

from bendtwin.planners.torch import rollout_costs

knots = torch.zeros(1, 5, task.dims, requires_grad=True)
rollout_costs(task, knots, state).sum().backward()
knots.grad
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import torch

from bendtwin.planners.task import Problem, Task
from bendtwin.simulation.state import InitialState
from bendtwin.simulation.world import GradientOptions

_SMOOTHED = GradientOptions(smoothing_m=0.001)


class _RolloutCosts(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, knots: Any, task: Problem, initial: InitialState | None) -> Any:
        wanted = ctx.needs_input_grad[0]
        plans = knots.detach().cpu().double().numpy()
        evaluation = task.evaluate(plans, initial, gradients=wanted)
        if wanted:
            ctx.save_for_backward(torch.as_tensor(evaluation.gradients).to(knots))
        return torch.as_tensor(evaluation.costs).to(knots)

    @staticmethod
    def backward(ctx: Any, *by_costs: Any) -> Any:
        (gradients,) = ctx.saved_tensors
        return by_costs[0][:, None, None] * gradients, None, None


def rollout_costs(task: Problem, knots: torch.Tensor, initial: InitialState | None = None) -> Any:
    """Costs [B] of knots [B, K, D] from a state, in one call; differentiable once by the knots.

    Contact is smoothed over a millimetre where a gradient is wanted, in the costs as well, unless
    the task has other options: a step along a gradient through impacts leads astray.
    """
    if isinstance(task, Task) and task.gradient is None:
        task = replace(task, gradient=_SMOOTHED)
    return _RolloutCosts.apply(knots, task, initial)
