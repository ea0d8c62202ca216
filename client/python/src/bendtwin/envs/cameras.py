"""Cameras of environments: where they are, and what is behind the scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.envs.body import Body
from bendtwin.simulation.pictures import looking

Array = npt.NDArray[np.floating[Any]]

#: Field of view of named cameras, radians.
_VIEW_RAD = 0.9


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A pinhole camera that stands still, or that a gripper carries."""

    #: Name in observations.
    name: str
    #: x, y, z [m] and a quaternion x, y, z, w, in the world or in the coordinates of its gripper;
    #: x to the right, y down, z forward.
    pose: npt.ArrayLike
    #: fx, fy, cx, cy in pixels.
    intrinsics: npt.ArrayLike
    width: int = 96
    height: int = 96
    #: What is seen where there is nothing: a colour [3] or an image [height, width, 3], uint8 sRGB,
    #: such as that of the recording without the object; None: a light grey.
    background: npt.ArrayLike | None = None
    #: The gripper that carries it.
    gripper: int | None = None

    def __post_init__(self) -> None:
        if np.shape(self.pose) != (7,) or np.shape(self.intrinsics) != (4,):
            raise ValueError(f"camera {self.name!r} needs a pose [7] and intrinsics [4]")

    @classmethod
    def looking(
        cls,
        name: str,
        eye: npt.ArrayLike,
        at: npt.ArrayLike,
        *,
        field_of_view_rad: float = _VIEW_RAD,
        width: int = 96,
        height: int = 96,
        **options: Any,
    ) -> Camera:
        """A camera that looks from a place at another, upright, with a field of view over the
        shorter side of its picture."""
        eye, at = np.asarray(eye, float), np.asarray(at, float)
        steep = abs(at[2] - eye[2]) >= 0.999 * np.linalg.norm(at - eye)
        up = np.array([0.0, 1.0, 0.0] if steep else [0.0, 0.0, 1.0])
        focal = 0.5 * min(width, height) / np.tan(0.5 * field_of_view_rad)
        return cls(
            name=name,
            pose=looking(eye, at, up),
            intrinsics=[focal, focal, 0.5 * (width - 1), 0.5 * (height - 1)],
            width=width,
            height=height,
            **options,
        )


def named(camera: str | Camera, body: Body, at: Array, radius_m: float, **size: int) -> Camera:
    """A camera by its name, for a scene of a radius around a place: "front", "side", "top", or
    "wrist", which the first gripper carries; a camera is returned unchanged."""
    if isinstance(camera, Camera):
        return camera
    away = radius_m / np.tan(0.5 * _VIEW_RAD)
    eyes = {"front": [0.0, -0.85, 0.65], "side": [0.85, 0.0, 0.65], "top": [0.0, 0.0, 1.0]}
    if camera in eyes:
        eye = at + away * np.array(eyes[camera])
        return Camera.looking(camera, eye, at, **size)
    if camera == "wrist":
        length = body.length_m
        eye = np.array([0.0, -0.25, 0.35]) * length
        return Camera.looking(camera, eye, np.zeros(3), gripper=0, **size)
    raise ValueError(
        f'there is no camera {camera!r}: give "front", "side", "top", "wrist" or a Camera'
    )


def chosen(
    cameras: Sequence[str | Camera], body: Body, at: Array, radius_m: float, **size: int
) -> list[Camera]:
    """Cameras by their names, which must differ."""
    found = [named(camera, body, at, radius_m, **size) for camera in cameras]
    if len({camera.name for camera in found}) != len(found):
        raise ValueError("the names of the cameras must differ")
    return found
