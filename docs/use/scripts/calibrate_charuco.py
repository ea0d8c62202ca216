"""Poses of cameras by OpenCV, from a ChArUco board that all of them see in one frame.

    python calibrate_charuco.py toy --columns 7 --rows 5 --square 0.03 --marker 0.022

Reads toy/metadata.json and toy/color/CAMERA/NUMBER.png, prints the reprojection error of each
camera, and writes toy/calibrate.json: camera to world, in metres, with z = 0 on the board and z up.
`bendtwin capture calibrate` does the same without OpenCV, and with several frames.
Needs `pip install opencv-python-headless`, version 4.7 or later.
"""

import argparse
import json
from pathlib import Path

import cv2
import numpy as np


def image_of(folder: Path, frame: int) -> Path:
    """The image of a frame: frames are counted from the smallest number."""
    images = [path for path in folder.iterdir() if path.suffix.lower() in (".png", ".jpg", ".jpeg")]
    return sorted(images, key=lambda path: int("".join(c for c in path.stem if c.isdigit())))[frame]


def main() -> None:
    """Finds the board in every camera, and writes the poses."""
    form = argparse.RawTextHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("recording", type=Path)
    parser.add_argument("--frame", type=int, default=0)
    parser.add_argument("--columns", type=int, required=True, help="squares in a row")
    parser.add_argument("--rows", type=int, required=True)
    parser.add_argument("--square", type=float, required=True, help="side of a square [m]")
    parser.add_argument("--marker", type=float, required=True, help="side of a marker [m]")
    parser.add_argument("--dictionary", default="DICT_5X5_100")
    legacy = "the board was drawn before OpenCV 4.6"
    parser.add_argument("--legacy", action="store_true", help=legacy)
    options = parser.parse_args()

    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, options.dictionary))
    size = (options.columns, options.rows)
    board = cv2.aruco.CharucoBoard(size, options.square, options.marker, dictionary)
    board.setLegacyPattern(options.legacy)
    detector = cv2.aruco.CharucoDetector(board)
    metadata = json.loads((options.recording / "metadata.json").read_text())
    poses = []
    for camera, intrinsics in enumerate(metadata["intrinsics"]):
        lens = np.array(intrinsics)
        file = image_of(options.recording / "color" / str(camera), options.frame)
        image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
        corners, ids, _, _ = detector.detectBoard(image)
        count = 0 if ids is None else len(ids)
        if count < 6:
            raise SystemExit(f"camera {camera} sees {count} corners of the board: 6 are needed")
        places, pixels = board.matchImagePoints(corners, ids)
        _, turn, shift = cv2.solvePnP(places, pixels, lens, None)
        turn, shift = cv2.solvePnPRefineLM(places, pixels, lens, None, turn, shift)
        again, _ = cv2.projectPoints(places, turn, shift, lens, None)
        error = np.sqrt(np.mean(np.sum((again - pixels.reshape(again.shape)) ** 2, axis=-1)))
        print(f"camera {camera}: {count} corners, {error:.2f} px")
        world_to_camera = np.eye(4)
        world_to_camera[:3, :3], world_to_camera[:3, 3] = cv2.Rodrigues(turn)[0], shift[:, 0]
        # OpenCV's board has y down and z into the table: turned about x, z points up.
        up = np.diag([1.0, -1.0, -1.0, 1.0])
        poses.append((up @ np.linalg.inv(world_to_camera)).tolist())
    (options.recording / "calibrate.json").write_text(json.dumps(poses, indent=1))
    metadata["up_axis"] = "+z"
    (options.recording / "metadata.json").write_text(json.dumps(metadata, indent=1))


if __name__ == "__main__":
    main()
