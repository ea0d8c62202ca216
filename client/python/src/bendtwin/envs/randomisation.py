"""Domain randomisation: what differs between episodes besides the start and the goal."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin import rotations

Array = npt.NDArray[np.floating[Any]]
Range = tuple[float, float]

_FACTORS = ("stiffness", "damping", "bending", "friction", "mass")


@dataclass(frozen=True, kw_only=True)
class Randomisation:
    """Ranges from which each episode draws; None: nothing is drawn, and nothing differs.

    Factors of the twin's own parameters are those of `Vary`. They are drawn with even logarithms,
    all else evenly.
    """

    stiffness: Range | None = None
    damping: Range | None = None
    bending: Range | None = None
    friction: Range | None = None
    mass: Range | None = None
    #: Restitution of the ground, 0..1: no factor.
    ground_restitution: Range | None = None
    #: Displacement of each camera along each of its axes [m], and turn about each of them [rad], up
    #: to these.
    camera_m: float = 0.0
    camera_rad: float = 0.0
    #: Factor of the field of view of cameras.
    field_of_view: Range | None = None
    #: Direction of the light: angle from the vertical, radians.
    light_rad: Range | None = None
    #: Share of even light, 0..1, and factor of all light, 0..4.
    ambient: Range | None = None
    brightness: Range | None = None
    #: Brightness of the backgrounds of cameras that have a colour or none, 0..255 in each channel.
    background: tuple[int, int] | None = None
    #: Change of the colours of obstacles in each channel, up to this, 0..255.
    colors: int = 0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not isinstance(value, tuple):
                continue
            if len(value) != 2 or not np.isfinite(value).all() or value[0] > value[1]:
                raise ValueError(
                    f"{field.name} is {value}: give the smallest and the largest value"
                )
            if field.name in (*_FACTORS, "field_of_view") and value[0] <= 0.0:
                raise ValueError(f"{field.name} is {value}: factors are above 0")

    @property
    def varied(self) -> tuple[str, ...]:
        """Fields of `Vary` that are drawn."""
        names = (*_FACTORS, "ground_restitution")
        return tuple(name for name in names if getattr(self, name) is not None)

    def factors(self, random: np.random.Generator) -> dict[str, float]:
        """Draws the values of `varied`."""
        drawn = {}
        for name in self.varied:
            low, high = getattr(self, name)
            if name in _FACTORS:
                drawn[name] = float(np.exp(random.uniform(np.log(low), np.log(high))))
            else:
                drawn[name] = float(random.uniform(low, high))
        return drawn

    def look(self, random: np.random.Generator, cameras: int, obstacles: int) -> Look:
        """Draws what pictures of an episode look like."""
        shift = random.uniform(-1.0, 1.0, (cameras, 3)) * self.camera_m
        turn = rotations.exponential(random.uniform(-1.0, 1.0, (cameras, 3)) * self.camera_rad)
        low, high = self.light_rad or (0.35, 0.35)
        slope, heading = random.uniform(low, high), random.uniform(-np.pi, np.pi)
        if self.light_rad is None:
            heading = 0.7
        light = [np.sin(slope) * np.cos(heading), np.sin(slope) * np.sin(heading), np.cos(slope)]
        background = self.background
        return Look(
            shift_m=shift,
            turn=turn,
            zoom=_even(random, self.field_of_view, 1.0, cameras),
            light=np.array(light),
            ambient=float(_even(random, self.ambient, 0.5, 1)[0]),
            brightness=float(_even(random, self.brightness, 1.0, 1)[0]),
            background=None
            if background is None
            else random.integers(background[0], background[1] + 1, (cameras, 3)),
            tint=random.integers(-self.colors, self.colors + 1, (obstacles, 3)),
        )


@dataclass(frozen=True)
class Look:
    """What pictures of one episode look like, for V cameras and O obstacles."""

    #: Displacements of cameras along their axes [V, 3], metres, and their turns [V, 4].
    shift_m: Array
    turn: Array
    #: Factors of fields of view [V].
    zoom: Array
    #: Direction of the light [3].
    light: Array
    ambient: float
    brightness: float
    #: Colours of backgrounds [V, 3]; None: those of the cameras.
    background: npt.NDArray[Any] | None
    #: Changes of colours of obstacles [O, 3].
    tint: npt.NDArray[Any]


def _even(random: np.random.Generator, of: Range | None, default: float, count: int) -> Array:
    return np.full(count, default) if of is None else random.uniform(of[0], of[1], count)
