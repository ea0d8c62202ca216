"""Links to twins: made, listed and revoked, by both clients."""

import asyncio

from fake import SHARE, TWIN, serve

from bendtwin import aio

PAGE = f"/#/shared/{TWIN.rpartition('/')[2]}?key=bt_1"


def test_links_are_made_listed_and_revoked(client, fake):
    made = client.share_twin(TWIN, display_name="the board", days=0.5, allow_export=True)
    sent = fake.update
    assert (sent.twin, sent.display_name, sent.ttl_s) == (TWIN, "the board", 43_200)
    assert sent.allow_export
    assert (made.share.name, made.share.twin) == (SHARE, TWIN)
    assert made.link.startswith("http://127.0.0.1:")
    assert made.link.endswith(PAGE)
    assert "bt_1" not in repr(made)
    names = [share.name for share in client.shares(TWIN)]
    assert names == ["shares/0", "shares/1", "shares/2"]
    client.delete_share(SHARE)
    assert fake.removed.name == SHARE


def test_the_client_of_asyncio_has_the_same_calls(fake):
    server, address = serve(fake)

    async def main():
        async with aio.Client(address) as client:
            made = await client.share_twin(TWIN)
            return made.link, [share.name async for share in client.shares(TWIN)]

    try:
        link, names = asyncio.run(main())
    finally:
        server.stop(None)
    assert link == f"http://{address}{PAGE}"
    assert (len(names), fake.update.ttl_s) == (3, 604_800)
