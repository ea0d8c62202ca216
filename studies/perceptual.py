"""LPIPS of the images that `bendtwin eval CAPTURE --pairs DIR` has written.

Prints the mean of each camera, model and span of frames, with the network of Alex, whose weights
the package fetches:

    pip install lpips pillow torch torchvision
    python -m studies.perceptual DIR
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import numpy as np

Distance = Callable[[np.ndarray, np.ndarray], float]


def alex() -> Distance:
    """LPIPS of two images of shape [height, width, 3], values in -1 to 1."""
    import lpips
    import torch

    network = lpips.LPIPS(net="alex").eval()

    def distance(recorded: np.ndarray, rendered: np.ndarray) -> float:
        images = [torch.from_numpy(i.transpose(2, 0, 1)[None].copy()) for i in (recorded, rendered)]
        with torch.no_grad():
            return float(network(*images))

    return distance


def means(folder: Path, distance: Distance) -> dict[str, float]:
    """Mean distance of the pairs in a folder, by the part of their names before the frame."""
    from PIL import Image

    distances = defaultdict(list)
    for path in sorted(folder.glob("camera*-*-*.png")):
        pair = np.asarray(Image.open(path).convert("RGB"), dtype=np.float32) / 127.5 - 1.0
        recorded, rendered = np.split(pair, 2, axis=1)
        distances[path.stem.rpartition("-")[0]].append(distance(recorded, rendered))
    return {name: float(np.mean(values)) for name, values in distances.items()}


def main() -> None:
    """Prints the table of the folder that is named on the command line."""
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for name, mean in means(Path(sys.argv[1]), alex()).items():
        print(f"{name:30} {mean:.4f}")


if __name__ == "__main__":
    main()
