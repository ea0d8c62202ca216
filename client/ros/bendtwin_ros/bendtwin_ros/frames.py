"""Frames: where one coordinate system is in another, as TF answers it."""

from __future__ import annotations

from typing import Protocol

from bendtwin_ros.poses import Array


class MissingTransform(Exception):
    """TF does not know a transform; the message names the frames and says what to do."""


class Frames(Protocol):
    """Transforms by time."""

    def pose(self, target: str, source: str, at_ns: int) -> Array:
        """The pose [7] of frame `source` in frame `target` at a time, in nanoseconds; 0 means the
        latest.

        Raises:
            MissingTransform: If it is not known.
        """
