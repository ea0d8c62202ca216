"""Episodes of LeRobot datasets (versions 2 and 3) as captures.

A dataset has the images of its cameras as videos or in its tables, and a table with a row for each
moment. What it lacks is stated by `EpisodeCamera` and `EpisodeGripper`. The episode becomes a raw
bundle (docs/formats/capture.md, sections 5 and 15).
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.captures.robots import dataset as tables
from bendtwin.captures.robots.depth import Depth, depth_of
from bendtwin.captures.robots.episode import (
    ROTATIONS,
    Array,
    EpisodeCamera,
    EpisodeFault,
    EpisodeGripper,
    matrices,
    posed,
    rows,
)
from bendtwin.captures.robots.images import PngWriter

#: Coefficients that a lens of Brown and Conrady may have.
_LENSES = (0, 4, 5, 8)
_TRAIN_SHARE = 0.7
_MASKS = (".png", ".jpg", ".jpeg")


@dataclass(frozen=True)
class _Made:
    """A gripper's poses in the cameras' world, and its widths, by row."""

    gripper: EpisodeGripper
    poses: Array
    widths: Array | None


def from_lerobot(
    dataset: str | PathLike[str],
    episode: int,
    out: str | PathLike[str],
    *,
    cameras: Sequence[EpisodeCamera],
    grippers: Sequence[EpisodeGripper],
    ground_m: float | None = 0.0,
    start_s: float = 0.0,
    end_s: float | None = None,
    every: int = 1,
) -> Path:
    """Writes an episode of a LeRobot dataset as a raw recording, and returns its folder.

    Args:
        dataset: The folder with `meta`, `data` and `videos`.
        episode: Number of the episode.
        out: Folder to write, which must not exist yet.
        cameras: Cameras to use, each with depth.
        grippers: Grippers that move the object.
        ground_m: Height of the table in the cameras' world, whose z points up; None: none.
        start_s: Time of the episode at which the recording starts: the object is then held.
        end_s: Time at which it ends; None: the end of the episode.
        every: Use every n-th row, as a twin needs no more than 30 frames a second.

    Raises:
        EpisodeFault: If something is missing or does not fit; the message says what to do.
    """
    folder = Path(out)
    if folder.exists():
        raise EpisodeFault(f"{folder} is there already: name another folder, or remove it")
    if not cameras or not grippers:
        raise EpisodeFault("give at least one camera and one gripper")
    found = tables.Episode(Path(dataset), episode, start_s, end_s, every)
    made = [_made(gripper, found) for gripper in grippers]
    folder.mkdir(parents=True)
    try:
        documents = [
            _camera(number, camera, found, made, folder) for number, camera in enumerate(cameras)
        ]
        _write(folder, found, documents, made, ground_m)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return folder


def _write(
    folder: Path,
    found: tables.Episode,
    cameras: list[dict[str, Any]],
    made: list[_Made],
    ground_m: float | None,
) -> None:
    ground = None if ground_m is None else {"normal": [0, 0, 1], "offset": float(ground_m)}
    train = max(1, round(_TRAIN_SHARE * len(found)))
    document = {
        "format": "bendtwin-capture",
        "version": 1,
        "name": found.name,
        "units": "m",
        "up_axis": "+z",
        "handedness": "right",
        "fps": found.fps,
        "ground": ground,
        "raw": {"frame_count": len(found), "train_frame_count": train, "cameras": cameras},
    }
    (folder / "capture.json").write_text(json.dumps(document, indent=1))
    grippers = []
    for number, one in enumerate(made):
        entry: dict[str, Any] = {
            "name": one.gripper.name,
            "poses": f"grippers/{number}_poses.npy",
            "axes": {"approach": one.gripper.approach, "opening": one.gripper.opening},
            "pad": {"length_m": one.gripper.pad[0], "breadth_m": one.gripper.pad[1]},
        }
        (folder / "grippers").mkdir(exist_ok=True)
        np.save(folder / entry["poses"], rows(one.poses))
        if one.widths is not None:
            entry["widths"] = f"grippers/{number}_widths.npy"
            np.save(folder / entry["widths"], one.widths)
        grippers.append(entry)
    document = {"format": "bendtwin-grippers", "version": 1, "grippers": grippers}
    (folder / "grippers.json").write_text(json.dumps(document, indent=1))


def _made(gripper: EpisodeGripper, found: tables.Episode) -> _Made:
    given = gripper.poses
    if isinstance(given, str):
        wanted = 3 + ROTATIONS[gripper.rotation]
        elements = list(gripper.elements)
        if len(elements) != wanted:
            raise EpisodeFault(
                f"gripper {gripper.name!r} has {len(elements)} elements: name {wanted}, "
                f"those of x, y, z and of the {gripper.rotation}"
            )
        poses = posed(gripper.name, found.elements(given, elements), gripper.rotation)
    else:
        stated = given(found.columns()) if callable(given) else found.rows_of("poses", given)
        poses = matrices(f"poses of {gripper.name!r}", stated)
        if len(poses) != len(found):
            raise EpisodeFault(f"gripper {gripper.name!r} has {len(poses)} poses, not {len(found)}")
    if gripper.base is not None:
        poses = matrices("base", gripper.base)[0] @ poses
    return _Made(gripper, poses, _widths(gripper, found))


def _widths(gripper: EpisodeGripper, found: tables.Episode) -> Array | None:
    if gripper.widths is None:
        return None
    if isinstance(gripper.widths, str):
        values = found.elements(gripper.widths, list(gripper.width_elements)).sum(axis=1)
    else:
        values = np.asarray(found.rows_of("widths", gripper.widths), dtype=np.float64)
    widths = gripper.width_offset_m + gripper.width_scale * values
    finite = widths[np.isfinite(widths)]
    if finite.size and (finite.min() < -0.01 or finite.max() > 1.0):
        raise EpisodeFault(
            f"widths of {gripper.name!r} are from {finite.min():.3g} to {finite.max():.3g} m: "
            "set width_scale and width_offset_m so that they are distances between the fingers"
        )
    return np.asarray(np.maximum(widths, 0.0))


def _camera(
    number: int,
    camera: EpisodeCamera,
    found: tables.Episode,
    made: list[_Made],
    folder: Path,
) -> dict[str, Any]:
    """Writes the images of a camera; returns what the bundle says about it."""
    depth = depth_of(camera, found.info)
    base = Path("cameras") / str(number)
    for kind in ("color", "depth"):
        (folder / base / kind).mkdir(parents=True)
    size = _write_images(found.images(camera.color), folder / base / "color", camera.color, None)
    depths = found.images(depth.feature)
    if _write_images(depths, folder / base / "depth", depth.feature, depth) != size:
        raise EpisodeFault(f"{depth.feature} and {camera.color} have images of different sizes")
    fx, fy, cx, cy = _intrinsics(camera)
    document: dict[str, Any] = {
        "name": camera.name or camera.color.rsplit(".", 1)[-1],
        "size": size,
        "intrinsics": {"fx": fx, "fy": fy, "cx": cx, "cy": cy},
        "color": f"{base.as_posix()}/color/{{frame:06}}.png",
        "depth": {
            "files": f"{base.as_posix()}/depth/{{frame:06}}.png",
            "unit_m": depth.written_unit_m,
        },
        **_pose(camera, made, folder, base),
    }
    if camera.distortion:
        coefficients = [float(c) for c in camera.distortion]
        document["distortion"] = {"model": "brown_conrady", "coefficients": coefficients}
    if camera.masks is not None:
        document["masks"] = {"object": [_masks(Path(camera.masks), found, folder, base)]}
    if camera.tracks is not None:
        document["tracks"] = _tracks(camera.tracks, found, folder, base)
    return document


def _write_images(
    images: Iterator[npt.NDArray[Any]], folder: Path, feature: str, depth: Depth | None
) -> list[int]:
    """Writes images; returns columns and rows."""
    writer, size = PngWriter(), [0, 0]
    for i, image in enumerate(images):
        if depth is not None:
            image = depth.written(image)
        elif image.ndim != 3 or image.dtype != np.uint8:
            raise EpisodeFault(f"{feature} has no colour: name the colour images as `color`")
        writer.write(folder / f"{i:06}.png", image)
        size = [image.shape[1], image.shape[0]]
    return size


def _intrinsics(camera: EpisodeCamera) -> list[float]:
    numbers = [float(x) for x in camera.intrinsics]
    if len(numbers) != 4 or not np.isfinite(numbers).all() or min(numbers[:2]) <= 0:
        raise EpisodeFault(f"intrinsics of {camera.color} are {numbers}: give fx, fy, cx, cy")
    if len(camera.distortion) not in _LENSES:
        count = len(camera.distortion)
        raise EpisodeFault(f"distortion of {camera.color} has {count} numbers: give 4, 5 or 8")
    return numbers


def _pose(camera: EpisodeCamera, made: list[_Made], folder: Path, base: Path) -> dict[str, Any]:
    [own] = matrices(f"pose of {camera.color}", camera.pose)
    if camera.on is None:
        rotation, translation = own[:3, :3].tolist(), own[:3, 3].tolist()
        return {"pose": {"rotation": rotation, "translation": translation}}
    carriers = [one for one in made if one.gripper.name == camera.on]
    if not carriers:
        names = ", ".join(one.gripper.name for one in made)
        raise EpisodeFault(f"{camera.color} is on {camera.on!r}: the grippers are {names}")
    np.save(folder / base / "poses.npy", carriers[0].poses @ own)
    return {"poses": f"{base.as_posix()}/poses.npy"}


def _tracks(
    tracks: tuple[npt.ArrayLike, npt.ArrayLike | None],
    found: tables.Episode,
    folder: Path,
    base: Path,
) -> dict[str, str]:
    """Writes the tracks of the rows that are used."""
    points = np.asarray(found.rows_of("tracks", tracks[0]), dtype=np.float32)
    if points.ndim != 3 or points.shape[2] != 2:
        raise EpisodeFault(f"tracks have shape {points.shape}: give pixels [rows, N, 2]")
    seen = np.isfinite(points).all(axis=2)
    if tracks[1] is not None:
        visible = np.asarray(found.rows_of("visibilities of tracks", tracks[1]), dtype=bool)
        if visible.shape != seen.shape:
            raise EpisodeFault(f"visibilities of tracks have shape {visible.shape}: {seen.shape}")
        seen &= visible
    names = {"points": "tracks.npy", "visible": "tracks_visible.npy"}
    for name, array in (("points", points), ("visible", seen)):
        np.save(folder / base / names[name], array)
    return {name: f"{base.as_posix()}/{file}" for name, file in names.items()}


def _masks(masks: Path, found: tables.Episode, folder: Path, base: Path) -> str:
    """Copies the masks of the rows that are used."""
    files = [file for file in masks.iterdir() if file.suffix.lower() in _MASKS]
    files.sort(key=lambda file: (len(file.stem), file.stem))
    if len(files) != found.all_rows:
        raise EpisodeFault(
            f"{masks} has {len(files)} masks: the episode has {found.all_rows} rows, give one each"
        )
    (folder / base / "object").mkdir()
    suffix = files[0].suffix
    for i, row in enumerate(found.numbers):
        shutil.copyfile(files[row], folder / base / "object" / f"{i:06}{suffix}")
    return f"{base.as_posix()}/object/{{frame:06}}{suffix}"
