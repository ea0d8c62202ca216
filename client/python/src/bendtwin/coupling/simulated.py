"""The side of the twin: a session whose slots are advanced frame by frame, over one stream.

The state after the last frame is kept here, so that the session can be brought back to it after a
loss.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from bendtwin.coupling.errors import CouplingError
from bendtwin.coupling.surroundings import Surroundings
from bendtwin.errors import BendTwinError, Category
from bendtwin.session import Session
from bendtwin.simulation.arguments import RolloutArguments
from bendtwin.simulation.rollout import Returns, RolloutResult
from bendtwin.simulation.state import State
from bendtwin.v1 import session_pb2

Rows = npt.NDArray[np.float32]

#: Most evaluations between two copies of the state to the other slots.
MOST_TRIALS = 7


class Simulated:
    """A twin in a session. With one slot a frame is final; with more, frames are tried in the other
    slots until one is taken."""

    def __init__(self, session: Session, around: Surroundings, returns: Returns) -> None:
        self.session = session
        #: Slot in which the twin is after the last frame.
        self.slot = 0
        #: The state there.
        self.state: State = session.states([0])[0]
        self._around, self._returns = around, returns
        self._usual = tuple(grasp.closed is True for grasp in around.grasps)
        #: Other slots in the same state.
        self._fresh: list[int] = []
        self._stream: Iterator[RolloutResult] | None = None
        #: Messages by which grasps are closed; of each only slot and poses change.
        self._messages: dict[tuple[bool, ...], session_pb2.AdvanceSessionRequest] = {}
        self._next: session_pb2.AdvanceSessionRequest | None = None
        self._sent: deque[session_pb2.AdvanceSessionRequest] = deque()
        self._is_in_doubt = self._is_lost = False

    def evaluate(
        self, start: Rows, end: Rows, closed: tuple[bool, ...]
    ) -> tuple[int, RolloutResult]:
        """The frame in which the grippers move from poses [G, 7] to others, and its slot.

        Raises:
            CouplingError: If the twin diverges; nothing has changed.
            BendTwinError: As any call.
        """
        slots = self.session.info.slots
        slot = self.slot
        if slots > 1:
            if not self._fresh:
                self.session.fork(slot)
                self._fresh = [other for other in range(slots) if other != slot]
            slot = self._fresh.pop()
        rows = np.stack([start, end])[None]
        message = self._messages.get(closed)
        if message is None:
            message = self._messages[closed] = self._message(rows, closed)
        message.slots[:] = [slot]
        message.rollout.poses.poses.data = rows.tobytes()
        self._next = message
        if self._stream is None:
            call = self.session._control(self._sent, self._requests())
            self._stream = self.session._caller.exchange(call)
        result = next(self._stream, None)
        if result is None:
            text = "the server has ended the stream of frames: it stops or restarts"
            raise BendTwinError(Category.UNAVAILABLE, "UNAVAILABLE", text)
        if result.diverged:
            raise CouplingError(
                "TWIN_DIVERGED",
                f"the twin diverged at node {result.diverged[0].node}: a body moved it faster or "
                "farther than its springs allow; move slower, or let grasps slip (max_force_n)",
            )
        return slot, result

    def take(self, slot: int, result: RolloutResult) -> None:
        """Makes a frame that was tried in a slot the last one."""
        if self.session.info.slots > 1:
            # The others are where the frame began, or elsewhere.
            self.slot, self._fresh = slot, []
        self.state = result.state(0)

    def set(self, state: State) -> None:
        """Sets the state; the session follows with `agree`."""
        self.state, self._is_in_doubt = state, True

    def missed(self, error: BaseException) -> bool:
        """Notes a call that failed; true if the same may succeed after `agree`."""
        if isinstance(error, CouplingError):
            return False
        self._is_in_doubt = True
        if isinstance(error, BendTwinError):
            self._is_lost |= error.reason == "SESSION_LOST"
            return self._is_lost or error.category is Category.UNAVAILABLE
        return False

    def agree(self) -> None:
        """Brings the session to the state that is kept here, if it may be in another."""
        if not self._is_in_doubt:
            return
        self._end_stream()
        if self._is_lost:
            self.session.reopen()
            self._is_lost = False
        self.session.reset([self.slot], self.state)
        self._fresh = []
        self._is_in_doubt = False

    def close(self) -> None:
        """Ends the session."""
        self._end_stream()
        self.session.close()

    def _message(self, rows: Rows, closed: tuple[bool, ...]) -> session_pb2.AdvanceSessionRequest:
        arguments: RolloutArguments = {
            "poses": rows,
            "gripper_of_control": self._around.gripper_of_control,
            "frames": 1,
            "returns": self._returns,
        }
        if closed != self._usual:
            grasps = zip(self._around.grasps, closed, strict=True)
            arguments["grasps"] = [replace(grasp, closed=is_closed) for grasp, is_closed in grasps]
        return self.session._advance_request([], arguments)

    def _requests(self) -> Iterator[session_pb2.AdvanceSessionRequest]:
        while self._next is not None:
            self._sent.append(self._next)
            yield self._next

    def _end_stream(self) -> None:
        if isinstance(self._stream, Generator):
            self._stream.close()
        self._stream = None
        # Another session has another name.
        self._messages.clear()
        self._sent.clear()
