"""The client for asyncio: the same methods as `bendtwin.Client`, to be awaited.

from bendtwin import aio

async with aio.Client("127.0.0.1:7070") as client:
    twin = await client.twin(name)
    result = await twin.rollout(trajectories=actions)
    async for part in twin.stream_rollout(trajectories=actions):
        part.costs
"""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import AsyncIterable, AsyncIterator, Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import grpc.aio
from numpy.typing import ArrayLike

from bendtwin import calls, session_calls
from bendtwin.archive import archive_of
from bendtwin.arguments import RolloutArguments
from bendtwin.caller import AsyncCaller
from bendtwin.errors import FitFailed, IngestFailed
from bendtwin.geometry import Geometry
from bendtwin.labels import LabelArguments, ListArguments
from bendtwin.motion import Motion, bundle, bundle_file
from bendtwin.plan import PlanArguments, PlanUpdate, plan_request, whole
from bendtwin.registration import (
    CorrectArguments,
    Correction,
    RegisterArguments,
    Registration,
    register_state,
)
from bendtwin.resources import (
    Capture,
    Fit,
    JobState,
    LossCurve,
    Requirements,
    SessionInfo,
    TwinInfo,
    Worker,
)
from bendtwin.rollout import Fidelity, Returns, RolloutResult
from bendtwin.session import SessionCalls
from bendtwin.state import InitialState, State
from bendtwin.step import Step
from bendtwin.token import aio_interceptors, shown_token
from bendtwin.transport import transport
from bendtwin.twin import TwinFacts
from bendtwin.uploads import Sender
from bendtwin.v1 import session_pb2
from bendtwin.world import Grasp, Vary, World

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Twin(TwinFacts[AsyncCaller]):
    """A fitted twin at the server. Get one with `Client.twin`; await its rollouts."""

    async def geometry(self, *, timeout_s: float | None = None) -> Geometry:
        """Its nodes, springs and control points; asked for once, as twins never change."""
        if self._geometry is None:
            self._geometry = await self._caller.run(calls.twin_geometry(self.name), timeout_s)
        return self._geometry

    async def rollout(
        self, *, timeout_s: float | None = None, **arguments: Unpack[RolloutArguments]
    ) -> RolloutResult:
        """Predicts what a batch of actions does: see `bendtwin.Twin.rollout`."""
        call = calls.roll_out(self.rollout_request(**arguments))
        return await self._caller.run(call, timeout_s)

    def stream_rollout(
        self,
        *,
        part_frames: int = 0,
        timeout_s: float | None = None,
        **arguments: Unpack[RolloutArguments],
    ) -> AsyncIterator[RolloutResult]:
        """The same in parts, as instances finish, and in time with `part_frames`; see
        `bendtwin.Twin.stream_rollout`."""
        call = calls.stream_roll_out(self.rollout_request(**arguments), part_frames)
        return self._caller.parts(call, timeout_s)

    async def register(
        self,
        points: ArrayLike,
        *,
        timeout_s: float | None = None,
        **arguments: Unpack[RegisterArguments],
    ) -> Registration:
        """The state in which the twin explains points: see `bendtwin.Twin.register`."""
        call = register_state(self.name, points, arguments)
        return await self._caller.run(call, timeout_s)

    async def evaluate(self, capture: str, *, timeout_s: float | None = None) -> dict[str, Any]:
        """The quality table of the twin on a capture: see `bendtwin.Twin.evaluate`."""
        return await self._caller.run(calls.evaluate_twin(self.name, capture), timeout_s)

    async def plan(
        self,
        *,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> PlanUpdate:
        """Has the server look for actions that lower the costs: see `bendtwin.Twin.plan`."""
        request = plan_request(self.name, arguments)
        return await _last_of(self._caller.parts(calls.plan(request), timeout_s))

    def stream_plan(
        self,
        *,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> AsyncIterator[PlanUpdate]:
        """The best so far after each iteration of `plan`; closing the iterator ends the search."""
        request = plan_request(self.name, arguments)
        return self._caller.parts(calls.plan(request), timeout_s)


class Session(SessionCalls[AsyncCaller, Twin]):
    """`bendtwin.Session` for asyncio. Close it, or use it in `async with`."""

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
        """A batch from where the session is, which stays there."""
        return await self._caller.run(self._roll_out(slots, arguments), timeout_s)

    async def plan(
        self,
        *,
        slot: int = 0,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> PlanUpdate:
        """A plan from where a slot is: see `bendtwin.Session.plan`."""
        request = self._plan_request(slot, arguments)
        return await _last_of(self._caller.parts(calls.plan(request), timeout_s))

    def stream_plan(
        self,
        *,
        slot: int = 0,
        timeout_s: float | None = None,
        **arguments: Unpack[PlanArguments],
    ) -> AsyncIterator[PlanUpdate]:
        """The best so far after each iteration of `plan`; closing the iterator ends the search."""
        request = self._plan_request(slot, arguments)
        return self._caller.parts(calls.plan(request), timeout_s)

    async def advance(
        self,
        *,
        slots: Sequence[int] = (),
        timeout_s: float | None = None,
        **arguments: Unpack[RolloutArguments],
    ) -> RolloutResult:
        """Applies actions and leaves the slots where they end."""
        return await self._caller.run(self._advance(slots, arguments), timeout_s)

    def control(
        self, actions: AsyncIterable[RolloutArguments], *, slots: Sequence[int] = ()
    ) -> AsyncIterator[RolloutResult]:
        """Advances by one set of actions after another over one connection."""
        sent: deque[session_pb2.AdvanceSessionRequest] = deque()

        async def requests() -> AsyncIterator[session_pb2.AdvanceSessionRequest]:
            async for arguments in actions:
                sent.append(self._advance_request(slots, arguments))
                yield sent[-1]

        return self._caller.exchange(self._control(sent, requests()))

    async def correct(
        self,
        points: ArrayLike,
        *,
        slots: Sequence[int] = (),
        timeout_s: float | None = None,
        **arguments: Unpack[CorrectArguments],
    ) -> list[Correction]:
        """Brings the states of slots closer to points: see `bendtwin.Session.correct`."""
        return await self._caller.run(self._correct(slots, points, arguments), timeout_s)

    async def step(
        self,
        points: ArrayLike | None,
        search: PlanArguments,
        *,
        frames: int = 1,
        slot: int = 0,
        correct: CorrectArguments | None = None,
        returns: Returns | None = None,
        deadline_s: float | None = None,
        timeout_s: float | None = None,
    ) -> Step:
        """Takes a step of a closed loop in one call: see `bendtwin.Session.step`."""
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

    async def states(self, slots: Sequence[int] = ()) -> list[State]:
        """The states of slots, or of all of them."""
        return await self._caller.run(self._states(slots))

    async def refresh(self) -> SessionInfo:
        """The session as the server sees it now."""
        return await self._caller.run(session_calls.get_session(self.name))

    async def fork(self, source: int, to: Sequence[int] = ()) -> None:
        """Copies the state of a slot, and its rest shape, to others, or to all others."""
        await self._caller.run(self._fork(source, to))

    async def reset(self, slots: Sequence[int] = (), initial: InitialState | None = None) -> None:
        """Sets slots, or all, back to a first or given state: see `bendtwin.Session.reset`."""
        await self._caller.run(self._reset(slots, initial))

    async def reopen(self) -> list[int]:
        """Opens it again after it was lost: see `bendtwin.Session.reopen`."""
        opened = await self._caller.run(session_calls.open_session(self._opening))
        for call in self._resets(opened):
            await self._caller.run(call)
        return self._goes_on(opened)

    async def close(self) -> None:
        """Ends it; it is no error if it has ended."""
        await self._caller.run(session_calls.close_session(self.name))


class Client:
    """A BendTwin server, `host:port` or a URL, for one event loop. Close it or use `async with`.

    `token` is a key or the token of the server, `token_file` a file with either, which others must
    not be able to read. Without both it is that of `BENDTWIN_TOKEN`, in the file of
    `BENDTWIN_TOKEN_FILE`, or the one that a server of the same user on the same machine left. `ca`
    is as in `bendtwin.Client`.
    """

    def __init__(
        self,
        address: str = "127.0.0.1:7070",
        *,
        token: str | None = None,
        token_file: str | PathLike[str] | None = None,
        ca: str | PathLike[str] | None = None,
    ) -> None:
        self._transport = transport(address, ca)
        target, options = self._transport.target, calls.CHANNEL_OPTIONS
        self._token = shown_token(target, token, token_file)
        interceptors = aio_interceptors(self._token)
        if self._transport.is_https:
            credentials = self._transport.credentials()
            self._channel = grpc.aio.secure_channel(
                target, credentials, options=options, interceptors=interceptors
            )
        else:
            self._channel = grpc.aio.insecure_channel(
                target, options=options, interceptors=interceptors
            )
        self._caller = AsyncCaller(calls.Services(self._channel))

    async def __aenter__(self) -> Client:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Closes the connection."""
        await self._channel.close()

    # Captures

    async def upload_capture(
        self,
        path: str | PathLike[str],
        *,
        display_name: str | None = None,
        request_id: str | None = None,
        ingest: dict[str, Any] | None = None,
        ingest_requirements: Requirements | None = None,
    ) -> Capture:
        """Uploads a capture: see `bendtwin.Client.upload_capture`."""
        path = Path(path)
        name = path.stem if display_name is None else display_name
        packed = archive_of(path)
        archive = await asyncio.to_thread(packed.__enter__)
        try:
            return await self._caller.run(
                calls.create_capture(archive, name, request_id, ingest, ingest_requirements)
            )
        finally:
            packed.__exit__(None, None, None)

    async def upload_motion(
        self,
        motions: Motion | Sequence[Motion],
        *,
        fps: float,
        display_name: str = "motion",
        request_id: str | None = None,
        ingest: dict[str, Any] | None = None,
        ingest_requirements: Requirements | None = None,
        units: str = "m",
        up_axis: str = "+z",
        ground: float | None = 0.0,
        edges: ArrayLike | None = None,
        rest_points: ArrayLike | None = None,
        pins: ArrayLike | None = None,
    ) -> Capture:
        """Uploads motion capture: see `bendtwin.Client.upload_motion`."""
        content = bundle(
            motions,
            fps=fps,
            name=display_name,
            units=units,
            up_axis=up_axis,
            ground=ground,
            edges=edges,
            rest_points=rest_points,
            pins=pins,
        )
        with bundle_file(content) as path:
            return await self.upload_capture(
                path,
                display_name=display_name,
                request_id=request_id,
                ingest=ingest,
                ingest_requirements=ingest_requirements,
            )

    async def open_session(
        self,
        twin: Twin | str,
        *,
        initial: InitialState | None = None,
        slots: int = 1,
        world: World | None = None,
        grasps: Sequence[Grasp] = (),
        vary: Vary | None = None,
        fidelity: Fidelity = "exact",
        idle_timeout_s: float = 0.0,
    ) -> Session:
        """Opens simulations of a twin that stay: see `bendtwin.Client.open_session`."""
        of = await self.twin(twin) if isinstance(twin, str) else twin
        request = session_calls.open_request(
            of.name, initial, slots, world, grasps, vary, fidelity, idle_timeout_s
        )
        info = await self._caller.run(session_calls.open_session(request))
        return Session(self._caller, of, request, info, vary)

    async def push_capture(
        self,
        path: str | PathLike[str],
        *,
        display_name: str | None = None,
        request_id: str | None = None,
        ingest_requirements: Requirements | None = None,
        on_progress: Callable[[int, int], None] | None = None,
    ) -> Capture:
        """Uploads a capture resumably, in a thread: see `bendtwin.Client.push_capture`."""
        path = Path(path)
        if display_name is None:
            display_name = path.resolve().name if path.is_dir() else path.stem

        def send(display_name: str) -> str:
            with archive_of(path) as archive:
                sender = Sender(
                    self._transport,
                    archive,
                    display_name,
                    request_id,
                    token=self._token,
                    requirements=ingest_requirements,
                )
                return sender.send(on_progress)

        return await self.capture(await asyncio.to_thread(send, display_name))

    async def capture(self, name: str) -> Capture:
        """One capture."""
        return await self._caller.run(calls.get_capture(name))

    def captures(self, **choice: Unpack[ListArguments]) -> AsyncIterator[Capture]:
        """All captures, newest first, or those with a text or a tag, in another order."""
        return self._caller.pages(calls.list_captures(choice))

    async def update_capture(self, name: str, **change: Unpack[LabelArguments]) -> Capture:
        """Changes display name, note and tags of a capture; what is not given stays."""
        return await self._caller.run(calls.update_capture(name, change))

    async def delete_capture(self, name: str) -> None:
        """Deletes a capture; its twins stay."""
        await self._caller.run(calls.delete_capture(name))

    async def ingest_capture(
        self,
        name: str,
        settings: dict[str, Any] | None = None,
        *,
        request_id: str | None = None,
        requirements: Requirements | None = None,
    ) -> Capture:
        """Has a capture read again, with other settings say (docs/use/settings.md)."""
        return await self._caller.run(
            calls.ingest_capture(name, settings, request_id, requirements)
        )

    async def cancel_ingest(self, name: str) -> Capture:
        """Asks the ingest of a capture to stop; one that has ended is left as it is."""
        return await self._caller.run(calls.cancel_ingest(name))

    def watch_capture(self, name: str, *, timeout_s: float | None = None) -> AsyncIterator[Capture]:
        """The capture now and after every change of its ingest, until that has ended."""
        return self._caller.follow(calls.watch_capture(name), timeout_s)

    async def wait_for_capture(
        self,
        capture: Capture | str,
        *,
        timeout_s: float | None = None,
        on_progress: Callable[[Capture], None] | None = None,
    ) -> Capture:
        """Waits until a capture has been read. Raises IngestFailed if it cannot be fitted."""
        name = capture if isinstance(capture, str) else capture.name
        last: Capture | None = None
        async for last in self.watch_capture(name, timeout_s=timeout_s):
            if on_progress is not None:
                on_progress(last)
        ended = last if last is not None else await self.capture(name)
        if ended.ingest is not None and ended.ingest.state is not JobState.SUCCEEDED:
            raise IngestFailed(ended)
        return ended

    async def capture_report(self, name: str) -> dict[str, Any]:
        """Report on a capture: verdict, findings and what they rest on."""
        parts = [part async for part in self._caller.parts(calls.capture_report(name, html=False))]
        report: dict[str, Any] = json.loads(b"".join(parts))
        return report

    async def save_capture_report(self, name: str, path: str | PathLike[str]) -> None:
        """Writes the report of a capture as a page with pictures, to be opened in a browser."""
        await self._caller.save(calls.capture_report(name, html=True), path)

    async def export_observation(self, name: str, path: str | PathLike[str]) -> None:
        """Writes what fits of a capture work on, tracked points as a bundle (ZIP)."""
        await self._caller.save(calls.export_observation(name), path)

    # Fits

    async def fit(
        self,
        capture: str,
        settings: dict[str, Any] | None = None,
        *,
        priority: int = 0,
        request_id: str | None = None,
        display_name: str = "",
        requirements: Requirements | None = None,
    ) -> Fit:
        """Starts a fit of a capture. `settings` are those of docs/use/settings.md.

        Without a `display_name` it has its capture's; without `requirements` any worker will do.
        """
        return await self._caller.run(
            calls.create_fit(capture, settings, priority, request_id, display_name, requirements)
        )

    async def get_fit(self, name: str) -> Fit:
        """One fit as it stands."""
        return await self._caller.run(calls.get_fit(name))

    def fits(
        self, capture: str = "", *, state: JobState | None = None, **choice: Unpack[ListArguments]
    ) -> AsyncIterator[Fit]:
        """All fits, newest first, or those of a capture, in a state, with a text or a tag."""
        return self._caller.pages(calls.list_fits(capture, state, choice))

    async def update_fit(self, name: str, **change: Unpack[LabelArguments]) -> Fit:
        """Changes display name, note and tags of a fit; what is not given stays."""
        return await self._caller.run(calls.update_fit(name, change))

    async def fit_losses(self, fit: Fit | str) -> list[LossCurve]:
        """The losses of a fit, by stage and model. They stay until it is deleted."""
        name = fit if isinstance(fit, str) else fit.name
        return await self._caller.run(calls.fit_losses(name))

    async def cancel_fit(self, name: str) -> Fit:
        """Asks a fit to stop; one that has ended is returned as it is."""
        return await self._caller.run(calls.cancel_fit(name))

    async def delete_fit(self, name: str) -> None:
        """Deletes a fit that has ended; its twin stays."""
        await self._caller.run(calls.delete_fit(name))

    def watch(self, name: str, *, timeout_s: float | None = None) -> AsyncIterator[Fit]:
        """The fit now and after every change, until it has ended."""
        return self._caller.follow(calls.watch_fit(name), timeout_s)

    async def wait(
        self,
        fit: Fit | str,
        *,
        timeout_s: float | None = None,
        on_progress: Callable[[Fit], None] | None = None,
    ) -> Fit:
        """Waits for a fit to succeed. Raises FitFailed if it ends without a twin."""
        name = fit if isinstance(fit, str) else fit.name
        last: Fit | None = None
        async for last in self.watch(name, timeout_s=timeout_s):
            if on_progress is not None:
                on_progress(last)
        ended = last if last is not None else await self.get_fit(name)
        if ended.state is not JobState.SUCCEEDED:
            raise FitFailed(ended)
        return ended

    # Twins

    async def twin(self, name: str) -> Twin:
        """A twin, ready for rollouts."""
        return self._twin(await self._caller.run(calls.get_twin(name)))

    async def twins(
        self, capture: str = "", **choice: Unpack[ListArguments]
    ) -> AsyncIterator[Twin]:
        """All twins, newest first, or those of a capture, with a text or a tag."""
        async for info in self._caller.pages(calls.list_twins(capture, choice)):
            yield self._twin(info)

    async def update_twin(self, name: str, **change: Unpack[LabelArguments]) -> Twin:
        """Changes display name, note and tags of a twin; what is not given stays."""
        return self._twin(await self._caller.run(calls.update_twin(name, change)))

    async def export_twin(self, name: str, path: str | PathLike[str]) -> None:
        """Writes a twin's file (safetensors, docs/formats/twin.md)."""
        await self._caller.save(calls.export_twin(name), path)

    async def import_twin(
        self,
        path: str | PathLike[str],
        *,
        display_name: str | None = None,
        request_id: str | None = None,
    ) -> Twin:
        """Stores a twin file that was exported elsewhere."""
        return self._twin(await self._caller.run(calls.create_twin(path, display_name, request_id)))

    async def delete_twin(self, name: str) -> None:
        """Deletes a twin."""
        await self._caller.run(calls.delete_twin(name))

    # Workers

    def workers(self) -> AsyncIterator[Worker]:
        """The workers that the server knows."""
        return self._caller.pages(calls.list_workers())

    async def drain_worker(self, name: str) -> Worker:
        """Asks a worker to take no more work, hand back its job, and end after its rollouts."""
        return await self._caller.run(calls.drain_worker(name))

    def _twin(self, info: TwinInfo) -> Twin:
        return Twin(info, self._caller)


async def _last_of(updates: AsyncIterator[PlanUpdate]) -> PlanUpdate:
    last = None
    async for update in updates:
        last = update
    return whole(last)
