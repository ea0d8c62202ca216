"""Parameters of the node: one table with defaults and limits, and the settings that it makes.

The table in README.md has the same rows (a test compares them).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from bendtwin_ros.clouds import LEAST_CELL_M
from bendtwin_ros.poses import Array, settled

Start = Literal["register", "settled", "rest"]

#: Most grippers: the server's requests have room for more, but no robot has.
_MOST_GRIPPERS = 16
_FAR = 1.0e3


class ParameterFault(ValueError):
    """A parameter whose value is not possible; the message names it and says what is."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of ROS."""

    name: str
    #: ROS fixes the type of a parameter by its default.
    default: Any
    #: Condition that a value fulfils, and what it is in words.
    holds: Callable[[Any], bool] = lambda _: True
    needs: str = ""


def _number(name: str, default: float, low: float, high: float) -> Parameter:
    def holds(value: Any) -> bool:
        return bool(np.isfinite(value)) and low <= value <= high

    return Parameter(name, default, holds, f"a number from {low:g} to {high:g}")


def _numbers(name: str, default: list[float]) -> Parameter:
    def holds(value: Any) -> bool:
        return len(value) == len(default) and bool(np.isfinite(value).all())

    return Parameter(name, default, holds, f"{len(default)} finite numbers")


def _pose(name: str) -> Parameter:
    default = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    needs = "x, y, z [m] and a unit quaternion x, y, z, w"
    return Parameter(name, default, lambda value: settled(value) is not None, needs)


def _named(name: str, default: str = "") -> Parameter:
    return Parameter(name, default, bool, "a name")


#: Parameters of the node.
PARAMETERS: tuple[Parameter, ...] = (
    _named("twin"),
    _named("server.address", "127.0.0.1:7070"),
    Parameter("server.token_file", ""),
    Parameter("server.ca", ""),
    _number("server.timeout_s", 2.0, 0.05, 60.0),
    _named("twin_frame", "twin"),
    Parameter("parent_frame", ""),
    _pose("twin_pose"),
    Parameter(
        "start",
        "register",
        lambda value: value in ("register", "settled", "rest"),
        "register, settled or rest",
    ),
    _number("mass_kg", 0.0, 0.0, 1.0e3),
    _number("transform_timeout_s", 0.1, 0.0, 5.0),
    _numbers("cloud.low", [-_FAR] * 3),
    _numbers("cloud.high", [_FAR] * 3),
    _number("cloud.cell_m", 0.004, LEAST_CELL_M, 0.5),
    _number("cloud.max_points", 3000, 10, 200_000),
    _number("cloud.min_points", 20, 3, 10_000),
    _number("cloud.noise_m", 0.005, 1.0e-4, 0.1),
    _number("clock.max_gap_s", 1.0, 0.05, 60.0),
    _number("clock.coast_after_s", 0.3, 0.02, 60.0),
    _number("clock.future_s", 0.5, 0.0, 60.0),
    Parameter("grippers", [""]),
    _number("publish.rate_hz", 10.0, 0.1, 200.0),
    Parameter("publish.markers", True),
    Parameter("publish.skin", True),
    Parameter("publish.wrenches", True),
    _number("publish.max_triangles", 4000, 0, 200_000),
    _numbers("publish.color", [0.9, 0.5, 0.1, 1.0]),
    _number("plan.knots", 6, 2, 64),
    _number("plan.samples", 64, 1, 4096),
    _number("plan.iterations", 10, 1, 1000),
    _number("plan.sigma_m", 0.05, 0.0, 1.0),
    _number("plan.sigma_rad", 0.0, 0.0, 3.2),
    _number("plan.speed_m_s", 0.25, 1.0e-3, 5.0),
    _number("plan.turn_rad_s", 1.0, 1.0e-3, 20.0),
    _number("plan.max_horizon_s", 10.0, 0.1, 120.0),
    _number("plan.deadline_s", 10.0, 0.1, 600.0),
    _number("plan.friction", 0.5, 0.0, 2.0),
    _number("plan.margin_m", 0.005, 0.0, 0.1),
)

