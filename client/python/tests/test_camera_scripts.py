"""The scripts of docs/use/scripts on made data: the programs that they call stand in for."""

import json
import runpy
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from types import ModuleType, SimpleNamespace

import cv2
import numpy as np
import pytest
from server import BINARY, needs_server

SCRIPTS = Path(__file__).parents[3] / "docs" / "use" / "scripts"
FRAMES = 12


def run(monkeypatch, script, *options):
    monkeypatch.setattr(sys, "argv", [script, *map(str, options)])
    runpy.run_path(str(SCRIPTS / script), run_name="__main__")


def check(recording):
    """Exit status and words of `bendtwin capture check`."""
    command = [BINARY, "capture", "check", recording]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


@pytest.fixture
def toy(tmp_path):
    """A made recording of two cameras, with its masks moved away."""
    case = tmp_path / "toy"
    made = ["capture", "make", "toy", case, "--raw", "--tiny", "--frames", str(FRAMES)]
    subprocess.run([BINARY, *made], check=True)
    (case / "mask").rename(tmp_path / "truth")
    return case


def truth(toy, camera, part, frame):
    """A mask as it should be."""
    root = toy.parent / "truth"
    names = json.loads((root / f"mask_info_{camera}.json").read_text())
    [folder] = [key for key, name in names.items() if (name == "hand") == (part == "hand")]
    return cv2.imread(str(root / str(camera) / folder / f"{frame}.png"), cv2.IMREAD_GRAYSCALE) > 0


def stand_in(monkeypatch, **modules):
    for name, content in modules.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name.replace("__", "."), module)


class Tensor:
    """The part of a tensor that the scripts use."""

    def __init__(self, array):
        self.array = array

    def __getitem__(self, index):
        return Tensor(self.array[index])

    def __gt__(self, number):
        return Tensor(self.array > number)

    def cpu(self):
        return self

    def numpy(self):
        return self.array


def frames_in(folder):
    """The number of frames in a folder of JPEG files that are named by number."""
    names = sorted(Path(folder).iterdir(), key=lambda path: int(path.stem))
    assert [int(path.stem) for path in names] == list(range(len(names)))
    assert all(path.read_bytes()[:2] == b"\xff\xd8" for path in names)
    return len(names)


@needs_server
def test_masks_of_sam_2_are_read(monkeypatch, toy):
    class Predictor:
        cameras = iter([0, 1])

        @classmethod
        def from_pretrained(cls, model):
            assert "sam2" in model
            return cls()

        def init_state(self, folder):
            return SimpleNamespace(frames=frames_in(folder), camera=next(self.cameras), parts=[])

        def add_new_points_or_box(self, state, frame_idx, obj_id, points, labels):
            assert frame_idx == 0
            assert points.shape == (1, 2)
            assert labels.tolist() == [1]
            state.parts.append(obj_id)

        def propagate_in_video(self, state):
            names = {1: "object", 2: "hand"}
            for frame in range(state.frames):
                seen = [truth(toy, state.camera, names[part], frame) for part in state.parts]
                scores = Tensor(np.stack(seen)[:, None].astype(np.float32) - 0.5)
                yield frame, state.parts, [scores[i] for i in range(len(seen))]

    stand_in(
        monkeypatch,
        torch={
            "inference_mode": nullcontext,
            "autocast": lambda *_, **__: nullcontext(),
            "bfloat16": None,
        },
        sam2={},
        sam2__sam2_video_predictor={"SAM2VideoPredictor": Predictor},
    )
    clicks = [f"--{part}={camera}:40,30" for camera in (0, 1) for part in ("object", "hand")]
    run(monkeypatch, "masks_sam2.py", toy, *clicks)
    status, said = check(toy)
    assert status == 0, said


