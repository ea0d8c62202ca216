"""Recordings of robots as captures: episodes of LeRobot datasets, and MCAP.

from bendtwin.captures.robots import EpisodeCamera, EpisodeGripper, from_lerobot

folder = from_lerobot("my_dataset", 3, "episode", cameras=[...], grippers=[...])
capture = client.push_capture(folder)

Each writes a folder that `Client.push_capture` and `bendtwin capture mask` take
(docs/use/robot-recordings.md).
"""

from bendtwin.captures.robots.episode import (
    EpisodeCamera,
    EpisodeFault,
    EpisodeGripper,
    McapGripper,
)
from bendtwin.captures.robots.lerobot import from_lerobot
from bendtwin.captures.robots.mcap import from_mcap

__all__ = [
    "EpisodeCamera",
    "EpisodeFault",
    "EpisodeGripper",
    "McapGripper",
    "from_lerobot",
    "from_mcap",
]
