import asyncio
import json
import socket
import zipfile
from io import BytesIO

import numpy as np
import pytest
from fake import CAPTURE, FIT, TWIN

from bendtwin import (
    BendTwinError,
    Category,
    Client,
    FitFailed,
    IngestFailed,
    JobState,
    Motion,
    Requirements,
    aio,
)
from bendtwin.labels import texts
from bendtwin.v1 import job_pb2


def test_an_archive_is_uploaded_in_chunks(client, fake, tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(b"x" * 700_000)
    capture = client.upload_capture(path, request_id="once")
    assert (capture.name, capture.display_name, capture.size_bytes) == (CAPTURE, "rope", 700_000)
    assert fake.metadata.request_id == "once"
    assert fake.uploaded == path.read_bytes()


def test_a_folder_is_packed_the_same_way_every_time(client, fake, tmp_path):
    folder = tmp_path / "rope"
    (folder / "arrays").mkdir(parents=True)
    (folder / "capture.json").write_text("{}")
    (folder / "arrays" / "points.npy").write_bytes(b"123")
    client.upload_capture(folder)
    first = fake.uploaded
    client.upload_capture(folder)
    assert fake.uploaded == first
    with zipfile.ZipFile(BytesIO(first)) as archive:
        assert archive.namelist() == ["arrays/points.npy", "capture.json"]


def test_motion_capture_is_packed_with_its_description(client, fake, tmp_path):
    arrays = tmp_path / "DLO4.npz"
    arrays.write_bytes(b"arrays")
    with pytest.raises(FileNotFoundError, match=r"DLO4\.json"):
        client.upload_capture(arrays)
    (tmp_path / "DLO4.json").write_text('{"fps": 100}')
    (tmp_path / "DLO5.json").write_text("{}")
    assert client.upload_capture(arrays).display_name == "DLO4"
    with zipfile.ZipFile(BytesIO(fake.uploaded)) as archive:
        assert archive.namelist() == ["DLO4.json", "DLO4.npz"]
        assert archive.read("DLO4.npz") == b"arrays"


@pytest.mark.parametrize("name", ["take.csv", "take.C3D", "take.trc"])
def test_markers_are_packed_with_a_description_beside_them(client, fake, tmp_path, name):
    (tmp_path / name).write_bytes(b"markers")
    client.upload_capture(tmp_path / name)
    assert fake.uploaded == b"markers"
    (tmp_path / "take.json").write_text('{"units": "mm"}')
    assert client.upload_capture(tmp_path / name).display_name == "take"
    with zipfile.ZipFile(BytesIO(fake.uploaded)) as archive:
        assert archive.namelist() == ["take.json", name]
        assert archive.read(name) == b"markers"


def test_lists_follow_pages(client):
    names = [c.name for c in client.captures()]
    assert names == [f"captures/{page}-{i}" for page in range(3) for i in range(2)]


def test_a_fit_is_waited_for_over_restarts_of_the_server(client, fake):
    seen = []
    fit = client.fit(CAPTURE, {"seed": 7}, priority=5)
    assert fake.fit_request.settings_json == '{"seed": 7}'
    assert fake.fit_request.request_id
    assert not fake.fit_request.HasField("requirements")
    ended = client.wait(fit, timeout_s=30, on_progress=lambda f: seen.append(f.job.revision))
    assert ended.state is JobState.SUCCEEDED
    assert ended.twin == TWIN
    assert seen == [1, 2, 3, 4]
    assert fake.watched_from == [0, 1, 2, 3]
    assert ended.progress.loss == 0.5
    assert ended.progress.eta_s is None


def test_a_fit_can_ask_for_a_worker(client, fake):
    requirements = Requirements(backend="cuda", memory_bytes=1 << 34, labels=("gpu=h100",))
    client.fit(CAPTURE, requirements=requirements)
    assert Requirements.from_proto(fake.fit_request.requirements) == requirements


def test_an_ingest_can_ask_for_a_worker(client, fake, tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(b"x")
    requirements = Requirements(backend="cpu", memory_bytes=1 << 30, labels=("disk=big",))
    client.upload_capture(path, ingest_requirements=requirements)
    assert Requirements.from_proto(fake.metadata.ingest_requirements) == requirements
    client.upload_capture(path)
    assert not fake.metadata.HasField("ingest_requirements")
    client.ingest_capture(CAPTURE, requirements=requirements)
    assert Requirements.from_proto(fake.ingest_request.requirements) == requirements


def test_who_recorded_a_capture_is_stated_and_changed(client, fake, tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(b"x")
    client.upload_capture(path, recorded_by="Ada")
    assert (fake.metadata.recorded_by, fake.metadata.display_name) == ("Ada", "rope")
    motion = Motion(np.zeros((2, 3, 3)), np.zeros((2, 1, 3)))
    client.upload_motion(motion, fps=30, recorded_by="Ada")
    assert (fake.metadata.recorded_by, fake.metadata.display_name) == ("Ada", "motion")
    client.update_capture(CAPTURE, recorded_by="")
    assert fake.update.update_mask.paths == ["recorded_by"]
    list(client.captures(recorded_by="Ada"))
    assert fake.listed.recorded_by == "Ada"
    assert texts({"recorded_by": "Ada", "ingest": {"spacing_m": 0.01}, "request_id": None}) == {
        "recorded_by": "Ada",
        "ingest": '{"spacing_m": 0.01}',
    }


def test_a_failed_fit_says_why(client, fake):
    fake.ends = job_pb2.Job.FAILED
    with pytest.raises(FitFailed, match="record again") as failure:
        client.wait(FIT, timeout_s=30)
    assert failure.value.reason == "CAPTURE_WITHOUT_POINTS"
    assert failure.value.category is Category.INVALID_ARGUMENT
    assert failure.value.fit.name == FIT


def test_a_capture_is_watched_until_it_is_read(client, fake, tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(b"x")
    capture = client.upload_capture(path, ingest={"spacing_m": 0.004})
    assert fake.metadata.ingest_json == '{"spacing_m": 0.004}'
    seen = []
    ended = client.wait_for_capture(
        capture, timeout_s=30, on_progress=lambda c: seen.append(c.ingest.revision)
    )
    assert (ended.ingest.state, ended.verdict) == (JobState.SUCCEEDED, "usable")
    assert seen == [1, 2, 3, 4]
    assert client.capture_report(CAPTURE) == {"verdict": "usable", "findings": []}
    client.save_capture_report(CAPTURE, tmp_path / "report.html")
    assert (tmp_path / "report.html").read_bytes() == b"<!doctype html>"
    client.export_observation(CAPTURE, tmp_path / "observation.zip")
    assert (tmp_path / "observation.zip").read_bytes() == b"PKpoints"


def test_a_capture_that_cannot_be_fitted_says_why(client, fake):
    fake.reads = job_pb2.Job.FAILED
    with pytest.raises(IngestFailed, match="segment it again") as failure:
        client.wait_for_capture(CAPTURE, timeout_s=30)
    assert failure.value.reason == "OBJECT_NOT_SEEN"
    assert client.ingest_capture(CAPTURE, {"spacing_m": 0.01}).ingest.state is JobState.QUEUED
    assert fake.ingest_request.settings_json == '{"spacing_m": 0.01}'
    assert client.cancel_ingest(CAPTURE).ingest.state is JobState.CANCELLED


def test_usage_is_that_of_the_key_or_of_all_owners(client):
    usage = client.usage()
    assert (usage.owner, usage.captures, usage.queued_jobs) == ("ada", 2, 1)
    assert (usage.stored_bytes.total, usage.stored_bytes.derived) == (300, 100)
    assert (usage.quotas.stored_bytes, usage.quotas.rollouts) == (1000, None)
    assert [owner.owner for owner in client.owner_usage()] == ["ada", "bob"]


def test_errors_carry_category_reason_and_request(client):
    with pytest.raises(BendTwinError, match="list twins") as failure:
        client.twin("twins/none")
    error = failure.value
    assert (error.category, error.reason) == (Category.NOT_FOUND, "TWIN_NOT_FOUND")
    assert error.request_id == "r-1"
    assert not error.category.is_transient


def test_a_method_that_the_server_lacks_is_an_error_too(client):
    with pytest.raises(BendTwinError) as failure:
        list(client.workers())
    assert failure.value.category is Category.INTERNAL


def test_no_server_is_unavailable():
    with Client("127.0.0.1:1") as client, pytest.raises(BendTwinError) as failure:
        client.capture(CAPTURE)
    assert failure.value.category is Category.UNAVAILABLE
    assert failure.value.category.is_transient


def test_a_twin_is_exported(client, tmp_path):
    client.export_twin(TWIN, tmp_path / "twin.safetensors")
    assert (tmp_path / "twin.safetensors").read_bytes() == b"safetensors"


def test_masks_are_added_to_a_capture_as_a_folder_an_archive_or_bytes(client, fake, tmp_path):
    case = tmp_path / "rope"
    (case / "mask" / "0" / "object").mkdir(parents=True)
    (case / "mask" / "0" / "object" / "0.png").write_bytes(b"png")
    (case / "color.png").write_bytes(b"not a mask")
    captured = client.add_masks(CAPTURE, case)
    assert (fake.supplement.name, fake.supplement.kind) == (CAPTURE, "masks")
    assert captured.masks
    assert [(s.kind, s.size_bytes) for s in captured.supplements] == [("masks", len(fake.uploaded))]
    # The folder of the masks itself is the same.
    for folder in (case, case / "mask"):
        client.add_masks(CAPTURE, folder)
        with zipfile.ZipFile(BytesIO(fake.uploaded)) as archive:
            assert archive.namelist() == ["mask/0/object/0.png"]
    (tmp_path / "masks.zip").write_bytes(b"an archive")
    client.add_masks(CAPTURE, tmp_path / "masks.zip")
    assert fake.uploaded == b"an archive"
    client.add_masks(CAPTURE, b"x" * 700_000)
    assert fake.uploaded == b"x" * 700_000
    (tmp_path / "empty").mkdir()
    for missing in ("empty", "nothing"):
        with pytest.raises(FileNotFoundError):
            client.add_masks(CAPTURE, tmp_path / missing)


def test_a_calibration_is_added_downloaded_and_removed(client, fake, tmp_path):
    document = {"format": "bendtwin-calibration", "version": 1, "cameras": []}
    path = tmp_path / "calibration.json"
    path.write_text(json.dumps(document))
    for given in (document, path, path.read_bytes()):
        client.add_calibration(CAPTURE, given)
        assert fake.supplement.kind == "calibration"
        assert json.loads(fake.uploaded) == document
    client.download_supplement(CAPTURE, "calibration", tmp_path / "out")
    assert (tmp_path / "out").read_bytes() == b"calibration"
    client.delete_supplement(CAPTURE, "calibration")
    assert (fake.removed.name, fake.removed.kind) == (CAPTURE, "calibration")


def test_masks_of_strokes_are_downloaded(client, fake, tmp_path):
    stroke = {"part": "object", "camera": 0, "points": [[120, 88]]}
    client.ingest_capture(CAPTURE, {"until": "masks", "strokes": [stroke]})
    assert json.loads(fake.ingest_request.settings_json)["strokes"] == [stroke]
    client.download_masks(CAPTURE, tmp_path / "masks.zip")
    assert (tmp_path / "masks.zip").read_bytes() == b"PKmasks"


def test_what_is_deleted_goes_to_the_trash_or_for_good(client, fake):
    for delete in (client.delete_capture, client.delete_fit, client.delete_twin):
        delete("x/0")
        assert (fake.deleted.name, fake.deleted.purge) == ("x/0", False)
        delete("x/0", purge=True)
        assert fake.deleted.purge


def test_the_trash_is_listed_and_restored_from(client, fake):
    names = [trashed.name for trashed in client.trashed_captures("ada")]
    assert names == ["captures/0-0", "captures/0-1", "captures/1-0", "captures/1-1"]
    assert fake.listed.owner == "ada"
    assert [trashed.name for trashed in client.trashed_fits()] == ["fits/0"]
    assert [trashed.name for trashed in client.trashed_twins()] == ["twins/0"]
    assert client.restore_capture(CAPTURE).name == CAPTURE
    assert client.restore_fit("fits/0").name == "fits/0"
    assert client.restore_twin("twins/0").name == "twins/0"
    assert fake.restored.name == "twins/0"


def test_a_client_may_have_a_deadline_for_all_calls():
    async def waiting(address):
        async with aio.Client(address, timeout_s=0.2) as client:
            await client.twin("twins/x")

    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"127.0.0.1:{silent.getsockname()[1]}"
        with Client(address, timeout_s=0.2) as client, pytest.raises(BendTwinError) as late:
            client.twin("twins/x")
        assert late.value.category is Category.DEADLINE_EXCEEDED
        with pytest.raises(BendTwinError) as late:
            asyncio.run(waiting(address))
        assert late.value.category is Category.DEADLINE_EXCEEDED
