"""Motion capture as a capture: tracked points in, a bundle of docs/formats/capture.md out."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Motion:
    """A recorded motion: points of an object, and of the hand or gripper, by frame.

    A point that was not seen in a frame is NaN there, or False in `visible`.
    """

    #: Tracked points of the object, [T, P, 3]. Point p is the same spot in every frame.
    points: ArrayLike
    #: Points on the hand or gripper, [T, C, 3], in every frame.
    controls: ArrayLike | None = None
    #: [T, P]: whether a point was seen. Default: where it is finite.
    visible: ArrayLike | None = None
    #: Frames 0..n are fitted, the others only predicted. Default: the first 70 %.
    train_frames: int | None = None


def bundle(
    motions: Motion | Sequence[Motion],
    *,
    fps: float,
    name: str = "",
    units: str = "m",
    up_axis: str = "+z",
    ground: float | None = 0.0,
    edges: ArrayLike | None = None,
    rest_points: ArrayLike | None = None,
    pins: ArrayLike | None = None,
) -> bytes:
    """The bundle of some motions of one object, as the bytes of a ZIP archive.

    `ground` is its height along `up_axis`, in `units`; None means no ground. `edges` [E, 2] are
    pairs of points that are joined, `rest_points` [P, 3] the undeformed shape, `pins` [H, 2] pairs
    of a point and the control point that holds it. Equal motions give equal bytes.
    """
    recorded = [motions] if isinstance(motions, Motion) else list(motions)
    if not recorded:
        raise ValueError("there is no motion: give at least one")
    if len(up_axis) != 2 or up_axis[0] not in "+-" or up_axis[1] not in "xyz":
        raise ValueError(f"up_axis is {up_axis!r}: give +x, -x, +y, -y, +z or -z")
    arrays: dict[str, NDArray[Any]] = {}
    sequences: list[dict[str, Any]] = []
    for number, motion in enumerate(recorded):
        folder = f"sequences/{number:04}/" if len(recorded) > 1 else ""
        points = _points("points", motion.points)
        frames = len(points)
        seen = np.logical_and.reduce(np.isfinite(points), axis=2, dtype=np.bool_)
        if motion.visible is not None:
            visible = np.asarray(motion.visible, dtype=bool)
            if visible.shape != points.shape[:2]:
                raise ValueError(f"visible has shape {visible.shape}, not {points.shape[:2]}")
            seen = np.logical_and(seen, visible)
        arrays[f"{folder}object_points.npy"] = points
        arrays[f"{folder}object_visible.npy"] = seen
        if motion.controls is not None:
            controls = _points("controls", motion.controls)
            if len(controls) != frames:
                raise ValueError(f"controls has {len(controls)} frames, points has {frames}")
            arrays[f"{folder}control_points.npy"] = controls
        default = max(1, round(0.7 * frames))
        train = default if motion.train_frames is None else motion.train_frames
        sequences.append({"train_frame_count": int(train)})
        if folder:
            sequences[-1]["folder"] = folder.rstrip("/")
    for file, given in (("edges", edges), ("pins", pins)):
        if given is not None:
            arrays[f"{file}.npy"] = np.asarray(given, dtype="<u4").reshape(-1, 2)
    if rest_points is not None:
        arrays["rest_points.npy"] = np.asarray(rest_points, dtype="<f4").reshape(-1, 3)
    up = [0.0, 0.0, 0.0]
    up["xyz".index(up_axis[1])] = 1.0 if up_axis[0] == "+" else -1.0
    document: dict[str, Any] = {
        "format": "bendtwin-capture",
        "version": 1,
        "units": units,
        "up_axis": up_axis,
        "handedness": "right",
        "fps": float(fps),
        "ground": None if ground is None else {"normal": up, "offset": float(ground)},
        "sequences": sequences,
    }
    if name:
        document["name"] = name
    return _zipped({"capture.json": json.dumps(document).encode(), **_encoded(arrays)})


@contextmanager
def bundle_file(content: bytes) -> Iterator[Path]:
    """The bundle as a temporary file."""
    with tempfile.TemporaryDirectory(prefix="bendtwin-") as folder:
        path = Path(folder) / "motion.zip"
        path.write_bytes(content)
        yield path


def _points(name: str, given: ArrayLike) -> NDArray[np.float32]:
    points = np.asarray(given, dtype="<f4")
    if points.ndim != 3 or points.shape[2] != 3 or 0 in points.shape:
        raise ValueError(f"{name} has shape {points.shape}, not [frames, points, 3]")
    return points


def _encoded(arrays: dict[str, NDArray[Any]]) -> dict[str, bytes]:
    files = {}
    for file, array in arrays.items():
        out = io.BytesIO()
        np.save(out, np.ascontiguousarray(array))
        files[file] = out.getvalue()
    return files


def _zipped(files: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for file, content in files.items():
            # With a fixed time, so that equal motions have equal bytes.
            archive.writestr(zipfile.ZipInfo(file), content, zipfile.ZIP_DEFLATED, 1)
    return out.getvalue()
