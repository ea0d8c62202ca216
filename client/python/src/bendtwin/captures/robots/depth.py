"""Depth of a LeRobot dataset: where it is, and what its numbers mean."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.captures.robots.episode import EpisodeCamera, EpisodeFault

#: Unit of depths that are not written as they were stored, metres; 16 bits reach to 13 m.
_OWN_UNIT_M = 0.0002
#: Codes of videos of depth: those of 12 bits.
_LAST_CODE = 4095
_WHAT_TO_RECORD = (
    "BendTwin places points by depth: record it beside colour and aligned to it, for example with "
    "`use_depth: true` of LeRobot's RealSense camera, as images of 16 bits or in a video of more "
    "than 8; or record with ROS 2 into MCAP"
)


@dataclass(frozen=True)
class Depth:
    """A feature with depth."""

    feature: str
    #: Metres for a stored 1; None: codes of a quantized video.
    unit_m: float | None
    #: Depths of the first and the last code, metres.
    range_m: tuple[float, float] = (0.0, 0.0)
    #: Metres that were added before the logarithm of codes; None for linear codes.
    shift_m: float | None = None
    #: Metres for a written 1.
    written_unit_m: float = _OWN_UNIT_M

    def written(self, image: npt.NDArray[Any]) -> npt.NDArray[np.uint16]:
        """The image to write, [rows, columns]; 0 is unknown.

        Raises:
            EpisodeFault: If it has 8 bits or colours.
        """
        if image.ndim == 3 and image.shape[2] == 1:
            image = image[:, :, 0]
        if image.ndim != 2 or image.dtype == np.uint8:
            raise EpisodeFault(
                f"{self.feature} has 8 bits or colours, which is too coarse. {_WHAT_TO_RECORD}"
            )
        if self.unit_m is not None and np.issubdtype(image.dtype, np.integer):
            if self.written_unit_m != self.unit_m:
                raise EpisodeFault(f"{self.feature} has integers: state its depth_unit_m")
            return np.asarray(np.clip(image, 0, 65535), dtype=np.uint16)
        metres = self._metres(image)
        known = np.isfinite(metres) & (metres > 0.0)
        codes = np.where(known, metres, 0.0) / self.written_unit_m
        return np.asarray(np.where(codes <= 65535, np.rint(codes), 0), dtype=np.uint16)

    def _metres(self, image: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
        numbers = image.astype(np.float64)
        if self.unit_m is not None:
            return np.asarray(numbers * self.unit_m)
        low, high = self.range_m
        share = numbers / _LAST_CODE
        if self.shift_m is None:
            metres = low + share * (high - low)
        else:
            first, last = np.log(low + self.shift_m), np.log(high + self.shift_m)
            metres = np.exp(first + share * (last - first)) - self.shift_m
        # The first code is also what was not measured.
        return np.asarray(np.where(numbers > 0, metres, 0.0))


def depth_of(camera: EpisodeCamera, info: dict[str, Any]) -> Depth:
    """The depth of a camera, as the dataset's `meta/info.json` describes it.

    Raises:
        EpisodeFault: If it has no depth; the message says what to record.
    """
    features = info["features"]
    name = camera.depth or _beside(camera.color, features)
    if name is None or name not in features:
        others = ", ".join(sorted(features))
        missing = f"has no feature {name!r}" if name else f"has no depth for {camera.color}"
        raise EpisodeFault(f"the dataset {missing} (it has {others}). {_WHAT_TO_RECORD}")
    feature = features[name]
    facts = {**(feature.get("video_info") or {}), **(feature.get("info") or {})}
    if "video.depth_max" in facts:
        return _quantized(name, facts)
    stated = {"m": 1.0, "mm": 0.001}.get(facts.get("depth_unit", ""))
    unit_m = camera.depth_unit_m or stated
    is_float = str(feature.get("dtype", "")).startswith("float") or stated == 1.0
    if is_float:
        return Depth(name, unit_m or 1.0)
    return Depth(name, unit_m or 0.001, written_unit_m=unit_m or 0.001)


def _quantized(name: str, facts: dict[str, Any]) -> Depth:
    """Depth in codes of 12 bits, as LeRobot's encoder of depth writes it."""
    low, high = float(facts["video.depth_min"]), float(facts["video.depth_max"])
    shift = float(facts.get("video.shift", 0.0)) if facts.get("video.use_log", True) else None
    if not 0.0 <= low < high or (shift is not None and low + shift <= 0.0):
        raise EpisodeFault(f"{name} has depths from {low} to {high} m: check meta/info.json")
    return Depth(name, None, (low, high), shift)


def _beside(color: str, features: dict[str, Any]) -> str | None:
    """The feature that is the depth of a colour feature by its name."""
    stem, _, last = color.rpartition(".")
    names = [f"{color}_depth", f"{color}.depth", f"{stem}.depth_{last}", f"{stem}.depth"]
    for word in ("rgb", "color", "image"):
        if word in last:
            names.append(f"{stem}.{last.replace(word, 'depth')}")
    return next((name for name in names if name in features), None)
