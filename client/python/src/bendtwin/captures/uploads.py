"""Uploads over tus 1.0.0 that survive broken connections and restarts of either side.

There is no file of state: an upload is found again by its request id, which is made of the
content's digest and of its facts. So the same content resumes where it stopped, from any process,
and bytes that the server has are not sent again.
"""

from __future__ import annotations

import hashlib
import http.client
import json
import random
import time
from base64 import b64encode
from collections.abc import Callable, Mapping
from pathlib import Path
from urllib.parse import urlsplit

from bendtwin.connection.transport import Transport, tls_fault, transport
from bendtwin.errors import BendTwinError, Category, category_named
from bendtwin.labels import CaptureArguments, texts

#: Bytes of one request: what a dead server costs at most.
PART_BYTES = 16 * 1024 * 1024
#: Time without progress after which an upload is given up; the same call resumes it later.
PATIENCE_S = 120.0

#: Times that an upload may be gone after it was created.
MOST_GONE = 3

_UPLOADS = "/v1/uploads"
_CHUNK_BYTES = 256 * 1024
_SILENCE_S = 300.0
_FIRST_PAUSE_S, _LONGEST_PAUSE_S = 0.2, 10.0
_CATEGORIES = {
    404: Category.NOT_FOUND,
    409: Category.ABORTED,
    410: Category.NOT_FOUND,
    423: Category.ABORTED,
    429: Category.RESOURCE_EXHAUSTED,
    502: Category.UNAVAILABLE,
    503: Category.UNAVAILABLE,
    504: Category.UNAVAILABLE,
}
_PASSING_REASONS = ("CHECKSUM_MISMATCH", "UPLOAD_IDLE", "BODY_TOO_SLOW", "UPLOAD_BROKEN")


class Sender:
    """Sender of a file to a server."""

    def __init__(
        self,
        server: Transport | str,
        path: Path,
        facts: CaptureArguments,
        patience_s: float = PATIENCE_S,
        token: str | None = None,
    ) -> None:
        self._transport = transport(server, None) if isinstance(server, str) else server
        self._server = self._transport.url
        # Read once: each request has a new connection.
        self._context = self._transport.context() if self._transport.is_https else None
        self._path = path
        self._length = path.stat().st_size
        self._patience_s = patience_s
        self._headers = {"tus-resumable": "1.0.0"}
        if token is not None:
            self._headers["authorization"] = f"Bearer {token}"
        # Sorted: the server compares the metadata of a creation byte for byte.
        stated = dict(sorted(texts(facts).items()))
        pairs = {"filename": path.name, **stated}
        if "request_id" not in pairs:
            key = hashlib.sha256()
            with path.open("rb") as file:
                while chunk := file.read(_CHUNK_BYTES):
                    key.update(chunk)
            # The display name has no name before it: ids of uploads with a name alone stay.
            key.update(stated.get("display_name", "").encode())
            for name, text in stated.items():
                if name != "display_name":
                    key.update(f"\0{name}\0{text}".encode())
            pairs["request_id"] = f"tus-{key.hexdigest()[:32]}"
        self._metadata = ",".join(
            f"{key} {b64encode(value.encode()).decode()}" for key, value in pairs.items()
        )

    def send(self, on_progress: Callable[[int, int], None] | None = None) -> str:
        """Sends what is missing; returns the name of the capture that it became.

        `on_progress` gets the bytes that the server has, and the total.
        """
        url: str | None = None
        offset: int | None = None
        # Bytes that the server had at most, and the number of times that an upload was gone.
        most, gone = 0, 0
        ends, pause = time.monotonic() + self._patience_s, _FIRST_PAUSE_S
        while True:
            try:
                if url is None:
                    answer = self._ask("POST", f"{self._server}{_UPLOADS}", self._creation())
                    url = _address(self._server, answer.get("location", ""))
                elif offset is None:
                    answer = self._ask("HEAD", url, {})
                else:
                    answer = self._send_part(url, offset)
                reached = int(answer.get("upload-offset", 0))
                if on_progress is not None:
                    on_progress(reached, self._length)
                if "bendtwin-capture" in answer:
                    return answer["bendtwin-capture"]
                moved = reached != offset and reached < self._length
                offset = reached if reached < self._length else None
                if reached > most:
                    most = reached
                    ends, pause = time.monotonic() + self._patience_s, _FIRST_PAUSE_S
                if moved:
                    continue
                failure = BendTwinError(
                    Category.UNAVAILABLE,
                    "UPLOAD_STUCK",
                    "the server takes no more bytes and makes no capture: try again later",
                )
            except BendTwinError as error:
                if url is not None and error.category is Category.NOT_FOUND:
                    url, most, gone = None, 0, gone + 1  # It expired, or was terminated.
                    if gone > MOST_GONE:
                        raise _lost(self._server) from error
                elif not _is_worth_another_try(error):
                    raise
                offset, failure = None, error
            if time.monotonic() + pause > ends:
                raise failure
            # Clients that lost the same server should not all come back together.
            time.sleep(pause * random.uniform(0.5, 1.0))
            pause = min(2 * pause, _LONGEST_PAUSE_S)

    def _creation(self) -> dict[str, str]:
        return {"upload-length": str(self._length), "upload-metadata": self._metadata}

    def _send_part(self, url: str, offset: int) -> Mapping[str, str]:
        size = min(PART_BYTES, self._length - offset)
        with self._path.open("rb") as file:
            file.seek(offset)
            part = file.read(size)
        if len(part) != size:
            message = f"{self._path} has become shorter: upload it again"
            raise BendTwinError(Category.INVALID_ARGUMENT, "INVALID_ARGUMENT", message)
        checksum = b64encode(hashlib.sha256(part).digest()).decode()
        headers = {
            "content-type": "application/offset+octet-stream",
            "upload-offset": str(offset),
            "upload-checksum": f"sha256 {checksum}",
        }
        return self._ask("PATCH", url, headers, part)

    def _ask(
        self, method: str, url: str, headers: dict[str, str], body: bytes | None = None
    ) -> Mapping[str, str]:
        """The headers of the answer, in lower case."""
        parts = urlsplit(url)
        connection = self._connection(parts.netloc)
        try:
            connection.request(method, parts.path, body, {**self._headers, **headers})
            response = connection.getresponse()
            text = response.read()
        except (OSError, http.client.HTTPException) as error:
            fault = tls_fault(str(error))
            if fault is not None:
                raise BendTwinError(Category.FAILED_PRECONDITION, *fault) from error
            message = f"no BendTwin server answers at {self._server} ({error!r})"
            raise BendTwinError(Category.UNAVAILABLE, "SERVER_UNREACHABLE", message) from error
        finally:
            connection.close()
        if response.status < 300:
            return {key.lower(): value for key, value in response.getheaders()}
        raise refusal(response.status, text)

    def _connection(self, host: str) -> http.client.HTTPConnection:
        if self._context is None:
            return http.client.HTTPConnection(host, timeout=_SILENCE_S)
        return http.client.HTTPSConnection(host, timeout=_SILENCE_S, context=self._context)


