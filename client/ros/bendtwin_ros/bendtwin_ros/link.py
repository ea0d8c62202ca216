"""The link to the server: a client, the twin and a session, made again when they are lost.

Every call of the node goes through `Link.run`, which decides what a failure means: to try again
after a pause, to open the session again, or to wait for a person. No failure leaves this file but
`Unavailable` and those of a single request.
"""

from __future__ import annotations

import enum
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar

from bendtwin import BendTwinError, Category, Client, Session, Twin
from bendtwin.simulation.state import InitialState
from bendtwin_ros.parameters import Settings
from bendtwin_ros.status import Status

_Reply = TypeVar("_Reply")

#: Pauses, seconds: the first after a failure, the longest, and the one while only a person can
#: help, who may at any time.
_FIRST_S = 0.25
_LONGEST_S = 10.0
_PERSON_S = 15.0
#: A session without calls for this time ends; it is opened again when clouds return.
_IDLE_S = 600.0
#: Time limit of calls that are given no other one, seconds.
_CALL_S = 10.0
#: Slot that follows the object, and slot from which plans start.
TRACKED, PLANNED = 0, 1


class Unavailable(Exception):
    """There is no server, twin or session now; the message says why."""


class Trouble(enum.Enum):
    """What a failed call means."""

    #: The next call may succeed.
    TRANSIENT = enum.auto()
    #: The session ended, the rest stands.
    SESSION = enum.auto()
    #: Somebody has to do something: the twin was deleted, or the key has expired.
    PERSON = enum.auto()
    #: This request alone is wrong.
    REQUEST = enum.auto()


#: After these a call may have had its effect at the worker.
_UNKNOWN_EFFECT = (Category.UNAVAILABLE, Category.DEADLINE_EXCEEDED)
_PERSON = (Category.NOT_FOUND, Category.UNAUTHENTICATED, Category.PERMISSION_DENIED)


def trouble_of(error: BendTwinError) -> Trouble:
    """What an error means for the calls that follow."""
    if error.reason in ("SESSION_LOST", "SESSION_ELSEWHERE"):
        return Trouble.SESSION
    if error.category in _PERSON:
        return Trouble.PERSON
    if error.category.is_transient or error.category is Category.DEADLINE_EXCEEDED:
        return Trouble.TRANSIENT
    return Trouble.REQUEST


