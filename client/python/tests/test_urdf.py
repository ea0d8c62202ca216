"""Descriptions of robots that are odd, faulty or hostile, and meshes of their links."""

import sys
import time
from itertools import pairwise

import numpy as np
import pytest

from bendtwin.robots import JointSpace, Limits, Robot, RobotError, Workcell

SOLID = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
LIMIT = '<limit lower="-1" upper="1" velocity="1"/>'


def robot(*, links=("a", "b"), joints=None, before="", inside="", solid=""):
    """The text of a robot whose links follow one after the other."""
    if joints is None:
        joints = "".join(joint(f"j{b}", a, b) for a, b in pairwise(links))
    bodies = "".join(f'<link name="{name}">{solid}</link>' for name in links)
    return f'{before}<robot name="r">{bodies}{joints}{inside}</robot>'


def joint(name, parent, child, kind="revolute", more=LIMIT):
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{more}</joint>'


def collision(shape):
    return f"<collision><geometry>{shape}</geometry></collision>"


LAUGHS = "".join(f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(9))
BOMB = f'<?xml version="1.0"?><!DOCTYPE robot [<!ENTITY l0 "ha">{LAUGHS}]>'
FAULTS = [
    (robot(before=BOMB, inside="<gazebo>&l9;</gazebo>"), "DOCTYPE"),
    (
        '<!DOCTYPE r [<!ENTITY f SYSTEM "file:///etc/passwd">]><robot><link name="&f;"/></robot>',
        "DOCTYPE",
    ),
    ("<robot><link", "not XML"),
    ("<sdf><model/></sdf>", "begins with <sdf>"),
    ("<robot/>", "no links"),
    ('<robot><xacro:include filename="x"/></robot>', "xacro FILE"),
    (robot(solid=collision('<box size="${side} 1 1"/>')), "xacro FILE"),
    (
        '<robot xmlns:xacro="http://ros.org/wiki/xacro"><link name="a"/><xacro:arm/></robot>',
        "xacro FILE",
    ),
    (robot(links=("a", "a"), joints=""), "two links 'a'"),
    (
        robot(links=("a", "b", "c"), joints=joint("j", "a", "b") + joint("j", "b", "c")),
        "two joints",
    ),
    (robot(links=("a", "b"), joints=""), "have no parent"),
    (robot(links=("a", "b"), joints=joint("j", "a", "c")), "'c', which is missing"),
    (robot(links=("a", "b"), joints=joint("j", "a", "b") + joint("k", "b", "a")), "form a loop"),
    (
        robot(links=("r", "a", "b"), joints=joint("j", "a", "b") + joint("k", "b", "a")),
        "loop apart from 'r'",
    ),
    (
        robot(
            links=("a", "b", "c"),
            joints=joint("j", "a", "c") + joint("k", "a", "b") + joint("l", "b", "c"),
        ),
        "two parents",
    ),
    (robot(joints=joint("j", "a", "b", "floating")), "'floating'"),
    (robot(joints=joint("j", "a", "b", "planar")), "revolute, continuous, prismatic"),
    (robot(joints='<joint name="j" type="fixed"><parent link="a"/></joint>'), "no child"),
    (robot(joints=joint("j", "a", "b", more='<axis xyz="0 0 0"/>')), "axis of zeros"),
    (robot(joints=joint("j", "a", "b", more='<axis xyz="0 1"/>')), "give 3 numbers"),
    (robot(joints=joint("j", "a", "b", more='<origin xyz="1e300 0 0"/>')), "at most 1000"),
    (robot(joints=joint("j", "a", "b", more='<origin rpy="nan 0 0"/>')), "finite"),
    (robot(joints=joint("j", "a", "b", more='<limit lower="2" upper="1"/>')), "above its upper"),
    (robot(joints=joint("j", "a", "b", more='<limit velocity="-1"/>')), "below 0"),
    (robot(joints=joint("j", "a", "b", more='<mimic joint="k"/>')), "does not move"),
    (robot(joints=joint("j", "a", "b", more='<mimic joint="j"/>')), "mimics itself"),
    (robot(joints=joint("j", "a", "b", more="<mimic/>")), "without a joint"),
    (robot(solid="<collision/>"), "without a geometry"),
    (robot(solid=collision('<sphere radius="0"/>')), "above 0"),
    (robot(solid=collision("<sphere/>")), "without radius"),
    (robot(solid=collision('<cylinder radius="1" length="1e9"/>')), "at most 1000"),
    (robot(solid=collision('<box size="1 -1 1"/>')), "above 0"),
    (robot(solid=collision('<torus radius="1"/>')), "'torus'"),
    (robot(solid=collision("<mesh/>")), "without a filename"),
    (robot(solid=collision('<mesh filename="a.stl" scale="1 0 1"/>')), "scale of 0"),
    (robot(links=("a" * 101,)), "printable"),
    (robot(links=[f"l{i}" for i in range(1001)]), "1001 links"),
    ('<robot><link name="a"/><link/></robot>', "no name"),
    ("<robot>" + "<a>" * 20000 + "</a>" * 20000 + "</robot>", "no links"),
]


