"""Rigid things that pictures show beside the object: obstacles, goals, grippers.

This file has what they are; `pictures` sends them to the server.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.simulation.world import Shape

Array = npt.NDArray[np.floating[Any]]

#: Colours (sRGB) of obstacles, goals, and open and closed grippers.
OBSTACLE = (150, 152, 160)
GOAL = (60, 200, 90)
OPEN, CLOSED = (70, 90, 120), (200, 80, 60)


@dataclass(frozen=True)
class Marker:
    """A thing at a place that depends on the goal. Markers are small, so that they hide little."""

    shape: Shape
    #: Poses [B, 7] of goals [B, D]; None: the origin.
    pose: Callable[[Array], Array] | None = None
    color: tuple[int, int, int] = GOAL
