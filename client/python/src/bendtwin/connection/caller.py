"""Ways to make the calls of `bendtwin.calls`: one that blocks, and one to be awaited.

All that differs between the two clients is here; what they send and read is in `calls`.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractContextManager, asynccontextmanager, contextmanager
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

import grpc
import grpc.aio

from bendtwin import calls
from bendtwin.captures.archive import archive_of
from bendtwin.connection.token import aio_interceptors, with_token
from bendtwin.connection.transport import Transport
from bendtwin.errors import BendTwinError, translated

_Read = TypeVar("_Read")
_Packer = Callable[[Path], AbstractContextManager[Path]]


class Caller:
    """Calls that return when they are answered."""

    def __init__(
        self, server: Transport, token: str | None, timeout_s: float | None = None
    ) -> None:
        #: Deadline of calls that get none themselves.
        self._timeout_s = timeout_s
        target, options = server.target, calls.CHANNEL_OPTIONS
        if server.is_https:
            self._channel = grpc.secure_channel(target, server.credentials(), options=options)
        else:
            self._channel = grpc.insecure_channel(target, options=options)
        self._services = calls.Services(with_token(self._channel, token))

    def close(self) -> None:
        """Closes the connection."""
        self._channel.close()

    def run(self, call: calls.Call[_Read], timeout_s: float | None = None) -> _Read:
        """The answer to a call."""
        deadline_s = self._timeout_s if timeout_s is None else timeout_s
        with translated():
            reply = call.method(self._services)(call.request, timeout=deadline_s)
        return call.read(reply)

    def parts(self, call: calls.Call[_Read], timeout_s: float | None = None) -> Iterator[_Read]:
        """The answer to a call, in parts."""
        with translated():
            for part in call.method(self._services)(call.request, timeout=timeout_s):
                yield call.read(part)

    def last(self, call: calls.Call[_Read], timeout_s: float | None = None) -> _Read | None:
        """The last part of an answer; None for an empty answer."""
        last: _Read | None = None
        for part in self.parts(call, timeout_s):
            last = part
        return last

    def content(self, call: calls.Call[bytes]) -> bytes:
        """An answer that comes in chunks, as one."""
        chunks = self.parts(call)
        return b"".join(chunks)

    def exchange(self, call: calls.Call[_Read]) -> Iterator[_Read]:
        """The answers to messages of an iterator, each of which is taken when the answer to the one
        before has been."""
        turn, has_ended, faults = threading.Semaphore(), threading.Event(), list[Exception]()

        def requests() -> Iterator[Any]:
            iterator = iter(call.request)
            # gRPC reads ahead, on a separate thread.
            while turn.acquire() and not has_ended.is_set():
                try:
                    yield next(iterator)
                except StopIteration:
                    return
                except Exception as fault:
                    faults.append(fault)
                    return

        stream = call.method(self._services)(requests())
        try:
            with translated():
                for reply in stream:
                    yield call.read(reply)
                    turn.release()
        finally:
            has_ended.set()
            turn.release()
            stream.cancel()
        if faults:
            raise faults[0]

    def save(self, call: calls.Call[bytes], path: str | PathLike[str]) -> None:
        """Writes an answer that comes in chunks to a file."""
        with open(path, "wb") as file:
            for chunk in self.parts(call):
                file.write(chunk)

    def pages(self, pages: calls.Pages[_Read]) -> Iterator[_Read]:
        """The items of a list."""
        request = pages.request
        while True:
            with translated():
                page = pages.method(self._services)(request)
            yield from pages.read(page)
            if not page.next_page_token:
                return
            request.page_token = page.next_page_token

    def follow(self, watched: calls.Watched[_Read], timeout_s: float | None) -> Iterator[_Read]:
        """The states of a resource until its last, over restarts of the server."""
        following = calls.Following(watched, timeout_s)
        method = watched.method(self._services)
        while True:
            try:
                with translated():
                    for message in method(following.request, timeout=following.left_s):
                        yield following.take(message)
                        if following.has_ended:
                            return
            except BendTwinError as error:
                if not following.survives(error):
                    raise
            time.sleep(calls.RECONNECT_S)

    def blocking(self, work: Callable[[], _Read]) -> _Read:
        """The result of a function that waits."""
        return work()

    @contextmanager
    def packed(self, path: Path, pack: _Packer = archive_of) -> Iterator[Path]:
        """A folder as one file: see `archive_of` and `masks_of`."""
        with pack(path) as archive:
            yield archive


class AsyncCaller:
    """The same calls, to be awaited."""

    def __init__(
        self, server: Transport, token: str | None, timeout_s: float | None = None
    ) -> None:
        #: Deadline of calls that get none themselves.
        self._timeout_s = timeout_s
        target, options = server.target, calls.CHANNEL_OPTIONS
        shown = aio_interceptors(token)
        if server.is_https:
            self._channel = grpc.aio.secure_channel(
                target, server.credentials(), options=options, interceptors=shown
            )
        else:
            self._channel = grpc.aio.insecure_channel(target, options=options, interceptors=shown)
        self._services = calls.Services(self._channel)

    async def close(self) -> None:
        """Closes the connection."""
        await self._channel.close()

    async def run(self, call: calls.Call[_Read], timeout_s: float | None = None) -> _Read:
        """The answer to a call."""
        deadline_s = self._timeout_s if timeout_s is None else timeout_s
        with translated():
            reply = await call.method(self._services)(call.request, timeout=deadline_s)
        return call.read(reply)

    async def parts(
        self, call: calls.Call[_Read], timeout_s: float | None = None
    ) -> AsyncIterator[_Read]:
        """The answer to a call, in parts."""
        with translated():
            async for part in call.method(self._services)(call.request, timeout=timeout_s):
                yield call.read(part)

    async def last(self, call: calls.Call[_Read], timeout_s: float | None = None) -> _Read | None:
        """The last part of an answer; None for an empty answer."""
        last: _Read | None = None
        async for part in self.parts(call, timeout_s):
            last = part
        return last

    async def content(self, call: calls.Call[bytes]) -> bytes:
        """An answer that comes in chunks, as one."""
        return b"".join([chunk async for chunk in self.parts(call)])

    async def exchange(self, call: calls.Call[_Read]) -> AsyncIterator[_Read]:
        """The answers to messages of an iterator, each of which is taken when the answer to the one
        before has been."""
        turn, faults = asyncio.Semaphore(), list[Exception]()

        async def requests() -> AsyncIterator[Any]:
            iterator = aiter(call.request)
            while await turn.acquire():
                try:
                    yield await anext(iterator)
                except StopAsyncIteration:
                    return
                except Exception as fault:
                    faults.append(fault)
                    return

        stream = call.method(self._services)(requests())
        try:
            with translated():
                async for reply in stream:
                    yield call.read(reply)
                    turn.release()
        finally:
            stream.cancel()
        if faults:
            raise faults[0]

    async def save(self, call: calls.Call[bytes], path: str | PathLike[str]) -> None:
        """Writes an answer that comes in chunks to a file."""
        with open(path, "wb") as file:
            async for chunk in self.parts(call):
                file.write(chunk)

    async def pages(self, pages: calls.Pages[_Read]) -> AsyncIterator[_Read]:
        """The items of a list."""
        request = pages.request
        while True:
            with translated():
                page = await pages.method(self._services)(request)
            for item in pages.read(page):
                yield item
            if not page.next_page_token:
                return
            request.page_token = page.next_page_token

    async def follow(
        self, watched: calls.Watched[_Read], timeout_s: float | None
    ) -> AsyncIterator[_Read]:
        """The states of a resource until its last, over restarts of the server."""
        following = calls.Following(watched, timeout_s)
        method = watched.method(self._services)
        while True:
            try:
                with translated():
                    async for message in method(following.request, timeout=following.left_s):
                        yield following.take(message)
                        if following.has_ended:
                            return
            except BendTwinError as error:
                if not following.survives(error):
                    raise
            await asyncio.sleep(calls.RECONNECT_S)

    async def blocking(self, work: Callable[[], _Read]) -> _Read:
        """The result of a function that waits, in a thread."""
        return await asyncio.to_thread(work)

    @asynccontextmanager
    async def packed(self, path: Path, pack: _Packer = archive_of) -> AsyncIterator[Path]:
        """A folder as one file, packed in a thread: see `archive_of` and `masks_of`."""
        packed = pack(path)
        archive = await asyncio.to_thread(packed.__enter__)
        try:
            yield archive
        finally:
            packed.__exit__(None, None, None)
