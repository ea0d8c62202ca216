"""The token or key that is shown to a server.

It is in the environment, in a file that is named there, in the file of a sign-in (`bendtwin
login`), or, for servers of the same user on the same machine, in a file that the server leaves by
its port.
"""

from __future__ import annotations

import ipaddress
import os
import re
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

import grpc
import grpc.aio


def find_token(target: str, is_https: bool = False) -> str | None:
    """The token or key for `host:port`: of BENDTWIN_TOKEN, in the file that BENDTWIN_TOKEN_FILE
    names, of a sign-in, or as a server on this machine left it."""
    given = os.environ.get("BENDTWIN_TOKEN")
    if given:
        return given
    file = os.environ.get("BENDTWIN_TOKEN_FILE")
    if file:
        return read_token(file)
    try:
        parts = urlsplit(f"//{target}")
        host, port = parts.hostname, parts.port
    except ValueError:
        return None
    if host is None:
        return None
    signed_in = _sign_in(host, port or (443 if is_https else 80), is_https)
    if signed_in is not None:
        return signed_in
    if not _is_loopback(host):
        return None
    try:
        path = _state() / "bendtwin" / "tokens" / str(port or 80)
        return path.read_text().strip() or None
    except (OSError, RuntimeError, ValueError):
        return None


def shown_token(
    target: str,
    token: str | None,
    token_file: str | PathLike[str] | None,
    is_https: bool = False,
) -> str | None:
    """The token or key that a client shows.

    That is the one that it was given, else the one in the file that it was given, else the one that
    is found.
    """
    if token is not None:
        return token
    return find_token(target, is_https) if token_file is None else read_token(token_file)


def read_token(path: str | PathLike[str]) -> str:
    """The token or key in a file, which other users of the machine must not be able to read."""
    with open(path, encoding="utf-8") as file:
        mode = os.fstat(file.fileno()).st_mode & 0o777
        if os.name == "posix" and mode & 0o077:
            raise PermissionError(
                f"other users can use {path}, which has a token or key (mode {mode:03o}): "
                f"`chmod 600 {path}`, and have another key made if they may have read this one"
            )
        token = file.read().strip()
    if not token:
        raise ValueError(f"{path}: there is no token or key in it")
    return token


def with_token(channel: grpc.Channel, token: str | None) -> grpc.Channel:
    """A channel that shows the token with every call."""
    return channel if token is None else grpc.intercept_channel(channel, _Credentials(token))


def _sign_in(host: str, port: int, is_https: bool) -> str | None:
    """The key with which this user signed in at a server, as `bendtwin login` keeps it."""
    scheme = "https" if is_https else "http"
    name = f"{scheme}_{re.sub(r'[^a-z0-9.-]', '_', host.lower())}_{port}"
    try:
        path = _state() / "bendtwin" / "sign-ins" / name
        return read_token(path) if path.exists() else None
    except RuntimeError:
        return None


def _state() -> Path:
    given = os.environ.get("XDG_STATE_HOME", "")
    return Path(given) if os.path.isabs(given) else Path.home() / ".local" / "state"


def _is_loopback(host: str) -> bool:
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class _Details(NamedTuple):
    method: str
    timeout: float | None
    metadata: list[tuple[str, str]]
    credentials: grpc.CallCredentials | None
    wait_for_ready: bool | None
    compression: grpc.Compression | None


class _CallDetails(_Details, grpc.ClientCallDetails):  # type: ignore[misc]
    pass


class _Credentials(
    grpc.UnaryUnaryClientInterceptor,  # type: ignore[misc]
    grpc.UnaryStreamClientInterceptor,  # type: ignore[misc]
    grpc.StreamUnaryClientInterceptor,  # type: ignore[misc]
    grpc.StreamStreamClientInterceptor,  # type: ignore[misc]
):
    def __init__(self, token: str) -> None:
        self._header = ("authorization", f"Bearer {token}")

    def _with_header(self, details: Any) -> _CallDetails:
        return _CallDetails(
            details.method,
            details.timeout,
            [*(details.metadata or ()), self._header],
            details.credentials,
            getattr(details, "wait_for_ready", None),
            getattr(details, "compression", None),
        )

    def intercept_unary_unary(
        self, continuation: Callable[..., Any], client_call_details: Any, request: Any
    ) -> Any:
        return continuation(self._with_header(client_call_details), request)

    def intercept_unary_stream(
        self, continuation: Callable[..., Any], client_call_details: Any, request: Any
    ) -> Any:
        return continuation(self._with_header(client_call_details), request)

    def intercept_stream_unary(
        self, continuation: Callable[..., Any], client_call_details: Any, request_iterator: Any
    ) -> Any:
        return continuation(self._with_header(client_call_details), request_iterator)

    def intercept_stream_stream(
        self, continuation: Callable[..., Any], client_call_details: Any, request_iterator: Any
    ) -> Any:
        return continuation(self._with_header(client_call_details), request_iterator)


def aio_interceptors(token: str | None) -> list[Any]:
    """Interceptors that show the token with every call of an asyncio channel."""
    kinds = (_AioUnaryUnary, _AioUnaryStream, _AioStreamUnary, _AioStreamStream)
    return [] if token is None else [kind(token) for kind in kinds]


class _AioCredentials:
    # One class for each kind of call: a channel uses an interceptor for the first kind it has.
    def __init__(self, token: str) -> None:
        self._header = ("authorization", f"Bearer {token}")

    def _with_header(self, details: Any) -> Any:
        metadata = grpc.aio.Metadata(*(details.metadata or ()))
        metadata.add(*self._header)
        return details._replace(metadata=metadata)


class _AioUnaryUnary(_AioCredentials, grpc.aio.UnaryUnaryClientInterceptor):  # type: ignore[misc]
    async def intercept_unary_unary(
        self, continuation: Callable[..., Any], client_call_details: Any, request: Any
    ) -> Any:
        return await continuation(self._with_header(client_call_details), request)


class _AioUnaryStream(_AioCredentials, grpc.aio.UnaryStreamClientInterceptor):  # type: ignore[misc]
    async def intercept_unary_stream(
        self, continuation: Callable[..., Any], client_call_details: Any, request: Any
    ) -> Any:
        return await continuation(self._with_header(client_call_details), request)


class _AioStreamUnary(_AioCredentials, grpc.aio.StreamUnaryClientInterceptor):  # type: ignore[misc]
    async def intercept_stream_unary(
        self, continuation: Callable[..., Any], client_call_details: Any, request_iterator: Any
    ) -> Any:
        return await continuation(self._with_header(client_call_details), request_iterator)


class _AioStreamStream(_AioCredentials, grpc.aio.StreamStreamClientInterceptor):  # type: ignore[misc]
    async def intercept_stream_stream(
        self, continuation: Callable[..., Any], client_call_details: Any, request_iterator: Any
    ) -> Any:
        return await continuation(self._with_header(client_call_details), request_iterator)
