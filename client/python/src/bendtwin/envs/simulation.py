"""The session of an environment: all slots in one call, with a message that is made once.

Between steps only poses, openings and factors change, so their bytes are replaced in the message
of the step before. Replies bring the recorded points and nothing else. A slot that diverges does
not keep the others from moving, and a lost session is opened again.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from queue import SimpleQueue
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from bendtwin import session_calls
from bendtwin.calls import Call
from bendtwin.connection.caller import Caller
from bendtwin.envs.body import Array, Indices
from bendtwin.errors import BendTwinError, Category
from bendtwin.session import Session
from bendtwin.simulation.rollout import Fidelity, Returns
from bendtwin.simulation.state import State
from bendtwin.simulation.world import Grasp, Sphere, Vary, World
from bendtwin.tensors import unpack
from bendtwin.twin import Twin
from bendtwin.v1 import rollout_pb2, session_pb2

Mask = npt.NDArray[np.bool_]
_Result = TypeVar("_Result")

#: Time without calls after which a session ends: the longest, as policies learn between episodes.
_IDLE_S = 3600.0
#: Time for which a lost session is opened again, and between two tries.
_REOPEN_S, _PAUSE_S = 60.0, 0.2


#: Errors after which nobody knows whether the slots have moved.
_UNKNOWN = (Category.UNAVAILABLE, Category.ABORTED, Category.CANCELLED)


class SessionLost(Exception):
    """The worker of the session was lost, or the connection to it, and with it the states of all
    slots."""


@dataclass(frozen=True, kw_only=True)
class Setup:
    """What a session simulates."""

    world: World
    #: Number of grippers, and the radius of a gripper's reach in metres.
    grippers: int
    radius_m: float
    #: Frames and knots of a step.
    frames: int
    knots: int
    #: Nodes that are recorded; None: all.
    nodes: Indices | None = None
    velocities: bool = False
    slip_force_n: float | None = None
    #: Fields of `Vary` that differ between slots.
    factors: Sequence[str] = ()
    fidelity: Fidelity = "exact"


@dataclass(frozen=True)
class Stepped:
    """Points at the end of a step. Rows of slots that diverged have no meaning."""

    #: Metres, [B, M, 3].
    positions: npt.NDArray[np.float32]
    #: Metres per second, [B, M, 3], if they are recorded.
    velocities: npt.NDArray[np.float32] | None
    #: [B]. The state of such a slot is the one before the step.
    diverged: Mask
    #: Beyond a limit of `Plausibility`, [B].
    implausible: Mask


@dataclass
class Simulation:
    """Slots of a session whose grippers hold what is in their reach when they close.

    The recorded control points hold nothing: an additional gripper that stands still has them.
    """

    twin: Twin
    setup: Setup
    slots: int
    session: Session = field(init=False)
    _stream: _Stream | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        setup, geometry = self.setup, self.twin.geometry()
        free = setup.grippers
        hands = [
            Grasp(gripper=free, hand=hand, closed=False) for hand in range(geometry.hand_count)
        ]
        closed = np.zeros((self.slots, setup.knots + 1), np.uint32)
        grasps = [
            Grasp(
                gripper=gripper,
                region=Sphere(setup.radius_m),
                closed=closed,
                max_force_n=setup.slip_force_n,
            )
            for gripper in range(free)
        ]
        self._poses = np.zeros((self.slots, setup.knots + 1, free + 1, 7), np.float32)
        self._poses[..., 6] = 1.0
        self._closed = np.zeros((free, *closed.shape), np.uint32)
        self._factors = {name: np.ones(self.slots, np.float32) for name in setup.factors}
        controls = np.full(len(geometry.controls), free)
        arguments: Any = {
            "poses": self._poses,
            "gripper_of_control": controls,
            "frames": setup.frames,
            "grasps": [*grasps, *hands],
            "vary": _vary(self._factors),
            "returns": Returns(
                every_frames=setup.frames, nodes=setup.nodes, velocities=setup.velocities
            ),
        }
        nodes = setup.nodes
        self._points = len(geometry.rest_positions) if nodes is None else len(nodes)
        self._opening = session_calls.open_request(
            self.twin.name, None, self.slots, setup.world, (), None, setup.fidelity, _IDLE_S
        )
        self._open()
        self._request = session_calls.advance_request(
            self.session.name, range(self.slots), arguments
        )

    def step(self, poses: Array, closed: Mask, rows: Indices) -> Stepped:
        """Moves the grippers of some slots [R] by knots [B, K + 1, G, 7], closed or open from each
        on, [B, K + 1, G].

        Raises:
            SessionLost: If all states are lost.
        """
        self._poses[:, :, :-1] = poses
        self._closed[:] = np.moveaxis(closed, 2, 0)
        diverged = np.zeros(self.slots, bool)
        while len(rows):
            reply = self._run(self._advance(rows))
            if not reply.diverged:
                return self._read(reply, rows, diverged)
            # Nothing has moved: those that stayed finite do so again without the others.
            diverged[rows[[one.instance for one in reply.diverged]]] = True
            rows = rows[~diverged[rows]]
        nothing = np.zeros((self.slots, self._points, 3), np.float32)
        return Stepped(nothing, nothing, diverged, np.zeros_like(diverged))

    def reset(self, slots: Indices, states: State, factors: Mapping[str, Array]) -> None:
        """Sets slots [R] to states [R], with factors [R] by name."""
        for name, values in factors.items():
            self._factors[name][slots] = values
        self._call(session_calls.reset_session(self.session.name, slots.tolist(), states))

    def reopen(self) -> None:
        """Opens the session again; its slots are to be reset."""
        self._hang_up()
        self._open()
        self._request.name = self.session.name

    def close(self) -> None:
        """Ends the session."""
        self._hang_up()
        self.session.close()

    def run(self, what: Callable[[], _Result]) -> _Result:
        """The result of a function that calls the session.

        Raises:
            SessionLost: If the session was lost.
        """
        try:
            return what()
        except BendTwinError as error:
            if error.category in _UNKNOWN:
                raise SessionLost(str(error)) from error
            raise

    def _open(self) -> None:
        deadline = time.monotonic() + _REOPEN_S
        while True:
            try:
                info = self.twin._caller.run(session_calls.open_session(self._opening))
                break
            except BendTwinError as error:
                if not error.category.is_transient or time.monotonic() > deadline:
                    raise
            time.sleep(_PAUSE_S)
        self.session = Session(self.twin._caller, self.twin, self._opening, info)

    def _advance(self, rows: Indices) -> session_pb2.AdvanceSessionRequest:
        """The message that advances some slots; that of all slots is kept."""
        request = self._request
        if len(rows) != self.slots:
            request = session_pb2.AdvanceSessionRequest()
            request.CopyFrom(self._request)
            request.slots[:] = rows.tolist()
        rollout = request.rollout
        _fill(rollout.poses.poses, self._poses[rows])
        for gripper, closed in enumerate(self._closed):
            _fill(rollout.grasps[gripper].closed, closed[rows])
        for name, values in self._factors.items():
            _fill(getattr(rollout.vary, name), values[rows])
        return request

    def _run(self, request: session_pb2.AdvanceSessionRequest) -> rollout_pb2.RollOutResponse:
        if self._stream is None:
            self._stream = _Stream(self.twin._caller)
        stream = self._stream
        try:
            return self.run(lambda: stream.ask(request))
        except BaseException:
            # It ends with an advance that fails.
            self._hang_up()
            raise

    def _hang_up(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close()

    def _call(self, call: Call[_Result]) -> _Result:
        return self.run(lambda: self.twin._caller.run(call))

    def _read(self, reply: rollout_pb2.RollOutResponse, rows: Indices, diverged: Mask) -> Stepped:
        implausible = np.zeros(self.slots, bool)
        for one in reply.implausible:
            implausible[rows[one.instance]] = True
        positions = self._whole(reply.positions, rows)
        velocities = self._whole(reply.velocities, rows) if self.setup.velocities else None
        return Stepped(positions, velocities, diverged, implausible)

    def _whole(self, tensor: Any, rows: Indices) -> npt.NDArray[np.float32]:
        """The last recorded frame of some slots, with rows for all."""
        array = _last(tensor)
        if len(rows) == self.slots:
            return array
        whole = np.zeros((self.slots, *array.shape[1:]), np.float32)
        whole[rows] = array
        return whole


class _Stream:
    """Advances over one call, whose messages cost less than separate calls."""

    def __init__(self, caller: Caller) -> None:
        self._sent: SimpleQueue[session_pb2.AdvanceSessionRequest | None] = SimpleQueue()
        requests = iter(self._sent.get, None)
        call: Call[rollout_pb2.RollOutResponse] = Call(
            lambda s: s.sessions.ControlSession, requests, lambda reply: reply
        )
        self._replies = caller.exchange(call)

    def ask(self, request: session_pb2.AdvanceSessionRequest) -> rollout_pb2.RollOutResponse:
        """The reply to a message, which must not change before."""
        self._sent.put(request)
        reply = next(self._replies, None)
        if reply is None:
            raise SessionLost("the server has ended the stream of the session")
        return reply

    def close(self) -> None:
        """Ends the call."""
        self._sent.put(None)
        close: Any = getattr(self._replies, "close", None)
        if close is not None:
            close()


def _vary(factors: Mapping[str, Any]) -> Vary | None:
    """Factors by name, each with a row for every slot."""
    return Vary(**factors) if factors else None


def _last(tensor: Any) -> npt.NDArray[np.float32]:
    """The last recorded frame of points, [B, M, 3]."""
    array = unpack(tensor)
    if array is None:
        raise ValueError("the reply has no recorded points")
    return np.asarray(array, np.float32)[:, -1]


def _fill(tensor: Any, values: npt.NDArray[Any]) -> None:
    """Replaces the numbers of a tensor of the same type."""
    if tensor.shape[0] != len(values):
        tensor.shape[:] = values.shape
    tensor.data = values.tobytes()
