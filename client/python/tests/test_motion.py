"""Bundles of motion capture."""

import io
import json
import zipfile

import numpy as np
import pytest

from bendtwin import Motion
from bendtwin.captures.motion import bundle


def read(content):
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    document = json.loads(files.pop("capture.json"))
    return document, {name: np.load(io.BytesIO(file)) for name, file in files.items()}


def motion(frames=10):
    points = np.arange(frames * 6, dtype=float).reshape(frames, 2, 3)
    return Motion(points, controls=points[:, :1])


def test_one_motion_lies_beside_the_document():
    document, arrays = read(bundle(motion(), fps=50, name="rope", units="cm", up_axis="-y"))
    assert document["sequences"] == [{"train_frame_count": 7}]
    assert document["ground"] == {"normal": [0, -1, 0], "offset": 0}
    assert (document["fps"], document["units"], document["name"]) == (50, "cm", "rope")
    np.testing.assert_array_equal(arrays["object_points.npy"], motion().points)
    assert arrays["object_visible.npy"].all()
    assert arrays["control_points.npy"].shape == (10, 1, 3)


def test_several_motions_and_what_holds_of_the_object():
    given = [motion(), Motion(motion(4).points, train_frames=0)]
    rest, edges, pins = np.zeros((2, 3)), [[0, 1]], [[1, 0]]
    made = bundle(given, fps=1, ground=None, edges=edges, pins=pins, rest_points=rest)
    document, arrays = read(made)
    assert document["ground"] is None
    assert [s["folder"] for s in document["sequences"]] == ["sequences/0000", "sequences/0001"]
    assert [s["train_frame_count"] for s in document["sequences"]] == [7, 0]
    assert arrays["sequences/0001/object_points.npy"].shape == (4, 2, 3)
    assert arrays["edges.npy"].tolist() == edges
    assert arrays["pins.npy"].tolist() == pins
    assert arrays["rest_points.npy"].shape == (2, 3)
    assert made == bundle(given, fps=1, ground=None, edges=edges, pins=pins, rest_points=rest)


def test_points_that_are_not_finite_were_not_seen():
    points = np.array(motion().points)
    points[3, 1, 2] = np.nan
    visible = np.ones((10, 2), bool)
    visible[0, 0] = False
    seen = read(bundle(Motion(points, visible=visible), fps=30))[1]["object_visible.npy"]
    assert np.argwhere(~seen).tolist() == [[0, 0], [3, 1]]


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        (Motion(np.zeros((4, 3))), "points has shape"),
        (Motion(np.zeros((0, 2, 3))), "points has shape"),
        (Motion(np.zeros((4, 2, 3)), controls=np.zeros((3, 1, 3))), "controls has 3 frames"),
        (Motion(np.zeros((4, 2, 3)), visible=np.ones((4, 3))), "visible has shape"),
        ([], "no motion"),
    ],
)
def test_wrong_shapes_are_refused(given, fault):
    with pytest.raises(ValueError, match=fault):
        bundle(given, fps=30)


def test_the_axis_is_one_of_six():
    with pytest.raises(ValueError, match="up_axis"):
        bundle(motion(), fps=30, up_axis="z")
