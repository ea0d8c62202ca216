"""Tasks, which planners minimize: the cost of knots, as a twin simulates them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from bendtwin.calls import roll_out
from bendtwin.planners.knots import Array, curve_matrix
from bendtwin.planners.schedule import Schedule, check_rows
from bendtwin.planners.spaces import ActionSpace, Grippers, MachineSpace
from bendtwin.simulation.bounds import Bounds
from bendtwin.simulation.costs import Cost
from bendtwin.simulation.interpolation import Interpolation, interpolate, interpolate_poses
from bendtwin.simulation.plan import GraspSearch, excess_share
from bendtwin.simulation.rollout import Fidelity, Returns, RolloutResult, warned
from bendtwin.simulation.state import InitialState, Rest
from bendtwin.simulation.world import Ensemble, GradientOptions, Grasp, Plausibility, Vary, World
from bendtwin.twin import Twin

_COSTS_ALONE = Returns()
_REST = Rest()
_NO_BOUNDS = Bounds()
_CURVES = {"trajectories": interpolate, "poses": interpolate_poses}
#: What planners of this package say of a grasp search.
NO_PLACES = (
    "the planners of the client do not search places to grasp: plan with OnServer, or without "
    "grasp_search"
)
#: Arguments of a rollout that have a row for each knot.
ACTIONS = _CURVES.keys()


@dataclass(frozen=True)
class Evaluation:
    """Result of simulating a batch of plans."""

    #: [B]; +inf where an instance diverged.
    costs: npt.NDArray[np.float64]
    #: d cost / d knots [B, K, D], if asked for.
    gradients: Array | None = None
    #: How far strain, forces of grasps, or a machine are beyond their limits, 0 where they are not
    #: [B]: a plan beyond a limit is worse than all that keep them. None: all keep them.
    excess: npt.NDArray[np.float64] | None = None


class Problem(Protocol):
    """The cost of knots; `Task` is one that asks a twin."""

    @property
    def frames(self) -> int:
        """Horizon [frames]."""

    @property
    def interpolation(self) -> Interpolation:
        """How positions between knots are made."""

    @property
    def dims(self) -> int:
        """Number of coordinates D of a knot."""

    @property
    def frame_s(self) -> float:
        """Seconds from frame to frame."""

    def at(self, frame: float) -> Problem:
        """The same problem after a number of executed frames."""

    def evaluate(
        self,
        knots: Array,
        initial: InitialState | None,
        *,
        gradients: bool = False,
        timeout_s: float | None = None,
    ) -> Evaluation:
        """Simulates knots [B, K, D] from a state."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """Costs of a twin's motion over a horizon, as a function of knots in an action space.

    All planners and adapters request rollouts and plans by `request`, so that all options here
    apply to them.
    """

    twin: Twin
    costs: Sequence[Cost]
    #: Coordinates of the knots.
    space: ActionSpace
    #: Horizon [frames].
    frames: int
    interpolation: Interpolation = "linear"
    fidelity: Fidelity = "exact"
    #: State from which planners start by default; for a session: `SessionSlots`.
    initial: InitialState = _REST
    #: Ground, gravity and colliders. A `Collider.path` has a pose for each frame boundary, [T, 7],
    #: of which the last holds on. None with the space of a machine, which has a world.
    world: World | None = None
    #: They need a space of grippers. `Grasp.closed` has a value for each frame boundary, [T], of
    #: which the last holds on, or one for all.
    grasps: Sequence[Grasp] = ()
    #: By member of the ensemble; without one, a factor for all plans.
    vary: Vary | None = None
    ensemble: Ensemble | None = None
    #: Of gradients, and of the costs beside them: gradients through impacts mislead, so smooth the
    #: contact of what lies on something (docs/use/gradients.md). Costs without gradients stay.
    gradient: GradientOptions | None = None
    #: With `refuse` plans beyond the limits count as diverged.
    plausibility: Plausibility | None = None
    #: Places to grasp, for `OnServer`, in a space of `Grippers`.
    grasp_search: GraspSearch | None = None
    #: The frame of paths and closings that the horizon begins in, or [B] of them: see `at`.
    since: npt.ArrayLike = 0.0

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise ValueError("the horizon must be one frame or more")
        if self.world is not None and isinstance(self.space, MachineSpace):
            raise ValueError("the space has a world: give the rest of it to its workcell instead")
        if self.grasp_search is not None and not isinstance(self.space, Grippers):
            raise TypeError("places to grasp are poses of grippers: plan in a space of Grippers")
        check_rows(self._world(), self.grasps, self.frames)

    @property
    def dims(self) -> int:
        """Number of coordinates D of a knot."""
        return self.space.dims

    @property
    def bounds(self) -> Bounds:
        """Limits of the coordinates: those of a machine, or none."""
        return self.space.bounds if isinstance(self.space, MachineSpace) else _NO_BOUNDS

    @property
    def frame_s(self) -> float:
        """Seconds from frame to frame of the twin."""
        return 1.0 / self.twin.info.fps if self.twin.info.fps else 1.0

    def at(self, frame: float) -> Task:
        """The same task after a number of executed frames: paths and closings continue there."""
        return replace(self, since=np.asarray(self.since) + frame)

    def at_place(self, place: int) -> Task:
        """The same task with the grippers at one of the places to grasp, and no search of these."""
        space, search = self.space, self.grasp_search
        if search is None or not isinstance(space, Grippers):
            return self
        start = np.array(space.start)
        poses = np.asarray(search.poses, np.float64)
        poses = poses[:, None] if poses.ndim == 2 else poses
        start[list(search.grippers) or slice(None)] = poses[place]
        return replace(self, space=replace(space, start=start), grasp_search=None)

    def request(
        self, knots: Array, initial: InitialState | None = None, *, frames: int | None = None
    ) -> dict[str, Any]:
        """Arguments of `Twin.rollout` and `Twin.plan` for knots [B, K, D] from a state, over the
        horizon or another one [frames].

        Actions have an entry for every knot, or for every frame where surroundings change between
        knots.
        """
        frames = self.frames if frames is None else frames
        ensemble = self.ensemble
        if self.vary is not None and ensemble is None and self.vary.is_of_one:
            ensemble = Ensemble(1)
        given = {
            "vary": self.vary,
            "ensemble": ensemble,
            "gradient": self.gradient,
            "plausibility": self.plausibility,
        }
        return {
            **self._motion(knots, frames),
            "initial": self.initial if initial is None else initial,
            "costs": self.costs,
            "fidelity": self.fidelity,
            **{name: value for name, value in given.items() if value is not None},
        }

    def rollout(
        self,
        knots: Array,
        initial: InitialState | None = None,
        *,
        frames: int | None = None,
        returns: Returns = _COSTS_ALONE,
        timeout_s: float | None = None,
    ) -> RolloutResult:
        """Simulates knots [B, K, D] from a state, in one call.

        Costs are +inf where an instance diverged, or is implausible and that is refused. There is a
        warning where the start is implausible, which all plans share; a search tries the rest.
        """
        request = self.request(knots, initial, frames=frames)
        refuses = self.plausibility is not None and self.plausibility.refuse
        if refuses:
            request["plausibility"] = replace(request["plausibility"], refuse=False)
        call = roll_out(self.twin.rollout_request(**request, returns=returns))
        call = replace(call, read=RolloutResult.from_proto)
        result = self.twin._caller.run(call, timeout_s)
        costs = np.where(np.isnan(result.costs), np.inf, result.costs)
        members = 1 if self.ensemble is None else self.ensemble.members
        if refuses:
            costs[[i.instance // members for i in result.implausible]] = np.inf
            costs[self._excess(knots, frames) > 0.0] = np.inf
        warned(replace(result, implausible=[i for i in result.implausible if i.is_of_start]))
        return replace(result, costs=costs)

    def evaluate(
        self,
        knots: Array,
        initial: InitialState | None,
        *,
        gradients: bool = False,
        timeout_s: float | None = None,
    ) -> Evaluation:
        """Simulates knots [B, K, D] from a state, in one call; None is the task's own.

        Raises:
            ValueError: If places to grasp are to be searched, which planners do not do here.
        """
        if self.grasp_search is not None:
            raise ValueError(NO_PLACES)
        returns = Returns(action_gradients=gradients)
        result = self.rollout(knots, initial, returns=returns, timeout_s=timeout_s)
        excess = _excess(result) + self._excess(knots)
        if not gradients:
            return Evaluation(np.asarray(result.costs, np.float64), excess=excess)
        if result.action_gradients is None:
            raise ValueError("the server returned no gradients: is it older than this client?")
        by_actions = np.asarray(result.action_gradients, np.float64)
        costs = np.asarray(result.costs, np.float64)
        count = knots.shape[1]
        if isinstance(self.space, MachineSpace):
            by_path = self.space.gradients(self.path(knots), by_actions)
            curve = self._curve(count, self.frames)
            return Evaluation(costs, np.einsum("fk,bfd->bkd", curve, by_path), excess)
        if by_actions.shape[1] != count:
            if by_actions.shape[-1] == 7:
                raise ValueError(
                    "gradients of poses need surroundings that change at knots alone: choose the "
                    "number of knots, and the frames of closings and paths, so that they do"
                )
            by_actions = np.einsum("fk,bfcx->bkcx", self._curve(count, self.frames), by_actions)
        return Evaluation(costs, self.space.gradients(knots, by_actions), excess)

    def path(self, knots: Array, frames: int | None = None) -> Array:
        """Coordinates at every frame boundary [B, F + 1, D] between knots [B, K, D], over the
        horizon or another one."""
        curve = self._curve(knots.shape[1], self.frames if frames is None else frames)
        return np.asarray(np.einsum("fk,bkd->bfd", curve, knots))

    def actions(self, knots: Array, frames: int | None = None) -> dict[str, Any]:
        """Arguments of `Twin.rollout` that execute knots [K, D] in the task's surroundings: all of
        them, or the first frames, then with an action for every frame, so that they are the very
        motion that was planned."""
        if frames is not None and not 1 <= frames <= self.frames:
            raise ValueError(f"the plan has {self.frames} frames: give 1..{self.frames}")
        return self._motion(knots[None], self.frames, frames)

    def _motion(self, knots: Array, frames: int, first: int | None = None) -> dict[str, Any]:
        """Actions, world and grasps over a horizon, or over its first frames."""
        schedule = Schedule(self._world(), self.grasps, frames, self.since)
        if isinstance(self.space, MachineSpace):
            knots = self.path(knots, frames)
        named = self.space.actions(knots)
        count = knots.shape[1]
        if first is None and schedule.has_knots(count, self.interpolation):
            named["interpolation"] = self.interpolation
            return {**named, **schedule.at(count, frames), "frames": frames}
        first = frames if first is None else first
        for kind in ACTIONS & named.keys():
            dense = _CURVES[kind](named[kind], frames, interpolation=self.interpolation)
            named[kind] = dense[:, : first + 1]
        return {**named, **schedule.at(first + 1, first), "frames": first}

    def _world(self) -> World | None:
        return self.space.world if isinstance(self.space, MachineSpace) else self.world

    def _curve(self, knots: int, frames: int) -> Array:
        """The matrix [F + 1, K] that turns knots into coordinates by frame."""
        times = np.arange(frames + 1) * (knots - 1) / frames
        return curve_matrix(times, knots, self.interpolation)

    def _excess(self, knots: Array, frames: int | None = None) -> npt.NDArray[np.float64]:
        """How far a machine is beyond its limits, [B]."""
        if not isinstance(self.space, MachineSpace):
            return np.zeros(len(knots))
        return self.space.excess(self.path(knots, frames))


def _excess(result: RolloutResult) -> npt.NDArray[np.float64]:
    """Excess of each action, with an ensemble the largest of its members, over the limits of strain
    and forces, as the sum of its shares of these."""
    members = 1 if result.member_costs is None else result.member_costs.shape[1]
    excess = {reason: np.zeros(len(result.costs)) for reason in ("STRAIN", "GRASP_FORCE")}
    for found in result.implausible:
        if found.reason in excess:
            action, share = found.instance // members, excess_share(found.found, found.limit)
            excess[found.reason][action] = max(excess[found.reason][action], share)
    return excess["STRAIN"] + excess["GRASP_FORCE"]