@needs_server
def test_masks_of_sam_3_are_read(monkeypatch, toy):
    class Predictor:
        sessions = 0

        def handle_request(self, request):
            if request["type"] == "start_session":
                self.frames = frames_in(request["resource_path"])
                self.sessions += 1
                return {"session_id": str(self.sessions)}
            if request["type"] == "add_prompt":
                self.text = request["text"]
                return {"frame_index": 0, "outputs": {}}
            assert request == {"type": "close_session", "session_id": str(self.sessions)}
            return {"is_success": True}

        def handle_stream_request(self, request):
            assert request["type"] == "propagate_in_video"
            camera, part = (self.sessions - 1) // 2, "hand" if self.text == "hand" else "object"
            for frame in range(self.frames):
                mask = truth(toy, camera, part, frame)[None]
                yield {"frame_index": frame, "outputs": {"out_binary_masks": mask}}

    stand_in(monkeypatch, sam3={}, sam3__model_builder={"build_sam3_video_predictor": Predictor})
    run(monkeypatch, "masks_sam3.py", toy, "--object", "plush toy")
    status, said = check(toy)
    assert status == 0, said


@needs_server
def test_a_recording_of_realsense_cameras_is_read(monkeypatch, toy, tmp_path):
    images = {
        camera: [
            (
                cv2.imread(str(toy / "color" / str(camera) / f"{frame}.png")),
                depth_of(toy, camera, frame),
            )
            for frame in range(FRAMES)
        ]
        for camera in (0, 1)
    }
    metadata = json.loads((toy / "metadata.json").read_text())
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr("time.monotonic", lambda: clock.now)

    class Frame:
        def __init__(self, image, number):
            self.image, self.number = image, number

        def get_data(self):
            return self.image

        def get_timestamp(self):
            return 1e6 + self.number * 1000 / 30

    class Pipeline:
        def __init__(self):
            self.number = -31

        def start(self, config):
            self.camera = int(config.serial) - 100
            i = metadata["intrinsics"][self.camera]
            lens = SimpleNamespace(fx=i[0][0], fy=i[1][1], ppx=i[0][2], ppy=i[1][2])
            stream = SimpleNamespace(get_intrinsics=lambda: lens)
            sensor = SimpleNamespace(
                supports=lambda _: True, set_option=lambda *_: None, get_depth_scale=lambda: 0.001
            )
            return SimpleNamespace(
                get_device=lambda: SimpleNamespace(first_depth_sensor=lambda: sensor),
                get_stream=lambda _: SimpleNamespace(as_video_stream_profile=lambda: stream),
            )

        def wait_for_frames(self, _):
            self.number += 1
            # Both cameras are read once for each frame of the clock.
            clock.now = max(clock.now, self.number / 30)
            color, depth = images[self.camera][min(max(self.number, 0), FRAMES - 1)]
            return SimpleNamespace(
                get_color_frame=lambda: Frame(color, self.number),
                get_depth_frame=lambda: Frame(depth, self.number),
            )

        def stop(self):
            pass

    class Config:
        def enable_device(self, serial):
            self.serial = serial

        def enable_stream(self, stream, width, height, form, fps):
            assert [width, height] == metadata["WH"]

    devices = [SimpleNamespace(get_info=lambda _, s=serial: s) for serial in ("101", "100")]
    stand_in(
        monkeypatch,
        pyrealsense2={
            "pipeline": Pipeline,
            "config": Config,
            "align": lambda _: SimpleNamespace(process=lambda frames: frames),
            "context": lambda: SimpleNamespace(query_devices=lambda: devices),
            "stream": SimpleNamespace(color="color", depth="depth"),
            "format": SimpleNamespace(z16="z16", bgr8="bgr8"),
            "option": SimpleNamespace(inter_cam_sync_mode="sync"),
            "camera_info": SimpleNamespace(serial_number="serial"),
        },
    )
    case = tmp_path / "recorded"
    width, height = metadata["WH"]
    run(
        monkeypatch,
        "record_realsense.py",
        *(case, "--seconds", (FRAMES - 2) / 30, "--width", width, "--height", height),
    )
    written = json.loads((case / "metadata.json").read_text())
    assert written["serial_numbers"] == ["100", "101"]
    assert written["frame_num"] >= FRAMES - 2
    for camera in (0, 1):
        for kind in ("color", "depth"):
            names = sorted(path.name for path in (case / kind / str(camera)).iterdir())
            assert names == [f"{frame:04}.png" for frame in range(written["frame_num"])]
        stored = cv2.imread(str(case / "depth" / str(camera) / "0003.png"), cv2.IMREAD_UNCHANGED)
        assert (stored == images[camera][3][1]).all()
    # With calibration and masks it is whole.
    for name in ("calibrate.pkl", "calibrate.json"):
        if (toy / name).exists():
            (case / name).write_bytes((toy / name).read_bytes())
    written["up_axis"] = metadata.get("up_axis", "-z")
    (case / "metadata.json").write_text(json.dumps(written))
    said = check(case)[1]
    assert "NOT_CALIBRATED" not in said
    assert "docs/use/cameras.md#masks" in said


