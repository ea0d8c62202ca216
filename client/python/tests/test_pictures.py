"""Cameras, messages of pictures, and playbacks, without a server; and pictures of a real one."""

import io
import json
import re
import uuid
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from server import needs_server, with_rope

from bendtwin import (
    BendTwinError,
    Capsule,
    Category,
    ConvexMesh,
    Cuboid,
    Light,
    PictureCamera,
    Prop,
    Sphere,
)
from bendtwin.captures.playback import playback_cameras
from bendtwin.simulation.pictures import render_session
from bendtwin.tensors import unpack

PAGE = Path(__file__).parents[3] / "docs" / "use" / "looks.md"


def rotation(pose):
    x, y, z, w = pose[3:]
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def projected(camera, point):
    """Pixel of a point."""
    pose = np.asarray(camera.pose)
    x, y, z = rotation(pose).T @ (np.asarray(point) - pose[:3])
    fx, fy, cx, cy = np.asarray(camera.intrinsics)
    return np.array([fx * x / z + cx, fy * y / z + cy])


@pytest.mark.parametrize("eye", [(1, 0, 0.5), (-1, -2, 3), (0.1, 0, -1), (0, 1, 0)])
def test_a_camera_looks_at_its_target_with_the_world_upright(eye):
    camera = PictureCamera.looking_at(eye, (0, 0, 0.1), width=90, height=60, field_of_view_deg=60)
    np.testing.assert_allclose(projected(camera, (0, 0, 0.1)), [44.5, 29.5], atol=1e-9)
    above = projected(camera, (0, 0, 0.2))
    assert above[1] < 29.5
    assert above[0] == pytest.approx(44.5, abs=1e-9)
    # The left and the right edge are 60 degrees apart.
    assert camera.intrinsics[0] == pytest.approx(45 / np.tan(np.pi / 6))
    turn = rotation(camera.pose)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1)


def test_cameras_look_from_many_places_together():
    eyes = np.array([[1, 0, 1], [0, 2, 1]])
    camera = PictureCamera.looking_at(eyes, (0, 0, 0), width=8, height=8, field_of_view_deg=90)
    assert np.shape(camera.pose) == (2, 7)
    np.testing.assert_allclose(np.asarray(camera.pose)[:, :3], eyes)
    for wrong in [{"eye": (0, 0, 0)}, {"eye": (0, 0, 2)}]:
        with pytest.raises(ValueError, match="camera"):
            PictureCamera.looking_at(
                **wrong, target=(0, 0, 0), width=8, height=8, field_of_view_deg=90
            )


def test_a_request_has_what_is_given():
    camera = PictureCamera(
        16, 12, (9, 9, 7.5, 5.5), np.zeros((2, 7)), background=np.full((12, 16, 3), 7)
    )
    props = [
        Prop(Sphere(0.1), color=(1, 2, 3)),
        Prop(Capsule((0, 0, 0), (0, 0, 1), 0.2), pose=(0, 0, 0, 0, 0, 0, 1)),
        Prop(Cuboid((0, 0, 0), (1, 1, 1))),
        Prop(ConvexMesh(np.eye(4, 3)), color=np.zeros((2, 3), np.uint8)),
    ]
    light = Light(direction=(0, 0, 1), ambient=0.3, brightness=[1, 2])
    call = render_session("sessions/s", [1, 0], [camera], "surface", props, light, True, False)
    request = call.request
    assert (request.slots, request.depths, request.labels) == ([1, 0], True, False)
    assert request.look == request.SURFACE
    (sent,) = request.cameras
    assert (sent.width, sent.height) == (16, 12)
    assert unpack(sent.pose).shape == (2, 7)
    assert unpack(sent.background).dtype == np.uint8
    kinds = [prop.WhichOneof("shape") for prop in request.props]
    assert kinds == ["sphere", "capsule", "cuboid", "convex_mesh"]
    np.testing.assert_array_equal(unpack(request.props[0].color), [1, 2, 3])
    np.testing.assert_array_equal(unpack(request.light.ambient), np.float32([0.3]))
    np.testing.assert_array_equal(unpack(request.light.brightness), [1, 2])
    with pytest.raises(ValueError, match="look"):
        render_session("s", [], [camera], "photo", [], None, False, False)
    with pytest.raises(ValueError, match=r"0\.\.255"):
        Prop(Sphere(0.1), color=(256, 0, 0)).to_proto()
    with pytest.raises(ValueError, match="whole numbers"):
        PictureCamera(8, 8, (8, 8, 4, 4), np.zeros(7), background=(0.5, 0.5, 0.5)).to_proto()


