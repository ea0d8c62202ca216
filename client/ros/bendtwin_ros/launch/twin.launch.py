"""A twin that follows what a depth camera sees.

ros2 launch bendtwin_ros twin.launch.py config:=mine.yaml cloud:=/camera/depth/color/points
"""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """The node, with its topics led to those of the camera and the robot."""
    config = PathJoinSubstitution([FindPackageShare("bendtwin_ros"), "config", "twin.yaml"])
    arguments = [
        DeclareLaunchArgument("config", default_value=config, description="file of parameters"),
        DeclareLaunchArgument(
            "cloud",
            default_value="/camera/depth/color/points",
            description="topic of clouds, sensor_msgs/PointCloud2",
        ),
        DeclareLaunchArgument(
            "joint_states", default_value="/joint_states", description="topic of joints"
        ),
        DeclareLaunchArgument(
            "planning_scene",
            default_value="/monitored_planning_scene",
            description="topic of MoveIt's scene",
        ),
        DeclareLaunchArgument(
            "use_sim_time", default_value="false", description="true for bags and simulators"
        ),
    ]
    topics = ("cloud", "joint_states", "planning_scene")
    node = Node(
        package="bendtwin_ros",
        executable="bendtwin",
        name="bendtwin",
        output="screen",
        parameters=[
            LaunchConfiguration("config"),
            {"use_sim_time": LaunchConfiguration("use_sim_time")},
        ],
        remappings=[(topic, LaunchConfiguration(topic)) for topic in topics],
    )
    return LaunchDescription([*arguments, node])
