"""Ways to make the calls of `bendtwin.calls`: one that blocks, and one to be awaited.

All that differs between the two clients is here; what they send and read is in `calls`.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Iterator
from os import PathLike
from typing import TypeVar

from bendtwin import calls
from bendtwin.errors import BendTwinError, translated

_Read = TypeVar("_Read")


class Caller:
    """Calls that return when they are answered."""

    def __init__(self, services: calls.Services) -> None:
        self._services = services

    def run(self, call: calls.Call[_Read], timeout_s: float | None = None) -> _Read:
        """The answer to a call."""
        with translated():
            reply = call.method(self._services)(call.request, timeout=timeout_s)
        return call.read(reply)

    def parts(self, call: calls.Call[_Read], timeout_s: float | None = None) -> Iterator[_Read]:
        """The answer to a call, in parts."""
        with translated():
            for part in call.method(self._services)(call.request, timeout=timeout_s):
                yield call.read(part)

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


class AsyncCaller:
    """The same calls, to be awaited."""

    def __init__(self, services: calls.Services) -> None:
        self._services = services

    async def run(self, call: calls.Call[_Read], timeout_s: float | None = None) -> _Read:
        """The answer to a call."""
        with translated():
            reply = await call.method(self._services)(call.request, timeout=timeout_s)
        return call.read(reply)

    async def parts(
        self, call: calls.Call[_Read], timeout_s: float | None = None
    ) -> AsyncIterator[_Read]:
        """The answer to a call, in parts."""
        with translated():
            async for part in call.method(self._services)(call.request, timeout=timeout_s):
                yield call.read(part)

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