def playback(images, masks, *, distortion=("none", ()), size=(80, 60), poses=None):
    """The content of a playback with one camera."""
    model, coefficients = distortion
    poses = np.eye(3, 4, dtype="<f4")[None] if poses is None else poses
    parts = [poses.astype("<f4").tobytes(), b"".join(images), b"".join(masks)]
    ends = np.cumsum([0, *map(len, parts)])
    ranges = [[int(a), len(part)] for a, part in zip(ends, parts, strict=False)]
    camera = {
        "name": "left",
        "size": size,
        "intrinsics": {"fx": 70.0, "fy": 70.0, "cx": 39.5, "cy": 29.5},
        "distortion": {"model": model, "coefficients": list(coefficients)},
        "poses": ranges[0],
        "images": {"size": [40, 30], "every": 1, "lengths": list(map(len, images))},
        "masks": {"lengths": list(map(len, masks)), "bytes": ranges[2]},
    }
    camera["images"]["bytes"] = ranges[1]
    head = json.dumps({"version": 1, "sequences": [{"cameras": [camera]}]}).encode()
    head += b" " * (-len(head) % 8)
    numbers = b"".join(n.to_bytes(4, "little") for n in (1, len(head)))
    return b"BENDPLAY" + numbers + head + b"".join(parts)


def jpeg(array):
    image = pytest.importorskip("PIL.Image")
    out = io.BytesIO()
    image.fromarray(array).save(out, "JPEG", quality=95)
    return out.getvalue()


def runs(labels):
    """A mask as its runs."""
    out, values = b"", labels.ravel()
    ends = [0, *(np.flatnonzero(np.diff(values)) + 1), values.size]
    for a, b in pairwise(ends):
        value = (b - a) * 4 + int(values[a])
        while value > 0x7F:
            out += bytes([value & 0x7F | 0x80])
            value >>= 7
        out += bytes([value])
    return out


def test_the_background_is_what_was_behind_object_and_hands():
    scene = np.full((30, 40, 3), 90, np.uint8)
    scene[:, 20:] = 180
    images, masks = [], []
    for k in range(7):
        image, mask = scene.copy(), np.zeros((30, 40), np.uint8)
        # It rests in one place, and moves through another.
        image[10:20, 2:10], mask[10:20, 2:10] = (250, 0, 0), 1
        image[5:25, 22 + 2 * k : 28 + 2 * k] = (0, 250, 0)
        mask[5:25, 22 + 2 * k : 28 + 2 * k] = 2
        images.append(jpeg(image))
        masks.append(runs(mask))
    (camera,) = playback_cameras(playback(images, [b"", *masks[1:]]))
    empty = camera.empty_scene().astype(int)
    assert abs(empty - scene).max() < 40
    assert abs(empty - scene).mean() < 2
    made = camera.picture_camera(40, 30)
    assert np.asarray(made.background).shape == (30, 40, 3)
    # Half as many pixels: the centre of the picture is the same.
    np.testing.assert_allclose(made.intrinsics, [35, 35, 19.5, 14.5])
    square = camera.picture_camera(30, 30)
    np.testing.assert_allclose(square.intrinsics, [35, 35, 14.5, 14.5])
    np.testing.assert_allclose(square.pose[:3], 0)
    np.testing.assert_allclose(abs(np.asarray(square.pose[3:])), [0, 0, 0, 1])


