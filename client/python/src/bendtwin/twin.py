"""A twin that answers rollouts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy.typing as npt

from bendtwin import calls
from bendtwin.arguments import RolloutArguments, rollout_request
from bendtwin.caller import Caller
from bendtwin.geometry import Geometry
from bendtwin.plan import PlanArguments, PlanUpdate, last_of, plan_request
from bendtwin.registration import RegisterArguments, Registration, register_state
from bendtwin.resources import TwinInfo
from bendtwin.rollout import RolloutResult
from bendtwin.v1 import rollout_pb2

if TYPE_CHECKING:
    from typing_extensions import Unpack

_Caller = TypeVar("_Caller")


class TwinFacts(Generic[_Caller]):
    """Facts of a twin, whatever the way to wait for a reply."""

    def __init__(self, info: TwinInfo, caller: _Caller) -> None:
        #: What the server says about it.
        self.info = info
        self._caller = caller
        self._geometry: Geometry | None = None

    @property
    def name(self) -> str:
        """twins/{uuid}."""
        return self.info.name

    @property
    def identifiability(self) -> dict[str, Any] | None:
        """The report of what its recordings leave open: `summary` in sentences, `groups` of
        parameters, `motions` in metres, and what to record `next`, as docs/formats/twin.md describes
        them; None for a twin that no fit made. `geometry()` has it by node and by skin point.
        """
        report: dict[str, Any] | None = self.info.quality.get("identifiability")
        return report

    def rollout_request(self, **arguments: Unpack[RolloutArguments]) -> rollout_pb2.RollOutRequest:
        """The message of `rollout` with the same arguments."""
        return rollout_request(self.name, arguments)


class Twin(TwinFacts[Caller]):
    """A fitted twin at the server. Get one with `Client.twin`."""

    def geometry(self, *, timeout_s: float | None = None) -> Geometry:
        """Its nodes, springs and control points; asked for once, as twins never change."""
        if self._geometry is None:
            self._geometry = self._caller.run(calls.twin_geometry(self.name), timeout_s)
        return self._geometry

    def rollout(
        self, *, timeout_s: float | None = None, **arguments: Unpack[RolloutArguments]
    ) -> RolloutResult:
        """Predicts what a batch of actions does. The arguments are in `RolloutArguments`:
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
        """The same in parts, as instances finish; see `RolloutResult.first_instance`.

        Args:
            part_frames: Divides parts in time too: each has at most so many frames, which
                `RolloutResult.window` names, and comes while later ones are simulated.
            timeout_s: Deadline of the call.
            arguments: As those of `rollout`.
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
        """The state in which the twin explains points [M, 3], metres, that were seen of it.

        A cloud by default; with `nodes` or `places` it is known what the points are. The other
        arguments are in `RegisterArguments`.

        Args:
            points: Positions in the twin's coordinates. Rows that are not finite are left out.
            timeout_s: Deadline of the call.
            arguments: Knowledge of the points, and options.

        Raises:
            BendTwinError: With the reason OBSERVATION_NOT_EXPLAINED if too much is left between the
                points and the twin, or another one of the server's.
            ValueError: If an array's shape or content is wrong before anything is sent.
        """
        call = register_state(self.name, points, arguments)
        return self._caller.run(call, timeout_s)

    def evaluate(self, capture: str, *, timeout_s: float | None = None) -> dict[str, Any]:
        """The quality table of the twin on a capture, as `info.quality` has that of its fit.

        To another recording of its object the twin is registered first: `recordings` in the table
        says how well. All frames of such a recording count as future.

        Args:
            capture: `captures/{uuid}`, whose ingest has ended.
            timeout_s: Deadline of the call.

        Raises:
            BendTwinError: With the reason OBSERVATION_NOT_EXPLAINED if the twin does not explain
                the first frame, or another one of the server's.
        """
        return self._caller.run(calls.evaluate_twin(self.name, capture), timeout_s)

    def plan(
        self,
        *,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> PlanUpdate:
        """Has the server look for actions that lower the costs: the best that it found.

        It is never worse than the nominal plan, which are the actions, of one instance: row 0 is
        where things are, and stays. `update.knots` are the next nominal plan.

        Args:
            timeout_s: Deadline of the call, after which there is no plan.
            arguments: Those of `PlanArguments`: search, space and shift_frames, beside those of
                `rollout`.

        Raises:
            BendTwinError: With the server's reason.
        """
        request = plan_request(self.name, arguments)
        return last_of(self._caller.parts(calls.plan(request), timeout_s))

    def stream_plan(
        self,
        *,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> Iterator[PlanUpdate]:
        """The best so far after each iteration of `plan`; closing the iterator ends the search."""
        request = plan_request(self.name, arguments)
        return self._caller.parts(calls.plan(request), timeout_s)