@pytest.mark.parametrize(("text", "fault"), FAULTS, ids=[fault for _, fault in FAULTS])
def test_faulty_descriptions_are_refused_with_advice(text, fault):
    began = time.monotonic()
    with pytest.raises(RobotError, match=fault):
        Robot.from_urdf(text)
    assert time.monotonic() - began < 1.0


def test_files_are_told_from_text(tmp_path):
    (tmp_path / "robot.urdf").write_text("\ufeff" + robot(), encoding="utf-8")
    assert Robot.from_urdf(str(tmp_path / "robot.urdf")).links == ("a", "b")
    (tmp_path / "robot.bin").write_bytes(robot().encode("utf-16"))
    with pytest.raises(RobotError, match="UTF-8"):
        Robot.from_urdf(tmp_path / "robot.bin")
    with pytest.raises(FileNotFoundError):
        Robot.from_urdf("nowhere.urdf")


def test_long_chains_need_no_recursion():
    chain = Robot.from_urdf(robot(links=[f"l{i}" for i in range(1000)]))
    assert chain.tips == ("l999",)
    assert chain.link_poses(np.zeros(999)).shape == (1000, 7)


def test_a_tip_must_be_named_where_there_are_several():
    joints = joint("j", "a", "b") + joint("k", "a", "c")
    text = robot(links=("a", "b", "c"), joints=joints)
    with pytest.raises(RobotError, match=r"tip=.*\['b', 'c'\]"):
        Robot.from_urdf(text)
    assert Robot.from_urdf(text, tip=["b", "c"]).tips == ("b", "c")
    with pytest.raises(RobotError, match="no link 'd'"):
        Robot.from_urdf(text, tip="d")
    with pytest.raises(RobotError, match="differ"):
        Robot.from_urdf(text, tip=["b", "b"])


@pytest.mark.parametrize(
    ("limit", "fault"),
    [
        ("", "no limits of its position"),
        ('<limit velocity="1"/>', "no limits of its position"),
        ('<limit lower="-1" upper="1"/>', "speed above 0"),
        ('<limit lower="-1" upper="1" velocity="0"/>', "speed above 0"),
        ('<limit lower="0" upper="0" velocity="1"/>', "room between"),
    ],
)
def test_joints_without_limits_move_but_are_not_planned(limit, fault):
    text = robot(joints=joint("j", "a", "b", more=limit))
    loose = Robot.from_urdf(text)
    assert loose.tip_poses([0.5]).shape == (1, 7)
    with pytest.raises(RobotError, match=fault):
        JointSpace(Workcell(loose), start=[0.0])
    tight = Robot.from_urdf(text, limits={"j": Limits(low=-1, high=1, speed=1)})
    assert JointSpace(Workcell(tight), start=[0.0]).dims == 1


def ball_mesh(trimesh, folder, name, **settings):
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=0.05, **settings)
    folder.mkdir(parents=True, exist_ok=True)
    mesh.export(folder / name)
    return mesh


def with_mesh(name, more=""):
    return robot(links=("a",), solid=collision(f'<mesh filename="{name}" {more}/>'))


