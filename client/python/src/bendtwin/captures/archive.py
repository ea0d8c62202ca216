"""Captures and masks as files: folders are packed, archives are read in chunks."""

from __future__ import annotations

import tempfile
import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_CHUNK_BYTES = 256 * 1024
#: Contents that are compressed already: deflating them again costs time and saves nothing.
_PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".exr", ".mp4", ".mkv", ".avi")
_COMPRESSED = frozenset(
    (*_PICTURES, ".npz", ".zip", ".gz", ".zst", ".zstd", ".mcap", ".glb", ".pth")
)
#: Markers of motion capture, which a `.json` beside them may describe.
_MARKERS = frozenset((".c3d", ".csv", ".trc"))


@contextmanager
def archive_of(path: Path) -> Iterator[Path]:
    """The capture as one file: `path` itself, or a temporary ZIP archive.

    Of a folder, all regular files but hidden ones are packed, and motion capture (`.npz`, `.c3d`,
    `.csv`, `.trc`) with the `.json` that describes it, the same way every time: so the same files
    have the same digest, by which an upload that broke off is found again.
    """
    files = _parts_of(path)
    if files is None:
        path.stat()  # Missing files fail here, not in the middle of a call.
        yield path
        return
    with _zipped(f"{path.name}.zip", files) as archive:
        yield archive


@contextmanager
def masks_of(path: Path) -> Iterator[Path]:
    """Masks as one file: `path` itself, or a temporary ZIP archive with a folder `mask`.

    Of a folder that has a folder `mask` only that is packed; any other folder is packed under that
    name.
    """
    if not path.is_dir():
        path.stat()
        yield path
        return
    root = path / "mask" if (path / "mask").is_dir() else path
    if not root.resolve().is_relative_to(path.resolve()):
        raise ValueError(
            f"{root} is a link that leads out of {path}, and links are not followed: "
            "name the folder with the masks itself"
        )
    files = sorted(p for p in root.rglob("*") if _is_packed(p, root))
    if not files:
        raise FileNotFoundError(f"there are no masks in {path}")
    named = [(f"mask/{file.relative_to(root).as_posix()}", file) for file in files]
    with _zipped("masks.zip", named) as archive:
        yield archive


@contextmanager
def _zipped(name: str, files: list[tuple[str, Path]]) -> Iterator[Path]:
    """A temporary archive of that name with these files."""
    with tempfile.TemporaryDirectory(prefix="bendtwin-") as folder:
        archive = Path(folder) / name
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as zipped:
            for entry_name, file in files:
                # A fixed time, for the time of a file says nothing about its content.
                entry = zipfile.ZipInfo(entry_name)
                stored = file.suffix.lower() in _COMPRESSED
                entry.compress_type = zipfile.ZIP_STORED if stored else zipfile.ZIP_DEFLATED
                entry.file_size = file.stat().st_size  # Decides on the long form of its header.
                with file.open("rb") as source, zipped.open(entry, "w") as target:
                    while chunk := source.read(_CHUNK_BYTES):
                        target.write(chunk)
        yield archive


def _parts_of(path: Path) -> list[tuple[str, Path]] | None:
    """The files that a capture consists of, by their names in an archive; None if it is a file."""
    if path.is_dir():
        everything = list(path.rglob("*"))
        links = sorted(p.relative_to(path).as_posix() for p in everything if p.is_symlink())
        if links:
            message = f"{len(links)} links in {path} are not followed, and left out ({links[0]})"
            warnings.warn(message, stacklevel=5)
        files = sorted(p for p in everything if _is_packed(p, path))
        return [(file.relative_to(path).as_posix(), file) for file in files]
    suffix = path.suffix.lower()
    description = path.with_suffix(".json")
    if suffix != ".npz" and (suffix not in _MARKERS or not description.is_file()):
        return None
    if path.is_file() and not description.is_file():
        raise FileNotFoundError(f"{path.name} is motion capture, and needs {description} beside it")
    return [(file.name, file) for file in (description, path)]


def _is_packed(file: Path, root: Path) -> bool:
    hidden = any(part.startswith(".") for part in file.relative_to(root).parts)
    # Also of folders: what is behind a link may be no part of the recording.
    within = file.resolve() == root.resolve() / file.relative_to(root)
    return file.is_file() and within and not hidden


def chunks_of(content: Path | bytes) -> Iterator[bytes]:
    """The content of a file, or these bytes, in pieces."""
    if isinstance(content, bytes):
        for start in range(0, len(content), _CHUNK_BYTES):
            yield content[start : start + _CHUNK_BYTES]
        return
    with content.open("rb") as file:
        while chunk := file.read(_CHUNK_BYTES):
            yield chunk
