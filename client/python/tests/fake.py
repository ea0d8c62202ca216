"""A server in this process that answers as the real one would, with made-up physics."""

from __future__ import annotations

from concurrent import futures
from dataclasses import dataclass, field

import grpc
import numpy as np
from google.protobuf import any_pb2
from google.rpc import error_details_pb2, status_pb2

from bendtwin.v1 import (
    capture_pb2,
    capture_pb2_grpc,
    fit_pb2,
    fit_pb2_grpc,
    job_pb2,
    key_pb2,
    key_pb2_grpc,
    project_pb2,
    project_pb2_grpc,
    rollout_pb2,
    rollout_pb2_grpc,
    tensor_pb2,
    trash_pb2,
    trash_pb2_grpc,
    twin_pb2,
    twin_pb2_grpc,
    usage_pb2,
    usage_pb2_grpc,
)

CAPTURE = "captures/0190a000-0000-7000-8000-000000000001"
FIT = "fits/0190a000-0000-7000-8000-000000000002"
SHARE = "shares/0190a000-0000-7000-8000-000000000005"
PROJECT = "projects/0190a000-0000-7000-8000-000000000004"
TWIN = "twins/0190a000-0000-7000-8000-000000000003"

_WIRE = tensor_pb2.Tensor
_DTYPES = {"float32": _WIRE.FLOAT32, "float64": _WIRE.FLOAT64, "uint32": _WIRE.UINT32}


def tensor(array: np.ndarray) -> tensor_pb2.Tensor:
    return _WIRE(dtype=_DTYPES[array.dtype.name], shape=array.shape, data=array.tobytes())


def refuse(context: grpc.ServicerContext, code: grpc.StatusCode, reason: str, message: str):
    """Ends the call as the real server does: a status with ErrorInfo and RequestInfo."""
    details = [any_pb2.Any(), any_pb2.Any()]
    details[0].Pack(error_details_pb2.ErrorInfo(reason=reason, domain="bendtwin"))
    details[1].Pack(error_details_pb2.RequestInfo(request_id="r-1"))
    status = status_pb2.Status(code=code.value[0], message=message, details=details)
    context.set_trailing_metadata([("grpc-status-details-bin", status.SerializeToString())])
    context.abort(code, message)


