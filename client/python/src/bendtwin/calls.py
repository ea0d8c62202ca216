"""Calls of a server as values: what is sent, and how the reply is read.

The synchronous client and that of asyncio make the same calls; how they wait is their own.
"""

from __future__ import annotations

import json
import time
import uuid
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Generic, TypeVar

from bendtwin.captures.archive import chunks_of
from bendtwin.errors import BendTwinError, Category
from bendtwin.geometry import Geometry
from bendtwin.labels import (
    CaptureArguments,
    CaptureLabelArguments,
    CaptureListArguments,
    LabelArguments,
    ListArguments,
    beside,
    fields,
    metadata,
)
from bendtwin.resources import (
    Capture,
    Fit,
    FitPreview,
    JobState,
    LossCurve,
    Requirements,
    Trashed,
    TwinInfo,
    Worker,
)
from bendtwin.simulation.plan import PlanUpdate
from bendtwin.simulation.rollout import RolloutResult, warned
from bendtwin.surface import Surface
from bendtwin.v1 import (
    capture_pb2,
    capture_pb2_grpc,
    evaluation_pb2,
    evaluation_pb2_grpc,
    fit_pb2,
    fit_pb2_grpc,
    key_pb2_grpc,
    planning_pb2,
    planning_pb2_grpc,
    project_pb2_grpc,
    registration_pb2_grpc,
    rollout_pb2,
    rollout_pb2_grpc,
    session_pb2_grpc,
    trash_pb2,
    trash_pb2_grpc,
    twin_pb2,
    twin_pb2_grpc,
    usage_pb2_grpc,
    worker_pb2,
    worker_pb2_grpc,
)

CHANNEL_OPTIONS = [
    # Trajectories of large batches are larger than gRPC's default of 4 MiB.
    ("grpc.max_receive_message_length", -1),
    ("grpc.max_send_message_length", -1),
]
#: Time before another try where a server restarts.
RECONNECT_S = 0.2

_Read = TypeVar("_Read")
_Settings = dict[str, Any] | None


class Services:
    """The services of a server, over a channel of either kind."""

    def __init__(self, channel: Any) -> None:
        self.captures = capture_pb2_grpc.CaptureServiceStub(channel)
        self.fits = fit_pb2_grpc.FitServiceStub(channel)
        self.twins = twin_pb2_grpc.TwinServiceStub(channel)
        self.usage = usage_pb2_grpc.UsageServiceStub(channel)
        self.workers = worker_pb2_grpc.WorkerServiceStub(channel)
        self.projects = project_pb2_grpc.ProjectServiceStub(channel)
        self.rollouts = rollout_pb2_grpc.RolloutServiceStub(channel)
        self.registrations = registration_pb2_grpc.RegistrationServiceStub(channel)
        self.evaluations = evaluation_pb2_grpc.EvaluationServiceStub(channel)
        self.sessions = session_pb2_grpc.SessionServiceStub(channel)
        self.shares = key_pb2_grpc.ShareServiceStub(channel)
        self.trash = trash_pb2_grpc.TrashServiceStub(channel)
        self.planning = planning_pb2_grpc.PlanningServiceStub(channel)


@dataclass(frozen=True)
class Call(Generic[_Read]):
    """A call. `request` is a message, or an iterator of messages for an upload."""

    method: Callable[[Services], Any]
    request: Any
    read: Callable[[Any], _Read]


@dataclass(frozen=True)
class Pages(Generic[_Read]):
    """A list that comes in pages; `read` makes items of a page."""

    method: Callable[[Services], Any]
    request: Any
    read: Callable[[Any], list[_Read]]


@dataclass(frozen=True)
class Watched(Generic[_Read]):
    """A resource to follow: `request` asks for changes after a revision, `standing` tells the
    revision of a state, and whether it is the last."""

    method: Callable[[Services], Any]
    request: Callable[[int], Any]
    read: Callable[[Any], _Read]
    standing: Callable[[_Read], tuple[int, bool]]


