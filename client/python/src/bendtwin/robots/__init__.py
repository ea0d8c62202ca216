"""Robots from URDF: their links are colliders of a twin's world, their joints what a plan moves.

from bendtwin.robots import JointSpace, Robot, Workcell

robot = Robot.from_urdf("arm.urdf", tip="tool", base_pose=[-0.4, 0, 0, 0, 0, 0, 1])
cell = Workcell(robot, twin.geometry(), margin_m=0.005)
space = JointSpace(cell, start=robot.positions({"elbow": 1.2}))
costs = [*costs, *cell.clearance(margin_m=0.02, weight=1e3)]
plan = Cem(Task(twin=twin, costs=costs, space=space, frames=30), sigma=0.2).plan()
space.path(plan).positions  # [F + 1, J], radians
"""

from pathlib import Path

from bendtwin.robots.contacts import Contact
from bendtwin.robots.description import Joint, Limits, RobotError
from bendtwin.robots.inverse import Inverse
from bendtwin.robots.path import JointPath
from bendtwin.robots.robot import Robot
from bendtwin.robots.space import JointSpace
from bendtwin.robots.workcell import Workcell

#: An arm with six joints and a parallel gripper, made of boxes, cylinders and spheres, to try
#: things with. Its tip is `tool`.
EXAMPLE_URDF: Path = Path(__file__).parent / "arm.urdf"

__all__ = [
    "EXAMPLE_URDF",
    "Contact",
    "Inverse",
    "Joint",
    "JointPath",
    "JointSpace",
    "Limits",
    "Robot",
    "RobotError",
    "Workcell",
]
