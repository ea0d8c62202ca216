"""The files of the packages agree with one another and with the code."""

from __future__ import annotations

import ast
import json
import re
import xml.etree.ElementTree as ET
from dataclasses import fields

import pytest
import yaml

import fake_messages
from bendtwin_ros import logic
from bendtwin_ros.messages import basic, own, scene, shown
from bendtwin_ros.parameters import GRIPPER_PARAMETERS, PARAMETERS, ParameterFault
from conftest import ROOT
from made_ros import settings

PACKAGE = ROOT / "bendtwin_ros"
MESSAGES = ROOT / "bendtwin_msgs"
README = (PACKAGE / "README.md").read_text()
CODE = sorted((PACKAGE / "bendtwin_ros").rglob("*.py"))


def rows(text):
    """Names and values of the rows of tables that begin with two cells of code."""
    return [
        (name, json.loads(value))
        for name, value in re.findall(r"^\| `([\w.]+)` \| `([^`]+)` \|", text, re.MULTILINE)
    ]


def test_the_readme_has_every_parameter_with_its_default():
    own_rows, gripper_rows = README.split("## Parameters")[1].split("Each gripper has its own")
    assert rows(own_rows) == [(p.name, p.default) for p in PARAMETERS]
    assert rows(gripper_rows) == [(p.name, p.default) for p in GRIPPER_PARAMETERS]


def test_the_example_of_parameters_is_possible():
    [(_, content)] = yaml.safe_load((PACKAGE / "config" / "twin.yaml").read_text()).items()
    given = content["ros__parameters"]
    made = settings(**given)
    assert [gripper.name for gripper in made.grippers] == ["left", "right"]
    defaults = {p.name: p.default for p in PARAMETERS}
    for name in ("left", "right"):
        defaults |= {f"{name}.{p.name}": p.default for p in GRIPPER_PARAMETERS}
    # ROS refuses a value of another type than that of the default.
    assert all(type(value) is type(defaults[name]) for name, value in given.items())


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"twin": ""}, "twin is ''"),
        ({"cloud__low": [0.0, 0.0]}, "cloud.low is"),
        ({"cloud__low": [0.0, 0.0, 2000.0]}, "below those of cloud.high"),
        ({"cloud__cell_m": float("nan")}, "from 0.0005 to 0.5"),
        ({"twin_pose": [0.0] * 7}, "unit quaternion"),
        ({"start": "anywhere"}, "register, settled or rest"),
        ({"grippers": ["a", "a"]}, "different names"),
        ({"grippers": ["a"]}, "a.frame is empty"),
        ({"grippers": ["a"], "a__frame": "f", "a__hand": -2}, "a.hand is -2"),
        (
            {
                "grippers": ["a", "b"],
                "a__frame": "f",
                "b__frame": "g",
                "a__hand": 0,
                "b__hand": 0,
            },
            "same `hand`",
        ),
    ],
)
def test_a_parameter_that_is_not_possible_is_named_with_what_is(given, said):
    with pytest.raises(ParameterFault, match=re.escape(said)):
        settings(**{"twin": "rope", **given})


@pytest.mark.parametrize(
    ("cls", "file", "part"),
    [
        (own.GripperPath, "msg/GripperPath.msg", 0),
        (own.PlanGoal, "action/PlanDeformable.action", 0),
        (own.PlanResult, "action/PlanDeformable.action", 1),
        (own.PlanFeedback, "action/PlanDeformable.action", 2),
        (own.RegisterRequest, "srv/Register.srv", 0),
        (own.RegisterResponse, "srv/Register.srv", 1),
    ],
)
def test_interfaces_have_the_fields_of_their_dataclasses(cls, file, part):
    text = fake_messages.parts_of(MESSAGES / file)[part]
    assert [one.split()[1] for one in text.split(", ")] == [field.name for field in fields(cls)]


def test_constants_of_the_action_are_those_of_the_goal():
    text = (MESSAGES / "action" / "PlanDeformable.action").read_text()
    found = dict(re.findall(r"^uint8 (\w+) = (\d+)$", text, re.MULTILINE))
    assert {name: int(value) for name, value in found.items()} == {
        name: getattr(own.PlanGoal, name) for name in found
    }
    assert len(found) == 3


def test_packages_state_the_packages_that_they_use():
    used = {"rclpy", "tf2_ros", "launch", "launch_ros", "rviz2"}
    for module in (basic, own, scene, shown):
        used |= {c.ROS.split("/")[0] for c in vars(module).values() if hasattr(c, "ROS")}
    stated = ET.parse(PACKAGE / "package.xml").getroot()
    named = {one.text for one in stated.iter("exec_depend")}
    assert named - {"python3-numpy", "python3-scipy"} == used
    interfaces = [*MESSAGES.glob("msg/*"), *MESSAGES.glob("srv/*"), *MESSAGES.glob("action/*")]
    texts = [file.read_text() for file in interfaces]
    kinds = {kind for text in texts for kind in re.findall(r"^(\w+)/\w+", text, re.MULTILINE)}
    stated = ET.parse(MESSAGES / "package.xml").getroot()
    assert {one.text for one in stated.iter("depend")} == kinds - {"bendtwin_msgs"}
    cmake = (MESSAGES / "CMakeLists.txt").read_text()
    for file in interfaces:
        assert f'"{file.relative_to(MESSAGES)}"' in cmake
    for kind in kinds - {"bendtwin_msgs"}:
        assert f"find_package({kind} REQUIRED)" in cmake


def test_launch_files_compile_and_name_what_is_there():
    twin = (PACKAGE / "launch" / "twin.launch.py").read_text()
    rviz = (PACKAGE / "launch" / "rviz.launch.py").read_text()
    for text in (twin, rviz):
        names = {
            node.name for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)
        }
        assert names == {"generate_launch_description"}
    remapped = ast.literal_eval(re.search(r"topics = (\(.*\))", twin)[1])
    assert set(remapped) == {logic.CLOUD, logic.JOINTS, logic.SCENE}
    assert "config" in twin
    assert (PACKAGE / "config" / "twin.yaml").is_file()
    assert 'executable="bendtwin"' in twin
    assert "bendtwin = {NAME}.node:main" in (PACKAGE / "setup.py").read_text()
    assert '"launch", "twin.launch.py"' in rviz
    assert '"rviz", "bendtwin.rviz"' in rviz


def test_the_view_of_rviz_shows_topics_of_the_node():
    view = yaml.safe_load((PACKAGE / "rviz" / "bendtwin.rviz").read_text())
    displays = view["Visualization Manager"]["Displays"]
    shown_topics = {one["Topic"]["Value"] for one in displays if "Topic" in one}
    wrenches = {logic.wrench_topic(name) for name in ("left", "right")}
    own_topics = {logic.MARKERS, logic.SKIN, *wrenches}
    assert shown_topics == {topic.replace("~", "/bendtwin") for topic in own_topics}


def test_only_the_node_knows_rclpy():
    imports = re.compile(r"^(import|from) (rclpy|tf2)", re.MULTILINE)
    importing = [file.name for file in CODE if imports.search(file.read_text())]
    assert importing == ["node.py"]
    assert all(topic in README for topic in (logic.CLOUD, logic.MARKERS, logic.SKIN, "~/plan"))
