"""Files for other programs are read by these programs' own libraries, and say what the server does.

Of each library one version or newer is needed; where it is not installed its test says so."""

import importlib
import json
import zipfile
from dataclasses import replace
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy_twin import TwinFile, norm
from scenes import FRAMES, dragged, dropped, sheet, twin_file
from server import needs_server, run, running

from bendtwin import Client, Returns

pytestmark = needs_server


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("exchange")


@pytest.fixture(scope="module")
def client(folder):
    with running(folder) as address, Client(address) as client:
        yield client


@pytest.fixture(scope="module")
def twin(client, folder):
    """A twin of which the skin is not its nodes, and its file."""
    path = folder / "twin.safetensors"
    path.write_bytes(dragged()[0].encode())
    return client.import_twin(path)


def export(folder, name, *options):
    """Exports the twin file without a server; returns the path."""
    path = folder / name
    done = run("twin", "export", folder / "twin.safetensors", path, *options)
    assert done.returncode == 0, done.stderr
    return path


@pytest.fixture(scope="module")
def recorded(client, twin, folder):
    """A rollout written by the file's name, beside the positions that the client gets."""
    path = dragged()[1].astype(np.float32)
    np.save(folder / "actions.npy", path[None])
    returns = {"returns": Returns(every_frames=3)}
    expected = twin.rollout(trajectories=path[None], **returns).positions[0]

    def write(name, *options):
        file = folder / name
        # A path would lose the slash that tells a folder.
        out = f"{folder}/{name}"
        done = run(
            "rollout",
            twin.name,
            *("--actions", folder / "actions.npy", "--every", "3", "--out", out),
            *options,
            address=client._address,
        )
        assert done.returncode == 0, done.stderr
        return file

    write.expected, write.controls = expected, path[3::3]
    return write


def test_the_format_follows_the_name_or_the_flag_and_is_never_another(folder, twin, recorded):
    done = run("twin", "export", folder / "twin.safetensors", folder / "rope.fbx")
    assert done.returncode != 0
    assert json.loads(done.stderr)["error"]["reason"] == "EXPORT_FORMAT_UNKNOWN"
    assert ".glb" in done.stderr
    assert not (folder / "rope.fbx").exists()
    assert export(folder, "said.fbx", "--format", "ply").read_bytes()[:4] == b"ply\n"
    magic = {
        "a.ply": b"ply\n",
        "a.glb": b"glTF",
        "a.npz": b"PK",
        "a.usda": b"#usda",
        "a.usdz": b"PK",
        "a.obj": b"# bendtwin",
        "a.xml": b"<!--",
    }
    magic |= {"a.zip": b"PK", "a.mcap": b"\x89MCAP"}
    for name, start in magic.items():
        assert export(folder, name).read_bytes().startswith(start), name
    for name in ("a.twin", "a.safetensors"):
        same = export(folder, name).read_bytes()
        assert TwinFile.decode(same).about["timing"] == {"fps": 30.0, "substeps": 60}


def test_a_server_s_twin_is_exported_by_its_name(client, twin, folder):
    from_server = folder / "from-server.npz"
    done = run("twin", "export", twin.name, from_server, address=client._address)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["format"] == "npz"
    mine = np.load(export(folder, "from-file.npz"))
    with np.load(from_server) as arrays:
        assert sorted(arrays) == sorted(mine)
        np.testing.assert_array_equal(arrays["positions"], mine["positions"])


def test_npz_has_every_tensor_of_the_twin_file(folder, twin, recorded):
    file = TwinFile.decode((folder / "twin.safetensors").read_bytes())
    with np.load(recorded("a.npz")) as arrays:
        np.testing.assert_array_equal(arrays["positions"], recorded.expected)
        np.testing.assert_array_equal(arrays["controls"], recorded.controls)
        np.testing.assert_allclose(arrays["times_s"], np.arange(3, FRAMES + 1, 3) / 30)
        for name, array in file.tensors.items():
            np.testing.assert_array_equal(arrays[name], array, err_msg=name)
        about = json.loads(arrays["twin.json"])
    assert about["contact"].keys() == file.about["contact"].keys()


