"""A twin that answers rollouts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy.typing as npt

from bendtwin import calls
from bendtwin.connection.caller import Caller
from bendtwin.geometry import Geometry
from bendtwin.resources import TwinInfo
from bendtwin.simulation.arguments import RolloutArguments, rollout_request
from bendtwin.simulation.plan import PlanArguments, PlanUpdate, plan_request, whole
from bendtwin.simulation.registration import RegisterArguments, Registration, register_state
from bendtwin.simulation.rollout import RolloutResult
from bendtwin.surface import Surface
from bendtwin.v1 import rollout_pb2

if TYPE_CHECKING:
    from typing_extensions import Self, Unpack

_Caller = TypeVar("_Caller")


class TwinFacts(Generic[_Caller]):
    """Facts of a twin, shared by the blocking and the asynchronous client."""

    def __init__(self, info: TwinInfo, caller: _Caller) -> None:
        #: Facts from the server.
        self.info = info
        self._caller = caller
        self._geometry: Geometry | None = None
        self._surface: Surface | None = None

    def __deepcopy__(self, _: Any) -> Self:
        """Itself: twins never change, and a connection cannot be copied. Gymnasium copies the
        arguments of environments."""
        return self

    @property
    def name(self) -> str:
        """twins/{uuid}."""
        return self.info.name

    @property
    def identifiability(self) -> dict[str, Any] | None:
        """The report of what the recordings leave open: `summary` in sentences, `groups` of
        parameters, `motions` in metres, and the `next` recordings to make (docs/formats/twin.md);
        None for a twin without a fit. `geometry()` has it by node and by skin point.
        """
        report: dict[str, Any] | None = self.info.quality.get("identifiability")
        return report

    def rollout_request(self, **arguments: Unpack[RolloutArguments]) -> rollout_pb2.RollOutRequest:
        """The message of `rollout` with the same arguments."""
        return rollout_request(self.name, arguments)


class Twin(TwinFacts[Caller]):
    """A fitted twin at the server. Get one with `Client.twin`."""

    def geometry(self, *, timeout_s: float | None = None) -> Geometry:
        """Nodes, springs and control points of the twin; fetched once, since twins never change."""
        if self._geometry is None:
            self._geometry = self._caller.run(calls.twin_geometry(self.name), timeout_s)
        return self._geometry

    def surface(self, *, timeout_s: float | None = None) -> Surface:
        """Triangles around the twin in its colours, or tubes along its cables, to be looked at;
        fetched once, since twins never change."""
        if self._surface is None:
            self._surface = self._caller.run(calls.twin_surface(self.name), timeout_s)
        return self._surface

    def rollout(
        self, *, timeout_s: float | None = None, **arguments: Unpack[RolloutArguments]
    ) -> RolloutResult:
        """Predicts the motion under a batch of actions. The arguments are in `RolloutArguments`:
        trajectories or poses, initial, frames, costs, returns, world, grasps and others.

        Args:
            timeout_s: Deadline of the call.
            arguments: Those of a rollout: actions, costs, returns and so on.

        Raises:
            BendTwinError: With the server's reason.
            TypeError: If a rollout has no argument of a name.
            ValueError: If an array's shape or content is wrong before anything is sent.
        """
        return self._caller.run(calls.roll_out(self.rollout_request(**arguments)), timeout_s)

    def stream_rollout(
        self,
        *,
        part_frames: int = 0,
        timeout_s: float | None = None,
        **arguments: Unpack[RolloutArguments],
    ) -> Iterator[RolloutResult]:
        """Like `rollout`, in parts as instances finish; see `RolloutResult.first_instance`.

        Args:
            part_frames: Divides parts in time too: the largest number of frames of a part, whose
            `RolloutResult.window` names them, and which comes while later ones are simulated.
            timeout_s: Deadline of the call.
            arguments: Those of `rollout`.
        """
        call = calls.stream_roll_out(self.rollout_request(**arguments), part_frames)
        return self._caller.parts(call, timeout_s)

    def register(
        self,
        points: npt.ArrayLike,
        *,
        timeout_s: float | None = None,
        **arguments: Unpack[RegisterArguments],
    ) -> Registration:
        """The state in which the twin explains observed points [M, 3], metres, of its object.

        The points are a cloud by default; `nodes` or `places` give their places on the object. The
        other arguments are in `RegisterArguments`.

        Args:
            points: Positions in the twin's coordinates. Rows that are not finite are left out.
            timeout_s: Deadline of the call.
            arguments: Knowledge of the points, and options.

        Raises:
            BendTwinError: With the reason OBSERVATION_NOT_EXPLAINED if the remaining distances are
            too large, or another reason of the server.
            ValueError: If an array's shape or content is wrong before anything is sent.
        """
        call = register_state(self.name, points, arguments)
        return self._caller.run(call, timeout_s)

    def evaluate(self, capture: str, *, timeout_s: float | None = None) -> dict[str, Any]:
        """The quality table of the twin on a capture, in the form of `info.quality`.

        The twin is first registered to another recording of its object: `recordings` in the table
        has the quality of the registration. All frames of such a recording count as future.

        Args:
            capture: `captures/{uuid}`, whose ingest has ended.
            timeout_s: Deadline of the call.

        Raises:
            BendTwinError: With the reason OBSERVATION_NOT_EXPLAINED if the twin does not explain
                the first frame, or another reason of the server.
        """
        return self._caller.run(calls.evaluate_twin(self.name, capture), timeout_s)

    def plan(
        self,
        *,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> PlanUpdate:
        """Searches at the server for actions that lower the costs, and returns the best plan.

        The plan is never worse than the nominal plan, which the actions, of one instance, define:
        their row 0 is the current position and is not changed. `update.knots` are the next nominal
        plan.

        Args:
            timeout_s: Deadline of the call, after which no plan is returned.
            arguments: Those of `PlanArguments`: search, space and shift_frames, in addition to
            those of `rollout`.

        Raises:
            BendTwinError: With the server's reason.
        """
        request = plan_request(self.name, arguments)
        update = self._caller.last(calls.plan(request), timeout_s)
        return whole(update)

    def stream_plan(
        self,
        *,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> Iterator[PlanUpdate]:
        """The best plan after each iteration of `plan`; closing the iterator ends the search."""
        request = plan_request(self.name, arguments)
        return self._caller.parts(calls.plan(request), timeout_s)
