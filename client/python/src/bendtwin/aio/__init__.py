"""The client for asyncio: the same methods as `bendtwin.Client`, to be awaited.

from bendtwin import aio

async with aio.Client("127.0.0.1:7070") as client:
    twin = await client.twin(name)
    result = await twin.rollout(trajectories=actions)
    async for part in twin.stream_rollout(trajectories=actions):
        part.costs
"""

from bendtwin.aio.client import Client
from bendtwin.aio.session import Session
from bendtwin.aio.twin import Twin

__all__ = ["Client", "Session", "Twin"]
