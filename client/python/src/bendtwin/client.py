"""The connection to a server."""

from __future__ import annotations

import json
import time
import uuid
from collections.abc import Callable, Iterator
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

import grpc

from bendtwin.archive import archive_of, chunks_of
from bendtwin.errors import BendTwinError, Category, FitFailed, IngestFailed, translated
from bendtwin.resources import Capture, Fit, JobState, TwinInfo, Worker
from bendtwin.token import find_token, with_token
from bendtwin.twin import Twin
from bendtwin.uploads import Sender
from bendtwin.v1 import (
    capture_pb2,
    capture_pb2_grpc,
    fit_pb2,
    fit_pb2_grpc,
    rollout_pb2_grpc,
    twin_pb2,
    twin_pb2_grpc,
    worker_pb2,
    worker_pb2_grpc,
)

_CHANNEL_OPTIONS = [
    # Trajectories of large batches are larger than gRPC's default of 4 MiB.
    ("grpc.max_receive_message_length", -1),
    ("grpc.max_send_message_length", -1),
]
_RECONNECT_S = 0.2

_Message = TypeVar("_Message")
_Watched = TypeVar("_Watched")


class Client:
    """A BendTwin server, `host:port`. Thread-safe; close it or use it in a `with` statement.

    Without `token` it is that of `BENDTWIN_TOKEN`, or the one that a server of the same user on the
    same machine left.
    """

    def __init__(self, address: str = "127.0.0.1:7070", *, token: str | None = None) -> None:
        target = address.removeprefix("http://").rstrip("/")
        self._address = target
        self._token = find_token(target) if token is None else token
        self._channel = grpc.insecure_channel(target, options=_CHANNEL_OPTIONS)
        channel = with_token(self._channel, self._token)
        self._captures = capture_pb2_grpc.CaptureServiceStub(channel)
        self._fits = fit_pb2_grpc.FitServiceStub(channel)
        self._twins = twin_pb2_grpc.TwinServiceStub(channel)
        self._workers = worker_pb2_grpc.WorkerServiceStub(channel)
        self._rollouts = rollout_pb2_grpc.RolloutServiceStub(channel)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the connection."""
        self._channel.close()

    # Captures

    def upload_capture(
        self,
        path: str | PathLike[str],
        *,
        display_name: str | None = None,
        request_id: str | None = None,
        ingest: dict[str, Any] | None = None,
    ) -> Capture:
        """Uploads a capture: a ZIP archive, or a folder that is packed first.

        `ingest` says what differs from the default settings of reading it (docs/settings.md).
        The same content under the same `request_id` answers with the capture that exists.
        """
        path = Path(path)
        metadata = capture_pb2.CaptureMetadata(
            display_name=path.stem if display_name is None else display_name,
            request_id=request_id or str(uuid.uuid4()),
            ingest_settings_json=json.dumps(ingest) if ingest else "",
        )

        def messages(archive: Path) -> Iterator[capture_pb2.CreateCaptureRequest]:
            yield capture_pb2.CreateCaptureRequest(metadata=metadata)
            for chunk in chunks_of(archive):
                yield capture_pb2.CreateCaptureRequest(chunk=chunk)

        with archive_of(path) as archive, translated():
            reply = self._captures.CreateCapture(messages(archive))
        return Capture.from_proto(reply.capture)

    def push_capture(
        self,
        path: str | PathLike[str],
        *,
        display_name: str | None = None,
        request_id: str | None = None,
        on_progress: Callable[[int, int], None] | None = None,
    ) -> Capture:
        """Uploads a capture resumably (tus 1.0.0): a ZIP archive, or a folder that is packed first.

        Goes on over broken connections and restarts of the server, and, called again, over
        restarts of its own process. The same content under the same name is one capture and is not
        sent twice. `on_progress` is told the bytes that the server has, and how many there are.
        """
        path = Path(path)
        if display_name is None:
            display_name = path.resolve().name if path.is_dir() else path.stem
        with archive_of(path) as archive:
            sender = Sender(self._address, archive, display_name, request_id, token=self._token)
            name = sender.send(on_progress)
        return self.capture(name)

    def capture(self, name: str) -> Capture:
        """One capture."""
        with translated():
            request = capture_pb2.GetCaptureRequest(name=name)
            return Capture.from_proto(self._captures.GetCapture(request))

    def captures(self) -> Iterator[Capture]:
        """All captures, newest first."""
        pages = _pages(self._captures.ListCaptures, capture_pb2.ListCapturesRequest())
        return (Capture.from_proto(c) for page in pages for c in page.captures)

    def delete_capture(self, name: str) -> None:
        """Deletes a capture; its twins stay."""
        with translated():
            self._captures.DeleteCapture(capture_pb2.DeleteCaptureRequest(name=name))

    # Reading captures

    def ingest_capture(
        self,
        name: str,
        settings: dict[str, Any] | None = None,
        *,
        request_id: str | None = None,
    ) -> Capture:
        """Has a capture read again, with other settings say (docs/settings.md)."""
        request = capture_pb2.IngestCaptureRequest(
            name=name,
            settings_json=json.dumps(settings) if settings else "",
            request_id=request_id or str(uuid.uuid4()),
        )
        with translated():
            return Capture.from_proto(self._captures.IngestCapture(request))

    def cancel_ingest(self, name: str) -> Capture:
        """Asks the ingest of a capture to stop; one that has ended is left as it is."""
        with translated():
            request = capture_pb2.CancelIngestRequest(name=name)
            return Capture.from_proto(self._captures.CancelIngest(request))

    def watch_capture(self, name: str, *, timeout_s: float | None = None) -> Iterator[Capture]:
        """The capture now and after every change of its ingest, until that has ended.

        Goes on over restarts of the server. Raises BendTwinError (DEADLINE_EXCEEDED) after
        `timeout_s`.
        """

        def changes(revision: int, left: float | None) -> Iterator[Capture]:
            request = capture_pb2.WatchIngestRequest(name=name, after_revision=revision)
            for message in self._captures.WatchIngest(request, timeout=left):
                yield Capture.from_proto(message)

        def standing(capture: Capture) -> tuple[int, bool]:
            ingest = capture.ingest
            return (0, True) if ingest is None else (ingest.revision, ingest.state.has_ended)

        return _watched(changes, standing, timeout_s)

    def wait_for_capture(
        self,
        capture: Capture | str,
        *,
        timeout_s: float | None = None,
        on_progress: Callable[[Capture], None] | None = None,
    ) -> Capture:
        """Waits until a capture has been read. Raises IngestFailed if it cannot be fitted."""
        name = capture if isinstance(capture, str) else capture.name
        last: Capture | None = None
        for last in self.watch_capture(name, timeout_s=timeout_s):
            if on_progress is not None:
                on_progress(last)
        ended = last if last is not None else self.capture(name)
        if ended.ingest is not None and ended.ingest.state is not JobState.SUCCEEDED:
            raise IngestFailed(ended)
        return ended

    def capture_report(self, name: str) -> dict[str, Any]:
        """Report on a capture: verdict, findings and what they rest on."""
        request = capture_pb2.GetCaptureReportRequest(name=name)
        with translated():
            parts = [part.chunk for part in self._captures.GetCaptureReport(request)]
        report: dict[str, Any] = json.loads(b"".join(parts))
        return report

    def save_capture_report(self, name: str, path: str | PathLike[str]) -> None:
        """Writes the report of a capture as a page with pictures, to be opened in a browser."""
        html = capture_pb2.GetCaptureReportRequest.HTML
        request = capture_pb2.GetCaptureReportRequest(name=name, format=html)
        with translated(), open(path, "wb") as file:
            for part in self._captures.GetCaptureReport(request):
                file.write(part.chunk)

    def export_observation(self, name: str, path: str | PathLike[str]) -> None:
        """Writes what fits of a capture work on, tracked points as a bundle (ZIP)."""
        request = capture_pb2.ExportObservationRequest(name=name)
        with translated(), open(path, "wb") as file:
            for part in self._captures.ExportObservation(request):
                file.write(part.chunk)

    # Fits

    def fit(
        self,
        capture: str,
        settings: dict[str, Any] | None = None,
        *,
        priority: int = 0,
        request_id: str | None = None,
    ) -> Fit:
        """Starts a fit of a capture. `settings` are those of docs/settings.md."""
        request = fit_pb2.CreateFitRequest(
            capture=capture,
            settings_json=json.dumps(settings) if settings else "",
            priority=priority,
            request_id=request_id or str(uuid.uuid4()),
        )
        with translated():
            return Fit.from_proto(self._fits.CreateFit(request))

    def get_fit(self, name: str) -> Fit:
        """One fit as it stands."""
        with translated():
            return Fit.from_proto(self._fits.GetFit(fit_pb2.GetFitRequest(name=name)))

    def fits(self, capture: str = "") -> Iterator[Fit]:
        """All fits, or those of one capture, newest first."""
        pages = _pages(self._fits.ListFits, fit_pb2.ListFitsRequest(capture=capture))
        return (Fit.from_proto(f) for page in pages for f in page.fits)

    def cancel_fit(self, name: str) -> Fit:
        """Asks a fit to stop; one that has ended is returned as it is."""
        with translated():
            return Fit.from_proto(self._fits.CancelFit(fit_pb2.CancelFitRequest(name=name)))

    def delete_fit(self, name: str) -> None:
        """Deletes a fit that has ended; its twin stays."""
        with translated():
            self._fits.DeleteFit(fit_pb2.DeleteFitRequest(name=name))

    def watch(self, name: str, *, timeout_s: float | None = None) -> Iterator[Fit]:
        """The fit now and after every change, until it has ended.

        Goes on over restarts of the server. Raises BendTwinError (DEADLINE_EXCEEDED) after
        `timeout_s`.
        """

        def changes(revision: int, left: float | None) -> Iterator[Fit]:
            request = fit_pb2.WatchFitRequest(name=name, after_revision=revision)
            for message in self._fits.WatchFit(request, timeout=left):
                yield Fit.from_proto(message)

        return _watched(changes, lambda fit: (fit.job.revision, fit.state.has_ended), timeout_s)

    def wait(
        self,
        fit: Fit | str,
        *,
        timeout_s: float | None = None,
        on_progress: Callable[[Fit], None] | None = None,
    ) -> Fit:
        """Waits for a fit to succeed. Raises FitFailed if it ends without a twin."""
        name = fit if isinstance(fit, str) else fit.name
        last: Fit | None = None
        for last in self.watch(name, timeout_s=timeout_s):
            if on_progress is not None:
                on_progress(last)
        ended = last if last is not None else self.get_fit(name)
        if ended.state is not JobState.SUCCEEDED:
            raise FitFailed(ended)
        return ended

    # Twins

    def twin(self, name: str) -> Twin:
        """A twin, ready for rollouts."""
        with translated():
            info = TwinInfo.from_proto(self._twins.GetTwin(twin_pb2.GetTwinRequest(name=name)))
        return Twin(info, self._rollouts, self._twins)

    def twins(self, capture: str = "") -> Iterator[Twin]:
        """All twins, or those of one capture, newest first."""
        pages = _pages(self._twins.ListTwins, twin_pb2.ListTwinsRequest(capture=capture))
        infos = (TwinInfo.from_proto(t) for page in pages for t in page.twins)
        return (Twin(info, self._rollouts, self._twins) for info in infos)

    def export_twin(self, name: str, path: str | PathLike[str]) -> None:
        """Writes a twin's file (safetensors, docs/twin-format.md)."""
        with translated(), open(path, "wb") as file:
            for part in self._twins.ExportTwin(twin_pb2.ExportTwinRequest(name=name)):
                file.write(part.chunk)

    def import_twin(
        self,
        path: str | PathLike[str],
        *,
        display_name: str | None = None,
        request_id: str | None = None,
    ) -> Twin:
        """Stores a twin file that was exported elsewhere."""
        path = Path(path)
        metadata = twin_pb2.TwinMetadata(
            display_name=path.stem if display_name is None else display_name,
            request_id=request_id or str(uuid.uuid4()),
        )

        def messages() -> Iterator[twin_pb2.CreateTwinRequest]:
            yield twin_pb2.CreateTwinRequest(metadata=metadata)
            for chunk in chunks_of(path):
                yield twin_pb2.CreateTwinRequest(chunk=chunk)

        with translated():
            info = TwinInfo.from_proto(self._twins.CreateTwin(messages()))
        return Twin(info, self._rollouts, self._twins)

    def delete_twin(self, name: str) -> None:
        """Deletes a twin."""
        with translated():
            self._twins.DeleteTwin(twin_pb2.DeleteTwinRequest(name=name))

    # Workers

    def workers(self) -> Iterator[Worker]:
        """The workers that the server knows."""
        pages = _pages(self._workers.ListWorkers, worker_pb2.ListWorkersRequest())
        return (Worker.from_proto(w) for page in pages for w in page.workers)


def _watched(
    changes: Callable[[int, float | None], Iterator[_Watched]],
    standing: Callable[[_Watched], tuple[int, bool]],
    timeout_s: float | None,
) -> Iterator[_Watched]:
    """Follows changes until one is the last, over restarts of the server.

    `changes` are those after a revision; `standing` tells a state's revision, and whether it is the
    last.
    """
    deadline = None if timeout_s is None else time.monotonic() + timeout_s
    revision = 0
    while True:
        left = None if deadline is None else max(0.0, deadline - time.monotonic())
        try:
            with translated():
                for state in changes(revision, left):
                    revision, ended = standing(state)
                    yield state
                    if ended:
                        return
        except BendTwinError as error:
            if error.category is not Category.UNAVAILABLE:
                raise
        time.sleep(_RECONNECT_S)


def _pages(call: Callable[[Any], Any], request: Any) -> Iterator[Any]:
    while True:
        with translated():
            page = call(request)
        yield page
        if not page.next_page_token:
            return
        request.page_token = page.next_page_token
