"""The bending springs of the code that was published with the paper, written anew from its text.

python -m studies.reference_arm DIR/cases/*.zip

Two checks of `qqtt/model/diff_simulator/spring_mass_warp.py` (qiwang067/BendTwin at 9a7b3c2): the
forces of `eval_bending_forces` beside central differences of the energy k (theta - theta0)^2 / 2,
and the share of nodes that `compute_spring_angle_kernel` gives a bending spring, for the surface
points of cases in PhysTwin's layout, in the order of their file and joined as in `_init_start`.
"""

from __future__ import annotations

import argparse
import io
import pickle
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

RADIUS_M = 0.02
MOST_NEIGHBOURS = 30
SHARES = (1.0, 0.1, 0.05)
STEP = 1e-6

Array = NDArray[np.float64]


class Arrays(pickle.Unpickler):
    """Plain numpy arrays, and nothing that a pickle could run."""

    def find_class(self, module_name: str, global_name: str) -> Any:
        """A part of numpy that arrays are made of."""
        if module_name.split(".")[0] == "numpy" and global_name in {
            "_reconstruct",
            "_frombuffer",
            "ndarray",
            "dtype",
            "scalar",
        }:
            return super().find_class(module_name, global_name)
        raise pickle.UnpicklingError(f"{module_name}.{global_name} is no array")


def surface(path: Path) -> Array:
    """Tracked and completed points of a case in its first frame [m], shape [N, 3]."""
    with zipfile.ZipFile(path) as archive:
        name = next(n for n in archive.namelist() if n.endswith("final_data.pkl"))
        data = Arrays(io.BytesIO(archive.read(name))).load()
    points = np.concatenate([data["object_points"][0], data["surface_points"]]).astype(float)
    return points[np.isfinite(points).all(axis=1)]


def springs(points: Array) -> list[tuple[int, int]]:
    """Pairs of points that are joined, in the order in which they are found."""
    found: dict[tuple[int, int], tuple[int, int]] = {}
    for i, point in enumerate(points):
        distances = np.linalg.norm(points - point, axis=1)
        # The point itself counts as its nearest neighbour.
        for j in np.argsort(distances, kind="stable")[1:MOST_NEIGHBOURS]:
            if 1e-4 < distances[j] < RADIUS_M:
                found.setdefault((min(i, j), max(i, j)), (i, int(j)))
    return list(found.values())


def share_with_bending(points: Array) -> float:
    """Share of nodes with a bending spring.

    It stands between a node's first spring and its neighbour of lowest number, where these differ.
    """
    arm: dict[int, int] = {}
    reference: dict[int, int] = {}
    for ends in springs(points):
        for node, other in (ends, ends[::-1]):
            arm.setdefault(node, other)
            reference[node] = min(reference.get(node, other), other)
    return sum(arm[node] != reference[node] for node in arm) / len(points)


def energy(positions: Array, rest: float) -> float:
    """Energy of a triplet of unit stiffness: centre, arm, reference arm."""
    arm, reference = positions[1] - positions[0], positions[2] - positions[0]
    cosine = arm @ reference / np.linalg.norm(arm) / np.linalg.norm(reference)
    return 0.5 * float(np.arccos(cosine) - rest) ** 2


def published_forces(positions: Array, rest: float) -> Array:
    """Elastic forces on centre, arm and reference arm as the code adds them up."""
    arm, reference = positions[1] - positions[0], positions[2] - positions[0]
    arm_m, reference_m = np.linalg.norm(arm), np.linalg.norm(reference)
    u, v = reference / reference_m, arm / arm_m
    axis = np.cross(u, v)
    excess = np.arccos(u @ v) - rest
    axis /= np.linalg.norm(axis)
    on_arm = -excess / arm_m * np.cross(axis, v)
    on_reference = excess / reference_m * np.cross(u, axis)
    return np.stack([-on_arm - on_reference, on_arm, on_reference])


def gradient_forces(positions: Array, rest: float) -> Array:
    """Forces by central differences of the energy."""
    forces = np.zeros_like(positions)
    for index in np.ndindex(positions.shape):
        step = np.zeros_like(positions)
        step[index] = STEP
        ends = energy(positions + step, rest), energy(positions - step, rest)
        forces[index] = (ends[1] - ends[0]) / (2 * STEP)
    return forces


def main() -> None:
    """Print both checks."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("cases", nargs="*", type=Path, help="cases in PhysTwin's layout, as .zip")
    args = parser.parse_args()
    random = np.random.default_rng(0)
    off = {"arm": [0.0], "reference arm": [0.0], "reference arm, turned": [0.0], "torque": [0.0]}
    for _ in range(100):
        positions, rest = random.normal(size=(3, 3)), 1.0
        published, true = published_forces(positions, rest), gradient_forces(positions, rest)
        excess = abs(2 * energy(positions, rest)) ** 0.5
        torque = np.linalg.norm(np.cross(positions, published).sum(axis=0))
        size = max(1.0, float(np.abs(true).max()))
        off["arm"].append(float(np.abs(published[1] - true[1]).max()) / size)
        off["reference arm"].append(float(np.abs(published[2] - true[2]).max()) / size)
        off["reference arm, turned"].append(float(np.abs(published[2] + true[2]).max()) / size)
        off["torque"].append(abs(torque - 2 * excess))
    print("largest difference from central differences, 100 random triplets")
    for name in ("arm", "reference arm", "reference arm, turned"):
        print(f"  force on the {name}: {max(off[name]):.1e}")
    print(f"  |sum of torques| from 2 k |theta - theta0|: {max(off['torque']):.1e}")
    for share in SHARES if args.cases else ():
        found = []
        for path in args.cases:
            points = surface(path)
            count = int(share * len(points))
            kept = np.sort(np.random.default_rng(0).choice(len(points), count, replace=False))
            found.append(100 * share_with_bending(points[kept]))
        ends = f"{min(found):.0f} to {max(found):.0f}"
        print(f"nodes with a bending spring, r = {share}: {np.mean(found):.0f} % ({ends})")


if __name__ == "__main__":
    main()
