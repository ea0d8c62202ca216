"""Names, notes and tags, lists by them, and the losses of fits."""

import asyncio

import numpy as np
from fake import CAPTURE, FIT, TWIN, serve

from bendtwin import JobState, aio


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