class Link:
    """Server, twin and session."""

    def __init__(
        self,
        settings: Settings,
        status: Status,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`clock`: seconds that only grow, for pauses."""
        self._settings = settings
        self._status = status
        self._clock = clock
        self._client: Client | None = None
        self._twin: Twin | None = None
        self._session: Session | None = None
        self._is_lost = False
        self._pause_s = _FIRST_S
        self._next = -float("inf")

    def close(self) -> None:
        """Closes session and connection; an unreachable server ends the session by itself."""
        if self._session is not None and not self._is_lost:
            try:
                self._session.close()
            except BendTwinError as error:
                self._status.count("session not closed", str(error))
        if self._client is not None:
            self._client.close()
        self._client = self._twin = self._session = None

    @property
    def is_open(self) -> bool:
        """True with a session, even if it has to be opened again."""
        return self._session is not None

    @property
    def twin_name(self) -> str:
        """twins/{uuid}, or what the parameter says before it is known."""
        return self._settings["twin"] if self._twin is None else self._twin.name

    def twin(self) -> Twin:
        """The twin.

        Raises:
            Unavailable: If it cannot be had now.
        """
        if self._twin is None:
            self._twin = self.run(self._found)
        return self._twin

    def open(self, start: InitialState) -> Session:
        """Opens the session, or sets all slots to a state if it is open.

        Raises:
            Unavailable: If that is not possible now.
        """
        if self._session is not None:
            session, _ = self.session()
            self.run(lambda: session.reset(initial=start))
            return session
        twin = self.twin()
        self._session = self.run(lambda: self._opened(twin, start))
        self._is_lost = False
        return self._session

    def session(self) -> tuple[Session, int]:
        """The session, and by how many frames the tracked slot is behind where it was, if it had
        to be opened again.

        Raises:
            Unavailable: If that is not possible now.
        """
        session = self._session
        if session is None:
            raise Unavailable("the object was not found yet")
        if not self._is_lost:
            return session, 0
        behind = self.run(session.reopen)
        self._is_lost = False
        self._status.count("session opened again", f"{session.name}")
        return session, behind[TRACKED]

    def drop_session(self) -> None:
        """Forgets the session, so that the next one starts from another state."""
        session, self._session = self._session, None
        if session is not None and not self._is_lost:
            # It ends by itself if this call does not reach the server.
            with suppress(Unavailable, BendTwinError):
                self.run(session.close)

    def run(self, call: Callable[[], _Reply]) -> _Reply:
        """The reply of a call.

        Raises:
            Unavailable: If there was none for lack of server, twin, session or rights, or if the
                pause after such a failure is not over.
            BendTwinError: If the request itself is refused.
        """
        if self._clock() < self._next:
            raise Unavailable(self._status.down)
        try:
            reply = call()
        except BendTwinError as error:
            trouble = trouble_of(error)
            if trouble is Trouble.REQUEST:
                self._up()
                raise
            self._fall(trouble, error)
            raise Unavailable(self._status.down) from error
        self._up()
        return reply

    def _up(self) -> None:
        self._pause_s, self._next = _FIRST_S, -float("inf")
        self._status.down, self._status.needs_person = "", False

    def _fall(self, trouble: Trouble, error: BendTwinError) -> None:
        self._status.count(f"call failed: {error.reason}", str(error))
        self._status.down = str(error)
        self._status.needs_person = trouble is Trouble.PERSON
        if trouble is Trouble.SESSION and not self._is_lost:
            # Another one may be opened immediately.
            self._is_lost = True
            return
        if error.category in _UNKNOWN_EFFECT and self._session is not None:
            # The slot may have been advanced or not: the reopened one is where it was last seen.
            self._is_lost = True
        pause = _PERSON_S if trouble is Trouble.PERSON else self._pause_s
        self._next = self._clock() + pause
        self._pause_s = min(2.0 * self._pause_s, _LONGEST_S)
        if trouble is Trouble.PERSON:
            # A new client reads the token again, and the twin may be another one of that name.
            client, self._client = self._client, None
            self._twin = self._session = None
            self._is_lost = False
            if client is not None:
                client.close()

    def _found(self) -> Twin:
        """The twin, which has its geometry from now on."""
        if self._client is None:
            self._client = self._made_client()
        twin = self._named(self._client)
        twin.geometry()
        return twin

    def _named(self, client: Client) -> Twin:
        wanted: str = self._settings["twin"]
        if wanted.startswith("twins/"):
            return client.twin(wanted)
        all_found = client.twins(search=wanted)
        named = [twin for twin in all_found if twin.info.display_name == wanted]
        if len(named) != 1:
            found = ", ".join(t.name for t in named) or "none"
            message = f"the parameter `twin` is {wanted!r}: name one twin (found: {found})"
            raise BendTwinError(Category.NOT_FOUND, "TWIN_NOT_FOUND", message)
        return named[0]

    def _made_client(self) -> Client:
        try:
            return Client(
                self._settings["server.address"],
                token_file=self._settings["server.token_file"] or None,
                ca=self._settings["server.ca"] or None,
                timeout_s=_CALL_S,
            )
        except (OSError, ValueError) as error:
            # A token file that is missing or readable by others, or a malformed address.
            raise BendTwinError(Category.UNAUTHENTICATED, "CLIENT_SETTINGS", str(error)) from error

    def _opened(self, twin: Twin, start: InitialState) -> Session:
        client = self._client
        if client is None:
            raise Unavailable("the connection was closed")
        return client.open_session(twin, initial=start, slots=2, idle_timeout_s=_IDLE_S)
