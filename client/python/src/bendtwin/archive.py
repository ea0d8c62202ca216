"""Captures as files: folders are packed, archives are read in chunks."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_CHUNK_BYTES = 256 * 1024


@contextmanager
def archive_of(path: Path) -> Iterator[Path]:
    """The capture as one ZIP file: `path` itself, or a temporary archive of the folder."""
    if not path.is_dir():
        path.stat()  # Missing files fail here, not in the middle of a call.
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="bendtwin-") as folder:
        archive = Path(folder) / f"{path.name}.zip"
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as zipped:
            for file in sorted(p for p in path.rglob("*") if p.is_file()):
                # A fixed time, so that the same folder gives the same bytes and the same digest.
                entry = zipfile.ZipInfo(file.relative_to(path).as_posix())
                entry.compress_type = zipfile.ZIP_DEFLATED
                with file.open("rb") as source, zipped.open(entry, "w") as target:
                    while chunk := source.read(_CHUNK_BYTES):
                        target.write(chunk)
        yield archive


def chunks_of(path: Path) -> Iterator[bytes]:
    """The file's content in pieces."""
    with path.open("rb") as file:
        while chunk := file.read(_CHUNK_BYTES):
            yield chunk
