"""Plans made at the server: settings of the search, and its results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol, cast

import numpy as np
import numpy.typing as npt

from bendtwin.simulation.arguments import RolloutArguments, rollout_request
from bendtwin.simulation.bounds import Bounds
from bendtwin.simulation.rollout import RolloutResult, warned
from bendtwin.tensors import pack_floats, unpack
from bendtwin.v1 import planning_pb2, tensor_pb2

Method = Literal["mppi", "cem", "predictive_sampling", "gradient"]
Coordinates = Literal["together", "points", "translation", "rigid"]
Origin = Literal["nominal", "mean", "sample"]

_COORDINATES: dict[str, planning_pb2.ActionSpace.Coordinates.ValueType] = {
    "together": planning_pb2.ActionSpace.TOGETHER,
    "points": planning_pb2.ActionSpace.POINTS,
    "translation": planning_pb2.ActionSpace.TRANSLATION,
    "rigid": planning_pb2.ActionSpace.RIGID,
}
_ORIGINS: dict[int, Origin] = {
    planning_pb2.PlanUpdate.MEAN: "mean",
    planning_pb2.PlanUpdate.SAMPLE: "sample",
}
_NO_BOUNDS = Bounds()


class ServerSpace(Protocol):
    """Action space that the server supports, such as those of `bendtwin.planners`."""

    def to_proto(self) -> planning_pb2.ActionSpace:
        """Makes the wire form."""


@dataclass(frozen=True, kw_only=True)
class Search:
    """Settings of the server's search for a plan, explained in `bendtwin.planners`."""

    method: Method = "mppi"
    #: Plans simulated in an iteration; None: 64, or 1 with "gradient".
    samples: int | None = None
    #: Iterations; None: 1, or 20 with "gradient".
    iterations: int | None = None
    #: Standard deviation of samples: a number, one by coordinate [D], or by knot and coordinate
    #: [K, D]; metres, radians for rotations.
    sigma: npt.ArrayLike = 0.02
    #: Correlation of neighbouring knots of a sample, 0..1: larger is smoother.
    correlation: float = 0.0
    #: Samples have sigma times a factor from 1 to this: large ones find ways, small ones the goal.
    #: None: 0.1, and 1 for methods that shrink their samples themselves.
    finest: float | None = None
    bounds: Bounds = _NO_BOUNDS
    #: Time for the iterations, after which the best plan so far is returned; the first iteration is
    #: always finished.
    deadline_s: float | None = None
    #: The same seed gives the same plan.
    seed: int = 0
    #: Temperature of "mppi", as a share of the spread of the costs.
    temperature: float = 0.1
    #: Number of best samples that "cem" uses for the next iteration.
    elites: int = 8
    #: Share of the old mean and spread in the new ones of "cem".
    memory: float = 0.1
    #: Smallest spread of "cem", as a share of sigma.
    smallest: float = 0.05
    #: Largest step of an iteration of "gradient", a number or by coordinate [D].
    rate: npt.ArrayLike = 0.005

    def add_to(self, request: planning_pb2.PlanRequest) -> None:
        """Adds the settings to a request."""
        request.method.CopyFrom(self._method())
        # Of these 0 is the server's default, which is not what was asked for.
        for name, value in (("samples", self.samples), ("iterations", self.iterations)):
            if value is not None and value < 1:
                raise ValueError(f"{name} is {value}: give 1 or more")
        if self.deadline_s is not None and not self.deadline_s > 0.0:
            raise ValueError(f"deadline_s is {self.deadline_s}: give more than 0, or None")
        request.samples = self.samples or 0
        request.iterations = self.iterations or 0
        request.deadline_s = self.deadline_s or 0.0
        request.correlation, request.seed = self.correlation, self.seed
        if self.finest is not None:
            request.finest = self.finest
        request.sigma.CopyFrom(_flat("sigma", self.sigma))
        for name in ("low", "high", "speed"):
            limit = getattr(self.bounds, name)
            if limit is not None:
                getattr(request.bounds, name).CopyFrom(_flat(f"bounds.{name}", limit))

    def _method(self) -> planning_pb2.PlanMethod:
        wire = planning_pb2.PlanMethod
        if self.method == "mppi":
            if not self.temperature > 0.0:
                raise ValueError("the temperature must be above 0")
            return wire(mppi=wire.Mppi(temperature=self.temperature))
        if self.method == "cem":
            if self.elites < 1:
                raise ValueError("give one elite or more")
            settings = {"memory": self.memory, "smallest": self.smallest}
            return wire(cem=wire.Cem(elites=self.elites, **settings))
        if self.method == "predictive_sampling":
            return wire(predictive_sampling=wire.PredictiveSampling())
        if self.method == "gradient":
            return wire(gradient=wire.Gradient(rate=_flat("rate", self.rate)))
        raise ValueError(f"method is {self.method!r}: give {Method}")


