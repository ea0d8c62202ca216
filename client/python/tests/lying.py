"""Depth of a twin's skin in the ground, with contact of its nodes and with that of its skin.

Lets go of the twin of a file 5 mm above the ground, and prints the deepest point in the last of 200
frames, and the farthest that a node moves in it: `python tests/lying.py TWIN...`
"""

import sys
from pathlib import Path

import numpy as np
from numpy_twin import Simulator, TwinFile, norm, skin


def lies(file, touches):
    file = file.without(skin=touches)
    # Control points hold nothing.
    held = (file["springs.ends"] >= len(file["nodes.rest_position"])).any(axis=1)
    tensors = {
        name: np.where(held, 0, file.tensors[name]).astype("<f4")
        for name in ("springs.stiffness", "springs.dashpot")
    }
    file.tensors.update(tensors)
    simulator = Simulator(file)
    ground = file.about["environment"]["ground"]
    normal = np.array(ground["normal"])

    def height(x):
        return (skin(file, x) @ normal - ground["offset_m"]).min(axis=-1)

    start = simulator.rest + (0.005 - height(simulator.rest[None])[0]) * normal
    controls = np.repeat(file["controls.rest_position"][None], 201, axis=0)
    frames = simulator.roll_out(controls, start)
    return -height(frames).min(), -height(frames[-1:])[0], norm(frames[-1] - frames[-2]).max()


if __name__ == "__main__":
    for name in sys.argv[1:]:
        file = TwinFile.decode(Path(name).read_bytes())
        for touches in (False, True):
            most, depth, moves = lies(file, touches)
            of = "skin " if touches else "nodes"
            print(
                f"{Path(name).stem}, contact of {of}: {1e3 * depth:.2f} mm deep at the end, "
                f"{1e3 * most:.2f} mm at most, moves {1e6 * moves:.1f} um a frame"
            )
