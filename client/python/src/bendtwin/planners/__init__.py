"""Planners in NumPy, on top of batched rollouts: small enough to read and to change.

from bendtwin.planners import Bounds, Mppi, Task, Together

task = Task(twin=twin, costs=costs, space=Together(controls), frames=20)
planner = Mppi(task, samples=64, sigma=0.06, bounds=Bounds(speed=0.5))
plan = planner.plan(state)
result = twin.rollout(**plan.actions(frames=3), initial=state)
planner.shift(frames=3)
"""

from bendtwin.planners.methods import Cem, GradientDescent, Mppi, PredictiveSampling
from bendtwin.planners.on_server import OnServer
from bendtwin.planners.plan import Plan, Planned, ServerPlan
from bendtwin.planners.planner import EveryPlanDiverged, Planner
from bendtwin.planners.spaces import ActionSpace, Grippers, MachineSpace, PerHand, Points, Together
from bendtwin.planners.task import Evaluation, Problem, Task
from bendtwin.simulation.bounds import Bounds

__all__ = [
    "ActionSpace",
    "Bounds",
    "Cem",
    "Evaluation",
    "EveryPlanDiverged",
    "GradientDescent",
    "Grippers",
    "MachineSpace",
    "Mppi",
    "OnServer",
    "PerHand",
    "Plan",
    "Planned",
    "Planner",
    "Points",
    "PredictiveSampling",
    "Problem",
    "ServerPlan",
    "Task",
    "Together",
]
