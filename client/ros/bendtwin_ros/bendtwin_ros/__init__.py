"""BendTwin in ROS 2: a twin that follows its object, and plans for it.

`node` alone knows rclpy. Everything else works on messages as dataclasses (`messages`), so that it
runs, and is tested, without ROS.
"""
