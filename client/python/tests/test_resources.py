"""Resources as values of their messages."""

import pickle
from dataclasses import dataclass, fields
from datetime import datetime, timezone
from types import SimpleNamespace
from typing import get_type_hints

import numpy as np
import pytest
import typing_extensions

from bendtwin import (
    Capture,
    CaptureArguments,
    CaptureLabelArguments,
    CaptureListArguments,
    Category,
    Correction,
    Deviation,
    Diagnostics,
    Divergence,
    Fault,
    Fit,
    Forces,
    Implausible,
    Job,
    JobState,
    LossCurve,
    ModelLoss,
    OwnerUsage,
    Progress,
    Project,
    Quotas,
    Requirements,
    Residual,
    RolloutResult,
    SessionInfo,
    Share,
    StoredBytes,
    Supplement,
    Timing,
    Tracking,
    Trashed,
    TwinInfo,
    Worker,
)
from bendtwin.messages import FromMessage
from bendtwin.simulation.rollout import FIDELITIES
from bendtwin.tensors import pack_floats
from bendtwin.v1 import (
    capture_pb2,
    fault_pb2,
    fit_pb2,
    job_pb2,
    key_pb2,
    project_pb2,
    registration_pb2,
    rollout_pb2,
    session_pb2,
    trash_pb2,
    twin_pb2,
    usage_pb2,
    worker_pb2,
)

REPLY = rollout_pb2.RollOutResponse
MESSAGES = {
    Capture: capture_pb2.Capture,
    Correction: session_pb2.CorrectedSession.Correction,
    Deviation: REPLY.Deviation,
    Diagnostics: REPLY.Diagnostics,
    Divergence: REPLY.Divergence,
    Fault: fault_pb2.Fault,
    Fit: fit_pb2.Fit,
    Forces: REPLY.Forces,
    Implausible: REPLY.Implausible,
    Job: job_pb2.Job,
    LossCurve: fit_pb2.FitLosses.LossCurve,
    ModelLoss: job_pb2.ModelLoss,
    OwnerUsage: usage_pb2.OwnerUsage,
    Progress: job_pb2.Progress,
    Project: project_pb2.Project,
    Quotas: key_pb2.KeyQuotas,
    Requirements: job_pb2.WorkerRequirements,
    Residual: registration_pb2.Residual,
    RolloutResult: REPLY,
    SessionInfo: session_pb2.Session,
    Share: key_pb2.Share,
    StoredBytes: usage_pb2.StoredBytes,
    Supplement: capture_pb2.Supplement,
    Timing: REPLY.Timing,
    Tracking: session_pb2.Tracking,
    Trashed: trash_pb2.TrashedResource,
    TwinInfo: twin_pb2.Twin,
    Worker: worker_pb2.Worker,
}


@pytest.mark.parametrize("kind", MESSAGES, ids=lambda kind: kind.__name__)
def test_a_resource_has_the_fields_of_its_message(kind):
    names = {field.name for field in MESSAGES[kind].DESCRIPTOR.fields}
    assert {field.name for field in fields(kind)} == {n.removesuffix("_json") for n in names}


@pytest.mark.parametrize(
    ("arguments", "message", "beside"),
    [
        # The digest is of the archive, which is packed on the way.
        (CaptureArguments, capture_pb2.CaptureMetadata, {"digest"}),
        (CaptureListArguments, capture_pb2.ListCapturesRequest, {"page_size", "page_token"}),
    ],
)
def test_arguments_are_the_fields_of_their_message(arguments, message, beside):
    names = {field.name.removesuffix("_json") for field in message.DESCRIPTOR.fields}
    assert get_type_hints(arguments).keys() == names - beside


def test_what_can_be_changed_of_a_capture_are_fields_of_it():
    names = {field.name for field in capture_pb2.Capture.DESCRIPTOR.fields}
    assert get_type_hints(CaptureLabelArguments).keys() - {"add_tags", "remove_tags"} <= names


def test_a_message_is_read_with_all_that_is_inside():
    message = fit_pb2.Fit(name="fits/1", capture="captures/1", tags=["b", "wet"], priority=-3)
    message.requirements.labels.append("gpu")
    job = message.job
    job.state, job.settings_json, job.revision = job_pb2.Job.FAILED, '{"seed": 7}', 9
    job.create_time.FromSeconds(60)
    job.fault.category, job.fault.reason = "NOT_FOUND", "GONE"
    job.attempt_faults.add(category="INTERNAL", message="again")
    job.progress.models.add(stage="search", loss=0.5)
    job.progress.best_loss = 0.0

    fit = Fit.from_proto(message)
    assert (fit.name, fit.twin, fit.tags, fit.priority) == ("fits/1", "", ("b", "wet"), -3)
    assert fit.requirements == Requirements(labels=("gpu",))
    assert (fit.state, fit.job.settings, fit.error_m) == (JobState.FAILED, {"seed": 7}, None)
    assert fit.job.create_time == datetime(1970, 1, 1, 0, 1, tzinfo=timezone.utc)
    assert fit.job.start_time is None
    assert fit.fault == Fault(Category.NOT_FOUND, "GONE", "")
    assert fit.job.attempt_faults == [Fault(Category.INTERNAL, "", "again")]
    assert (fit.progress.loss, fit.progress.best_loss, fit.progress.eta_s) == (None, 0.0, None)
    assert fit.progress.models == (ModelLoss("search", "", 0, 0.5, None),)

    message.error_m = 0.011
    assert Fit.from_proto(message).error_m == 0.011
    assert pickle.loads(pickle.dumps(fit)) == fit != Fit.from_proto(message)
    assert repr(fit).startswith("Fit(name='fits/1', capture='captures/1', twin='', job=Job(state=")


def test_a_word_of_an_enum_is_its_name():
    for fidelity in FIDELITIES:
        session = session_pb2.Session(name="sessions/1", fidelity=FIDELITIES[fidelity])
        assert SessionInfo.from_proto(session).fidelity == fidelity
    assert SessionInfo.from_proto(session_pb2.Session()).fidelity == "exact"
    assert SessionInfo.from_proto(session_pb2.Session(fidelity=77)).fidelity == "exact"


def test_arrays_and_pairs_are_read():
    message = REPLY(window=REPLY.Window(last_frame=3), cost_names=["tip"])
    message.positions.CopyFrom(pack_floats("positions", [[1.0, 2.0]], (1, 2)))
    result = RolloutResult.from_proto(message)
    assert (result.window, result.cost_names, result.costs.shape) == ((0, 3), ["tip"], (0,))
    np.testing.assert_array_equal(result.positions, [[1.0, 2.0]])
    assert (result.velocities, result.timing, result.mass_kg) == (None, None, None)


def test_what_a_message_leaves_out_has_its_default():
    capture = Capture.from_proto(capture_pb2.Capture(name="captures/1"))
    assert capture == Capture("captures/1", "", None, 0, "")
    assert Job.from_proto(job_pb2.Job(state=job_pb2.Job.QUEUED)).settings == {}


def test_aliases_of_types_are_read_as_what_they_stand_for():
    # NumPy's NDArray is one from 2.5 on, with Python 3.12.
    number = typing_extensions.TypeVar("number")
    alias = typing_extensions.TypeAliasType("alias", list[number], type_params=(number,))

    @dataclass
    class Read(FromMessage):
        slots: alias[int]

    assert Read.from_proto(SimpleNamespace(slots=(1, 2))).slots == [1, 2]
