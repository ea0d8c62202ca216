"""Cameras and grippers of an episode, as people know them beside what was recorded."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bendtwin import rotations

Array = npt.NDArray[np.float64]
Rotation = Literal["quaternion_xyzw", "quaternion_wxyz", "rotation_vector", "roll_pitch_yaw"]

#: Numbers of a rotation.
ROTATIONS: dict[str, int] = {
    "quaternion_xyzw": 4,
    "quaternion_wxyz": 4,
    "rotation_vector": 3,
    "roll_pitch_yaw": 3,
}


class EpisodeFault(ValueError):
    """An episode that cannot become a capture; the message says what to record or to state."""


@dataclass(frozen=True, kw_only=True)
class EpisodeCamera:
    """A camera with colour and depth, and its calibration, which datasets do not have."""

    #: Feature of the dataset with its colour images: "observation.images.front".
    color: str
    #: Focal lengths and principal point of the images as recorded, pixels: fx, fy, cx, cy.
    intrinsics: Sequence[float]
    #: Pose of the camera (x right, y down, z forwards): in the world, or in the gripper named by
    #: `on`. x, y, z [m] and a quaternion x, y, z, w; or a matrix [4, 4].
    pose: npt.ArrayLike
    #: Feature with its depth, aligned to colour. None: the one whose name is that of `color` with
    #: `_depth`, `.depth` or `depth` in the place of its last word.
    depth: str | None = None
    #: Metres for a depth of 1. None: as the dataset states it, or 0.001 for integers and 1 for
    #: floats.
    depth_unit_m: float | None = None
    #: Coefficients of Brown and Conrady as OpenCV orders them, 4, 5 or 8; none: no distortion.
    distortion: Sequence[float] = ()
    #: Name of the gripper that carries the camera. None: the camera stands still.
    on: str | None = None
    #: Folder of masks of the object, an image for each row of the episode in the order of their
    #: numbers. None: they are made later.
    masks: str | PathLike[str] | None = None
    #: Tracks of a point tracker, which plain objects need: pixels x, y [rows, N, 2], and whether
    #: each point was seen [rows, N] (None: where it is finite). None: the server tracks.
    tracks: tuple[npt.ArrayLike, npt.ArrayLike | None] | None = None
    #: Name in the capture; empty: the last word of `color`.
    name: str = ""


@dataclass(frozen=True, kw_only=True)
class EpisodeGripper:
    """A gripper, its pose between the tips of its fingers, and its width."""

    name: str = "gripper"
    #: Column with its pose, "observation.state"; poses by row, [rows, 7] or [rows, 4, 4]; or a
    #: function that makes these of the columns of the episode, for datasets that have only joint
    #: positions (forward kinematics: `bendtwin.robots`).
    poses: str | npt.ArrayLike | Callable[[dict[str, npt.NDArray[Any]]], npt.ArrayLike]
    #: Elements of the column: x, y, z [m] and the rotation, as numbers from 0 or by the names that
    #: the dataset gives them.
    elements: Sequence[int | str] = (0, 1, 2, 3, 4, 5)
    rotation: Rotation = "rotation_vector"
    #: Column of the width between the fingers; widths by row, [rows]; or None: unknown.
    widths: str | npt.ArrayLike | None = None
    #: Elements of that column, whose sum is scaled.
    width_elements: Sequence[int | str] = (6,)
    #: Metres: `width_offset_m` plus `width_scale` times the sum.
    width_scale: float = 1.0
    width_offset_m: float = 0.0
    #: Pose of what the poses refer to (a robot's base) in the cameras' world; None: the same.
    base: npt.ArrayLike | None = None
    #: Axes of the poses that point out of the gripper, and along which the fingers open.
    approach: str = "+z"
    opening: str = "+y"
    #: Length and breadth of the part of a finger that touches, metres.
    pad: tuple[float, float] = (0.02, 0.02)


@dataclass(frozen=True, kw_only=True)
class McapGripper:
    """A gripper of an MCAP recording, by a frame of TF and joints."""

    #: Frame between the tips of the fingers.
    frame: str
    name: str = "gripper"
    #: Joints whose positions add up to the width; none: unknown.
    joints: Sequence[str] = ()
    #: Metres: `width_offset_m` plus `width_scale` times the sum.
    width_scale: float = 1.0
    width_offset_m: float = 0.0
    #: Topic of the joints, if several have joints of these names.
    topic: str | None = None
    approach: str = "+z"
    opening: str = "+y"
    pad: tuple[float, float] = (0.02, 0.02)


def matrices(name: str, poses: npt.ArrayLike) -> Array:
    """Poses [T, 7] or [T, 4, 4], or one of them, as matrices [T, 4, 4].

    Raises:
        EpisodeFault: If the shape is another one, or a quaternion is not of unit length.
    """
    array = np.asarray(poses, dtype=np.float64)
    if array.shape[-2:] == (4, 4) and array.ndim in (2, 3):
        return array.reshape(-1, 4, 4)
    if array.shape[-1:] != (7,) or array.ndim > 2:
        raise EpisodeFault(f"{name} has shape {array.shape}: give [7] or [4, 4], or rows of them")
    return posed(name, array.reshape(-1, 7), "quaternion_xyzw")


def posed(name: str, rows: Array, rotation: Rotation) -> Array:
    """Matrices [T, 4, 4] of rows of x, y, z and a rotation. Rows that are not finite stay so."""
    turns = rows[:, 3:]
    if turns.shape[1] != ROTATIONS[rotation]:
        count = 3 + ROTATIONS[rotation]
        raise EpisodeFault(f"{name} has {rows.shape[1]} elements: {rotation} needs {count}")
    if rotation == "rotation_vector":
        quaternions = rotations.exponential(turns)
    elif rotation == "roll_pitch_yaw":
        quaternions = rotations.of_angles(turns)
    else:
        order = [0, 1, 2, 3] if rotation == "quaternion_xyzw" else [1, 2, 3, 0]
        quaternions = turns[:, order]
        lengths = np.linalg.norm(quaternions, axis=1)
        if (np.abs(lengths - 1.0) > 0.05).any():
            raise EpisodeFault(f"{name} has quaternions that are not of unit length")
        quaternions = quaternions / lengths[:, None]
    placed = np.tile(np.eye(4), (len(rows), 1, 1))
    placed[:, :3, :3] = rotations.matrices(quaternions)
    placed[:, :3, 3] = rows[:, :3]
    return placed


def rows(placed: Array) -> Array:
    """Poses [T, 7] of matrices [T, 4, 4], as rollouts take them; unknown ones are NaN."""
    found = np.full((len(placed), 7), np.nan)
    known = np.isfinite(placed).all(axis=(1, 2))
    found[:, :3] = placed[:, :3, 3]
    quaternions = rotations.quaternions(placed[known, :3, :3])
    # Signs are chosen so that neighbours are near each other, and the first has w >= 0.
    for k in range(len(quaternions)):
        before = quaternions[k - 1] if k else np.array([0.0, 0.0, 0.0, 1.0])
        if quaternions[k] @ before < 0.0:
            quaternions[k] *= -1.0
    found[known, 3:] = quaternions
    return found