class Following(Generic[_Read]):
    """State of following a resource, over restarts of the server."""

    def __init__(self, watched: Watched[_Read], timeout_s: float | None) -> None:
        self._watched = watched
        self._deadline = None if timeout_s is None else time.monotonic() + timeout_s
        self._revision = 0
        self.has_ended: bool = False

    @property
    def request(self) -> Any:
        """The message that asks for the changes that were not seen."""
        return self._watched.request(self._revision)

    @property
    def left_s(self) -> float | None:
        """Time left for it."""
        return None if self._deadline is None else max(0.0, self._deadline - time.monotonic())

    def take(self, message: Any) -> _Read:
        """Reads a change."""
        state = self._watched.read(message)
        self._revision, self.has_ended = self._watched.standing(state)
        return state

    @staticmethod
    def survives(error: BendTwinError) -> bool:
        """True if following continues after the error."""
        return error.category is Category.UNAVAILABLE


# Captures


def create_capture(archive: Path, facts: CaptureArguments) -> Call[Capture]:
    """Uploads a ZIP archive."""
    stated = capture_pb2.CaptureMetadata(**metadata(facts))
    stated.request_id = stated.request_id or str(uuid.uuid4())

    def messages() -> Iterator[capture_pb2.CreateCaptureRequest]:
        yield capture_pb2.CreateCaptureRequest(metadata=stated)
        for chunk in chunks_of(archive):
            yield capture_pb2.CreateCaptureRequest(chunk=chunk)

    return Call(
        lambda s: s.captures.CreateCapture,
        messages(),
        lambda reply: Capture.from_proto(reply.capture),
    )


def get_capture(name: str) -> Call[Capture]:
    """A capture."""
    request = capture_pb2.GetCaptureRequest(name=name)
    return Call(lambda s: s.captures.GetCapture, request, Capture.from_proto)


def list_captures(choice: CaptureListArguments) -> Pages[Capture]:
    """Captures."""
    request = capture_pb2.ListCapturesRequest(**choice)
    return Pages(
        lambda s: s.captures.ListCaptures,
        request,
        lambda page: [Capture.from_proto(c) for c in page.captures],
    )


def update_capture(name: str, change: CaptureLabelArguments) -> Call[Capture]:
    """Changes what is stated about a capture."""
    capture = capture_pb2.Capture(name=name, **fields(change))
    request = capture_pb2.UpdateCaptureRequest(capture=capture, **beside(change))
    return Call(lambda s: s.captures.UpdateCapture, request, Capture.from_proto)


def delete_capture(name: str, purge: bool) -> Call[None]:
    """Deletes a capture."""
    request = capture_pb2.DeleteCaptureRequest(name=name, purge=purge)
    return Call(lambda s: s.captures.DeleteCapture, request, _nothing)


def ingest_capture(
    name: str, settings: _Settings, request_id: str | None, requirements: Requirements | None
) -> Call[Capture]:
    """Has a capture read again."""
    request = capture_pb2.IngestCaptureRequest(
        name=name,
        settings_json=_json(settings),
        request_id=request_id or str(uuid.uuid4()),
        requirements=requirements.to_proto() if requirements else None,
    )
    return Call(lambda s: s.captures.IngestCapture, request, Capture.from_proto)


def cancel_ingest(name: str) -> Call[Capture]:
    """Asks an ingest to stop."""
    request = capture_pb2.CancelIngestRequest(name=name)
    return Call(lambda s: s.captures.CancelIngest, request, Capture.from_proto)


def watch_capture(name: str) -> Watched[Capture]:
    """Changes of a capture's ingest."""

    def standing(capture: Capture) -> tuple[int, bool]:
        ingest = capture.ingest
        return (0, True) if ingest is None else (ingest.revision, ingest.state.has_ended)

    return Watched(
        lambda s: s.captures.WatchIngest,
        lambda revision: capture_pb2.WatchIngestRequest(name=name, after_revision=revision),
        Capture.from_proto,
        standing,
    )


