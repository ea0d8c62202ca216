"""Episodes of LeRobot datasets as raw recordings."""

import dataclasses
import io
import json
import subprocess

import numpy as np
import pytest
from server import BINARY, needs_server

av = pytest.importorskip("av")
pytest.importorskip("pyarrow")
from robot_recordings import (  # noqa: E402
    cameras_of,
    first,
    states,
    write_lerobot,
    write_masks,
)

from bendtwin.captures.robots import EpisodeFault, EpisodeGripper, from_lerobot  # noqa: E402
from bendtwin.captures.robots.episode import matrices, posed, rows  # noqa: E402

pytestmark = needs_server
GRIPPER = EpisodeGripper(
    poses="observation.state", widths="observation.state", width_elements=["width"]
)


@pytest.fixture(scope="module")
def made(filmed):
    """The first frames of a filmed rope, with its masks."""
    cut = first(filmed, 6)
    write_masks(cut, filmed.folder / "masks")
    return cut


@pytest.fixture(scope="module")
def dataset(made, tmp_path_factory):
    """A dataset of version 3 with images."""
    folder = tmp_path_factory.mktemp("dataset") / "images"
    write_lerobot(made, folder, depth="image")
    return folder


def images(folder, document):
    """Colour and depth [mm] of the first camera."""
    camera = document["raw"]["cameras"][0]
    found = []
    for pattern, kind in ((camera["color"], "rgb24"), (camera["depth"]["files"], "gray16le")):
        files = sorted((folder / pattern).parent.iterdir())
        opened = [next(av.open(io.BytesIO(f.read_bytes())).decode(video=0)) for f in files]
        found.append(np.stack([frame.to_ndarray(format=kind) for frame in opened]).astype(float))
    return found[0], found[1] * camera["depth"]["unit_m"] * 1e3


def assert_same(found, true):
    """Compares poses, whose quaternions have either sign."""
    np.testing.assert_allclose(matrices("found", found), matrices("true", true), atol=1e-6)


@pytest.mark.parametrize(
    ("version", "depth"),
    [("v3.0", "video"), ("v2.1", "video"), ("v3.0", "image"), ("v2.1", "array")],
)
def test_every_kind_of_dataset_has_the_same_images_and_poses(made, tmp_path, version, depth):
    cut = first(made, 3) if depth == "array" else made
    write_lerobot(cut, tmp_path / "dataset", version=version, depth=depth)
    folder = from_lerobot(
        tmp_path / "dataset", 1, tmp_path / "out", cameras=cameras_of(cut), grippers=[GRIPPER]
    )
    document = json.loads((folder / "capture.json").read_text())
    assert document["fps"] == cut.fps
    assert document["raw"]["frame_count"] == len(cut)
    color, depths = images(folder, document)
    assert np.abs(color - cut.cameras[0]["color"]).mean() < (2.0 if depth == "video" else 1e-9)
    known = cut.cameras[0]["depth"] > 0
    # Steps of the logarithm are 1.6 mm at a metre.
    within = 1.0 if depth == "video" else 1e-9
    assert np.abs(depths - cut.cameras[0]["depth"])[known].max() <= within
    assert (depths[~known] == 0).all()
    poses = np.load(folder / "grippers" / "0_poses.npy")
    assert_same(poses, cut.poses)
    np.testing.assert_allclose(np.load(folder / "grippers" / "0_widths.npy"), 0.02, atol=1e-6)


def test_the_server_reads_what_is_written(made, dataset, tmp_path):
    masks = made.folder / "masks"
    cameras = [dataclasses.replace(c, tracks=None) for c in cameras_of(made, masks)]
    folder = from_lerobot(dataset, 1, tmp_path / "out", cameras=cameras, grippers=[GRIPPER])
    checked = subprocess.run(
        [BINARY, "capture", "check", folder], capture_output=True, text=True, check=False
    )
    assert "gripper of gripper: grippers.json" in checked.stdout, checked
    assert "a raw recording of 2 cameras over 6 frames" in checked.stdout


