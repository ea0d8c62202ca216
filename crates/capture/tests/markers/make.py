"""Writes the C3D files in this folder with two independent writers: `pip install numpy c3d ezc3d`.

A rope of six markers that bends and a hand of three, 20 frames at 100 a second, in millimetres with z up;
the rope's third marker is hidden in frames 5 to 7.
"""

from pathlib import Path

import c3d
import ezc3d
import numpy as np

HERE = Path(__file__).parent
FRAMES = 20
LABELS = [f"rope{i + 1}" for i in range(6)] + [f"hand{i + 1}" for i in range(3)]
HIDDEN = range(5, 8)


def scene():
    points = np.zeros((FRAMES, 9, 3))
    for t in range(FRAMES):
        bend = 0.2 + 4 * t / FRAMES
        for i in range(6):
            angle = bend * 0.05 * i
            points[t, i] = [1000 * np.sin(angle) / bend, 100 + t, 500 + 1000 * (1 - np.cos(angle)) / bend]
        for i in range(3):
            points[t, 6 + i] = [10 * i, 90 + t, 510 + 5 * i]
    return points


def with_c3d(points):
    writer = c3d.Writer(point_rate=100, analog_rate=0)
    frames = []
    for t in range(FRAMES):
        rows = np.zeros((9, 5), np.float32)
        rows[:, :3] = points[t]
        if t in HIDDEN:
            rows[2] = [0, 0, 0, -1, 0]
        frames.append((rows, np.zeros((0, 0))))
    writer.add_frames(frames)
    writer.set_point_labels(LABELS)
    writer.set_screen_axis("+X", "+Z")
    with open(HERE / "c3d_package.c3d", "wb") as file:
        writer.write(file)


def with_ezc3d(points):
    file = ezc3d.c3d()
    parameters = file["parameters"]["POINT"]
    parameters["RATE"]["value"] = [100.0]
    parameters["LABELS"]["value"] = LABELS
    parameters["UNITS"]["value"] = ["mm"]
    data = np.ones((4, 9, FRAMES))
    data[:3] = points.transpose(2, 1, 0)
    data[:3, 2, HIDDEN.start : HIDDEN.stop] = np.nan
    file["data"]["points"] = data
    file.add_parameter("POINT", "X_SCREEN", ["+X"])
    file.add_parameter("POINT", "Y_SCREEN", ["+Z"])
    file.write(str(HERE / "ezc3d.c3d"))


if __name__ == "__main__":
    with_c3d(scene())
    with_ezc3d(scene())