@dataclass(frozen=True)
class GraspSearch:
    """Places to grasp that the server searches together with the motion, of one or more grippers.

    Each place has its own search, which begins there and otherwise moves like the nominal plan. All
    places share the samples; after each round of iterations the worse half of the places is given
    up, until one is left. `bendtwin.grasp_places` proposes places.
    """

    #: Poses at the start of the motion [P, G', 7], or [P, 7] of one gripper; P in 2..256.
    poses: npt.ArrayLike
    #: Grippers whose places are searched, ascending; empty: all.
    grippers: Sequence[int] = ()

    def to_proto(self) -> planning_pb2.GraspSearch:
        """Makes the wire form."""
        poses = np.asarray(self.poses, np.float32)
        if poses.ndim == 2:
            poses = poses[:, None]
        packed = pack_floats("poses of the grasp search", poses, (None, None, 7))
        return planning_pb2.GraspSearch(poses=packed, grippers=list(self.grippers))


@dataclass(frozen=True)
class PlanUpdate:
    """The best plan that the server has found so far."""

    #: Knots in the shape of the actions, [1, K, C, 3] or [1, K, G, 7]: the next nominal plan.
    knots: npt.NDArray[np.float32]
    #: The same in the coordinates of the action space [K, D].
    coordinates: npt.NDArray[np.float64]
    #: Cost of exactly these knots, as simulated.
    cost: float
    #: Weighted terms of the cost by name.
    cost_terms: dict[str, float]
    #: The nominal plan, the mean that the method arrived at, or one of its samples.
    origin: Origin
    #: +inf if the nominal plan diverges; with a grasp search that of the place of the best plan.
    nominal_cost: float
    #: Iterations that were finished.
    iterations: int
    #: Simulated plans, and the diverged ones among them.
    simulated: int
    diverged: int
    #: True if the deadline ended the search before all iterations were done.
    stopped_by_deadline: bool
    #: Since planning began at the server.
    time_s: float
    #: True for the last update.
    last: bool
    #: The rollout of the best plan, in the last update, if returns were requested.
    rollout: RolloutResult | None = None
    #: Largest strain of the material in the plan's motion, and the limit. A plan beyond a limit is
    #: worse than every plan within all, so that this is above the limit only if all plans were
    #: beyond one.
    strain: float = 0.0
    strain_limit: float = float("inf")
    #: Plans beyond a limit, of the strain or of the force of a grasp, that did not diverge.
    overstrained: int = 0
    #: With a grasp search: the place of the best plan, and the cost of the best plan of each place
    #: so far [P]; +inf where every plan diverged or grasped nothing.
    grasp: int | None = None
    grasp_costs: npt.NDArray[np.float64] | None = None
    #: Largest mean force of a grasp over a frame in the plan's motion, newtons, and the limit of
    #: `Plausibility`; None without a limit, the force not so with a grasp search.
    grasp_force_n: float | None = None
    grasp_force_limit_n: float | None = None

    @property
    def excess(self) -> float:
        """Sum of the shares of their limits by which strain and force are beyond them: 0 unless
        every plan was beyond a limit."""
        force = excess_share(self.grasp_force_n or 0.0, self.grasp_force_limit_n or np.inf)
        return excess_share(self.strain, self.strain_limit) + force

    @property
    def actions(self) -> dict[str, npt.NDArray[np.float32]]:
        """The knots under their name among the arguments of a rollout."""
        return {"trajectories" if self.knots.shape[-1] == 3 else "poses": self.knots}

    @classmethod
    def from_proto(cls, message: planning_pb2.PlanUpdate) -> PlanUpdate:
        """Reads the wire form."""
        knots: Any = unpack(message.knots)
        coordinates: Any = unpack(message.coordinates)
        terms: Any = unpack(message.cost_terms)
        names = list(message.cost_names)
        costs: Any = unpack(message.grasp_costs)
        has_rollout = message.HasField("rollout")

        optional: Any = message

        def given(name: str) -> Any:
            return getattr(optional, name) if optional.HasField(name) else None

        return cls(
            knots=knots,
            coordinates=coordinates,
            cost=message.cost,
            cost_terms={} if terms is None else dict(zip(names, terms.tolist(), strict=False)),
            origin=_ORIGINS.get(message.origin, "nominal"),
            nominal_cost=message.nominal_cost,
            iterations=message.iterations,
            simulated=message.simulated,
            diverged=message.diverged,
            stopped_by_deadline=message.stopped_by_deadline,
            time_s=message.time_s,
            last=message.last,
            rollout=warned(RolloutResult.from_proto(message.rollout)) if has_rollout else None,
            strain=message.strain,
            strain_limit=message.strain_limit,
            overstrained=message.overstrained,
            grasp=given("grasp"),
            grasp_costs=costs if message.HasField("grasp_costs") else None,
            grasp_force_n=given("grasp_force_n"),
            grasp_force_limit_n=given("grasp_force_limit_n"),
        )


