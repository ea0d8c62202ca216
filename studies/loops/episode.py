"""The record of an episode."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Literal

#: What the controller knows of the object while it moves: 20 % of its skin with 3 mm of noise,
#: nothing, or the state itself, which tells errors of planning from errors of seeing.
Variant = Literal["corrected", "open_loop", "known"]

#: Parts of a step, and all of it.
PARTS = ("correct", "plan", "advance", "step")


@dataclass
class Episode:
    """Course and end of an episode."""

    loop: str
    variant: Variant
    seed: int
    success: bool = False
    error_mm: float = float("nan")
    also: dict[str, float] = field(default_factory=dict)
    largest_strain: float = 0.0
    largest_force_n: float = 0.0
    corrections: int = 0
    refused_corrections: int = 0
    #: Steps in which the server called the object lost.
    lost: int = 0
    #: The error after each step.
    errors_mm: list[float] = field(default_factory=list)
    #: Reason of the server, if it ended the episode.
    ended_by: str = ""
    #: Seconds of every step, by part.
    latencies_s: dict[str, list[float]] = field(
        default_factory=lambda: {part: [] for part in PARTS}
    )

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        """Adds the time of what is done within."""
        began = time.monotonic()
        try:
            yield
        finally:
            self.latencies_s[part].append(time.monotonic() - began)
