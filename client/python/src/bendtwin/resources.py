"""Resources of a server as plain values: captures, fits, twins, sessions, workers, usage."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from datetime import datetime, timezone
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bendtwin.errors import Category, category_named
from bendtwin.messages import FromMessage
from bendtwin.simulation.rollout import Fidelity
from bendtwin.tensors import unpack
from bendtwin.v1 import fault_pb2, fit_pb2, job_pb2


class JobState(enum.Enum):
    """State of a job: of a fit, or of the ingest of a capture."""

    QUEUED = job_pb2.Job.QUEUED
    RUNNING = job_pb2.Job.RUNNING
    SUCCEEDED = job_pb2.Job.SUCCEEDED
    FAILED = job_pb2.Job.FAILED
    CANCELLED = job_pb2.Job.CANCELLED

    @property
    def has_ended(self) -> bool:
        """True if nothing will change any more."""
        return self not in (JobState.QUEUED, JobState.RUNNING)


@dataclass(frozen=True)
class Fault(FromMessage):
    """Reason for a failure."""

    category: Category
    reason: str
    message: str

    @classmethod
    def from_proto(cls, message: fault_pb2.Fault) -> Fault:
        """Reads the wire form."""
        return cls(category_named(message.category), message.reason, message.message)


@dataclass(frozen=True)
class ModelLoss(FromMessage):
    """Loss of a model after an iteration."""

    #: Stage: search or refine.
    stage: str
    #: Model: bending or axial, with several starts followed by the start: `bending 2/3`.
    variant: str
    iteration: int
    #: None where the loss was not finite.
    loss: float | None
    best_loss: float | None
    #: Error over the training frames with the best parameters, metres; None without a preview.
    error_m: float | None = None


@dataclass(frozen=True)
class LossCurve:
    """Losses of one model over the iterations of a stage of a fit.

    Long stages are thinned: only every second, fourth, ... iteration is kept, and the last.
    """

    #: Stage: search or refine.
    stage: str
    #: Model: bending or axial, with several starts followed by the start: `bending 2/3`.
    variant: str
    #: Iterations, ascending from 1, [n].
    iterations: NDArray[np.int64]
    #: Losses, NaN where not finite, [n].
    losses: NDArray[np.float64]
    #: Lowest loss up to each iteration, [n].
    best_losses: NDArray[np.float64]
    #: Error over the training frames with the best parameters up to each iteration, metres; NaN
    #: where it was not measured, [n].
    errors_m: NDArray[np.float64]

    @classmethod
    def from_proto(cls, message: fit_pb2.FitLosses.LossCurve) -> LossCurve:
        """Reads the wire form."""
        return cls(
            message.stage,
            message.variant,
            np.array(message.iterations, np.int64),
            np.array(message.losses, np.float64),
            np.array(message.best_losses, np.float64),
            # A server of an earlier version has none.
            np.array(message.errors_m or [np.nan] * len(message.iterations), np.float64),
        )


@dataclass(frozen=True)
class FitPreview:
    """What a running fit has so far: predicted motion of P points in F frames, and its error."""

    #: Stage: search or refine.
    stage: str
    #: Model: bending or axial, with several starts followed by the start: `bending 2/3`.
    variant: str
    #: Iterations of the stage that were done.
    iteration: int
    #: Time at which the server received it.
    create_time: datetime
    #: Index of the sequence among those of the capture.
    sequence: int
    #: Numbers of the frames, ascending [F].
    frames: NDArray[np.int64]
    #: Positions [F, P, 3], metres.
    positions: NDArray[np.float32]
    #: Kind of the errors, the one that the twin will be judged by: track, coordinate or chamfer.
    measure: str
    #: Error over the frames that the parameters are fitted to, metres.
    error_m: float
    #: Error over training frames that are held back, metres; None: none are.
    held_back_m: float | None
    #: Error of the object standing still, over the frames of `error_m`, metres.
    baseline_m: float

    @classmethod
    def from_proto(cls, message: fit_pb2.FitPreview) -> FitPreview:
        """Reads the wire form."""
        return cls(
            message.stage,
            message.variant,
            message.iteration,
            message.create_time.ToDatetime(timezone.utc),
            message.sequence,
            np.asarray(unpack(message.frames), np.int64),
            np.asarray(unpack(message.positions), np.float32),
            message.measure,
            message.error_m,
            message.held_back_m if message.HasField("held_back_m") else None,
            message.baseline_m,
        )


@dataclass(frozen=True)
class Progress(FromMessage):
    """Progress of a running job."""

    #: Stage: ingest, search, refine or evaluate.
    stage: str
    #: Model: bending or axial; for an ingest, the step.
    variant: str
    iteration: int
    iterations: int
    #: Fraction of the whole job that is done, 0..1.
    fraction: float
    loss: float | None
    best_loss: float | None
    eta_s: float | None
    note: str
    #: The latest loss of each model, when several are fitted side by side.
    models: tuple[ModelLoss, ...] = ()
    #: Error over the training frames of the newest preview, metres.
    error_m: float | None = None


@dataclass(frozen=True)
class Job(FromMessage):
    """Work that a worker does for a fit, or for the ingest of a capture."""

    state: JobState
    settings: dict[str, Any]
    progress: Progress | None
    #: Reason of the failure.
    fault: Fault | None
    attempt_faults: list[Fault] = field(default_factory=list)
    attempts: int = 0
    #: workers/{uuid} while it runs, else empty.
    worker: str = ""
    cancel_requested: bool = False
    create_time: datetime | None = None
    start_time: datetime | None = None
    end_time: datetime | None = None
    #: Number that grows with every change, also from one run of an ingest to the next.
    revision: int = 0
    #: Time for which it has run at workers, over all attempts, as of the last report [s].
    run_s: float = 0.0


@dataclass(frozen=True)
class Requirements(FromMessage):
    """Requirements on the worker of a fit or an ingest, which waits for one; by default any
    worker."""

    #: `cpu` or `cuda`; empty means either.
    backend: str = ""
    #: Least device memory; on a CPU, least memory that a fit may take.
    memory_bytes: int = 0
    #: Labels that the worker must all have.
    labels: tuple[str, ...] = ()

    def to_proto(self) -> job_pb2.WorkerRequirements | None:
        """Writes the wire form; None if any worker will do."""
        if self == Requirements():
            return None
        return job_pb2.WorkerRequirements(
            backend=self.backend, memory_bytes=self.memory_bytes, labels=self.labels
        )


@dataclass(frozen=True)
class Supplement(FromMessage):
    """A file that was added to a capture, which ingests read beside the archive."""

    #: `masks` or `calibration`.
    kind: str
    size_bytes: int
    #: BLAKE3 of the file, hex.
    digest: str
    create_time: datetime | None


@dataclass(frozen=True)
class Capture(FromMessage):
    """A recording of a soft object."""

    name: str
    display_name: str
    create_time: datetime | None
    size_bytes: int
    #: BLAKE3 of the archive, hex.
    digest: str
    #: The job that reads the capture. Running it again replaces it. Fits of the capture fail with
    #: its fault. None in replies without it.
    ingest: Job | None = None
    #: Verdict of the report: good, usable or unusable; empty until the report exists.
    verdict: str = ""
    #: Note written by users.
    note: str = ""
    #: Tags, sorted.
    tags: tuple[str, ...] = ()
    #: Owner of the key that uploaded the capture; empty if unknown.
    owner: str = ""
    #: Worker that the ingest requires.
    ingest_requirements: Requirements = Requirements()
    #: Who recorded it; empty if not stated.
    recorded_by: str = ""
    #: Files that were added after the upload, one of each kind.
    supplements: tuple[Supplement, ...] = ()
    #: True if the last ingest made masks of strokes.
    masks: bool = False


@dataclass(frozen=True)
class Fit(FromMessage):
    """A fit."""

    name: str
    capture: str
    #: twins/{uuid} once the fit has succeeded, otherwise empty.
    twin: str
    job: Job
    #: Fits of higher priority run earlier.
    priority: int = 0
    #: Name given at creation, by default that of the capture.
    display_name: str = ""
    #: Note written by users.
    note: str = ""
    #: Tags, sorted.
    tags: tuple[str, ...] = ()
    #: Error of the twin over frames that it was not fitted to, in metres; None if unknown.
    error_m: float | None = None
    #: Owner of the key that created the fit; empty if unknown.
    owner: str = ""
    #: Worker that the fit requires.
    requirements: Requirements = Requirements()
    #: Kind of `error_m`: track, coordinate or chamfer; empty if unknown.
    measure: str = ""

    @property
    def state(self) -> JobState:
        """State of its job."""
        return self.job.state

    @property
    def progress(self) -> Progress | None:
        """Progress of its job."""
        return self.job.progress

    @property
    def fault(self) -> Fault | None:
        """Reason why its job failed."""
        return self.job.fault


@dataclass(frozen=True)
class TwinInfo(FromMessage):
    """Facts of a stored twin."""

    name: str
    display_name: str
    capture: str
    fit: str
    create_time: datetime | None
    size_bytes: int
    #: BLAKE3 of the twin file, hex.
    digest: str
    node_count: int
    spring_count: int
    triplet_count: int
    control_count: int
    fps: float
    substeps: int
    #: The quality table (docs/formats/twin.md).
    quality: dict[str, Any]
    #: Mass of the object; None if unknown.
    mass_kg: float | None = None
    #: Note written by users.
    note: str = ""
    #: Tags, sorted.
    tags: tuple[str, ...] = ()
    #: Error over frames that the twin was not fitted to, in metres: of tracks, else of coordinates,
    #: else the Chamfer distance; None if unknown.
    error_m: float | None = None
    #: Owner of its fit, or of the key that imported it; empty if unknown.
    owner: str = ""


@dataclass(frozen=True)
class Trashed(FromMessage):
    """A deleted capture, fit or twin, which can be restored."""

    name: str
    display_name: str
    owner: str
    create_time: datetime | None
    delete_time: datetime | None
    #: The server deletes it for good from this time on, or earlier if its disk gets full.
    purge_time: datetime | None
    #: Owner of the key that deleted it, or the rule that did; empty if unknown.
    deleted_by: str
    #: Size of the archive of a capture, or of a twin file; 0 for a fit.
    size_bytes: int


@dataclass(frozen=True)
class Worker(FromMessage):
    """A worker process that is registered with the server."""

    name: str
    backend: str
    device: str
    start_time: datetime | None
    last_seen_time: datetime | None
    fit: str
    warm_twins: list[str]
    rollouts_in_flight: int
    build: str
    #: Device memory in use by all processes, and in total; zero where unknown.
    memory_used_bytes: int
    memory_total_bytes: int
    #: The capture whose ingest is running, if any.
    ingest: str = ""
    #: Labels that the worker was started with and that fits can require.
    labels: tuple[str, ...] = ()
    #: True if the worker was asked to exit.
    draining: bool = False
    #: servers/{uuid} of the server that started it, whose rollouts it only answers; otherwise
    #: empty.
    server: str = ""


@dataclass(frozen=True)
class Project(FromMessage):
    """A set of owners who share what each of them has."""

    #: projects/{uuid}.
    name: str
    display_name: str
    #: Names of owners, sorted.
    members: tuple[str, ...]
    create_time: datetime | None


@dataclass(frozen=True)
class Share(FromMessage):
    """A link by which people without a token look at a twin and play with it."""

    #: shares/{uuid}.
    name: str
    #: twins/{uuid}.
    twin: str
    #: For whom it is.
    display_name: str
    #: Owner of the key that made it.
    owner: str
    #: True if those who have it may download the twin.
    allow_export: bool
    create_time: datetime | None
    expire_time: datetime | None
    #: None unless it was revoked.
    revoke_time: datetime | None
    #: Accurate to about a minute; None if it has not been used.
    last_use_time: datetime | None


@dataclass(frozen=True)
class MadeShare:
    """A newly made link, whose address is returned only here."""

    share: Share
    #: The address that opens the twin, which contains a key.
    link: str = field(repr=False)


@dataclass(frozen=True)
class StoredBytes(FromMessage):
    """Sizes of what is stored for an owner, bytes. Equal content counts for each resource."""

    #: The sum, which the quota bounds.
    total: int
    #: Archives of captures, and files that were added to them.
    captures: int
    #: Observations, playbacks, masks and reports, which ingests made.
    derived: int
    twins: int
    #: Checkpoints of jobs that have not ended.
    checkpoints: int
    #: Uploads in progress: the declared sizes, or what has arrived and is set aside for more.
    uploads: int


@dataclass(frozen=True)
class Quotas(FromMessage):
    """Bounds on what the owner of a key may have; None for no bound."""

    #: Fits and ingests that wait for a worker.
    queued_jobs: int | None = None
    #: Size of everything stored for the owner.
    stored_bytes: int | None = None
    #: Rollouts, plans, registrations and evaluations in progress at one server.
    rollouts: int | None = None
    #: Fits and ingests that run at workers.
    running_jobs: int | None = None
    #: Time for which one fit may run [s].
    fit_run_s: int | None = None
    #: Highest priority of a fit.
    priority: int | None = None


@dataclass(frozen=True)
class OwnerUsage(FromMessage):
    """What is stored for an owner, and its jobs."""

    #: Name of the owner; empty for what was made where no key was required.
    owner: str
    captures: int
    #: Fits, ended ones included.
    fits: int
    twins: int
    stored_bytes: StoredBytes
    #: Fits and ingests that wait for a worker.
    queued_jobs: int
    #: Fits and ingests that run.
    running_jobs: int
    #: Quotas of the key that is used; in a list the widest among the owner's valid keys.
    quotas: Quotas


@dataclass(frozen=True)
class SessionInfo(FromMessage):
    """Facts of a session."""

    #: sessions/{uuid}.
    name: str
    #: twins/{uuid}.
    twin: str
    slots: int
    #: Frames by which each slot has been advanced since its first state [slots].
    frames: tuple[int, ...]
    #: Time without calls after which the session ends, seconds.
    idle_timeout_s: float
    #: workers/{uuid}.
    worker: str
    #: Slots that no longer follow their object, ascending: see `Tracking`.
    lost: tuple[int, ...] = ()
    #: The model that answers.
    fidelity: Fidelity = "exact"