def add_supplement(name: str, kind: str, content: Path | bytes) -> Call[Capture]:
    """Adds a file to a capture."""
    stated = capture_pb2.SupplementMetadata(name=name, kind=kind)

    def messages() -> Iterator[capture_pb2.AddSupplementRequest]:
        yield capture_pb2.AddSupplementRequest(metadata=stated)
        for chunk in chunks_of(content):
            yield capture_pb2.AddSupplementRequest(chunk=chunk)

    return Call(
        lambda s: s.captures.AddSupplement,
        messages(),
        lambda reply: Capture.from_proto(reply.capture),
    )


def export_supplement(name: str, kind: str) -> Call[bytes]:
    """A file that was added to a capture, in chunks."""
    request = capture_pb2.ExportSupplementRequest(name=name, kind=kind)
    return Call(lambda s: s.captures.ExportSupplement, request, _chunk)


def delete_supplement(name: str, kind: str) -> Call[None]:
    """Removes a file that was added to a capture."""
    request = capture_pb2.DeleteSupplementRequest(name=name, kind=kind)
    return Call(lambda s: s.captures.DeleteSupplement, request, _nothing)


def export_masks(name: str) -> Call[bytes]:
    """The masks that an ingest made of strokes, in chunks."""
    request = capture_pb2.ExportMasksRequest(name=name)
    return Call(lambda s: s.captures.ExportMasks, request, _chunk)


def capture_report(name: str, *, html: bool) -> Call[bytes]:
    """Report on a capture, in chunks."""
    request = capture_pb2.GetCaptureReportRequest(name=name)
    if html:
        request.format = capture_pb2.GetCaptureReportRequest.HTML
    return Call(lambda s: s.captures.GetCaptureReport, request, _chunk)


def export_observation(name: str) -> Call[bytes]:
    """The observation that fits of a capture work on, in chunks."""
    request = capture_pb2.ExportObservationRequest(name=name)
    return Call(lambda s: s.captures.ExportObservation, request, _chunk)


# Fits


def create_fit(
    capture: str,
    settings: _Settings,
    priority: int,
    request_id: str | None,
    display_name: str,
    requirements: Requirements | None,
) -> Call[Fit]:
    """Starts a fit."""
    request = fit_pb2.CreateFitRequest(
        capture=capture,
        settings_json=_json(settings),
        priority=priority,
        request_id=request_id or str(uuid.uuid4()),
        display_name=display_name,
        requirements=requirements.to_proto() if requirements else None,
    )
    return Call(lambda s: s.fits.CreateFit, request, Fit.from_proto)


def get_fit(name: str) -> Call[Fit]:
    """A fit."""
    return Call(lambda s: s.fits.GetFit, fit_pb2.GetFitRequest(name=name), Fit.from_proto)


def list_fits(capture: str, state: JobState | None, choice: ListArguments) -> Pages[Fit]:
    """Fits, of all captures or one, in any state or one."""
    request = fit_pb2.ListFitsRequest(capture=capture, **choice)
    if state is not None:
        request.state = state.value
    return Pages(
        lambda s: s.fits.ListFits, request, lambda page: [Fit.from_proto(f) for f in page.fits]
    )


def update_fit(name: str, change: LabelArguments) -> Call[Fit]:
    """Changes name, note and tags of a fit."""
    fit = fit_pb2.Fit(name=name, **fields(change))
    request = fit_pb2.UpdateFitRequest(fit=fit, **beside(change))
    return Call(lambda s: s.fits.UpdateFit, request, Fit.from_proto)


def fit_losses(name: str) -> Call[list[LossCurve]]:
    """The losses of a fit."""
    request = fit_pb2.GetFitLossesRequest(name=name)
    return Call(
        lambda s: s.fits.GetFitLosses,
        request,
        lambda losses: [LossCurve.from_proto(c) for c in losses.curves],
    )