class PlanArguments(RolloutArguments, total=False):
    """Arguments of a plan, in addition to those of the rollout whose costs it lowers. The actions
    are the nominal plan, of one instance: row 0 is the current position and is not changed.
    `returns` apply only to the best plan."""

    #: How the server searches.
    search: Search
    #: What the coordinates of a plan move: a space of `bendtwin.planners`, or "together", "points"
    #: (trajectories), "translation" or "rigid" (poses), counted from row 0. By default all control
    #: points together, or rigid grippers.
    space: ServerSpace | Coordinates | None
    #: Frames executed since the nominal plan was made, by which it is shifted.
    shift_frames: float
    #: Places to grasp, searched together with the motion; needs `poses`, and a grasp of each
    #: gripper that is searched.
    grasp_search: GraspSearch | None


def plan_request(twin: str, arguments: PlanArguments) -> planning_pb2.PlanRequest:
    """The request message of a plan with a twin.

    Raises:
        TypeError: If a plan has no argument of a name, or the server does not know its space.
        ValueError: If a setting, or an array's shape or content, is wrong.
    """
    own = PlanArguments.__annotations__.keys() - RolloutArguments.__annotations__.keys()
    rollout: Any = {name: value for name, value in arguments.items() if name not in own}
    shift_frames = arguments.get("shift_frames", 0.0)
    request = planning_pb2.PlanRequest(
        rollout=rollout_request(twin, rollout), shift_frames=shift_frames
    )
    arguments.get("search", Search()).add_to(request)
    grasp_search = arguments.get("grasp_search")
    if grasp_search is not None:
        request.grasp_search.CopyFrom(grasp_search.to_proto())
    space = arguments.get("space")
    if isinstance(space, str):
        if space not in _COORDINATES:
            raise ValueError(f"space is {space!r}: give one of {sorted(_COORDINATES)}")
        request.space.coordinates = _COORDINATES[space]
    elif space is not None:
        request.space.CopyFrom(server_space(space).to_proto())
    return request


def server_space(space: object) -> ServerSpace:
    """A space, if the server supports it.

    Raises:
        TypeError: If it does not.
    """
    if not hasattr(space, "to_proto"):
        raise TypeError(
            f"the server does not know the coordinates of {type(space).__name__}, such as joints: "
            "plan with Mppi, Cem, PredictiveSampling or GradientDescent of bendtwin.planners"
        )
    return cast(ServerSpace, space)


def excess_share(found: float, limit: float) -> float:
    """Share of a limit by which a value is beyond it, or 0; of a limit of 0 the value itself."""
    return 0.0 if found <= limit else (found - limit) / (limit or 1.0)


def whole(last: PlanUpdate | None) -> PlanUpdate:
    """The last update of a plan that the server ended."""
    if last is None or not last.last:
        raise RuntimeError("the server ended a plan without its last update")
    return last


def _flat(name: str, values: npt.ArrayLike) -> tensor_pb2.Tensor:
    """Numbers in row-major order. The server counts them; limits may be infinite."""
    array = np.asarray(values, dtype="<f4").reshape(-1)
    if not array.size or np.isnan(array).any():
        raise ValueError(f"{name} has no values, or some that are not numbers")
    dtype = tensor_pb2.Tensor.FLOAT32
    return tensor_pb2.Tensor(dtype=dtype, shape=array.shape, data=array.tobytes())
