"""Motion capture, sent as the two files that it consists of, to a real server."""

import json

import numpy as np
from server import needs_server, running

from bendtwin import Client, JobState

pytestmark = needs_server


def test_motion_capture_is_sent_with_its_description(tmp_path):
    frames, vertices = 6, 4
    points = np.zeros((1, frames, vertices, 3), np.float32)
    points[..., 0] = 0.1 * np.arange(vertices)
    points[..., 2] = 0.5 + 0.01 * np.arange(frames)[:, None]
    edges = [[0, 1], [1, 2], [2, 3]]
    np.savez(tmp_path / "DLO4.npz", train=points, edges=edges, controlled=[0, 3])
    description = {"fps": 100, "units": "m", "up_axis": "+z", "gravity": [0, 0, -9.81]}
    (tmp_path / "DLO4.json").write_text(json.dumps(description))
    with running(tmp_path) as address, Client(address) as client:
        capture = client.wait_for_capture(client.push_capture(tmp_path / "DLO4.npz"))
    assert (capture.display_name, capture.ingest.state) == ("DLO4", JobState.SUCCEEDED)
