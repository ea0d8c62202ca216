"""What masks from clicks cost: errors of twins fitted with them, over errors with the true masks.

Films simulated objects, removes their masks, clicks once on the object and once on the hand in the
first frame of the first camera (at the middle of what the true masks show), and fits both:

    pip install ./client/python numpy pillow
    BENDTWIN_BIN=target/release/bendtwin python -m studies.clicked_masks toy:11 rope:12 ring:13

Each argument is a scene and its seed. A fit takes a minute on a GPU.
"""

from __future__ import annotations

import argparse
import json
import math
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from studies.lab import binary

_COLUMNS = [
    ("train", "track_m"),
    ("train", "chamfer_l1_m"),
    ("future", "track_m"),
    ("future", "chamfer_l1_m"),
]


def run(*words: object) -> str:
    """What a command of the program prints.

    Raises:
        subprocess.CalledProcessError: If it fails.
    """
    command = [str(word) for word in words]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def middle(mask: np.ndarray) -> tuple[int, int]:
    """Column and row of a pixel as far from the rim of a mask, shape [height, width], as any."""
    inner = np.pad(mask, 1)
    while True:
        left, right = inner[1:-1, :-2], inner[1:-1, 2:]
        smaller = np.zeros_like(inner)
        smaller[1:-1, 1:-1] = inner[1:-1, 1:-1] & left & right & inner[:-2, 1:-1] & inner[2:, 1:-1]
        if not smaller.any():
            break
        inner = smaller
    pixels = np.argwhere(inner) - 1
    row, column = pixels[len(pixels) // 2]
    return int(column), int(row)


def errors(program: Path, case: Path, options: list[str]) -> list[float]:
    """Errors of a twin fitted to a recording [m]: of tracks and surfaces, in training and after."""
    document = json.loads(run(program, "eval", case, "--json", *options))
    scores: list[dict[str, Any]] = document["quality"]["scores"]
    bending = next(score for score in scores if score["predictor"] == "bending")
    return [bending[part][measure] for part, measure in _COLUMNS]


def ratios(program: Path, folder: Path, scene: str, seed: str, options: list[str]) -> list[float]:
    """Errors with clicked masks over those with true ones."""
    from PIL import Image

    true, clicked = folder / "true", folder / "clicked"
    run(program, "capture", "make", scene, true, "--raw", "--no-mesh", "--seed", seed)
    shutil.copytree(true, clicked)
    shutil.rmtree(clicked / "mask")
    clicks: list[str] = []
    for option, part in [("--object", "0"), ("--hand", "1")]:
        mask = np.asarray(Image.open(true / "mask" / "0" / part / "0.png").convert("L")) > 0
        column, row = middle(mask)
        clicks += [option, f"0:{column},{row}"]
    run(program, "capture", "mask", clicked, *clicks)
    with_true, with_clicked = (errors(program, case, options) for case in (true, clicked))
    return [c / t for c, t in zip(with_clicked, with_true, strict=True)]


def main() -> None:
    """Prints a row for each scene on the command line, and the geometric means."""
    parser = argparse.ArgumentParser(prog="python -m studies.clicked_masks")
    parser.add_argument("scenes", nargs="+", metavar="SCENE[:SEED]")
    parser.add_argument("--effort", help="draft, standard or best; default: as `bendtwin eval`")
    given = parser.parse_args()
    options = ["--effort", given.effort] if given.effort else []
    program = binary()
    print(f"{'scene':16}" + "".join(f"{part} {measure:14}" for part, measure in _COLUMNS))
    rows: list[list[float]] = []
    for name in given.scenes:
        scene, _, seed = name.partition(":")
        with tempfile.TemporaryDirectory() as folder:
            rows.append(ratios(program, Path(folder), scene, seed or "0", options))
        print(f"{name:16}" + "".join(f"{ratio:<20.3f}" for ratio in rows[-1]), flush=True)
    means = [
        math.exp(sum(math.log(row[k]) for row in rows) / len(rows)) for k in range(len(_COLUMNS))
    ]
    print(f"{'mean':16}" + "".join(f"{mean:<20.3f}" for mean in means))


if __name__ == "__main__":
    main()
