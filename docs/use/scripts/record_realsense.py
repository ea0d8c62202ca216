"""Records RealSense cameras into the folder that BendTwin reads.

    python record_realsense.py toy --seconds 6

Starts all connected cameras (or those given with --serial, in this order), the first as the master
of hardware synchronisation, and writes colour, depth aligned to colour, and metadata.json. Frames
that any camera missed are gaps, and the program says how many there are. Depth is in millimetres.
Needs `pip install pyrealsense2 opencv-python-headless`; the cameras need a sync cable to take
frames together.
"""

import argparse
import json
import queue
import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pyrealsense2 as rs

MASTER, SLAVE = 1, 2


class Camera:
    """A camera that is recording."""

    def __init__(self, index: int, serial: str, options: argparse.Namespace) -> None:
        self.index, self.serial = index, serial
        self.folder: Path = options.recording
        for kind in ("color", "depth"):
            (self.folder / kind / str(index)).mkdir(parents=True, exist_ok=True)
        self.pipeline, config = rs.pipeline(), rs.config()
        config.enable_device(serial)
        width, height, fps = options.width, options.height, options.fps
        config.enable_stream(rs.stream.depth, width, height, rs.format.z16, fps)
        config.enable_stream(rs.stream.color, width, height, rs.format.bgr8, fps)
        profile = self.pipeline.start(config)
        sensor = profile.get_device().first_depth_sensor()
        if sensor.supports(rs.option.inter_cam_sync_mode):
            sensor.set_option(rs.option.inter_cam_sync_mode, MASTER if index == 0 else SLAVE)
        self.depth_unit_m = sensor.get_depth_scale()
        lens = profile.get_stream(rs.stream.color).as_video_stream_profile().get_intrinsics()
        self.intrinsics = [[lens.fx, 0, lens.ppx], [0, lens.fy, lens.ppy], [0, 0, 1]]
        self.align = rs.align(rs.stream.color)
        # Images are written by another thread: a slow disk must not cost frames.
        self.images: queue.Queue = queue.Queue(maxsize=300)
        self.numbers: list[int] = []
        self.writer = threading.Thread(target=self.write)
        self.writer.start()

    def read(self, start_ms: float, fps: int) -> None:
        """Reads a frame and queues it under the number that its time gives."""
        frames = self.align.process(self.pipeline.wait_for_frames(5000))
        color, depth = frames.get_color_frame(), frames.get_depth_frame()
        number = round((color.get_timestamp() - start_ms) * fps / 1000)
        if number >= 0 and number not in self.numbers[-3:]:
            self.numbers.append(number)
            pair = np.asanyarray(color.get_data()).copy(), np.asanyarray(depth.get_data()).copy()
            self.images.put((number, *pair))

    def write(self) -> None:
        """Writes queued images until None comes."""
        while (item := self.images.get()) is not None:
            number, color, depth = item
            metres = depth * self.depth_unit_m
            millimetres = np.clip(np.round(metres * 1000), 0, 65535).astype(np.uint16)
            for kind, image in (("color", color), ("depth", millimetres)):
                cv2.imwrite(str(self.folder / kind / str(self.index) / f"{number:04}.png"), image)

    def stop(self) -> None:
        """Stops the camera, once all its images are written."""
        self.images.put(None)
        self.writer.join()
        self.pipeline.stop()


def main() -> None:
    """Records, and writes what the cameras say about themselves."""
    form = argparse.RawTextHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("recording", type=Path)
    parser.add_argument("--seconds", type=float, default=6)
    serial = "serial number of a camera; default: all cameras"
    parser.add_argument("--serial", action="append", help=serial)
    parser.add_argument("--width", type=int, default=848)
    parser.add_argument("--height", type=int, default=480)
    parser.add_argument("--fps", type=int, default=30)
    options = parser.parse_args()

    devices = rs.context().query_devices()
    connected = [device.get_info(rs.camera_info.serial_number) for device in devices]
    serials = options.serial or sorted(connected)
    if not serials:
        raise SystemExit("no RealSense camera is connected")
    cameras = [Camera(index, serial, options) for index, serial in enumerate(serials)]
    try:
        # Automatic exposure settles meanwhile.
        for _ in range(options.fps):
            frames = [camera.pipeline.wait_for_frames(5000) for camera in cameras]
        latest_ms = max(frame.get_color_frame().get_timestamp() for frame in frames)
        start_ms = latest_ms + 1000 / options.fps
        print("recording: hold the object still for a moment, then move it")
        end = time.monotonic() + options.seconds
        while time.monotonic() < end:
            for camera in cameras:
                camera.read(start_ms, options.fps)
    finally:
        for camera in cameras:
            camera.stop()

    count = 1 + max(max(camera.numbers, default=0) for camera in cameras)
    for camera in cameras:
        missing = count - len(camera.numbers)
        print(f"camera {camera.index} ({camera.serial}): {missing} of {count} frames are missing")
    metadata = {
        "intrinsics": [camera.intrinsics for camera in cameras],
        "serial_numbers": [camera.serial for camera in cameras],
        "WH": [options.width, options.height],
        "fps": options.fps,
        "frame_num": count,
        "up_axis": "+z",
    }
    (options.recording / "metadata.json").write_text(json.dumps(metadata, indent=1))
    print(f"wrote {options.recording}: calibrate it next (bendtwin capture calibrate)")


if __name__ == "__main__":
    main()