def test_glb_is_read_by_trimesh_and_moves_by_pygltflib(folder, twin, recorded):
    trimesh, pygltflib = library("trimesh"), library("pygltflib")
    mesh = trimesh.creation.icosphere(1, 0.02).apply_translation([0.06, 0.045, 0.03])
    mesh.export(folder / "ball.ply")
    still = trimesh.load(export(folder, "ball.glb", "--mesh", folder / "ball.ply"), force="mesh")
    turned = still.vertices @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]).T
    assert norm(turned - mesh.vertices).max() < 1e-5
    assert len(still.faces) == len(mesh.faces)

    moving = pygltflib.GLTF2().load(str(recorded("a.glb", "--nodes")))
    blob, frames = moving.binary_blob(), len(recorded.expected)

    def floats(index):
        accessor = moving.accessors[index]
        view = moving.bufferViews[accessor.bufferView]
        width = {"SCALAR": 1, "VEC3": 3}[accessor.type]
        start = view.byteOffset or 0
        values = np.frombuffer(blob, "<f4", accessor.count * width, start)
        return values.reshape(-1, width) if width > 1 else values

    sampler = moving.animations[0].samplers[0]
    weights = floats(sampler.output).reshape(frames, frames - 1)
    np.testing.assert_allclose(floats(sampler.input), np.arange(3, FRAMES + 1, 3) / 30, rtol=1e-6)
    nodes = moving.meshes[0].primitives[0]
    first = floats(nodes.attributes.POSITION)
    targets = np.array([floats(target["POSITION"]) for target in nodes.targets])
    posed = first + np.einsum("ft,tni->fni", weights, targets)
    np.testing.assert_allclose(posed, recorded.expected, atol=1e-6)


def test_a_surface_is_closed_for_trimesh_and_usd(folder):
    trimesh = library("trimesh")
    ball = trimesh.creation.icosphere(2, 0.05).apply_translation([0, 0, 0.2])
    nodes = np.asarray(ball.vertices)
    file = twin_file(nodes, ball.edges_unique.tolist(), nodes[:1])
    (folder / "ball.safetensors").write_bytes(file.encode())
    volumes = set()
    for name in ("surface.ply", "surface.obj", "surface.glb", "surface.usdz"):
        done = run("twin", "export", folder / "ball.safetensors", folder / name)
        assert done.returncode == 0, done.stderr
        if name == "surface.usdz":
            continue
        mesh = trimesh.load(folder / name, force="mesh", process=False)
        assert mesh.is_watertight, name
        assert mesh.is_winding_consistent, name
        volumes.add((len(mesh.faces), round(mesh.volume / ball.volume, 2)))
    ((faces, share),) = volumes
    assert 0.9 < share < 1.1
    library("pxr.Usd")
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(folder / "surface.usdz"))
    surface = UsdGeom.Mesh(stage.GetPrimAtPath("/Twin/Surface"))
    assert len(surface.GetFaceVertexCountsAttr().Get()) == faces


def test_a_ply_sequence_has_a_file_for_each_frame(folder, twin, recorded):
    plyfile, trimesh = library("plyfile"), library("trimesh")
    springs = TwinFile.decode((folder / "twin.safetensors").read_bytes())["springs.ends"]
    springs = springs[springs[:, 1] < recorded.expected.shape[1]]
    with zipfile.ZipFile(recorded("a.zip", "--nodes")) as archive:
        names = sorted(archive.namelist())
        assert len(names) == len(recorded.expected)
        for name, expected in zip(names, recorded.expected, strict=True):
            read = plyfile.PlyData.read(BytesIO(archive.read(name)))
            places = np.stack([read["vertex"][axis] for axis in "xyz"], axis=1)
            np.testing.assert_array_equal(places, expected)
            ends = np.stack([read["edge"][end] for end in ("vertex1", "vertex2")], axis=1)
            np.testing.assert_array_equal(ends, springs)
    frames = recorded("frames/", "--skin")
    skin = [np.asarray(trimesh.load(path).vertices) for path in sorted(frames.iterdir())]
    alone = np.load(recorded("skin.npy", "--skin"))[0]
    assert norm(np.array(skin) - alone).max() < 1e-6