@pytest.mark.parametrize(
    "distortion",
    [("brown_conrady", (-0.6, 0.05, 0.001, -0.002)), ("kannala_brandt", (-0.4, 0.01))],
)
def test_backgrounds_have_no_distortion(distortion):
    # A step in the recorded image at column 60, half-way up: the ray that is seen there.
    image = np.zeros((30, 40, 3), np.uint8)
    image[:, 30:] = 255
    (camera,) = playback_cameras(playback([jpeg(image)], [b""], distortion=distortion))
    (plain,) = playback_cameras(playback([jpeg(image)], [b""]))
    steps = []
    for one in (camera, plain):
        background = np.asarray(one.picture_camera(80, 60).background)[30, :, 0].astype(float)
        steps.append(np.interp(127, background[40:], np.arange(40, 80)))
    x = np.linspace(0, 1, 20001)
    u, _ = camera._distorted(x, np.full_like(x, 0.5 / 70))
    expected = 70 * np.interp(59.5, u, x) + 39.5
    assert steps[1] == pytest.approx(59.5, abs=0.6)
    assert steps[0] == pytest.approx(expected, abs=0.6)
    assert abs(steps[0] - steps[1]) > 0.7


def test_faults_of_playbacks_are_named():
    with pytest.raises(ValueError, match="no playback"):
        playback_cameras(b"PK\x03\x04")
    content = playback([], [])
    with pytest.raises(ValueError, match="sequence is 1"):
        playback_cameras(content, 1)
    (camera,) = playback_cameras(content)
    with pytest.raises(ValueError, match="no images"):
        camera.picture_camera(8, 8)
    (camera,) = playback_cameras(playback([], [], poses=np.zeros((0, 3, 4))))
    with pytest.raises(ValueError, match="not calibrated"):
        camera.picture_camera(8, 8)


@needs_server
def test_a_session_is_pictured_beside_props(tmp_path):
    image = pytest.importorskip("PIL.Image")
    with with_rope(tmp_path) as made, made.client.open_session(made.twin.name, slots=2) as session:
        rest = np.asarray(made.twin.geometry().rest_positions)
        middle = rest.mean(axis=0)
        low = float(rest[:, 2].min())
        camera = PictureCamera.looking_at(
            middle + np.array([0.3, -0.7, 0.4]), middle, width=128, height=96, field_of_view_deg=50
        )
        table = Prop(
            Cuboid((-1, -1, low - 0.1), (1, 1, low - 0.01)),
            pose=(*middle[:2], 0, 0, 0, 0, 1),
            color=(120, 90, 70),
        )
        ball = Prop(Sphere(0.04), pose=[(*middle[:2], low, 0, 0, 0, 1)] * 2, color=(30, 90, 200))
        (pictures,) = session.render([camera], props=[table, ball], depths=True, labels=True)
        assert pictures.colors.shape == (2, 96, 128, 3)
        assert set(np.unique(pictures.labels)) == {0, 1, 2, 3}
        assert ((pictures.labels == 0) == (pictures.depths == 0)).all()
        # The same states, the same bits.
        np.testing.assert_array_equal(pictures.colors[0], pictures.colors[1])
        image.fromarray(pictures.colors[0]).save(tmp_path / "rope.png")
        assert image.open(tmp_path / "rope.png").size == (128, 96)
        with pytest.raises(BendTwinError, match="Gaussians") as refused:
            session.render([camera], look="gaussians")
        assert refused.value.reason == "GAUSSIANS_UNKNOWN"
        with pytest.raises(BendTwinError, match="intrinsics"):
            session.render([PictureCamera(8, 8, (0, 1, 1, 1), camera.pose)])
        made.client.download_playback(made.twin.info.capture, tmp_path / "rope.play")
        assert playback_cameras((tmp_path / "rope.play").read_bytes()) == []
        with pytest.raises(BendTwinError) as refused:
            made.client.capture_cameras(f"captures/{uuid.UUID(int=7)}", width=8, height=8)
        assert refused.value.category is Category.NOT_FOUND
        run_page(made.address)


def run_page(address):
    """Runs the snippets of docs/use/looks.md, one after the other."""
    if not PAGE.is_file():
        return
    page, names = PAGE.read_text(), {}
    snippets = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    assert len(snippets) == 2
    for snippet in snippets:
        line = page[: page.index(snippet)].count("\n")
        code = "\n" * line + snippet.replace("127.0.0.1:7070", address)
        # The page is the file in tracebacks, at its own lines.
        exec(compile(code, PAGE, "exec"), names)
    assert names["pictures"].colors.shape == (2, 96, 96, 3)
    assert set(np.unique(names["pictures"].labels)) == {0, 1, 2, 3}
    names["client"].close()
