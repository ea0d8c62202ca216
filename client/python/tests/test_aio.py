"""The client of asyncio, against the made-up server and against the real one."""

import asyncio
import inspect

import numpy as np
import pytest
from fake import CAPTURE, FIT, TWIN, serve

import bendtwin
from bendtwin import BendTwinError, Category, FitFailed, JobState, Returns, aio
from bendtwin.v1 import job_pb2


@pytest.fixture
def address(fake):
    server, address = serve(fake)
    yield address
    server.stop(None)


def run(address, work, **arguments):
    async def main():
        async with aio.Client(address, **arguments) as client:
            return await work(client)

    return asyncio.run(main())


def test_both_clients_have_the_same_methods():
    for kind in ("Client", "Twin", "Session"):
        ours, theirs = getattr(aio, kind), getattr(bendtwin, kind)
        names = {n for n in vars(theirs) if not n.startswith("_")}
        assert names == {n for n in vars(ours) if not n.startswith("_")}
        for name in names:
            signatures = [inspect.signature(getattr(c, name)) for c in (ours, theirs)]
            parameters = [
                [(p.name, p.kind, p.default) for p in s.parameters.values()] for s in signatures
            ]
            assert parameters[0] == parameters[1], name


def test_a_batch_comes_back_whole_and_in_parts(address):
    actions = np.arange(24, dtype=np.float32).reshape(2, 4, 1, 3) / 100

    async def work(client):
        twin = await client.twin(TWIN)
        result = await twin.rollout(trajectories=actions, returns=Returns(every_frames=1))
        parts = [part.first_instance async for part in twin.stream_rollout(trajectories=actions)]
        return result, parts

    result, parts = run(address, work)
    np.testing.assert_array_equal(result.positions[:, :, 0], actions[:, 1:, 0])
    assert parts == [0, 1]


def test_masks_are_added_and_downloaded(address, fake, tmp_path):
    (tmp_path / "case" / "mask").mkdir(parents=True)
    (tmp_path / "case" / "mask" / "0.png").write_bytes(b"png")

    async def work(client):
        added = await client.add_masks(CAPTURE, tmp_path / "case")
        await client.add_calibration(CAPTURE, {"format": "bendtwin-calibration"})
        await client.download_masks(CAPTURE, tmp_path / "masks.zip")
        return added

    assert run(address, work).supplements[0].kind == "masks"
    assert (fake.supplement.kind, fake.uploaded[:1]) == ("calibration", b"{")
    assert (tmp_path / "masks.zip").read_bytes() == b"PKmasks"


def test_calls_run_at_the_same_time(address):
    actions = np.zeros((1, 2, 1, 3), np.float32)

    async def work(client):
        twin = await client.twin(TWIN)
        calls = [twin.rollout(trajectories=actions + i) for i in range(8)]
        return [float(result.costs[0]) for result in await asyncio.gather(*calls)]

    np.testing.assert_allclose(run(address, work), np.sqrt(3) * np.arange(8), rtol=1e-6)


def test_a_capture_is_uploaded_listed_and_followed(address, fake, tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(b"x" * 700_000)

    async def work(client):
        capture = await client.upload_capture(path, request_id="once", ingest={"spacing_m": 0.01})
        names = [c.name async for c in client.captures()]
        read = await client.wait_for_capture(capture, timeout_s=30)
        report = await client.capture_report(CAPTURE)
        await client.export_observation(CAPTURE, tmp_path / "observation.zip")
        await client.export_twin(TWIN, tmp_path / "twin.safetensors")
        return capture, names, read, report

    capture, names, read, report = run(address, work)
    assert (capture.name, capture.display_name, capture.size_bytes) == (CAPTURE, "rope", 700_000)
    assert fake.uploaded == path.read_bytes()
    assert fake.metadata.request_id == "once"
    assert names == [f"captures/{page}-{i}" for page in range(3) for i in range(2)]
    assert (read.ingest.state, read.verdict) == (JobState.SUCCEEDED, "usable")
    assert fake.watched_from == [0, 1, 2, 3]
    assert report == {"verdict": "usable", "findings": []}
    assert (tmp_path / "observation.zip").read_bytes() == b"PKpoints"
    assert (tmp_path / "twin.safetensors").read_bytes() == b"safetensors"


def test_a_fit_is_watched_over_restarts_of_the_server(address, fake):
    seen = []

    async def work(client):
        fit = await client.fit(CAPTURE, {"seed": 7})
        return await client.wait(fit, timeout_s=30, on_progress=seen.append)

    ended = run(address, work)
    assert (ended.state, ended.twin) == (JobState.SUCCEEDED, TWIN)
    assert [f.job.revision for f in seen] == [1, 2, 3, 4]
    assert fake.fit_request.settings_json == '{"seed": 7}'
    fake.ends = job_pb2.Job.FAILED
    with pytest.raises(FitFailed, match="record again"):
        run(address, lambda client: client.wait(FIT, timeout_s=30))


def test_errors_carry_category_and_reason(address):
    with pytest.raises(BendTwinError, match="list twins") as failure:
        run(address, lambda client: client.twin("twins/none"))
    assert (failure.value.category, failure.value.reason) == (Category.NOT_FOUND, "TWIN_NOT_FOUND")
    assert failure.value.request_id == "r-1"
    with pytest.raises(BendTwinError) as failure:
        run("127.0.0.1:1", lambda client: client.capture(CAPTURE))
    assert failure.value.category is Category.UNAVAILABLE


def test_every_kind_of_call_shows_the_token(address, fake, tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(b"content")

    async def work(client):
        await client.upload_capture(path)
        await client.get_fit(FIT)
        await client.wait(FIT, timeout_s=30)

    run(address, work, token="secret")
    methods = {method for method, _ in fake.shown}
    assert {"CreateCapture", "GetFit", "WatchFit"} <= methods
    assert {shown for _, shown in fake.shown} == {"Bearer secret"}
