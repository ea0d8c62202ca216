"""Names, notes and tags, lists by them, and the losses of fits."""

import asyncio
import base64
import hashlib

import numpy as np
import pytest
from fake import CAPTURE, FIT, TWIN, serve

from bendtwin import JobState, aio
from bendtwin.captures.uploads import Sender


def test_what_is_not_given_stays(client, fake):
    assert client.update_capture(CAPTURE, note="left hand").note == "left hand"
    assert list(fake.update.update_mask.paths) == ["note"]
    client.update_capture(CAPTURE, note="", tags=("wet",))
    assert list(fake.update.update_mask.paths) == ["note", "tags"]
    assert list(fake.update.capture.tags) == ["wet"]
    fit = client.update_fit(FIT, add_tags=["wet"], remove_tags=["dry"])
    assert (fit.name, fit.tags) == (FIT, ("blue", "wet"))
    assert list(fake.update.update_mask.paths) == []
    assert (list(fake.update.add_tags), list(fake.update.remove_tags)) == (["wet"], ["dry"])
    assert client.update_twin(TWIN, display_name="toy").info.display_name == "toy"


def test_lists_are_searched_and_ordered(client, fake):
    fits = list(client.fits(CAPTURE, state=JobState.RUNNING, search="rope", order_by="error"))
    assert [fit.name for fit in fits] == [FIT]
    asked = fake.listed
    assert (asked.capture, asked.search, asked.order_by) == (CAPTURE, "rope", "error")
    assert asked.state == JobState.RUNNING.value
    (twin,) = client.twins(tag="wet")
    assert (twin.info.error_m, fake.listed.tag) == (0.004, "wet")


def test_losses_are_arrays(client):
    (curve,) = client.fit_losses(client.get_fit(FIT))
    assert (curve.stage, curve.variant) == ("refine", "bending")
    assert curve.iterations.tolist() == [1, 2]
    np.testing.assert_array_equal(curve.losses, [np.nan, 0.5])
    # A server of an earlier version has no errors.
    np.testing.assert_array_equal(curve.errors_m, [np.nan, np.nan])


def test_what_a_running_fit_has_is_an_array(client, fake):
    preview = client.fit_preview(client.get_fit(FIT))
    assert fake.previewed == FIT
    assert (preview.stage, preview.iteration, preview.sequence) == ("refine", 3, 0)
    assert preview.frames.tolist() == [0, 9]
    np.testing.assert_array_equal(preview.positions, [[[0, 1, 2]], [[1, 1, 1]]])
    assert (preview.measure, preview.error_m, preview.baseline_m) == ("track", 0.008, 0.041)
    assert preview.held_back_m is None
    assert preview.create_time.timestamp() == 60


def test_the_client_of_asyncio_makes_the_same_calls(fake):
    server, address = serve(fake)

    async def main():
        async with aio.Client(address) as client:
            await client.update_fit(FIT, display_name="stiffer")
            assert fake.update.fit.display_name == "stiffer"
            twins = [twin async for twin in client.twins(order_by="name")]
            assert (len(twins), fake.listed.order_by) == (1, "name")
            assert (await client.fit_losses(FIT))[0].losses[1] == 0.5
            assert (await client.update_twin(TWIN, note="x")).name == TWIN

    asyncio.run(main())
    server.stop(None)


def test_facts_that_do_not_exist_are_refused(client, tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(b"content")
    wrong = {"recorded_bye": "Ada"}
    for upload in (client.upload_capture, client.push_capture):
        with pytest.raises(TypeError, match="recorded_bye"):
            upload(path, **wrong)
    with pytest.raises(TypeError, match="recorded_bye"):
        client.upload_motion(np.zeros((2, 3, 3)), fps=30.0, **wrong)


def test_the_order_of_facts_does_not_matter_to_a_push(tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(b"content")

    def sent(**facts):
        return Sender("127.0.0.1:1", path, facts)._metadata

    ingest, changed = {"spacing_m": 0.004, "a": 1}, {"a": 1, "spacing_m": 0.004}
    first = sent(display_name="rope", recorded_by="Ada", ingest=ingest)
    assert first == sent(ingest=changed, recorded_by="Ada", display_name="rope")
    keyed = sent(display_name="rope", recorded_by="Ada", request_id="key")
    assert keyed == sent(request_id="key", recorded_by="Ada", display_name="rope")


def test_the_request_id_of_a_push_tells_which_fact_a_text_is(tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(b"content")

    def key(**facts):
        pairs = dict(
            pair.split(" ") for pair in Sender("127.0.0.1:1", path, facts)._metadata.split(",")
        )
        return base64.b64decode(pairs["request_id"]).decode()

    named = key(display_name="rope")
    assert named != key(recorded_by="rope")
    assert named != key(display_name="rope", recorded_by="rope")
    # As clients of before made it.
    assert named == f"tus-{hashlib.sha256(b'contentrope').hexdigest()[:32]}"