@dataclass
class Fake(
    capture_pb2_grpc.CaptureServiceServicer,
    fit_pb2_grpc.FitServiceServicer,
    twin_pb2_grpc.TwinServiceServicer,
    rollout_pb2_grpc.RolloutServiceServicer,
    project_pb2_grpc.ProjectServiceServicer,
    key_pb2_grpc.ShareServiceServicer,
    usage_pb2_grpc.UsageServiceServicer,
    trash_pb2_grpc.TrashServiceServicer,
):
    """Server that keeps the requests that it got, and ends jobs as it is told."""

    uploaded: bytes = b""
    shown: list[tuple[str, str | None]] = field(default_factory=list)
    metadata: capture_pb2.CaptureMetadata | None = None
    fit_request: fit_pb2.CreateFitRequest | None = None
    rollout_request: rollout_pb2.RollOutRequest | None = None
    ingest_request: capture_pb2.IngestCaptureRequest | None = None
    supplement: capture_pb2.SupplementMetadata | None = None
    removed: capture_pb2.DeleteSupplementRequest | None = None
    deleted: object = None
    restored: object = None
    update: object = None
    listed: object = None
    reads: int = job_pb2.Job.SUCCEEDED
    ends: int = job_pb2.Job.SUCCEEDED
    watched_from: list[int] = field(default_factory=list)
    implausible: list[tuple[int, str, float, float]] = field(default_factory=list)

    def CreateCapture(self, messages, context):
        self.metadata = next(messages).metadata
        self.uploaded = b"".join(m.chunk for m in messages)
        return capture_pb2.CreateCaptureResponse(
            capture=capture_pb2.Capture(
                name=CAPTURE,
                display_name=self.metadata.display_name,
                size_bytes=len(self.uploaded),
            )
        )

    def IngestCapture(self, request, context):
        self.ingest_request = request
        return self._capture(1, job_pb2.Job.QUEUED)

    def CancelIngest(self, request, context):
        return self._capture(4, job_pb2.Job.CANCELLED)

    def WatchIngest(self, request, context):
        """Breaks off after every message, as if the server restarted each time."""
        self.watched_from.append(request.after_revision)
        revision = request.after_revision + 1
        yield self._capture(revision, job_pb2.Job.RUNNING if revision < 4 else self.reads)
        if revision < 4:
            context.abort(grpc.StatusCode.UNAVAILABLE, "the server restarts")

    def _capture(self, revision, state):
        capture = capture_pb2.Capture(name=CAPTURE, verdict="usable" if revision == 4 else "")
        capture.ingest.CopyFrom(job_pb2.Job(state=state, revision=revision))
        if state == job_pb2.Job.FAILED:
            capture.ingest.fault.category = "INVALID_ARGUMENT"
            capture.ingest.fault.reason = "OBJECT_NOT_SEEN"
            capture.ingest.fault.message = "no mask shows the object: segment it again"
        return capture

    def GetCaptureReport(self, request, context):
        if request.format == capture_pb2.GetCaptureReportRequest.HTML:
            yield capture_pb2.GetCaptureReportResponse(chunk=b"<!doctype html>")
            return
        yield capture_pb2.GetCaptureReportResponse(chunk=b'{"verdict": "usable", ')
        yield capture_pb2.GetCaptureReportResponse(chunk=b'"findings": []}')

    def ExportObservation(self, request, context):
        yield capture_pb2.ExportObservationResponse(chunk=b"PK")
        yield capture_pb2.ExportObservationResponse(chunk=b"points")

    def ExportMasks(self, request, context):
        yield capture_pb2.ExportMasksResponse(chunk=b"PK")
        yield capture_pb2.ExportMasksResponse(chunk=b"masks")

    def AddSupplement(self, messages, context):
        self.supplement = next(messages).metadata
        self.uploaded = b"".join(m.chunk for m in messages)
        capture = capture_pb2.Capture(name=self.supplement.name, masks=True)
        capture.supplements.add(kind=self.supplement.kind, size_bytes=len(self.uploaded))
        return capture_pb2.AddSupplementResponse(capture=capture)

    def ExportSupplement(self, request, context):
        yield capture_pb2.ExportSupplementResponse(chunk=request.kind.encode())

    def DeleteSupplement(self, request, context):
        self.removed = request
        return capture_pb2.DeleteSupplementResponse()

    def DeleteCapture(self, request, context):
        self.deleted = request
        return capture_pb2.DeleteCaptureResponse()

    def DeleteFit(self, request, context):
        self.deleted = request
        return fit_pb2.DeleteFitResponse()

    def DeleteTwin(self, request, context):
        self.deleted = request
        return twin_pb2.DeleteTwinResponse()

    def ListTrashedCaptures(self, request, context):
        self.listed = request
        page = int(request.page_token or 0)
        return trash_pb2.ListTrashedCapturesResponse(
            resources=[trash_pb2.TrashedResource(name=f"captures/{page}-{i}") for i in range(2)],
            next_page_token="1" if page == 0 else "",
        )

    def ListTrashedFits(self, request, context):
        return trash_pb2.ListTrashedFitsResponse(
            resources=[trash_pb2.TrashedResource(name="fits/0")]
        )

    def ListTrashedTwins(self, request, context):
        return trash_pb2.ListTrashedTwinsResponse(
            resources=[trash_pb2.TrashedResource(name="twins/0")]
        )

    def UndeleteCapture(self, request, context):
        self.restored = request
        return self._capture(4, job_pb2.Job.SUCCEEDED)

    def UndeleteFit(self, request, context):
        self.restored = request
        return fit_pb2.Fit(name=request.name, job=job_pb2.Job(state=job_pb2.Job.SUCCEEDED))

    def UndeleteTwin(self, request, context):
        self.restored = request
        return twin_pb2.Twin(name=request.name)

    def ListCaptures(self, request, context):
        self.listed = request
        page = int(request.page_token or 0)
        return capture_pb2.ListCapturesResponse(
            captures=[capture_pb2.Capture(name=f"captures/{page}-{i}") for i in range(2)],
            next_page_token=str(page + 1) if page < 2 else "",
        )

    def UpdateCapture(self, request, context):
        self.update = request
        return capture_pb2.Capture(name=request.capture.name, note=request.capture.note)

    def UpdateFit(self, request, context):
        self.update = request
        fit = fit_pb2.Fit(name=request.fit.name, tags=["blue", "wet"])
        fit.job.state = job_pb2.Job.QUEUED
        return fit

    def UpdateTwin(self, request, context):
        self.update = request
        return twin_pb2.Twin(name=request.twin.name, display_name=request.twin.display_name)

    def ListFits(self, request, context):
        self.listed = request
        return fit_pb2.ListFitsResponse(fits=[self._fit(1, job_pb2.Job.RUNNING)])

    def ListTwins(self, request, context):
        self.listed = request
        return twin_pb2.ListTwinsResponse(twins=[twin_pb2.Twin(name=TWIN, error_m=0.004)])

    def CreateProject(self, request, context):
        self.update = request
        members = sorted(set(request.members))
        return project_pb2.Project(name=PROJECT, display_name=request.display_name, members=members)

    def GetProject(self, request, context):
        return project_pb2.Project(name=request.name, members=["ada"])

    def ListProjects(self, request, context):
        page = int(request.page_token or 0)
        return project_pb2.ListProjectsResponse(
            projects=[project_pb2.Project(name=f"projects/{page}")],
            next_page_token=str(page + 1) if page < 2 else "",
        )

    def UpdateProject(self, request, context):
        self.update = request
        return project_pb2.Project(name=request.project.name, members=request.add_members)

    def DeleteProject(self, request, context):
        self.removed = request
        return project_pb2.DeleteProjectResponse()

    def ShareTwin(self, request, context):
        self.update = request
        share = key_pb2.Share(name=SHARE, twin=request.twin, display_name=request.display_name)
        return key_pb2.ShareTwinResponse(share=share, secret_key="bt_1")

    def ListShares(self, request, context):
        page = int(request.page_token or 0)
        return key_pb2.ListSharesResponse(
            shares=[key_pb2.Share(name=f"shares/{page}", twin=request.twin)],
            next_page_token=str(page + 1) if page < 2 else "",
        )

    def DeleteShare(self, request, context):
        self.removed = request
        return key_pb2.DeleteShareResponse()

    def GetFitLosses(self, request, context):
        curve = fit_pb2.FitLosses.LossCurve(
            stage="refine",
            variant="bending",
            iterations=[1, 2],
            losses=[float("nan"), 0.5],
            best_losses=[float("nan"), 0.5],
        )
        return fit_pb2.FitLosses(curves=[curve])

    def GetFitPreview(self, request, context):
        self.previewed = request.name
        codes = np.array([[[-2, 0, 2]], [[0, 0, 0]]], "<i2")
        scaled = {"dtype": _WIRE.INT16_SCALED, "scale": 0.5, "offset": 1.0}
        return fit_pb2.FitPreview(
            stage="refine",
            variant="bending",
            iteration=3,
            create_time={"seconds": 60},
            frames=tensor(np.array([0, 9], np.uint32)),
            positions=_WIRE(shape=codes.shape, data=codes.tobytes(), **scaled),
            measure="track",
            error_m=0.008,
            baseline_m=0.041,
        )

    def CreateFit(self, request, context):
        self.fit_request = request
        return self._fit(1, job_pb2.Job.QUEUED)

    def GetFit(self, request, context):
        return self._fit(4, self.ends)

    def WatchFit(self, request, context):
        """Breaks off after every message, as if the server restarted each time."""
        self.watched_from.append(request.after_revision)
        revision = request.after_revision + 1
        yield self._fit(revision, job_pb2.Job.RUNNING if revision < 4 else self.ends)
        if revision < 4:
            context.abort(grpc.StatusCode.UNAVAILABLE, "the server restarts")

    def _fit(self, revision, state):
        job = job_pb2.Job(state=state, revision=revision)
        fit = fit_pb2.Fit(name=FIT, capture=CAPTURE, job=job)
        fit.job.progress.CopyFrom(job_pb2.Progress(stage="search", fraction=revision / 4, loss=0.5))
        if state == job_pb2.Job.SUCCEEDED:
            fit.twin = TWIN
        if state == job_pb2.Job.FAILED:
            fit.job.fault.category = "INVALID_ARGUMENT"
            fit.job.fault.reason = "CAPTURE_WITHOUT_POINTS"
            fit.job.fault.message = "the capture has no points: record again"
        return fit

    def GetTwin(self, request, context):
        if request.name != TWIN:
            refuse(
                context,
                grpc.StatusCode.NOT_FOUND,
                "TWIN_NOT_FOUND",
                f"there is no {request.name}: list twins to see what there is",
            )
        return twin_pb2.Twin(
            name=TWIN, node_count=3, control_count=1, quality_json='{"scores": []}'
        )

    def ExportTwin(self, request, context):
        yield twin_pb2.ExportTwinResponse(chunk=b"safe")
        yield twin_pb2.ExportTwinResponse(chunk=b"tensors")

    def RollOut(self, request, context):
        self.rollout_request = request
        if request.WhichOneof("actions") == "poses":
            return self._carried(request)
        return self._answer(request, 0, request.trajectories.positions.shape[0])

    def StreamRollOut(self, request, context):
        self.rollout_request = request
        for instance in range(request.trajectories.positions.shape[0]):
            yield self._answer(request, instance, 1)

    def _carried(self, request):
        """Costs of zero, a control point, and forces in every frame between two knots."""
        batch, knots = request.poses.poses.shape[:2]
        reply = rollout_pb2.RollOutResponse(costs=tensor(np.zeros(batch)))
        if request.HasField("ensemble"):
            members = np.zeros((batch, request.ensemble.members))
            reply.member_costs.CopyFrom(tensor(members))
        if request.returns.forces:
            rows = (batch, knots - 1)
            for name, shape in (
                ("controls", (*rows, 1, 3)),
                ("grasps", (*rows, len(request.grasps), 6)),
                ("ground", (*rows, 3)),
                ("colliders", (*rows, len(request.world.colliders), 6)),
            ):
                getattr(reply.forces, name).CopyFrom(tensor(np.ones(shape, np.float32)))
        for instance, reason, found, limit in self.implausible:
            reply.implausible.add(instance=instance, reason=reason, found=found, limit=limit)
        return reply

    @staticmethod
    def _answer(request, first, count):
        """The cost is how far the last knot is from the origin; nodes sit on control point 0."""
        positions = request.trajectories.positions
        knots = np.frombuffer(positions.data, "<f4").reshape(tuple(positions.shape))
        knots = knots[first : first + count]
        reply = rollout_pb2.RollOutResponse(first_instance=first, worker="workers/w")
        costs = np.linalg.norm(knots[:, -1, 0].astype(np.float64), axis=-1)
        reply.costs.CopyFrom(tensor(costs))
        reply.cost_terms.CopyFrom(tensor(costs[:, None].copy()))
        reply.cost_names.extend(c.name or f"cost{i}" for i, c in enumerate(request.costs))
        reply.timing.compute_s = 0.25
        reply.fidelity, reply.substeps = rollout_pb2.EXACT, 100
        if request.fidelity == rollout_pb2.FAST:
            reply.fidelity, reply.substeps = rollout_pb2.FAST, 20
            reply.deviation.mean_m = 5e-4
            reply.deviation.frames = 30
        if request.fidelity == rollout_pb2.PLANNER:
            reply.fidelity, reply.substeps = rollout_pb2.PLANNER, 40
            reply.deviation.mean_m = 1e-3
        if request.returns.every_frames:
            path = np.repeat(knots[:, 1:, :1], 3, axis=2)
            if request.returns.encoding == rollout_pb2.Returns.INT16:
                codes = np.round(path / 1e-3).astype("<i2")
                reply.positions.CopyFrom(
                    _WIRE(
                        dtype=_WIRE.INT16_SCALED,
                        shape=codes.shape,
                        data=codes.tobytes(),
                        scale=1e-3,
                    )
                )
            else:
                reply.positions.CopyFrom(tensor(path))
            reply.frames.CopyFrom(tensor(np.arange(1, path.shape[1] + 1, dtype=np.uint32)))
        if request.returns.control_gradients:
            reply.control_gradients.CopyFrom(tensor(knots.copy()))
            reply.gradient_exploded.CopyFrom(tensor(np.arange(count, dtype=np.uint32)))
        if request.returns.action_gradients:
            reply.action_gradients.CopyFrom(tensor(knots.copy()))
        Fake._more(request.returns, reply, knots)
        reply.diverged.add(instance=first, frame=3, node=2)
        return reply

    @staticmethod
    def _more(asked, reply, knots):
        """Rarely asked for arrays: zeros of the right shape, and the controls."""
        count, frames = knots.shape[:2]
        terms = len(reply.cost_names)
        if asked.velocities:
            reply.velocities.CopyFrom(tensor(np.zeros((count, frames - 1, 3, 3), np.float32)))
        if asked.frame_costs:
            reply.frame_costs.CopyFrom(tensor(np.zeros((count, frames, terms))))
        if asked.controls:
            reply.controls.CopyFrom(tensor(knots.copy()))
        if asked.gradient_norms:
            reply.gradient_norms.CopyFrom(tensor(np.zeros((count, frames))))
        if asked.initial_gradients:
            zeros = tensor(np.zeros((count, 3, 3), np.float32))
            reply.initial_position_gradients.CopyFrom(zeros)
            reply.initial_velocity_gradients.CopyFrom(zeros)

    def GetUsage(self, _, context):
        usage = usage_pb2.OwnerUsage(owner="ada", captures=2, queued_jobs=1)
        usage.stored_bytes.total, usage.stored_bytes.derived = 300, 100
        usage.quotas.stored_bytes = 1000
        return usage

    def ListOwnerUsage(self, request, context):
        names = ["ada", "bob"]
        first = int(request.page_token or 0)
        owners = [usage_pb2.OwnerUsage(owner=names[first])]
        token = str(first + 1) if first + 1 < len(names) else ""
        return usage_pb2.ListOwnerUsageResponse(owners=owners, next_page_token=token)