def test_a_part_of_an_episode_and_every_second_row(made, dataset, tmp_path):
    folder = from_lerobot(
        dataset,
        1,
        tmp_path / "out",
        cameras=cameras_of(made, made.folder / "masks"),
        grippers=[GRIPPER],
        start_s=1 / made.fps,
        end_s=5 / made.fps,
        every=2,
    )
    document = json.loads((folder / "capture.json").read_text())
    assert (document["fps"], document["raw"]["frame_count"]) == (made.fps / 2, 3)
    color, _ = images(folder, document)
    np.testing.assert_array_equal(color, made.cameras[0]["color"][1::2])
    poses = np.load(folder / "grippers" / "0_poses.npy")
    assert_same(poses, made.poses[1::2])
    masks = sorted((folder / "cameras" / "0" / "object").iterdir())
    truth = sorted((made.folder / "masks" / "0").iterdir())[1::2]
    assert [m.read_bytes() for m in masks] == [t.read_bytes() for t in truth]


def test_a_camera_on_a_gripper_moves_with_it(made, dataset, tmp_path):
    [camera, _] = cameras_of(made)
    camera = dataclasses.replace(camera, on="gripper", pose=[0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0])
    folder = from_lerobot(dataset, 1, tmp_path / "out", cameras=[camera], grippers=[GRIPPER])
    poses = np.load(folder / "cameras" / "0" / "poses.npy")
    # The gripper points down.
    expected = made.poses[:, :3] - [0.0, 0.0, 0.1]
    np.testing.assert_allclose(poses[:, :3, 3], expected, atol=1e-6)


def test_poses_may_be_given_or_computed_in_the_frame_of_the_robot(made, dataset, tmp_path):
    base = np.array([0.5, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0])
    inside = made.poses.copy()
    inside[:, :3] -= base[:3]

    def kinematics(columns):
        assert set(columns) == {"observation.state", "timestamp", "episode_index"}
        np.testing.assert_allclose(columns["observation.state"], states(made), atol=1e-6)
        return inside

    for i, poses in enumerate((inside, kinematics, matrices("all", inside))):
        gripper = EpisodeGripper(poses=poses, base=base)
        out = tmp_path / str(i)
        from_lerobot(dataset, 1, out, cameras=cameras_of(made)[:1], grippers=[gripper])
        found = np.load(out / "grippers" / "0_poses.npy")
        assert_same(found, made.poses)
        assert "widths" not in json.loads((out / "grippers.json").read_text())["grippers"][0]


def test_rotations_are_those_of_their_names():
    half = np.pi / 2
    quarter = posed("r", np.array([[0, 0, 0, 0, 0, half]]), "rotation_vector")
    for rotation, numbers in (
        ("roll_pitch_yaw", [0, 0, half]),
        ("quaternion_xyzw", [0, 0, np.sqrt(0.5), np.sqrt(0.5)]),
        ("quaternion_wxyz", [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]),
    ):
        found = posed("r", np.array([[0.0, 0, 0, *numbers]]), rotation)
        np.testing.assert_allclose(found, quarter, atol=1e-12)
    np.testing.assert_allclose(quarter[0, :3, :3] @ [1, 0, 0], [0, 1, 0], atol=1e-12)
    # First about x, then about the fixed y, then about the fixed z.
    x, y, z = (posed("r", np.eye(6)[3 + k][None], "rotation_vector")[0] for k in range(3))
    all_three = posed("r", np.array([[0, 0, 0, 1.0, 1.0, 1.0]]), "roll_pitch_yaw")
    np.testing.assert_allclose(all_three[0], z @ y @ x, atol=1e-12)