#: Parameters of each gripper, below its name: `left.frame`.
GRIPPER_PARAMETERS: tuple[Parameter, ...] = (
    Parameter("frame", ""),
    Parameter("pose_topic", ""),
    _number("hand", -1, -1, 255),
    _number("region_radius_m", 0.03, 1.0e-3, 1.0),
    _numbers("region_center", [0.0, 0.0, 0.0]),
    Parameter("joints", [""]),
    _number("scale", 1.0, -1.0e3, 1.0e3),
    _number("offset_m", 0.0, -10.0, 10.0),
    _number("closed_below_m", 0.02, -10.0, 10.0),
    _number("max_force_n", 0.0, 0.0, 1.0e6),
)


@dataclass(frozen=True)
class GripperSettings:
    """A gripper: where its pose and its width come from, and how it holds."""

    name: str
    #: The frame of its pose in TF, or of what is published about it.
    frame: str
    #: Topic of its pose; empty: TF.
    pose_topic: str
    #: Hand of the twin's capture whose control points it carries until it opens; None: none.
    hand: int | None
    #: What it takes hold of when it closes.
    region_radius_m: float
    region_center: tuple[float, float, float]
    #: Joints whose positions add up to its width; empty: always closed.
    joints: tuple[str, ...]
    scale: float
    offset_m: float
    closed_below_m: float
    #: Force above which the object slips, newtons; None: never.
    max_force_n: float | None


@dataclass(frozen=True)
class Settings:
    """All parameters of the node, checked."""

    values: Mapping[str, Any]
    grippers: tuple[GripperSettings, ...]

    def __getitem__(self, name: str) -> Any:
        return self.values[name]

    @property
    def twin_pose(self) -> Array:
        """Pose of the twin's frame in `parent_frame`."""
        pose = settled(self.values["twin_pose"])
        assert pose is not None
        return pose


def gripper_names(given: Sequence[str]) -> list[str]:
    """The names in the parameter `grippers`, whose parameters are to be declared.

    ROS has no type for an empty list, hence one empty name for none.

    Raises:
        ParameterFault: If names are the same, or too many.
    """
    names = [name for name in given if name]
    if len(set(names)) != len(names) or len(names) > _MOST_GRIPPERS:
        raise ParameterFault(f"grippers is {names}: give at most {_MOST_GRIPPERS} different names")
    return names


def settings_of(read: Callable[[str], Any]) -> Settings:
    """The settings of the values of declared parameters.

    Raises:
        ParameterFault: If a value is not possible.
    """
    values = {parameter.name: _checked(parameter, "", read) for parameter in PARAMETERS}
    low, high = values["cloud.low"], values["cloud.high"]
    if not all(a < b for a, b in zip(low, high, strict=True)):
        raise ParameterFault(f"cloud.low is {low}: give numbers below those of cloud.high, {high}")
    grippers = tuple(_gripper(name, read) for name in gripper_names(values["grippers"]))
    hands = [gripper.hand for gripper in grippers if gripper.hand is not None]
    if len(set(hands)) != len(hands):
        raise ParameterFault("two grippers have the same `hand`: give each its own, or -1")
    return Settings(values, grippers)


def _gripper(name: str, read: Callable[[str], Any]) -> GripperSettings:
    values = {p.name: _checked(p, f"{name}.", read) for p in GRIPPER_PARAMETERS}
    if not values["frame"]:
        raise ParameterFault(
            f"{name}.frame is empty: name the frame between the tips of the gripper's fingers"
        )
    hand, force = values.pop("hand"), values.pop("max_force_n")
    joints, center = values.pop("joints"), values.pop("region_center")
    x, y, z = (float(value) for value in center)
    return GripperSettings(
        name=name,
        hand=None if hand < 0 else int(hand),
        max_force_n=force or None,
        joints=tuple(joint for joint in joints if joint),
        region_center=(x, y, z),
        **values,
    )


def _checked(parameter: Parameter, prefix: str, read: Callable[[str], Any]) -> Any:
    name = prefix + parameter.name
    value = read(name)
    try:
        holds = parameter.holds(value)
    except (TypeError, ValueError):
        holds = False
    if not holds:
        raise ParameterFault(f"{name} is {value!r}: give {parameter.needs}")
    return value