def test_usd_is_read_by_pixar_s_library(folder, twin, recorded):
    library("pxr.Usd")
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(recorded("a.usda", "--nodes")))
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (3, FRAMES)
    assert stage.GetTimeCodesPerSecond() == 30
    points = UsdGeom.Points(stage.GetPrimAtPath("/Twin/Nodes"))
    assert points.GetPointsAttr().GetTimeSamples() == list(range(3, FRAMES + 1, 3))
    controls = UsdGeom.Points(stage.GetPrimAtPath("/Twin/Controls"))
    for f, (nodes, held) in enumerate(zip(recorded.expected, recorded.controls, strict=True)):
        code = 3 * (f + 1)
        np.testing.assert_array_equal(np.array(points.GetPointsAttr().Get(code)), nodes)
        np.testing.assert_array_equal(np.array(controls.GetPointsAttr().Get(code)), held)
        low, high = points.GetExtentAttr().Get(code)
        np.testing.assert_array_equal([low, high], [nodes.min(axis=0), nodes.max(axis=0)])

    stage = Usd.Stage.Open(str(export(folder, "rest.usda", "--nodes")))
    file = TwinFile.decode((folder / "twin.safetensors").read_bytes())
    springs = UsdGeom.BasisCurves(stage.GetPrimAtPath("/Twin/Springs"))
    inner = file["springs.ends"][:, 1] < len(file["nodes.mass"])
    stiffness = UsdGeom.PrimvarsAPI(springs).GetPrimvar("stiffness").Get()
    np.testing.assert_array_equal(np.array(stiffness), file["springs.stiffness"][inner])
    ends = np.array(springs.GetPointsAttr().Get()).reshape(-1, 2, 3)
    expected = file["nodes.rest_position"][file["springs.ends"][inner]]
    np.testing.assert_array_equal(ends, expected)