def test_poses_come_back_from_their_matrices_without_jumps():
    turns = np.linspace(0.0, 4.0 * np.pi, 60)[:, None] * np.array([0.36, 0.48, 0.8])
    placed = posed("r", np.concatenate([turns, turns], axis=1), "rotation_vector")
    placed[7, 0, 0] = np.nan
    found = rows(placed)
    known = np.arange(60) != 7
    np.testing.assert_allclose(matrices("m", found[known]), placed[known], atol=1e-9)
    assert np.isnan(found[7, 3:]).all()
    assert np.abs(np.diff(found[known, 3:], axis=0)).max() < 0.3


def test_a_dataset_without_depth_is_refused_with_what_to_record(made, tmp_path):
    write_lerobot(first(made, 2), tmp_path / "dataset", depth=None)
    with pytest.raises(EpisodeFault, match="use_depth: true") as fault:
        from_lerobot(
            tmp_path / "dataset", 1, tmp_path / "out", cameras=cameras_of(made), grippers=[GRIPPER]
        )
    assert "observation.images.cam0" in str(fault.value)
    assert not (tmp_path / "out").exists()


def refusal(made, dataset, out, camera=None, gripper=None, **more):
    cameras = [dataclasses.replace(cameras_of(made)[0], **(camera or {}))]
    grippers = [dataclasses.replace(GRIPPER, **(gripper or {}))]
    given = {"episode": 1, "cameras": cameras, "grippers": grippers} | more
    episode = given.pop("episode")
    with pytest.raises(EpisodeFault) as fault:
        from_lerobot(dataset, episode, out, **given)
    assert not out.exists()
    return str(fault.value)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"episode": 2}, "no episode 2"),
        ({"start_s": 9.0}, "lasts from 0.00 to 0.17 s"),
        ({"every": 0}, "every is 0"),
        ({"cameras": []}, "at least one camera"),
        ({"camera": {"color": "observation.images.top"}}, "no depth for observation.images.top"),
        ({"camera": {"depth": "observation.images.cam0"}}, "8 bits or colours"),
        ({"camera": {"color": "observation.state"}}, "no depth for observation.state"),
        ({"camera": {"intrinsics": [0, 1, 2, 3]}}, "give fx, fy, cx, cy"),
        ({"camera": {"distortion": [0.1, 0.2]}}, "give 4, 5 or 8"),
        ({"camera": {"pose": [0, 0, 0]}}, "[7] or [4, 4]"),
        ({"camera": {"on": "left"}}, "the grippers are gripper"),
        ({"camera": {"tracks": (np.zeros((6, 4, 3)), None)}}, "give pixels"),
        ({"gripper": {"poses": "action"}}, "no column 'action'"),
        ({"gripper": {"elements": [0, 1, 2]}}, "name 6"),
        ({"gripper": {"elements": ["x", "y", "z", "a", "b", "c"]}}, "no element 'a'"),
        ({"gripper": {"elements": [0, 1, 2, 3, 4, 9]}}, "has 7 elements"),
        ({"gripper": {"poses": np.zeros((3, 7))}}, "the episode has 6 rows"),
        ({"gripper": {"poses": np.zeros((6, 7))}}, "not of unit length"),
        ({"gripper": {"width_scale": 1000.0}}, "set width_scale"),
    ],
)
def test_what_does_not_fit_is_named_and_nothing_is_left(made, dataset, tmp_path, wrong, said):
    assert said in refusal(made, dataset, tmp_path / "out", **wrong)


def test_other_folders_are_no_datasets(made, dataset, tmp_path):
    (tmp_path / "empty").mkdir()
    assert "no meta/info.json" in refusal(made, tmp_path / "empty", tmp_path / "out")
    (tmp_path / "old" / "meta").mkdir(parents=True)
    (tmp_path / "old" / "meta" / "info.json").write_text('{"codebase_version": "v1.6"}')
    assert "versions 2 and 3" in refusal(made, tmp_path / "old", tmp_path / "out")
    with pytest.raises(EpisodeFault, match="is there already"):
        from_lerobot(dataset, 1, tmp_path, cameras=cameras_of(made), grippers=[GRIPPER])