def fit_preview(name: str) -> Call[FitPreview]:
    """What a running fit has so far."""
    request = fit_pb2.GetFitPreviewRequest(name=name)
    return Call(lambda s: s.fits.GetFitPreview, request, FitPreview.from_proto)


def cancel_fit(name: str) -> Call[Fit]:
    """Asks a fit to stop."""
    return Call(lambda s: s.fits.CancelFit, fit_pb2.CancelFitRequest(name=name), Fit.from_proto)


def delete_fit(name: str, purge: bool) -> Call[None]:
    """Deletes a fit."""
    request = fit_pb2.DeleteFitRequest(name=name, purge=purge)
    return Call(lambda s: s.fits.DeleteFit, request, _nothing)


def watch_fit(name: str) -> Watched[Fit]:
    """Changes of a fit."""
    return Watched(
        lambda s: s.fits.WatchFit,
        lambda revision: fit_pb2.WatchFitRequest(name=name, after_revision=revision),
        Fit.from_proto,
        lambda fit: (fit.job.revision, fit.state.has_ended),
    )


# Twins


def get_twin(name: str) -> Call[TwinInfo]:
    """A twin."""
    request = twin_pb2.GetTwinRequest(name=name)
    return Call(lambda s: s.twins.GetTwin, request, TwinInfo.from_proto)


def list_twins(capture: str, level: str, choice: ListArguments) -> Pages[TwinInfo]:
    """Twins, of all captures or one, of all levels of trust or one."""
    request = twin_pb2.ListTwinsRequest(capture=capture, level=level, **choice)
    return Pages(
        lambda s: s.twins.ListTwins,
        request,
        lambda page: [TwinInfo.from_proto(t) for t in page.twins],
    )


def export_twin(name: str) -> Call[bytes]:
    """The file of a twin, in chunks."""
    request = twin_pb2.ExportTwinRequest(name=name)
    return Call(lambda s: s.twins.ExportTwin, request, _chunk)


def create_twin(
    path: str | PathLike[str], display_name: str | None, request_id: str | None
) -> Call[TwinInfo]:
    """Uploads the file of a twin."""
    path = Path(path)
    stated = twin_pb2.TwinMetadata(
        display_name=path.stem if display_name is None else display_name,
        request_id=request_id or str(uuid.uuid4()),
    )

    def messages() -> Iterator[twin_pb2.CreateTwinRequest]:
        yield twin_pb2.CreateTwinRequest(metadata=stated)
        for chunk in chunks_of(path):
            yield twin_pb2.CreateTwinRequest(chunk=chunk)

    return Call(lambda s: s.twins.CreateTwin, messages(), TwinInfo.from_proto)


def update_twin(name: str, change: LabelArguments) -> Call[TwinInfo]:
    """Changes name, note and tags of a twin."""
    twin = twin_pb2.Twin(name=name, **fields(change))
    request = twin_pb2.UpdateTwinRequest(twin=twin, **beside(change))
    return Call(lambda s: s.twins.UpdateTwin, request, TwinInfo.from_proto)


def delete_twin(name: str, purge: bool) -> Call[None]:
    """Deletes a twin."""
    request = twin_pb2.DeleteTwinRequest(name=name, purge=purge)
    return Call(lambda s: s.twins.DeleteTwin, request, _nothing)


def evaluate_twin(twin: str, capture: str) -> Call[dict[str, Any]]:
    """Scores a twin on a capture."""
    request = evaluation_pb2.EvaluateTwinRequest(twin=twin, capture=capture)

    def quality(reply: evaluation_pb2.Evaluation) -> dict[str, Any]:
        table: dict[str, Any] = json.loads(reply.quality_json)
        return table

    return Call(lambda s: s.evaluations.EvaluateTwin, request, quality)


def twin_geometry(name: str) -> Call[Geometry]:
    """Nodes, springs and control points of a twin."""
    request = twin_pb2.GetTwinGeometryRequest(name=name)
    return Call(lambda s: s.twins.GetTwinGeometry, request, Geometry.from_proto)


