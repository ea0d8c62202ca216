"""The package as ament_python installs it."""

import xml.etree.ElementTree as ET
from pathlib import Path

from setuptools import find_packages, setup

NAME = "bendtwin_ros"


def shared(folder: str) -> tuple[str, list[str]]:
    """The files of a folder, and where they are installed."""
    files = sorted(str(path) for path in Path(folder).iterdir() if path.is_file())
    return f"share/{NAME}/{folder}", files


setup(
    name=NAME,
    version=ET.parse("package.xml").getroot().findtext("version"),
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        shared("launch"),
        shared("config"),
        shared("rviz"),
    ],
    # `bendtwin` and what it needs come from pip, for rosdep does not know it.
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="BendTwin contributors",
    maintainer_email="maintainers@bendtwin.invalid",
    description="A twin of a soft object that follows it, and plans with it, in ROS 2.",
    license="MIT OR Apache-2.0",
    entry_points={"console_scripts": [f"bendtwin = {NAME}.node:main"]},
)
