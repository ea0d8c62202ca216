"""Sessions: simulations that a worker keeps between calls."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from bendtwin import calls, session_calls
from bendtwin.connection.caller import Caller
from bendtwin.kept import Kept
from bendtwin.resources import SessionInfo
from bendtwin.simulation.arguments import RolloutArguments, rollout_request
from bendtwin.simulation.pictures import (
    Light,
    Look,
    PictureCamera,
    Pictures,
    Prop,
    render_session,
)
from bendtwin.simulation.plan import PlanArguments, PlanUpdate, plan_request, whole
from bendtwin.simulation.registration import CorrectArguments, Correction, correct_session
from bendtwin.simulation.rollout import Returns, RolloutResult
from bendtwin.simulation.state import InitialState, SessionSlots, State
from bendtwin.simulation.step import Step, step_session
from bendtwin.simulation.world import Vary
from bendtwin.twin import Twin
from bendtwin.v1 import planning_pb2, session_pb2

if TYPE_CHECKING:
    from typing_extensions import Unpack

_Caller = TypeVar("_Caller")
_Twin = TypeVar("_Twin")


class SessionCalls(Generic[_Caller, _Twin]):
    """The calls of a session as values, shared by the blocking and the asynchronous client. States
    in replies are kept when they are read."""

    def __init__(
        self,
        caller: _Caller,
        twin: _Twin,
        opening: session_pb2.OpenSessionRequest,
        info: SessionInfo,
        vary: Vary | None = None,
    ) -> None:
        #: Facts from the server.
        self.info: SessionInfo = info
        #: The twin that the session simulates.
        self.twin: _Twin = twin
        self._caller = caller
        self._opening = opening
        self._kept = Kept(info.slots)
        self._vary = vary

    @property
    def name(self) -> str:
        """sessions/{uuid}."""
        return self.info.name

    def _roll_out(
        self, slots: Sequence[int], arguments: RolloutArguments
    ) -> calls.Call[RolloutResult]:
        _refuse(arguments, "initial")
        own: Any = {
            "initial": SessionSlots(self.name, tuple(slots)),
            **self._varied(slots, arguments),
        }
        return calls.roll_out(rollout_request(self.info.twin, {**arguments, **own}))

    def _advance_request(
        self, slots: Sequence[int], arguments: RolloutArguments
    ) -> session_pb2.AdvanceSessionRequest:
        _refuse(arguments, "initial", "fidelity")
        own: Any = {**arguments, **self._varied(slots, arguments)}
        return session_calls.advance_request(self.name, slots, own)

    def _advance(
        self, slots: Sequence[int], arguments: RolloutArguments
    ) -> calls.Call[RolloutResult]:
        request = self._advance_request(slots, arguments)
        call = session_calls.advance_session(request)
        return replace(call, read=lambda reply: self._advanced(request, call.read(reply)))

    def _control(
        self, sent: deque[session_pb2.AdvanceSessionRequest], requests: Any
    ) -> calls.Call[RolloutResult]:
        """`sent` has the requests taken from an iterator until they are answered."""
        call = session_calls.control_session(requests)
        return replace(call, read=lambda r: self._advanced(sent.popleft(), call.read(r)))

    def _advanced(
        self, request: session_pb2.AdvanceSessionRequest, result: RolloutResult
    ) -> RolloutResult:
        self._kept.advanced(request.slots, request.rollout, result)
        return result

    def _correct(
        self, slots: Sequence[int], points: npt.ArrayLike, arguments: CorrectArguments
    ) -> calls.Call[list[Correction]]:
        call = correct_session(self.name, slots, points, arguments)

        def read(reply: Any) -> list[Correction]:
            corrections = call.read(reply)
            told = [(one.slot, one.state) for one in corrections if one.state is not None]
            if told:
                self._kept.told([slot for slot, _ in told], [state for _, state in told])
            return corrections

        return replace(call, read=read)

    def _states(self, slots: Sequence[int]) -> calls.Call[list[State]]:
        call = session_calls.session_states(self.name, slots)

        def read(reply: Any) -> list[State]:
            states = call.read(reply)
            self._kept.told(slots, states)
            return states

        return replace(call, read=read)

    def _fork(self, source: int, to: Sequence[int]) -> calls.Call[None]:
        call = session_calls.fork_session(self.name, source, to)
        return replace(call, read=lambda _: self._kept.forked(source, to))

    def _reset(self, slots: Sequence[int], initial: InitialState | None) -> calls.Call[None]:
        call = session_calls.reset_session(self.name, slots, initial)
        return replace(call, read=lambda _: self._kept.reset(slots, initial))

    def _resets(self, opened: SessionInfo) -> list[calls.Call[None]]:
        """The calls that restore the states of this session in a reopened one."""
        return [
            session_calls.reset_session(opened.name, slots, state)
            for state, slots in self._kept.resets()
        ]

    def _goes_on(self, opened: SessionInfo) -> list[int]:
        self.info = opened
        behind, self._kept.behind = self._kept.behind, [0] * opened.slots
        return behind

    def _step(
        self, points: npt.ArrayLike | None, search: PlanArguments, *, slot: int, **named: Any
    ) -> calls.Call[Step]:
        def see(state: State) -> None:
            self._kept.told([slot], [state])

        own: Any = {**search, **self._varied([slot], search)}
        return step_session(self.name, slot, points, own, see=see, **named)

    def _plan_request(self, slot: int, arguments: PlanArguments) -> planning_pb2.PlanRequest:
        _refuse(arguments, "initial")
        own: Any = {"initial": SessionSlots(self.name, (slot,)), **self._varied([slot], arguments)}
        return plan_request(self.info.twin, {**arguments, **own})

    def _varied(self, slots: Sequence[int], arguments: RolloutArguments) -> dict[str, Vary]:
        """The factors of the slots from which instances start, unless the call has its own."""
        if self._vary is None or arguments.keys() & {"vary", "ensemble"}:
            return {}
        actions = arguments.get("trajectories")
        batch = len(np.asarray(arguments.get("poses") if actions is None else actions))
        rows = list(slots) or [0]
        return {"vary": self._vary.of(rows if len(rows) == batch else rows[:1] * batch)}


class Session(SessionCalls[Caller, Twin]):
    """Simulations of a twin, in slots, that keep their states between calls.

    Get one with `Client.open_session`, and close it or use it in `with`. If its worker is lost, or
    the session is unused for too long, calls raise BendTwinError with the reason SESSION_LOST:
    `reopen` it.
    """

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def rollout(
        self,
        *,
        slots: Sequence[int] = (),
        timeout_s: float | None = None,
        **arguments: Unpack[RolloutArguments],
    ) -> RolloutResult:
        """Rolls out a batch from the state of the session, which does not change.

        `slots` has one slot for all instances (default: 0) or one for each; the other arguments are
        those of `Twin.rollout` without `initial`.
        """
        return self._caller.run(self._roll_out(slots, arguments), timeout_s)

    def plan(
        self,
        *,
        slot: int = 0,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> PlanUpdate:
        """Plans from the state of a slot: see `Twin.plan`. Do not advance the slot meanwhile.

        Row 0 of trajectories is taken from the session.
        """
        request = self._plan_request(slot, arguments)
        update = self._caller.last(calls.plan(request), timeout_s)
        return whole(update)

    def stream_plan(
        self,
        *,
        slot: int = 0,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> Iterator[PlanUpdate]:
        """The best plan after each iteration of `plan`; closing the iterator ends the search."""
        request = self._plan_request(slot, arguments)
        return self._caller.parts(calls.plan(request), timeout_s)

    def advance(
        self,
        *,
        slots: Sequence[int] = (),
        timeout_s: float | None = None,
        **arguments: Unpack[RolloutArguments],
    ) -> RolloutResult:
        """Applies actions and stores the final states in the slots: one slot (default: 0) an
        instance.

        The other arguments are those of `Twin.rollout` without `initial` and `fidelity`. Nothing
        changes if the call fails or an instance diverges.
        """
        return self._caller.run(self._advance(slots, arguments), timeout_s)

    def control(
        self, actions: Iterable[RolloutArguments], *, slots: Sequence[int] = ()
    ) -> Iterator[RolloutResult]:
        """Advances by one set of actions after another over one connection, for teleoperation.

        Each set is a dict of arguments of `advance`. The next one is taken from the iterator after
        the previous reply was consumed, so that it may depend on that reply.
        """
        sent: deque[session_pb2.AdvanceSessionRequest] = deque()

        def requests() -> Iterator[session_pb2.AdvanceSessionRequest]:
            for arguments in actions:
                sent.append(self._advance_request(slots, arguments))
                yield sent[-1]

        return self._caller.exchange(self._control(sent, requests()))

    def correct(
        self,
        points: npt.ArrayLike,
        *,
        slots: Sequence[int] = (),
        timeout_s: float | None = None,
        **arguments: Unpack[CorrectArguments],
    ) -> list[Correction]:
        """Moves the states of slots (default: 0) towards observed points [M, 3], metres.

        Nodes move smoothly, except those held by control points and grasps, and stay outside of
        ground and colliders, on the side where they were. The rest shapes of the slots take part
        (`carry`), so that later simulations do not spring back; they follow over several
        corrections: correct several times a second. Either all slots are corrected, or none if the
        points are too far from one of them: BendTwinError with the reason
        OBSERVATION_NOT_EXPLAINED, or OBJECT_LOST if that slot is lost (`Correction.lost`,
        `refresh().lost`); `register_if_lost=True` registers a lost slot with the same points. The
        other arguments are in `CorrectArguments`. Each correction contains the corrected state.
        """
        return self._caller.run(self._correct(slots, points, arguments), timeout_s)

    def step(
        self,
        points: npt.ArrayLike | None,
        search: PlanArguments,
        *,
        frames: int = 1,
        slot: int = 0,
        correct: CorrectArguments | None = None,
        returns: Returns | None = None,
        deadline_s: float | None = None,
        timeout_s: float | None = None,
    ) -> Step:
        """Takes a step of a closed loop in one call: corrects a slot by observed points [M, 3],
        metres (None: no correction), plans from the corrected state, and advances the slot by the
        first `frames` of the best plan (0: no advance).

        `search` has the arguments of `plan`; its actions are the nominal plan, and the next step
        uses `Step.search`. `correct` has the other arguments of `correct`; `returns` are those of
        the executed frames. The whole step is checked before anything changes.

        With `deadline_s` the search ends when nine tenths of it have passed, and the best plan so
        far is executed; its first iteration is always finished. Points that are too far from the
        object correct nothing, and the step starts from the predicted state: `Step.refused`.

        Raises:
            BendTwinError: EVERY_PLAN_DIVERGED, a lost worker or the time-out may leave the slot
                corrected, but not advanced; other refusals change nothing.
        """
        call = self._step(
            points,
            search,
            frames=frames,
            slot=slot,
            correct=correct,
            returns=returns,
            deadline_s=deadline_s,
        )
        return self._caller.run(call, timeout_s)

    def render(
        self,
        cameras: Sequence[PictureCamera],
        *,
        slots: Sequence[int] = (),
        look: Look | None = None,
        props: Sequence[Prop] = (),
        light: Light | None = None,
        depths: bool = False,
        labels: bool = False,
        timeout_s: float | None = None,
    ) -> list[Pictures]:
        """Takes pictures of the states of slots (default: all): one set for each camera.

        `look` is `"surface"`, the twin's surface in its colours, or `"gaussians"`; by default the
        Gaussians if the twin has them. `props` are rigid things beside the object. `depths` and
        `labels` ask for these as well. Nothing changes in the session.
        """
        call = render_session(self.name, slots, cameras, look, props, light, depths, labels)
        return self._caller.run(call, timeout_s)

    def states(self, slots: Sequence[int] = ()) -> list[State]:
        """The states of slots, or of all of them. Each can be the initial state of any call, which
        continues with the rest shape of the twin, without that of corrections."""
        return self._caller.run(self._states(slots))

    def refresh(self) -> SessionInfo:
        """The current state of the session at the server."""
        return self._caller.run(session_calls.get_session(self.name))

    def fork(self, source: int, to: Sequence[int] = ()) -> None:
        """Copies the state and the rest shape of a slot to others, or to all others."""
        self._caller.run(self._fork(source, to))

    def reset(self, slots: Sequence[int] = (), initial: InitialState | None = None) -> None:
        """Resets slots, or all of them, to the session's first state, or to a given one, and to the
        rest shape of the twin."""
        self._caller.run(self._reset(slots, initial))

    def reopen(self) -> list[int]:
        """Opens a lost session again, under a new name: each slot is in the last returned state,
        from `advance` with `Returns(final_state=True)`, from `states` or from `correct`, and
        continues from there bit for bit. Rest shapes from corrections are lost with the worker: the
        slots have that of the twin, until they are corrected again.

        Returns the number of frames by which each slot is behind: 0 if every advance returned its
        final state. Raises BendTwinError (UNAVAILABLE) while there is no worker: try again.
        """
        opened = self._caller.run(session_calls.open_session(self._opening))
        for call in self._resets(opened):
            self._caller.run(call)
        return self._goes_on(opened)

    def close(self) -> None:
        """Ends the session; ending it twice is not an error."""
        self._caller.run(session_calls.close_session(self.name))


def _refuse(arguments: RolloutArguments, *names: str) -> None:
    for name in names:
        if name in arguments:
            raise TypeError(f"{name} is that of the session: leave it out")
