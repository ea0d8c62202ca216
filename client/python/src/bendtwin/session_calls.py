"""Calls about a session as values, for `Session` and for that of asyncio."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bendtwin.calls import Call, read_rollout
from bendtwin.resources import SessionInfo
from bendtwin.simulation.arguments import RolloutArguments, rollout_request
from bendtwin.simulation.rollout import FIDELITIES, Fidelity, RolloutResult
from bendtwin.simulation.state import InitialState, State, state_of
from bendtwin.simulation.world import Grasp, Surroundings, Vary, World
from bendtwin.v1 import rollout_pb2, session_pb2


def open_request(
    twin: str,
    initial: InitialState | None,
    slots: int,
    world: World | None,
    grasps: Sequence[Grasp],
    vary: Vary | None,
    fidelity: Fidelity,
    idle_timeout_s: float,
) -> session_pb2.OpenSessionRequest:
    """The message that opens a session, whose client has the factors of its slots.

    Raises:
        ValueError: If there is neither one factor nor one for each slot.
    """
    if vary is not None and vary.fits:
        raise ValueError("fits go with an ensemble: give both to the calls of the session")
    for name, factor in ({} if vary is None else vary.factors).items():
        if factor.shape not in ((1,), (slots,)):
            raise ValueError(f"{name} has shape {factor.shape}: give one factor, or {slots}")
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


def open_session(request: session_pb2.OpenSessionRequest) -> Call[SessionInfo]:
    """Opens a session."""
    return Call(lambda s: s.sessions.OpenSession, request, SessionInfo.from_proto)


def get_session(name: str) -> Call[SessionInfo]:
    """A session as it stands."""
    request = session_pb2.GetSessionRequest(name=name)
    return Call(lambda s: s.sessions.GetSession, request, SessionInfo.from_proto)


def session_states(name: str, slots: Sequence[int]) -> Call[list[State]]:
    """States of slots, or of all."""
    request = session_pb2.GetSessionStatesRequest(name=name, slots=slots)
    return Call(lambda s: s.sessions.GetSessionStates, request, _read_states)


def advance_request(
    name: str, slots: Sequence[int], arguments: RolloutArguments
) -> session_pb2.AdvanceSessionRequest:
    """The message that advances slots by a rollout."""
    rollout = rollout_request("", arguments)
    # They are those of the session.
    rollout.ClearField("initial")
    rollout.ClearField("fidelity")
    return session_pb2.AdvanceSessionRequest(name=name, slots=slots, rollout=rollout)


def advance_session(request: session_pb2.AdvanceSessionRequest) -> Call[RolloutResult]:
    """Advances slots."""
    return Call(lambda s: s.sessions.AdvanceSession, request, read_rollout)


def control_session(requests: Any) -> Call[RolloutResult]:
    """Advances slots by each message of an iterator."""
    return Call(lambda s: s.sessions.ControlSession, requests, RolloutResult.from_proto)


def fork_session(name: str, source: int, to: Sequence[int]) -> Call[None]:
    """Copies the state of a slot to others, or to all others."""
    request = session_pb2.ForkSessionRequest(name=name, to=to, **{"from": source})
    return Call(lambda s: s.sessions.ForkSession, request, lambda _: None)


def reset_session(name: str, slots: Sequence[int], initial: InitialState | None) -> Call[None]:
    """Sets slots, or all, back to the first state, or to a given one."""
    request = session_pb2.ResetSessionRequest(name=name, slots=slots)
    if initial is not None:
        request.initial.CopyFrom(initial.to_proto())
    return Call(lambda s: s.sessions.ResetSession, request, lambda _: None)


def close_session(name: str) -> Call[None]:
    """Ends a session."""
    request = session_pb2.CloseSessionRequest(name=name)
    return Call(lambda s: s.sessions.CloseSession, request, lambda _: None)


def _read_states(reply: Any) -> list[State]:
    states = State.from_proto(reply.states)
    return [state_of(states, row) for row in range(len(reply.slots))]
