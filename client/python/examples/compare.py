"""Compares the two newest twins of a recording: how far each is off, and what they disagree on."""

import os
import sys
from itertools import islice

import numpy as np

from bendtwin import Client, Returns

with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    newest = next(client.twins())
    twins = list(islice(client.twins(newest.info.capture), 2))
    if len(twins) < 2:
        sys.exit("fit the recording once more, with other settings")
    for twin in twins:
        stiffness = twin.geometry().spring_stiffness
        print(
            f"{twin.info.display_name}: {1000 * (twin.info.error_m or 0.0):.1f} mm off,"
            f" {twin.info.node_count} nodes, stiffness {np.median(stiffness):.2g}"
        )

    # The same motion of the hand. Points of the skin are those of the recording, in both twins.
    ends = []
    for twin in twins:
        geometry = twin.geometry()
        lifted = np.stack([geometry.controls, geometry.controls + np.array([0.0, 0.0, 0.1])])[None]
        state = twin.rollout(
            trajectories=lifted, frames=30, returns=Returns(final_state=True)
        ).state(0)
        ends.append(geometry.skin.positions(state.positions))
    apart = 1000 * np.linalg.norm(ends[0] - ends[1], axis=1)
    print(f"lifted by 10 cm they are {apart.mean():.1f} mm apart, {apart.max():.1f} mm at most")
