"""Uploads a recording, waits for the verdict on it, and fits a twin.

python fit.py rope.zip
"""

import json
import os
import sys

from bendtwin import Client, Fit

path, *settings = sys.argv[1:]


def show(fit: Fit) -> None:
    """Shows how far the fit is."""
    progress = fit.job.progress
    if progress is not None:
        print(f"\r{progress.stage}: {progress.fraction:.0%} ", end="", file=sys.stderr)


with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    capture = client.wait_for_capture(client.upload_capture(path))
    print("the recording is", capture.verdict)
    # Settings are in docs/use/settings.md; without any, the recording decides.
    fit = client.fit(capture.name, json.loads(settings[0]) if settings else None)
    twin = client.twin(client.wait(fit, on_progress=show).twin)
    print(f"{twin.info.node_count} nodes and {twin.info.spring_count} springs")
    print(f"{1000 * (twin.info.error_m or 0.0):.1f} mm off where it was not fitted")
