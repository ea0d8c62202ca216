"""Images of an episode: decoded from videos and files, and written as PNG.

PyAV does both; it is imported when it is needed, and comes with the extra `recordings`.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.captures.robots.episode import EpisodeFault

Image = npt.NDArray[Any]

#: Images in colour are those with this many numbers a pixel.
_CHANNELS = 3
#: Formats of more than 8 bits with one channel: gray10le, gray12le, gray16be...
_WIDE_GRAY = ("gray9", "gray10", "gray12", "gray14", "gray16")


def needed(module: str) -> Any:
    """A package of the extra `recordings`.

    Raises:
        EpisodeFault: If it is not installed.
    """
    try:
        return __import__(module, fromlist=["_"])
    except ImportError as error:
        raise EpisodeFault(f"{module} is missing: pip install 'bendtwin[recordings]'") from error


def frames_at(file: Path, seconds: Sequence[float], reach_s: float) -> Iterator[Image]:
    """The images of a video nearest to increasing times, each within a reach.

    Raises:
        EpisodeFault: If the video cannot be read, or has no image within reach of a time.
    """
    av = needed("av")
    try:
        container = av.open(str(file))
    except (OSError, av.error.FFmpegError) as error:
        raise EpisodeFault(f"{file} cannot be read: {error}") from error
    with container:
        [stream, *_] = container.streams.video or [None]
        if stream is None:
            raise EpisodeFault(f"{file} has no video")
        stream.thread_type = "AUTO"
        start = max(seconds[0] - reach_s, 0.0)
        container.seek(int(start / stream.time_base), stream=stream)
        decoded = iter(container.decode(stream))
        nearest: Any = next(decoded, None)
        following: Any = next(decoded, None)
        for wanted in seconds:
            while following is not None and abs(following.time - wanted) <= abs(
                nearest.time - wanted
            ):
                nearest, following = following, next(decoded, None)
            if nearest is None or abs(nearest.time - wanted) > reach_s:
                raise EpisodeFault(f"{file} has no image at {wanted:.3f} s")
            yield _pixels(nearest)


def image_of(content: bytes, what: str) -> Image:
    """The pixels of an image file.

    Raises:
        EpisodeFault: If it cannot be read.
    """
    av = needed("av")
    try:
        with av.open(io.BytesIO(content)) as container:
            return _pixels(next(container.decode(video=0)))
    except (OSError, StopIteration, ValueError, av.error.FFmpegError) as error:
        raise EpisodeFault(f"{what} is no image that can be read: {error}") from error


def _pixels(frame: Any) -> Image:
    """Colour [rows, columns, 3] of 8 bits, or gray [rows, columns] of up to 16 or of floats."""
    name = frame.format.name
    if name.startswith("grayf32"):
        return np.asarray(frame.to_ndarray(), dtype=np.float32)
    if name.startswith(_WIDE_GRAY):
        return np.asarray(frame.to_ndarray(), dtype=np.uint16)
    if name in ("gray", "gray8", "monob", "monow", "pal8"):
        return np.asarray(frame.to_ndarray(format="gray"))
    return np.asarray(frame.to_ndarray(format="rgb24"))


class PngWriter:
    """Writes images of one size and kind as PNG."""

    def __init__(self) -> None:
        self._av = needed("av")
        self._context: Any = None

    def write(self, file: Path, image: Image) -> None:
        """Writes colour [rows, columns, 3] of 8 bits, or gray [rows, columns] of 16.

        Raises:
            EpisodeFault: If the size is not that of the first one.
        """
        is_color = image.ndim == _CHANNELS
        kind = "rgb24" if is_color else "gray16be"
        dtype = np.uint8 if is_color else np.uint16
        rows, columns = image.shape[:2]
        if self._context is None:
            self._context = self._av.codec.CodecContext.create("png", "w")
            self._context.width, self._context.height = columns, rows
            self._context.pix_fmt, self._context.time_base = kind, Fraction(1, 1)
        size = (self._context.height, self._context.width)
        if size != (rows, columns) or self._context.pix_fmt != kind:
            raise EpisodeFault(f"{file.name} has {columns} x {rows} pixels, the first has {size}")
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(image, dtype), format=kind)
        packets = self._context.encode(frame)
        file.write_bytes(b"".join(bytes(packet) for packet in packets))
