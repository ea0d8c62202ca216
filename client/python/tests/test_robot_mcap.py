"""Parts of MCAP recordings of robots as captures."""

import json
import subprocess

import pytest
from server import BINARY, needs_server

pytest.importorskip("av")
pytest.importorskip("mcap_ros2")
from mcap.reader import make_reader
from robot_mcap import write_mcap
from robot_recordings import first

from bendtwin.captures.robots import EpisodeFault, McapGripper, from_mcap

pytestmark = needs_server
WAIT = 10
GRIPPER = McapGripper(frame="tcp", joints=["finger"], width_scale=1.0)


@pytest.fixture(scope="module")
def recording(filmed):
    """Ten frames in which the robot waits, and six with the rope."""
    made, file = first(filmed, 6), filmed.folder / "long.mcap"
    write_mcap(made, file, WAIT)
    return made, file


def topics(file):
    counts = {}
    with file.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            counts.setdefault(channel.topic, []).append(message.log_time)
    return counts


def test_an_episode_is_cut_out_with_its_calibration_and_its_gripper(recording, tmp_path):
    made, file = recording
    start_s = (WAIT - 0.5) / made.fps
    folder = from_mcap(file, tmp_path / "episode", grippers=[GRIPPER], start_s=start_s)
    before, after = topics(file), topics(folder / "recording.mcap")
    assert set(after) == set(before)
    assert after["/cam0/color/image_raw"] == before["/cam0/color/image_raw"][WAIT:]
    assert after["/tf_static"] == before["/tf_static"]
    assert len(after["/joint_states"]) == len(made)
    checked = subprocess.run([BINARY, "capture", "check", folder], capture_output=True, text=True)
    assert "gripper of gripper: grippers.json" in checked.stdout, checked
    assert "a raw recording of 2 cameras over 6 frames" in checked.stdout
    [gripper] = json.loads((folder / "grippers.json").read_text())["grippers"]
    assert gripper["poses"] == {"frame": "tcp"}
    assert gripper["widths"] == {"joints": ["finger"], "scale": 1.0, "offset_m": 0.0}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"grippers": []}, "at least one gripper"),
        ({"start_s": 100.0}, "no messages between 100.0 and None s"),
        ({"recording": "missing.mcap"}, "name an .mcap file"),
        ({"recording": "broken.mcap"}, "mcap recover"),
    ],
)
def test_what_cannot_be_cut_is_named_and_nothing_is_left(recording, tmp_path, change, said):
    _, file = recording
    (tmp_path / "broken.mcap").write_bytes(file.read_bytes()[:500])
    given = {"grippers": [GRIPPER]} | change
    source = tmp_path / given.pop("recording") if "recording" in given else file
    with pytest.raises(EpisodeFault, match=said):
        from_mcap(source, tmp_path / "out", **given)
    assert not (tmp_path / "out").exists()
    with pytest.raises(EpisodeFault, match="is there already"):
        from_mcap(file, tmp_path, grippers=[GRIPPER])