class Recorder(grpc.ServerInterceptor):
    """Notes the token that each call shows."""

    def __init__(self, fake: Fake) -> None:
        self._fake = fake

    def intercept_service(self, continuation, details):
        shown = dict(details.invocation_metadata).get("authorization")
        self._fake.shown.append((details.method.rpartition("/")[2], shown))
        return continuation(details)


def serve(fake: Fake) -> tuple[grpc.Server, str]:
    pool = futures.ThreadPoolExecutor(max_workers=4)
    server = grpc.server(pool, interceptors=[Recorder(fake)])
    capture_pb2_grpc.add_CaptureServiceServicer_to_server(fake, server)
    fit_pb2_grpc.add_FitServiceServicer_to_server(fake, server)
    twin_pb2_grpc.add_TwinServiceServicer_to_server(fake, server)
    rollout_pb2_grpc.add_RolloutServiceServicer_to_server(fake, server)
    project_pb2_grpc.add_ProjectServiceServicer_to_server(fake, server)
    key_pb2_grpc.add_ShareServiceServicer_to_server(fake, server)
    usage_pb2_grpc.add_UsageServiceServicer_to_server(fake, server)
    trash_pb2_grpc.add_TrashServiceServicer_to_server(fake, server)
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    return server, f"127.0.0.1:{port}"
