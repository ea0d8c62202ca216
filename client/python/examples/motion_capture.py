"""Makes a capture of markers that a motion-capture system has tracked."""

import os

import numpy as np

from bendtwin import Client, Motion

FPS, FRAMES, MARKERS = 100, 60, 12
seconds = np.arange(FRAMES) / FPS

# A rope hangs from a hand that moves aside and back; each marker follows the one above it later.
late = 0.02 * np.arange(MARKERS)
points = np.zeros((FRAMES, MARKERS, 3))  # metres, z up
points[..., 0] = 0.05 * np.sin(2 * np.pi * np.clip(seconds[:, None] - late, 0.0, None))
points[..., 2] = 1.0 - 0.03 * np.arange(MARKERS)
hand = points[:, :1] + [0.0, 0.0, 0.03]
points[20:25, 4] = np.nan  # This marker was not seen for a while.

with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    joined = [[marker, marker + 1] for marker in range(MARKERS - 1)]
    motion = Motion(points, hand)
    capture = client.upload_motion(motion, fps=FPS, edges=joined, display_name="markers")
    capture = client.wait_for_capture(capture)
    report = client.capture_report(capture.name)
    print(f"{capture.display_name}: {capture.verdict}")
    for finding in report["findings"]:
        print(f"{finding['code']}: {finding['message']}")
    # From here on it is a capture like any other: client.fit(capture.name).
