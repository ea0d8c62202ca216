"""The planner of the server, with the interface of those in this package."""

from __future__ import annotations

import time

import numpy as np
import numpy.typing as npt

from bendtwin.errors import BendTwinError
from bendtwin.planners.knots import Array, shifted
from bendtwin.planners.plan import ServerPlan
from bendtwin.planners.planner import EveryPlanDiverged
from bendtwin.planners.task import ACTIONS, Task
from bendtwin.simulation.plan import PlanUpdate, Search, server_space
from bendtwin.simulation.state import InitialState

_SEARCH = Search()


class OnServer:
    """A planner with a warm start whose search is done by the server, in one call a plan.

    One plan goes over the wire instead of a batch of them in every iteration, and the server
    spreads batches over its workers. The space of the task is one of this package.

    With a `grasp_search` of the task the first plan also finds the place to grasp. From then on
    `task` is that of the place: its space starts there, and the following plans search no more.
    `reset` lets the next plan search again.
    """

    def __init__(self, task: Task, *, knots: int = 5, search: Search = _SEARCH) -> None:
        """Plans for a task with K knots; `search` says how."""
        if knots < 2:
            raise ValueError("a planner needs two knots or more")
        server_space(task.space)  # Refuses others before the first plan.
        self.task: Task = task
        self._first = task
        self.knots: int = knots
        self.search: Search = search
        #: Frames that were executed since the start, or since `reset`.
        self._frame = 0.0
        #: The plan that the next call begins with.
        self.nominal: Array = np.zeros((knots, task.dims))

    def plan(
        self, initial: InitialState | None = None, *, nominal: npt.ArrayLike | None = None
    ) -> ServerPlan:
        """Lowers the cost of the nominal plan from a state; None is the task's own.

        The nominal plan is that of the call before, shifted, unless one is given: knots [K, D].
        A state of a session stays at the server: `SessionSlots`.

        Raises:
            EveryPlanDiverged: If no plan of the first iteration could be simulated.
            BendTwinError: If the server refuses; see docs/use/errors.md.
            ValueError: If paths or closings of the task change between knots.
        """
        task, began = self.task.at(self._frame), time.monotonic()
        start = self.nominal if nominal is None else self._checked(nominal)
        request = task.request(start[None], initial)
        if any(request[kind].shape[1] != self.knots for kind in ACTIONS & request.keys()):
            raise ValueError(
                "paths and closings change between the knots of the plan: shift by as many frames "
                "as lie between knots, have them change there, or plan with Mppi, say"
            )
        try:
            found = task.twin.plan(
                **request,
                search=self.search,
                space=server_space(task.space),
                grasp_search=task.grasp_search,
            )
        except BendTwinError as error:
            if error.reason == "EVERY_PLAN_DIVERGED":
                raise EveryPlanDiverged from error
            raise
        self.nominal = np.array(found.coordinates)
        if found.grasp is not None:
            self.task, task = self.task.at_place(found.grasp), task.at_place(found.grasp)
        return self._planned(task, found, time.monotonic() - began)

    def shift(self, frames: float) -> None:
        """Moves the nominal plan on by frames that were executed, at its end it stands still, and
        the task with it."""
        self.nominal = shifted(self.nominal, frames, self.task.frames, self.task.interpolation)
        self._frame += frames

    def reset(self, nominal: npt.ArrayLike | None = None) -> None:
        """Forgets the plan before: the next one begins with these knots, or with staying still at
        the start of the action space."""
        shape = (self.knots, self.task.dims)
        self.nominal = np.zeros(shape) if nominal is None else self._checked(nominal)
        self._frame = 0.0
        self.task = self._first

    def _checked(self, nominal: npt.ArrayLike) -> Array:
        array = np.array(nominal, dtype=np.float64)
        shape = (self.knots, self.task.dims)
        if array.shape != shape or not np.isfinite(array).all():
            raise ValueError(f"nominal has shape {array.shape}: give finite knots {list(shape)}")
        return array

    def _planned(self, task: Task, found: PlanUpdate, time_s: float) -> ServerPlan:
        return ServerPlan(
            knots=self.nominal,
            cost=found.cost,
            origin=found.origin,
            nominal_cost=found.nominal_cost,
            iterations=found.iterations,
            time_s=time_s,
            stopped="deadline" if found.stopped_by_deadline else "iterations",
            problem=task,
            excess=found.excess,
            overstrained=found.overstrained,
            cost_terms=found.cost_terms,
            simulated=found.simulated,
            diverged=found.diverged,
            grasp=found.grasp,
            grasp_costs=found.grasp_costs,
            grasp_force_n=found.grasp_force_n,
        )