def test_meshes_become_hulls_around_them(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("scipy")
    for kind, inside in (("stl", ""), ("obj", "arm_description"), ("ply", "")):
        mesh = ball_mesh(trimesh, tmp_path / "arm_description" / "meshes", f"ball.{kind}")
        text = with_mesh(f"package://arm_description/meshes/ball.{kind}", 'scale="2 1 1"')
        made = Workcell(Robot.from_urdf(text, package_dirs=[tmp_path / inside]))
        points = np.asarray(made.world.colliders[0].shape.points)
        hull = trimesh.convex.convex_hull(points)
        corners = np.asarray(mesh.vertices) * [2.0, 1.0, 1.0]
        assert len(points) <= 60, "of 1280 triangles"
        # The hull contains every corner, and little else.
        offsets = np.einsum("fi,fi->f", hull.face_normals, hull.triangles[:, 0])
        assert (corners @ hull.face_normals.T - offsets).max() < 1e-6
        assert hull.volume < 1.25 * trimesh.convex.convex_hull(corners).volume


def test_paths_of_meshes_are_relative_to_the_file(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("scipy")
    ball_mesh(trimesh, tmp_path / "meshes", "ball.stl")
    (tmp_path / "robot.urdf").write_text(with_mesh("meshes/ball.stl"))
    assert Workcell(Robot.from_urdf(tmp_path / "robot.urdf")).world.colliders
    there = tmp_path / "meshes" / "ball.stl"
    assert Workcell(Robot.from_urdf(with_mesh(f"file://{there}"))).world.colliders


def test_meshes_in_millimetres_of_collada_are_scaled(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("collada")
    pytest.importorskip("scipy")
    mesh = trimesh.creation.box((100.0, 100.0, 100.0))
    data = trimesh.exchange.dae.export_collada(mesh).decode()
    there = tmp_path / "box.dae"
    unit = '<unit name="millimeter" meter="0.001" />'
    there.write_text(data.replace("<up_axis>", f"{unit}<up_axis>"))
    cell = Workcell(Robot.from_urdf(with_mesh(f"file://{there}")))
    points = np.asarray(cell.world.colliders[0].shape.points)
    np.testing.assert_allclose(np.abs(points).max(axis=0), 0.05, rtol=1e-5)


def test_a_flat_mesh_is_thickened(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("scipy")
    square = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]])
    trimesh.Trimesh(square, [[0, 1, 2], [0, 2, 3]]).export(tmp_path / "flat.stl")
    cell = Workcell(Robot.from_urdf(with_mesh(f"file://{tmp_path / 'flat.stl'}")))
    points = np.asarray(cell.world.colliders[0].shape.points)
    thickness = np.ptp(points, axis=0)[2]
    assert 0.0009 < thickness < 0.003


@pytest.mark.parametrize(
    ("name", "content", "fault"),
    [
        ("package://arm/ball.stl", None, "package_dirs="),
        ("ball.stl", None, "was not found at"),
        ("a" * 5000 + ".stl", None, "was not found at"),
        ("ball.txt", b"solid", "use one of"),
        ("ball.stl", b"", "cannot be read|empty"),
        ("ball.stl", b"\xff" * 500, "cannot be read|empty|larger"),
        ("ball.obj", b"v nan 0 0\nv 1 0 0\nf 1 2 2\n", "cannot be read|empty"),
        ("ball.dae", b"<!DOCTYPE a [<!ENTITY b 'c'>]><COLLADA/>", "DOCTYPE"),
    ],
)
def test_meshes_that_cannot_be_used_are_named(tmp_path, name, content, fault):
    pytest.importorskip("trimesh")
    pytest.importorskip("scipy")
    if content is not None:
        (tmp_path / name).write_bytes(content)
    made = Robot.from_urdf(with_mesh(name), package_dirs=[tmp_path])
    with pytest.raises(RobotError, match=fault) as error:
        Workcell(made)
    assert "link 'a'" in str(error.value)


@pytest.mark.parametrize("missing", ["trimesh", "scipy.spatial"])
def test_a_missing_library_is_named_with_the_command(tmp_path, monkeypatch, missing):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("scipy")
    ball_mesh(trimesh, tmp_path, "ball.stl")
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(RobotError, match=r"pip install 'bendtwin\[robots\]'"):
        Workcell(Robot.from_urdf(with_mesh("ball.stl"), package_dirs=[tmp_path]))