def test_mcap_is_read_by_foxglove_s_library(folder, twin, recorded):
    library("mcap.reader")
    import base64

    from mcap.reader import make_reader

    with recorded("a.mcap").open("rb") as file:
        found = list(make_reader(file, validate_crcs=True).iter_messages("/twin/nodes"))
    assert len(found) == len(recorded.expected)
    for f, (schema, channel, message) in enumerate(found):
        assert (schema.name, channel.message_encoding) == ("foxglove.PointCloud", "json")
        assert message.log_time == round((f + 1) * 1e8)
        cloud = json.loads(message.data)
        assert [field["name"] for field in cloud["fields"]] == ["x", "y", "z"]
        data = base64.b64decode(cloud["data"])
        places = np.frombuffer(data, "<f4").reshape(-1, cloud["point_stride"] // 4)
        np.testing.assert_array_equal(places, recorded.expected[f])


def callback():
    """The function of docs/formats/exchange.md for bending in MuJoCo."""
    page = Path(__file__).parents[3] / "docs/formats/exchange.md"
    blocks = [block.split("```")[0] for block in page.read_text().split("```python")[1:]]
    code = next(block for block in blocks if "def bending_of" in block)
    names = {}
    exec(code.split("\nmodel = ")[0], names)
    return names["bending_of"]


@pytest.fixture
def mujoco():
    module = library("mujoco")
    yield module
    module.set_mjcb_passive(None)


def in_mujoco(mujoco, path, controls, bends=None):
    """Positions of the nodes [F, N, 3] while control points take those of [F + 1, C, 3]."""
    mujoco.set_mjcb_passive(None)
    model = mujoco.MjModel.from_xml_path(str(path))
    mujoco.set_mjcb_passive(bends and bends(model))
    data = mujoco.MjData(model)
    nodes = sum(model.site(s).name.startswith("n") for s in range(model.nsite))
    sites = [model.site(f"n{n}").id for n in range(nodes)]
    frames, substeps = [], round(1 / 30 / model.opt.timestep)
    for start, end in pairwise(controls):
        for s in range(1, substeps + 1):
            data.mocap_pos[:] = (1 - s / substeps) * start + s / substeps * end
            mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        frames.append(data.site_xpos[sites].copy())
    return np.array(frames)


def hanging():
    """A sheet that hangs from two still control points, above the ground."""
    nodes, springs, triplets = sheet(5, 4, 0.03, [0, 0, 0.4])
    controls = np.array([[-0.02, 0.02, 0.42], [-0.02, 0.07, 0.42]])
    springs += [[e, 20 + c] for c in range(2) for e in range(4)]
    file = twin_file(nodes, springs, controls, triplets=triplets)
    return file, np.repeat(controls[None], FRAMES + 1, axis=0)


def test_mujoco_simulates_the_same_with_and_without_bending(client, folder, mujoco):
    file, path = hanging()
    straight = {n: a * 0 if n.startswith("triplets.bend") else a for n, a in file.tensors.items()}
    for name, tensors in {"bends": file.tensors, "straight": straight}.items():
        (folder / f"{name}.twin").write_bytes(replace(file, tensors=tensors).encode())
        done = run("twin", "export", folder / f"{name}.twin", folder / f"{name}.xml")
        assert done.returncode == 0, done.stderr
        twin = client.import_twin(folder / f"{name}.twin")
        ours = twin.rollout(trajectories=path[None], returns=Returns(every_frames=1)).positions[0]
        without = in_mujoco(mujoco, folder / f"{name}.xml", path)
        within = in_mujoco(mujoco, folder / f"{name}.xml", path, callback())
        off = [1e3 * norm(theirs - ours).max() for theirs in (within, without)]
        print(f"{name}: {off[0]:.3f} mm with the callback, {off[1]:.3f} without")
        assert off[0] < 1
        assert (off[1] < 1) == (name == "straight")


def test_mujoco_has_pins_objects_ground_and_frames(client, folder, mujoco):
    file, path = dropped()
    (folder / "dropped.twin").write_bytes(file.encode())
    twin = client.import_twin(folder / "dropped.twin")
    np.save(folder / "dropped.npy", path[None].astype(np.float32))
    done = run(
        *("rollout", twin.name, "--actions", folder / "dropped.npy"),
        *("--out", folder / "dropped.xml"),
        address=client._address,
    )
    assert done.returncode == 0, done.stderr
    ours = twin.rollout(trajectories=path[None], returns=Returns(every_frames=1)).positions[0]
    model = mujoco.MjModel.from_xml_path(str(folder / "dropped.xml"))
    assert (model.nkey, model.nmocap, model.ntendon > 0) == (FRAMES, 2, True)
    data = mujoco.MjData(model)
    for frame in (0, FRAMES - 1):
        mujoco.mj_resetDataKeyframe(model, data, frame)
        mujoco.mj_kinematics(model, data)
        places = np.array([data.site(f"n{n}").xpos for n in range(len(ours[0]))])
        assert norm(places - ours[frame]).max() < 1e-5
    # The ball is caught by the sheet, though MuJoCo's contact is softer.
    theirs = in_mujoco(mujoco, folder / "dropped.xml", path)
    height = theirs[:, 20:, 2].mean() - ours[:, 20:, 2].mean()
    assert abs(height) < 0.02
    through = ours[0, 20:, 2].mean() - 9.81 / 2
    assert theirs[-1, 20:, 2].mean() > through + 1


def library(name):
    """A library that reads a format; its absence is said."""
    try:
        return importlib.import_module(name)
    except ImportError:
        pytest.skip(f"{name} is not installed: pip install 'bendtwin[test]'")
