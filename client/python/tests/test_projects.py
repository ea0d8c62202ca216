"""Projects: made, listed, changed and deleted, by both clients."""

import asyncio

from fake import PROJECT, serve

from bendtwin import aio


def test_projects_are_made_listed_and_changed(client, fake):
    project = client.create_project("ropes", ["eve", "ada"])
    assert (project.name, project.display_name) == (PROJECT, "ropes")
    assert project.members == ("ada", "eve")
    assert client.project(PROJECT).members == ("ada",)
    names = [project.name for project in client.projects()]
    assert names == ["projects/0", "projects/1", "projects/2"]
    changed = client.update_project(PROJECT, add_members=["bob"], remove_members=["eve"])
    assert changed.members == ("bob",)
    sent = fake.update
    assert (sent.project.name, sent.project.display_name) == (PROJECT, "")
    assert (list(sent.add_members), list(sent.remove_members)) == (["bob"], ["eve"])
    assert list(sent.update_mask.paths) == []
    client.delete_project(PROJECT)
    assert fake.removed.name == PROJECT


def test_the_client_of_asyncio_has_the_same_calls(fake):
    server, address = serve(fake)

    async def main():
        async with aio.Client(address) as client:
            await client.update_project(PROJECT, display_name="all ropes")
            return [project.name async for project in client.projects()]

    try:
        assert len(asyncio.run(main())) == 3
    finally:
        server.stop(None)
    assert fake.update.project.display_name == "all ropes"