def _address(server: str, location: str) -> str:
    """Address of an upload.

    A server behind a proxy does not know the path or the host by which it is reached, so only the
    upload's own name is taken from the `Location` that it gives.
    """
    _, found, name = urlsplit(location).path.rpartition(f"{_UPLOADS}/")
    if not found or not name or "/" in name:
        message = f"the server answered with `{location}`, which is no address of an upload"
        raise BendTwinError(Category.INTERNAL, "MALFORMED_REPLY", message)
    return f"{server}{_UPLOADS}/{name}"


def _lost(server: str) -> BendTwinError:
    return BendTwinError(
        Category.NOT_FOUND,
        "UPLOAD_LOST",
        f"the server at {server} creates the upload and then does not find it: let the proxy in "
        f"front of it pass on {server}{_UPLOADS} and all below, with HEAD and PATCH",
    )


def _is_worth_another_try(error: BendTwinError) -> bool:
    # Whoever hears of a take-over has a connection that lives: another process sends the same, and
    # two would take it from each other for ever.
    passing = error.category.is_transient or error.reason in _PASSING_REASONS
    return passing and error.reason != "UPLOAD_TAKEN_OVER"


def refusal(status: int, body: bytes) -> BendTwinError:
    """Message of a problem document; an answer to HEAD has none, nor has a proxy's page."""
    try:
        problem = json.loads(body)
        return BendTwinError(
            category_named(problem["title"]),
            problem["reason"],
            problem["detail"],
            problem.get("request_id"),
        )
    except (ValueError, KeyError, TypeError):
        unknown = Category.INVALID_ARGUMENT if status < 500 else Category.INTERNAL
        category = _CATEGORIES.get(status, unknown)
        return BendTwinError(category, "HTTP_ERROR", f"the server answered HTTP {status}")
