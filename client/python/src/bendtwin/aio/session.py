"""Generated from session.py by client/python/generate_aio.py. Do not edit."""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncIterable, AsyncIterator, Sequence
from typing import TYPE_CHECKING

import numpy.typing as npt

from bendtwin import calls, session_calls
from bendtwin.aio.twin import Twin
from bendtwin.connection.caller import AsyncCaller
from bendtwin.resources import SessionInfo
from bendtwin.session import SessionCalls
from bendtwin.simulation.arguments import RolloutArguments
from bendtwin.simulation.pictures import (
    Light,
    Look,
    PictureCamera,
    Pictures,
    Prop,
    render_session,
)
from bendtwin.simulation.plan import PlanArguments, PlanUpdate, whole
from bendtwin.simulation.registration import CorrectArguments, Correction
from bendtwin.simulation.rollout import Returns, RolloutResult
from bendtwin.simulation.state import InitialState, State
from bendtwin.simulation.step import Step
from bendtwin.v1 import session_pb2

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Session(SessionCalls[AsyncCaller, Twin]):
    """Simulations of a twin, in slots, that keep their states between calls.

    Get one with `Client.open_session`, and close it or use it in `async with`. If its worker is lost, or
    the session is unused for too long, calls raise BendTwinError with the reason SESSION_LOST:
    `reopen` it.
    """

    async def __aenter__(self) -> Session:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def rollout(
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
        return await self._caller.run(self._roll_out(slots, arguments), timeout_s)

    async def plan(
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
        update = await self._caller.last(calls.plan(request), timeout_s)
        return whole(update)

    def stream_plan(
        self,
        *,
        slot: int = 0,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> AsyncIterator[PlanUpdate]:
        """The best plan after each iteration of `plan`; closing the iterator ends the search."""
        request = self._plan_request(slot, arguments)
        return self._caller.parts(calls.plan(request), timeout_s)

    async def advance(
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
        return await self._caller.run(self._advance(slots, arguments), timeout_s)

    def control(
        self, actions: AsyncIterable[RolloutArguments], *, slots: Sequence[int] = ()
    ) -> AsyncIterator[RolloutResult]:
        """Advances by one set of actions after another over one connection, for teleoperation.

        Each set is a dict of arguments of `advance`. The next one is taken from the iterator after
        the previous reply was consumed, so that it may depend on that reply.
        """
        sent: deque[session_pb2.AdvanceSessionRequest] = deque()

        async def requests() -> AsyncIterator[session_pb2.AdvanceSessionRequest]:
            async for arguments in actions:
                sent.append(self._advance_request(slots, arguments))
                yield sent[-1]

        return self._caller.exchange(self._control(sent, requests()))

    async def correct(
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
        return await self._caller.run(self._correct(slots, points, arguments), timeout_s)

    async def step(
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
        return await self._caller.run(call, timeout_s)

    async def render(
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
        return await self._caller.run(call, timeout_s)

    async def states(self, slots: Sequence[int] = ()) -> list[State]:
        """The states of slots, or of all of them. Each can be the initial state of any call, which
        continues with the rest shape of the twin, without that of corrections."""
        return await self._caller.run(self._states(slots))

    async def refresh(self) -> SessionInfo:
        """The current state of the session at the server."""
        return await self._caller.run(session_calls.get_session(self.name))

    async def fork(self, source: int, to: Sequence[int] = ()) -> None:
        """Copies the state and the rest shape of a slot to others, or to all others."""
        await self._caller.run(self._fork(source, to))

    async def reset(self, slots: Sequence[int] = (), initial: InitialState | None = None) -> None:
        """Resets slots, or all of them, to the session's first state, or to a given one, and to the
        rest shape of the twin."""
        await self._caller.run(self._reset(slots, initial))

    async def reopen(self) -> list[int]:
        """Opens a lost session again, under a new name: each slot is in the last returned state,
        from `advance` with `Returns(final_state=True)`, from `states` or from `correct`, and
        continues from there bit for bit. Rest shapes from corrections are lost with the worker: the
        slots have that of the twin, until they are corrected again.

        Returns the number of frames by which each slot is behind: 0 if every advance returned its
        final state. Raises BendTwinError (UNAVAILABLE) while there is no worker: try again.
        """
        opened = await self._caller.run(session_calls.open_session(self._opening))
        for call in self._resets(opened):
            await self._caller.run(call)
        return self._goes_on(opened)

    async def close(self) -> None:
        """Ends the session; ending it twice is not an error."""
        await self._caller.run(session_calls.close_session(self.name))
