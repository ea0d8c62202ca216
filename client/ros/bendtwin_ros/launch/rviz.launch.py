"""The twin of `twin.launch.py`, and RViz with a view of it.

ros2 launch bendtwin_ros rviz.launch.py config:=mine.yaml cloud:=/camera/depth/color/points
"""

from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """The node and RViz; the arguments are those of `twin.launch.py`."""
    share = FindPackageShare("bendtwin_ros")
    twin = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(PathJoinSubstitution([share, "launch", "twin.launch.py"]))
    )
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", PathJoinSubstitution([share, "rviz", "bendtwin.rviz"])],
        output="screen",
    )
    return LaunchDescription([twin, rviz])
