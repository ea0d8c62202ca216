"""The playback of a capture: small images of its cameras with their calibration, and the cameras
that take pictures from the same places.

The format is in docs/formats/playback.md. Images are decoded with Pillow
(`pip install "bendtwin[pictures]"`).
"""

from __future__ import annotations

import io
import json
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.rotations import quaternions
from bendtwin.simulation.pictures import PictureCamera

#: Images whose median is the background, evenly chosen.
MOST_IMAGES = 25
#: Samples of a pixel along each side where images are made smaller.
_SAMPLES = 3
#: Pixels around masks that are left out as well.
_MARGIN = 2
_BEFORE_HEAD = 16

_Image = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class PlaybackCamera:
    """A camera of a recorded sequence."""

    name: str
    #: Columns and rows of the recorded images, to which the intrinsics refer.
    size: tuple[int, int]
    #: fx, fy, cx, cy in pixels.
    intrinsics: tuple[float, float, float, float]
    #: `none`, `brown_conrady` or `kannala_brandt`, and its coefficients.
    distortion: tuple[str, tuple[float, ...]]
    #: From the camera to the world, [1, 3, 4], or [K, 3, 4] for a moving camera; empty if it is not
    #: calibrated.
    poses: npt.NDArray[np.float32]
    #: The K images as JPEG; empty where none was recorded.
    images: tuple[bytes, ...]
    #: Labels of the pixels of each image, run by run; empty where there are none.
    masks: tuple[bytes, ...]

    def picture_camera(self, width: int, height: int, *, background: bool = True) -> PictureCamera:
        """A camera of another size at the place of this one: the middle of its image, as large as
        fits, without distortion.

        The background is the median of its images, without what the masks label as object, hand or
        gripper. What no image shows free of these is filled from around it. A moving camera is that
        of its first image.

        Raises:
            ValueError: If the camera is not calibrated, or the background is asked for and there is
                no image.
        """
        if not len(self.poses):
            raise ValueError(f"camera {self.name} is not calibrated: add its calibration")
        scale = max(width / self.size[0], height / self.size[1])
        fx, fy, cx, cy = self.intrinsics
        left = (self.size[0] * scale - width) / 2
        top = (self.size[1] * scale - height) / 2
        own = (
            fx * scale,
            fy * scale,
            (cx + 0.5) * scale - 0.5 - left,
            (cy + 0.5) * scale - 0.5 - top,
        )
        pose = np.asarray(self.poses[0], float)
        return PictureCamera(
            width=width,
            height=height,
            intrinsics=own,
            pose=np.concatenate([pose[:, 3], quaternions(pose[:, :3])]),
            background=self._seen(self.empty_scene(), own, (width, height)) if background else None,
            name=self.name,
        )

    def empty_scene(self) -> _Image:
        """The median of the images, without what their masks label, [rows, columns, 3].

        Raises:
            ValueError: If there is no image.
        """
        there = [k for k, image in enumerate(self.images) if image]
        if not there:
            raise ValueError(f"camera {self.name} has no images")
        masked = [k for k in there if k < len(self.masks) and self.masks[k]]
        # In an image without a mask nobody knows where the object is.
        there = masked or there
        if len(self.poses) > 1:
            there = there[:1]
        chosen = {
            there[i * (len(there) - 1) // max(MOST_IMAGES - 1, 1)] for i in range(MOST_IMAGES)
        }
        images, free = [], []
        for k in sorted(chosen):
            image = _decoded(self.images[k])
            images.append(image)
            mask = self.masks[k] if k < len(self.masks) else b""
            free.append(_unlabelled(mask, image.shape[:2]))
        return _median(np.stack(images), np.stack(free))

    def _seen(self, image: _Image, intrinsics: tuple[float, ...], size: tuple[int, int]) -> _Image:
        """The image that a camera without distortion takes at the same place."""
        fx, fy, cx, cy = intrinsics
        width, height = size
        offsets = (np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5
        x = (np.add.outer(np.arange(width), offsets).ravel() - cx) / fx
        y = (np.add.outer(np.arange(height), offsets).ravel() - cy) / fy
        u, v = self._distorted(*np.meshgrid(x, y))
        # From pixels of the recorded images to those of the small ones.
        rows, columns = image.shape[:2]
        u = (u + 0.5) * columns / self.size[0] - 0.5
        v = (v + 0.5) * rows / self.size[1] - 0.5
        found = _interpolated(image, u, v)
        found = found.reshape(height, _SAMPLES, width, _SAMPLES, 3).mean((1, 3))
        return np.asarray(np.rint(found), np.uint8)

    def _distorted(
        self, x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Pixels of the recorded images where rays x, y, 1 are seen."""
        model, coefficients = self.distortion
        fx, fy, cx, cy = self.intrinsics
        square = x * x + y * y
        if model == "brown_conrady":
            k1, k2, p1, p2, k3, k4, k5, k6 = (*coefficients, *[0.0] * 8)[:8]
            radial = 1 + square * (k1 + square * (k2 + square * k3))
            radial = radial / (1 + square * (k4 + square * (k5 + square * k6)))
            x, y = (
                x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x),
                y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y,
            )
        elif model == "kannala_brandt":
            radius = np.sqrt(square)
            angle = np.arctan(radius)
            power = angle * angle
            k1, k2, k3, k4 = (*coefficients, *[0.0] * 4)[:4]
            bent = angle * (1 + power * (k1 + power * (k2 + power * (k3 + power * k4))))
            factor = np.where(radius > 1e-9, bent / np.maximum(radius, 1e-9), 1.0)
            x, y = x * factor, y * factor
        elif model != "none":
            raise ValueError(f"camera {self.name} has the unknown distortion {model}")
        return fx * x + cx, fy * y + cy


def playback_cameras(content: bytes, sequence: int = 0) -> list[PlaybackCamera]:
    """The cameras of a sequence in the content of a playback file.

    Raises:
        ValueError: If it is no playback, or has no such sequence.
    """
    if content[:8] != b"BENDPLAY":
        raise ValueError("this is no playback of a capture")
    version, length = (int.from_bytes(content[at : at + 4], "little") for at in (8, 12))
    if version != 1:
        raise ValueError(f"the playback has version {version}: a newer client reads it")
    data = memoryview(content)[_BEFORE_HEAD + length :]
    sequences = json.loads(content[_BEFORE_HEAD : _BEFORE_HEAD + length])["sequences"]
    if not 0 <= sequence < len(sequences):
        raise ValueError(f"sequence is {sequence}, and the playback has {len(sequences)}")
    return [_camera(camera, data) for camera in sequences[sequence]["cameras"]]


def _camera(head: dict[str, Any], data: memoryview) -> PlaybackCamera:
    def part(of: list[int]) -> memoryview:
        return data[of[0] : of[0] + of[1]]

    def pieces(of: dict[str, Any] | None) -> tuple[bytes, ...]:
        if of is None:
            return ()
        content, ends = part(of["bytes"]), np.cumsum([0, *of["lengths"]])
        return tuple(bytes(content[a:b]) for a, b in pairwise(ends))

    intrinsics, distortion = head["intrinsics"], head["distortion"]
    return PlaybackCamera(
        name=head["name"],
        size=(head["size"][0], head["size"][1]),
        intrinsics=(intrinsics["fx"], intrinsics["fy"], intrinsics["cx"], intrinsics["cy"]),
        distortion=(distortion["model"], tuple(distortion.get("coefficients", ()))),
        poses=np.frombuffer(part(head["poses"]), "<f4").reshape(-1, 3, 4),
        images=pieces(head["images"]),
        masks=pieces(head["masks"]),
    )


def _decoded(image: bytes) -> _Image:
    try:
        from PIL import Image
    except ModuleNotFoundError as error:
        advice = 'images of a playback need Pillow: pip install "bendtwin[pictures]"'
        raise ModuleNotFoundError(advice, name=error.name) from error
    return np.asarray(Image.open(io.BytesIO(image)).convert("RGB"))


def _unlabelled(mask: bytes, shape: tuple[int, int]) -> npt.NDArray[np.bool_]:
    """Where a mask has no label; everywhere without a mask."""
    if not mask:
        return np.ones(shape, bool)
    runs, value, shift = [], 0, 0
    for byte in mask:
        value |= (byte & 0x7F) << shift
        shift += 7
        if not byte & 0x80:
            runs.append(value)
            value, shift = 0, 0
    numbers = np.array(runs, np.int64)
    labels = np.repeat(numbers & 3, numbers >> 2)[: shape[0] * shape[1]].reshape(shape)
    free = np.pad(labels == 0, _MARGIN, constant_values=True)
    # Colours of what is labelled reach a little beyond it.
    moves = range(2 * _MARGIN + 1)
    parts = [free[i : i + shape[0], j : j + shape[1]] for i in moves for j in moves]
    return np.asarray(np.all(parts, axis=0))


def _median(images: npt.NDArray[np.uint8], free: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint8]:
    """The median of the free pixels; from around them where a pixel is never free."""
    known = free.any(axis=0)
    values = np.where(free[..., None], images, np.float32(np.nan))
    values[:, ~known] = 0
    median = np.asarray(np.nanmedian(values, axis=0), float)
    filled = _filled(median, np.asarray(known, float))
    return np.rint(np.clip(filled, 0, 255)).astype(np.uint8)


def _filled(
    colors: npt.NDArray[np.float64], weights: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Colours, multiplied by their weights 0..1, with those of coarser images where nothing is
    known."""
    rows, columns = weights.shape
    if rows * columns <= 1 or weights.min() >= 1:
        return colors / np.maximum(weights, 1e-9)[..., None]
    even = ((0, rows % 2), (0, columns % 2))
    quarters = (-(-rows // 2), 2, -(-columns // 2), 2)
    coarse = np.pad(colors, (*even, (0, 0))).reshape(*quarters, 3).sum((1, 3))
    total = np.pad(weights, even).reshape(quarters).sum((1, 3))
    most = np.maximum(total, 1.0)
    below = _filled(coarse / most[..., None], total / most)
    above = below.repeat(2, axis=0).repeat(2, axis=1)[:rows, :columns]
    return colors + (1 - weights[..., None]) * above


def _interpolated(
    image: _Image, u: npt.NDArray[np.float64], v: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Colours at places between pixels; those of the edge outside."""
    rows, columns = image.shape[:2]
    u, v = np.clip(u, 0, columns - 1), np.clip(v, 0, rows - 1)
    x, y = np.minimum(u.astype(int), columns - 2), np.minimum(v.astype(int), rows - 2)
    across, down = (u - x)[..., None], (v - y)[..., None]
    upper = image[y, x] * (1 - across) + image[y, x + 1] * across
    lower = image[y + 1, x] * (1 - across) + image[y + 1, x + 1] * across
    found: npt.NDArray[np.float64] = upper * (1 - down) + lower * down
    return found
