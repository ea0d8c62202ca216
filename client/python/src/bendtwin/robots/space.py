"""Plans in joint space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.planners.plan import Planned
from bendtwin.planners.task import Task
from bendtwin.robots.description import RobotError
from bendtwin.robots.path import JointPath
from bendtwin.robots.transforms import Array
from bendtwin.robots.workcell import Workcell
from bendtwin.simulation.bounds import Bounds
from bendtwin.simulation.world import World

#: Distance beyond its limits at which a start counts as on them [rad or m].
_NEARLY = 1e-2


class JointSpace:
    """Joints of a robot: D of them move, the others stay at the start. Coordinates are differences
    from the start.

    A task with this space has the world of the workcell, planners keep the limits of the joints,
    and a plan in which the robot gets deeper into the ground or into a static collider than is
    allowed, or than it is at the start, is worse than every plan in which it does not.
    """

    def __init__(
        self,
        cell: Workcell,
        start: npt.ArrayLike,
        *,
        joints: Sequence[str] | None = None,
        allowed_depth_m: float = 0.005,
    ) -> None:
        """Plans from joints.

        Args:
            cell: The robot among its surroundings.
            start: Joints [J] when planning begins; `Robot.positions` has them by name.
            joints: Joints that move; None: those that move a tip.
            allowed_depth_m: Depth that links may have in the ground and in static colliders.

        Raises:
            RobotError: If a joint that moves has no limits, or is beyond them.
        """
        robot = cell.robot
        self.cell: Workcell = cell
        self.start: Array = robot.checked(start)
        if self.start.ndim != 1:
            raise ValueError(f"start has shape {self.start.shape}: give [{len(robot.joints)}]")
        moving = np.flatnonzero(robot.moving_joints(robot.tips))
        if joints is not None:
            moving = np.array([robot.joint_index(name) for name in dict.fromkeys(joints)], int)
        if not len(moving):
            raise RobotError("no joint moves: name some, joints=[...]")
        self._moving: npt.NDArray[np.int64] = moving
        #: Names of the joints that move [D].
        self.joints: tuple[str, ...] = tuple(robot.joint_names[i] for i in moving)
        self.allowed_depth_m: float = max(allowed_depth_m, float(cell.depths(self.start)))
        for i in moving:
            _check_limits(robot.joints[i], float(self.start[i]))
        own = self.start[moving]
        #: Limits of the coordinates.
        self.bounds: Bounds = Bounds(
            low=np.minimum(robot.low[moving] - own, 0.0),
            high=np.maximum(robot.high[moving] - own, 0.0),
            speed=robot.speed[moving],
        )

    @property
    def dims(self) -> int:
        """Number of joints that move."""
        return len(self.joints)

    @property
    def world(self) -> World:
        """The world of the workcell."""
        return self.cell.world

    def positions(self, knots: npt.ArrayLike) -> Array:
        """Joints [..., J] of coordinates [..., D]."""
        changes = np.asarray(knots, dtype=np.float64)
        positions = np.broadcast_to(self.start, (*changes.shape[:-1], len(self.start))).copy()
        positions[..., self._moving] += changes
        return positions

    def coordinates(self, joints: npt.ArrayLike) -> Array:
        """Coordinates [..., D] of joints [..., J], such as those of `Robot.inverse`."""
        return np.asarray((self.cell.robot.checked(joints) - self.start)[..., self._moving])

    def actions(self, knots: Array) -> dict[str, Any]:
        """Arguments of `Twin.rollout` for coordinates at every frame boundary, [B, F + 1, D]."""
        return self.cell.actions(self.positions(knots))

    def gradients(self, knots: Array, by_actions: Array) -> Array:
        """d cost / d coordinates [B, K, D] by d cost / d poses [B, K, G, 7]."""
        link_poses = self.cell.robot.link_poses(self.positions(knots))
        return np.asarray(self.cell.gradients(link_poses, by_actions)[..., self._moving])

    def excess(self, knots: Array) -> npt.NDArray[np.float64]:
        """How much deeper than allowed the robot is in the ground or in a static collider, metres,
        in any row of coordinates [B, K, D]: [B]."""
        depths = self.cell.depths(self.positions(knots)).max(axis=1)
        return np.asarray(np.maximum(depths - self.allowed_depth_m, 0.0))

    def path(self, plan: Planned, frames: int | None = None) -> JointPath:
        """All joints along a plan in this space, or along its first frames, with times."""
        task = plan.problem
        if not isinstance(task, Task) or task.space is not self:
            raise TypeError("the plan is in another space")
        count = task.frames if frames is None else frames
        if not 1 <= count <= task.frames:
            raise ValueError(f"the plan has {task.frames} frames: give 1..{task.frames}")
        positions = self.positions(task.path(plan.knots[None])[0, : count + 1])
        times = np.asarray(np.arange(count + 1) * task.frame_s, dtype=np.float64)
        return JointPath(self.cell.robot.joint_names, times, positions)


def _check_limits(joint: Any, start: float) -> None:
    limits = joint.limits
    unbounded = not np.isfinite([limits.low, limits.high]).all()
    if joint.kind != "continuous" and unbounded:
        what = "limits of its position"
    elif not 0.0 < limits.speed < np.inf:
        what = "a speed above 0"
    elif limits.low == limits.high:
        what = "room between its limits"
    else:
        if not limits.low - _NEARLY <= start <= limits.high + _NEARLY:
            raise RobotError(
                f"joint {joint.name!r} starts at {start:.4g}, beyond its limits {limits.low:.4g} "
                f"and {limits.high:.4g}"
            )
        return
    raise RobotError(
        f"joint {joint.name!r} has no {what}: give the robot limits={{{joint.name!r}: "
        "Limits(low=..., high=..., speed=...)}, or name the joints that move, joints=[...]"
    )