def depth_of(toy, camera, frame):
    """Depth of a made recording [mm]."""
    file = toy / "depth" / str(camera) / f"{frame}"
    if file.with_suffix(".npy").exists():
        return np.load(file.with_suffix(".npy")).astype(np.uint16)
    return cv2.imread(str(file.with_suffix(".png")), cv2.IMREAD_UNCHANGED)


def test_a_charuco_board_gives_poses(monkeypatch, tmp_path):
    (columns, rows), square = (7, 5), 0.03
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
    board = cv2.aruco.CharucoBoard((columns, rows), square, 0.022, dictionary)
    per_square = 120
    drawn = board.generateImage((columns * per_square, rows * per_square))
    lens = np.array([[600.0, 0, 423.5], [0, 600.0, 239.5], [0, 0, 1]])
    poses = []
    for camera, turn in enumerate([(0.5, 0.3, 0.2), (-0.4, 0.5, -0.3)]):
        # The board's axes: x right, y down, z away from who looks at it.
        rotation = cv2.Rodrigues(np.array(turn))[0]
        middle = np.array([columns * square / 2, rows * square / 2, 0])
        shift = np.array([0.01, -0.02, 0.6]) - rotation @ middle
        # Pixels of the drawing to metres: its first pixel's centre is half a pixel inside.
        scale = square / per_square
        metres = np.array([[scale, 0, 0.5 * scale], [0, scale, 0.5 * scale], [0, 0, 1]])
        to_image = lens @ np.column_stack([rotation[:, :2], shift]) @ metres
        image = cv2.warpPerspective(
            drawn, to_image, (848, 480), flags=cv2.INTER_AREA, borderValue=200
        )
        folder = tmp_path / "board" / "color" / str(camera)
        folder.mkdir(parents=True)
        cv2.imwrite(str(folder / "0000.png"), image)
        world_to_camera = np.eye(4)
        world_to_camera[:3, :3], world_to_camera[:3, 3] = rotation, shift
        poses.append(np.diag([1.0, -1, -1, 1]) @ np.linalg.inv(world_to_camera))
    metadata = {"intrinsics": [lens.tolist()] * 2, "WH": [848, 480], "fps": 30}
    (tmp_path / "board" / "metadata.json").write_text(json.dumps(metadata))
    size = ["--columns", columns, "--rows", rows, "--square", square, "--marker", 0.022]
    run(monkeypatch, "calibrate_charuco.py", tmp_path / "board", *size)
    found = np.array(json.loads((tmp_path / "board" / "calibrate.json").read_text()))
    assert np.abs(found[:, :3, 3] - np.array(poses)[:, :3, 3]).max() < 0.002
    assert np.abs(found[:, :3, :3] - np.array(poses)[:, :3, :3]).max() < 0.005
    # Cameras are above the board.
    assert (found[:, 2, 3] > 0.2).all()
