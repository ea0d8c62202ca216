"""Tables of LeRobot datasets: where an episode is, its rows, and its images."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.captures.robots.episode import Array, EpisodeFault
from bendtwin.captures.robots.images import Image, frames_at, image_of, needed


class Episode:
    """The rows of an episode that are used."""

    def __init__(
        self, folder: Path, number: int, start_s: float, end_s: float | None, every: int
    ) -> None:
        """
        Raises:
            EpisodeFault: If the dataset or the episode is not there, or nothing of it is chosen.
        """
        self.folder = folder
        self.number = number
        self.info: dict[str, Any] = _info(folder)
        self.name: str = f"{folder.resolve().name} {number}"
        if every < 1:
            raise EpisodeFault(f"every is {every}: give 1 or more")
        self.fps: float = float(self.info["fps"]) / every
        self._facts = _facts(folder, self.info, number)
        self._table = self._read()
        #: Rows of the whole episode.
        self.all_rows: int = self._table.num_rows
        times = self._times()
        last = np.inf if end_s is None else end_s
        tolerance = 0.25 / float(self.info["fps"])
        chosen = np.flatnonzero((times >= start_s - tolerance) & (times <= last + tolerance))
        #: Rows that are used, from 0.
        self.numbers: list[int] = [int(i) for i in chosen[::every]]
        if len(self.numbers) < 2:
            raise EpisodeFault(
                f"episode {number} lasts from {times[0]:.2f} to {times[-1]:.2f} s: choose start_s, "
                "end_s and every so that at least two rows remain"
            )
        self._seconds = times[self.numbers]

    def __len__(self) -> int:
        return len(self.numbers)

    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """Columns of numbers, by row."""
        found = {}
        for name, feature in self.info["features"].items():
            kind = str(feature.get("dtype", ""))
            is_table = len(feature.get("shape", ())) <= 1
            if is_table and kind.startswith(("float", "int")) and name in self._table.column_names:
                found[name] = self._column(name)
        return found

    def elements(self, column: str, elements: Sequence[int | str]) -> Array:
        """Elements of a column, by number or name, [rows, elements].

        Raises:
            EpisodeFault: If the column has no such elements.
        """
        feature = self.info["features"].get(column)
        if feature is None or column not in self._table.column_names:
            known = ", ".join(sorted(self.columns()))
            raise EpisodeFault(f"the dataset has no column {column!r}; it has {known}")
        names = _flat_names(feature.get("names"))
        values = self._column(column).astype(np.float64).reshape(len(self), -1)
        chosen = []
        for element in elements:
            if isinstance(element, str):
                if names.count(element) != 1:
                    raise EpisodeFault(f"{column} has no element {element!r}, but {names}")
                element = names.index(element)
            if not 0 <= element < values.shape[1]:
                count = values.shape[1]
                raise EpisodeFault(f"{column} has {count} elements ({names}), not {element}")
            chosen.append(values[:, element])
        return np.stack(chosen, axis=1)

    def rows_of(self, name: str, values: npt.ArrayLike) -> npt.NDArray[Any]:
        """Values that were given for every row of the episode, or of those that are used."""
        array = np.asarray(values)
        if array.ndim and len(array) == self.all_rows:
            return np.asarray(array[self.numbers])
        if array.ndim and len(array) == len(self):
            return array
        raise EpisodeFault(f"{name} has shape {array.shape}: the episode has {self.all_rows} rows")

    def images(self, feature: str) -> Iterator[Image]:
        """The images of a feature, one after the other.

        Raises:
            EpisodeFault: If the dataset has no such images, or they cannot be read.
        """
        facts = self.info["features"].get(feature)
        if facts is None:
            known = ", ".join(n for n, f in self.info["features"].items() if len(f["shape"]) > 1)
            raise EpisodeFault(f"the dataset has no images {feature!r}; it has {known}")
        if facts["dtype"] == "video":
            yield from self._of_video(feature)
            return
        if feature not in self._table.column_names:
            raise EpisodeFault(f"the table of episode {self.number} has no column {feature!r}")
        shape = tuple(facts["shape"])
        for row in self.numbers:
            value = self._table.column(feature)[row].as_py()
            if isinstance(value, dict):
                content = value.get("bytes") or self._beside(value.get("path"), feature)
                yield image_of(content, f"{feature} of row {row}")
            else:
                yield _array(feature, value, facts["dtype"], shape)

    def _beside(self, path: str | None, feature: str) -> bytes:
        file = (self.folder / (path or "")).resolve()
        if path is None or not file.is_relative_to(self.folder.resolve()) or not file.is_file():
            raise EpisodeFault(f"{feature} has neither bytes nor a file within the dataset: {path}")
        return file.read_bytes()

    def _of_video(self, feature: str) -> Iterator[Image]:
        prefix = f"videos/{feature}/"
        starts = {key: value for key, value in self._facts.items() if key.startswith(prefix)}
        number = self.number
        path = self.info["video_path"].format(
            video_key=feature,
            chunk_index=starts.get(f"{prefix}chunk_index", 0),
            file_index=starts.get(f"{prefix}file_index", 0),
            episode_chunk=number // int(self.info.get("chunks_size", 1000)),
            episode_index=number,
        )
        offset = float(starts.get(f"{prefix}from_timestamp", 0.0))
        reach_s = 0.6 / float(self.info["fps"])
        yield from frames_at(self.folder / path, (self._seconds + offset).tolist(), reach_s)

    def _column(self, name: str) -> npt.NDArray[Any]:
        return np.array([self._table.column(name)[row].as_py() for row in self.numbers])

    def _times(self) -> Array:
        if "timestamp" in self._table.column_names:
            times = np.array(self._table.column("timestamp").to_pylist(), dtype=np.float64)
            return times.reshape(len(times), -1)[:, 0]
        return np.arange(self.all_rows) / float(self.info["fps"])

    def _read(self) -> Any:
        parquet, compute = needed("pyarrow.parquet"), needed("pyarrow.compute")
        path = self.info["data_path"].format(
            chunk_index=self._facts.get("data/chunk_index", 0),
            file_index=self._facts.get("data/file_index", 0),
            episode_chunk=self.number // int(self.info.get("chunks_size", 1000)),
            episode_index=self.number,
        )
        file = self.folder / path
        if not file.is_file():
            raise EpisodeFault(f"{file} is missing: download the whole dataset")
        filters = compute.field("episode_index") == self.number
        table = parquet.read_table(file, filters=filters)
        if table.num_rows == 0:
            raise EpisodeFault(f"{file} has no rows of episode {self.number}")
        return table


def _info(folder: Path) -> dict[str, Any]:
    file = folder / "meta" / "info.json"
    if not file.is_file():
        raise EpisodeFault(f"{folder} is no LeRobot dataset: it has no meta/info.json")
    info: dict[str, Any] = json.loads(file.read_text())
    version = str(info.get("codebase_version", ""))
    if not version.startswith(("v2", "v3")):
        raise EpisodeFault(f"{folder} has version {version!r}: versions 2 and 3 are read")
    for key in ("fps", "features", "data_path"):
        if not info.get(key):
            raise EpisodeFault(f"{file} has no `{key}`")
    return info


def _facts(folder: Path, info: dict[str, Any], number: int) -> dict[str, Any]:
    """What version 3 says about where an episode is; version 2 has it in the names of files."""
    total = info.get("total_episodes")
    if number < 0 or (total is not None and number >= int(total)):
        raise EpisodeFault(f"there is no episode {number}: the dataset has {total}")
    if not str(info["codebase_version"]).startswith("v3"):
        return {}
    parquet, compute = needed("pyarrow.parquet"), needed("pyarrow.compute")
    for file in sorted((folder / "meta" / "episodes").glob("*/*.parquet")):
        rows = parquet.read_table(file, filters=compute.field("episode_index") == number)
        if rows.num_rows:
            facts: dict[str, Any] = rows.to_pylist()[0]
            return facts
    raise EpisodeFault(f"{folder}/meta/episodes has no episode {number}")


def _flat_names(names: Any) -> list[str]:
    """Names of the elements of a feature, a list or a dictionary of one."""
    if isinstance(names, dict):
        names = next(iter(names.values()), [])
    return [str(name) for name in names or []]


def _array(feature: str, value: Any, dtype: str, shape: tuple[int, ...]) -> Image:
    """An image that is stored as numbers."""
    try:
        array = np.asarray(value, dtype=np.dtype(dtype)).reshape(shape)
    except (TypeError, ValueError) as error:
        raise EpisodeFault(f"{feature} has no image of {dtype} and shape {shape}") from error
    return array[0] if array.ndim == 3 and array.shape[0] == 1 else array
