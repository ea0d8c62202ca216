"""Grippers: bodies or sites of a MuJoCo model that hold a twin, and when they are closed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import mujoco

from bendtwin.simulation.world import Grasp

#: Whether a gripper is closed, by model and data.
Condition = Callable[[Any, Any], bool]

_ONE_COORDINATE = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


@dataclass(frozen=True, kw_only=True)
class ClosedWhen:
    """The condition that a joint's position or an actuator's control is beyond a threshold."""

    #: Name of a hinge or slide joint, compared by its position, radians or metres.
    joint: str | None = None
    #: Name of an actuator, compared by its control value.
    actuator: str | None = None
    #: Closed while the value is below this ...
    below: float | None = None
    #: ... or above this.
    above: float | None = None

    def condition(self, model: Any) -> Condition:
        """The condition in a model.

        Raises:
            ValueError: If the model has no such joint or actuator, or the threshold is not one.
        """
        if (self.below is None) == (self.above is None):
            raise ValueError("give ClosedWhen either below or above")
        if (self.joint is None) == (self.actuator is None):
            raise ValueError("give ClosedWhen either joint or actuator")
        if self.joint is not None:
            joint = named(model, "joint", self.joint)
            if mujoco.mjtJoint(int(model.jnt_type[joint])) not in _ONE_COORDINATE:
                raise ValueError(f"joint {self.joint!r} is neither a hinge nor a slide joint")
            array, index = "qpos", model.jnt_qposadr[joint]
        else:
            array, index = "ctrl", named(model, "actuator", str(self.actuator))
        if self.below is not None:
            below = self.below
            return lambda _, data: bool(getattr(data, array)[index] < below)
        above = self.above
        return lambda _, data: bool(getattr(data, array)[index] > above)


@dataclass(frozen=True, init=False)
class Gripper:
    """A body or site of the model that holds the object by grasps, while it is closed."""

    #: Grasps with regions in the coordinates of the body or site; their numbers of grippers are
    #: set by the coupling.
    grasps: tuple[Grasp, ...]
    #: True, False, a condition, or a function of model and data. It is evaluated at the start of
    #: each frame and holds for the whole frame.
    closed: bool | ClosedWhen | Condition = True

    def __init__(self, *grasps: Grasp, closed: bool | ClosedWhen | Condition = True) -> None:
        for grasp in grasps:
            if grasp.closed is not True:
                raise ValueError("give closed to the Gripper, not to its grasps")
        object.__setattr__(self, "grasps", grasps)
        object.__setattr__(self, "closed", closed)

    def condition(self, model: Any) -> Condition:
        """The condition under which it is closed in a model."""
        closed = self.closed
        if isinstance(closed, ClosedWhen):
            return closed.condition(model)
        if callable(closed):
            return closed
        always = bool(closed)
        return lambda *_: always

    def numbered(self, number: int) -> list[Grasp]:
        """The grasps of this gripper, given its number."""
        return [replace(grasp, gripper=number) for grasp in self.grasps]


def named(model: Any, kind: str, name: str) -> int:
    """The number of a joint, actuator, body, site or geom of a model.

    Raises:
        ValueError: If it has none of that name.
    """
    found = find(model, kind, name)
    if found < 0:
        raise ValueError(f"the model has no {kind} {name!r}")
    return found


def find(model: Any, kind: str, name: str) -> int:
    """The same, or -1."""
    kinds = mujoco.mjtObj
    number: int = mujoco.mj_name2id(model, getattr(kinds, f"mjOBJ_{kind.upper()}"), name)
    return number