def twin_surface(name: str) -> Call[Surface]:
    """The surface of a twin."""
    request = twin_pb2.GetTwinSurfaceRequest(name=name)
    return Call(lambda s: s.twins.GetTwinSurface, request, Surface.from_proto)


# Rollouts


def roll_out(request: rollout_pb2.RollOutRequest) -> Call[RolloutResult]:
    """A rollout."""
    return Call(lambda s: s.rollouts.RollOut, request, read_rollout)


def stream_roll_out(request: rollout_pb2.RollOutRequest, part_frames: int) -> Call[RolloutResult]:
    """A rollout in parts of at most `part_frames`; the first implausible part warns."""
    request.returns.part_frames = part_frames
    is_warned = False

    def read(part: Any) -> RolloutResult:
        nonlocal is_warned
        result = RolloutResult.from_proto(part)
        if is_warned:
            return result
        is_warned = bool(result.implausible)
        return warned(result)

    return Call(lambda s: s.rollouts.StreamRollOut, request, read)


def read_rollout(reply: Any) -> RolloutResult:
    """A result, after a warning of what is implausible."""
    return warned(RolloutResult.from_proto(reply))


def plan(request: planning_pb2.PlanRequest) -> Call[PlanUpdate]:
    """A plan, in updates."""
    return Call(lambda s: s.planning.Plan, request, PlanUpdate.from_proto)


# Trash


def list_trashed_captures(owner: str) -> Pages[Trashed]:
    """Deleted captures."""
    request = trash_pb2.ListTrashedCapturesRequest(owner=owner)
    return Pages(lambda s: s.trash.ListTrashedCaptures, request, _trashed)


def list_trashed_fits(owner: str) -> Pages[Trashed]:
    """Deleted fits."""
    request = trash_pb2.ListTrashedFitsRequest(owner=owner)
    return Pages(lambda s: s.trash.ListTrashedFits, request, _trashed)


def list_trashed_twins(owner: str) -> Pages[Trashed]:
    """Deleted twins."""
    request = trash_pb2.ListTrashedTwinsRequest(owner=owner)
    return Pages(lambda s: s.trash.ListTrashedTwins, request, _trashed)


def restore_capture(name: str) -> Call[Capture]:
    """Restores a deleted capture."""
    request = trash_pb2.UndeleteCaptureRequest(name=name)
    return Call(lambda s: s.trash.UndeleteCapture, request, Capture.from_proto)


def restore_fit(name: str) -> Call[Fit]:
    """Restores a deleted fit."""
    request = trash_pb2.UndeleteFitRequest(name=name)
    return Call(lambda s: s.trash.UndeleteFit, request, Fit.from_proto)


def restore_twin(name: str) -> Call[TwinInfo]:
    """Restores a deleted twin."""
    request = trash_pb2.UndeleteTwinRequest(name=name)
    return Call(lambda s: s.trash.UndeleteTwin, request, TwinInfo.from_proto)


# Workers


def drain_worker(name: str) -> Call[Worker]:
    """Asks a worker to end."""
    return Call(
        lambda s: s.workers.DrainWorker,
        worker_pb2.DrainWorkerRequest(name=name),
        Worker.from_proto,
    )


def list_workers() -> Pages[Worker]:
    """The workers that the server knows."""
    return Pages(
        lambda s: s.workers.ListWorkers,
        worker_pb2.ListWorkersRequest(),
        lambda page: [Worker.from_proto(w) for w in page.workers],
    )


def _trashed(page: Any) -> list[Trashed]:
    return [Trashed.from_proto(resource) for resource in page.resources]


def _chunk(part: Any) -> bytes:
    chunk: bytes = part.chunk
    return chunk


def _nothing(_: Any) -> None:
    return None


def _json(settings: _Settings) -> str:
    return json.dumps(settings) if settings else ""
