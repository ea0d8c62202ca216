"""Sessions: simulations that live at a worker between calls."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from bendtwin import calls
from bendtwin.errors import translated
from bendtwin.rollout import FIDELITIES, Fidelity, RolloutResult, warned
from bendtwin.state import Grasping, InitialState, SessionSlots, State
from bendtwin.tensors import unpack
from bendtwin.twin import Rollouts, Twin
from bendtwin.v1 import rollout_pb2, session_pb2
from bendtwin.world import Grasp, Surroundings, World


@dataclass(frozen=True)
class SessionInfo:
    """Facts of a session."""

    #: sessions/{uuid}.
    name: str
    #: twins/{uuid}.
    twin: str
    slots: int
    #: Frames by which each slot has been advanced since its first state [slots].
    frames: tuple[int, ...]
    #: The session ends when nobody has used it for so long.
    idle_timeout_s: float
    #: workers/{uuid}.
    worker: str

    @classmethod
    def from_proto(cls, message: session_pb2.Session) -> SessionInfo:
        """Reads the wire form."""
        return cls(
            name=message.name,
            twin=message.twin,
            slots=message.slots,
            frames=tuple(message.frames),
            idle_timeout_s=message.idle_timeout_s,
            worker=message.worker,
        )


class Session:
    """One or several simulations of a twin that stay where they are between calls.

    Get one with `Client.open_session`, and close it or use it in `with`. If its worker is lost, or
    nobody uses it for a while, calls raise BendTwinError with the reason SESSION_LOST: open another
    from the last state that you have.
    """

    def __init__(self, services: calls.Services, twin: Twin, info: SessionInfo) -> None:
        #: What the server said when it was opened.
        self.info = info
        self.twin = twin
        self._sessions = services.sessions

    @property
    def name(self) -> str:
        """sessions/{uuid}."""
        return self.info.name

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def rollout(self, *, slots: Sequence[int] = (), **arguments: Any) -> RolloutResult:
        """A batch from where the session is, which stays there.

        `slots` are one for all instances (default: 0) or one for each; the other arguments are
        those of `Twin.rollout` without `initial`.
        """
        return self.twin.rollout(initial=SessionSlots(self.name, tuple(slots)), **arguments)

    def advance(
        self, *, slots: Sequence[int] = (), timeout_s: float | None = None, **arguments: Any
    ) -> RolloutResult:
        """Applies actions and leaves the slots where they end: one slot (default: 0) an instance.

        The other arguments are those of `Twin.rollout` without `initial` and `fidelity`. Nothing
        changes if it fails or an instance diverges.
        """
        request = advance_request(self.name, self.twin, slots, arguments)
        with translated():
            reply = self._sessions.AdvanceSession(request, timeout=timeout_s)
        return warned(RolloutResult.from_proto(reply))

    def control(
        self, actions: Iterable[dict[str, Any]], *, slots: Sequence[int] = ()
    ) -> Iterator[RolloutResult]:
        """Advances by one set of actions after another over one connection: teleoperation.

        Each is a dict of arguments of `advance`, and is answered before the next is asked for.
        """
        messages = (advance_request(self.name, self.twin, slots, a) for a in actions)
        with translated():
            for reply in self._sessions.ControlSession(messages):
                yield RolloutResult.from_proto(reply)

    def states(self, slots: Sequence[int] = ()) -> list[State]:
        """The states of slots, or of all of them; each can be an initial state anywhere."""
        request = session_pb2.GetSessionStatesRequest(name=self.name, slots=slots)
        with translated():
            reply = self._sessions.GetSessionStates(request)
        return read_states(reply)

    def refresh(self) -> SessionInfo:
        """The session as the server sees it now."""
        with translated():
            reply = self._sessions.GetSession(session_pb2.GetSessionRequest(name=self.name))
        return SessionInfo.from_proto(reply)

    def fork(self, source: int, to: Sequence[int] = ()) -> None:
        """Copies the state of a slot to others, or to all others."""
        request = session_pb2.ForkSessionRequest(name=self.name, to=to, **{"from": source})
        with translated():
            self._sessions.ForkSession(request)

    def reset(self, slots: Sequence[int] = (), initial: InitialState | None = None) -> None:
        """Sets slots, or all, back to the session's first state, or to a given one."""
        request = session_pb2.ResetSessionRequest(name=self.name, slots=slots)
        if initial is not None:
            request.initial.CopyFrom(initial.to_proto())
        with translated():
            self._sessions.ResetSession(request)

    def close(self) -> None:
        """Ends it; it is no error if it has ended."""
        with translated():
            self._sessions.CloseSession(session_pb2.CloseSessionRequest(name=self.name))


def advance_request(
    name: str, twin: Rollouts[Any, Any], slots: Sequence[int], arguments: dict[str, Any]
) -> session_pb2.AdvanceSessionRequest:
    """The message that advances a session."""
    rollout = twin.rollout_request(**arguments)
    for field in ("twin", "initial", "fidelity"):
        rollout.ClearField(field)
    return session_pb2.AdvanceSessionRequest(name=name, slots=slots, rollout=rollout)


def read_states(reply: session_pb2.SessionStates) -> list[State]:
    """The states of slots."""
    given = reply.states
    arrays: dict[str, Any] = {
        name: unpack(getattr(given, name))
        for name in ("positions", "velocities", "twists", "controls")
    }
    grasping = Grasping.from_proto(given.grasping) if given.HasField("grasping") else None

    def one(row: int) -> State:
        values: dict[str, Any] = {n: None if a is None else a[row] for n, a in arrays.items()}
        return State(grasping=None if grasping is None else grasping.row(row), **values)

    return [one(row) for row in range(len(reply.slots))]


def open_request(
    twin: str,
    initial: InitialState | None,
    slots: int,
    world: World | None,
    grasps: Sequence[Grasp],
    fidelity: Fidelity,
    idle_timeout_s: float,
) -> session_pb2.OpenSessionRequest:
    """The message that opens a session."""
    request = session_pb2.OpenSessionRequest(
        twin=twin, slots=slots, fidelity=FIDELITIES[fidelity], idle_timeout_s=idle_timeout_s
    )
    if initial is not None:
        request.initial.CopyFrom(initial.to_proto())
    surroundings = rollout_pb2.RollOutRequest()
    Surroundings(world=world, grasps=grasps).add_to(surroundings)
    if surroundings.HasField("world"):
        request.world.CopyFrom(surroundings.world)
    request.grasps.extend(surroundings.grasps)
    return request
