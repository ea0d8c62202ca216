"""Action spaces: what the coordinates of a plan move.

A plan consists of knots [K, D]. Coordinates are differences from the start of the space, so that
zeros always mean to stay there: `start` has the positions of the control points, or the poses of
the grippers, when planning begins. It does not move with the loop; row 0 of a plan is their current
position.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from bendtwin import rotations
from bendtwin.simulation.bounds import Bounds
from bendtwin.simulation.world import World
from bendtwin.tensors import pack_floats, pack_indices
from bendtwin.v1 import planning_pb2

Array = npt.NDArray[np.float64]


class ActionSpace(Protocol):
    """Coordinates of a plan, and the actions that they stand for."""

    @property
    def dims(self) -> int:
        """Number of coordinates D of a knot."""

    def actions(self, knots: Array) -> dict[str, Any]:
        """Arguments of `Twin.rollout` for knots [B, K, D]."""

    def gradients(self, knots: Array, by_actions: Array) -> Array:
        """d cost / d knots [B, K, D] of the gradient by what `actions` gives, in its shape."""


@runtime_checkable
class MachineSpace(ActionSpace, Protocol):
    """Coordinates of a machine, such as the joints of a robot: `bendtwin.robots.JointSpace`.

    Its actions are not linear in the coordinates, so that a task interpolates the latter and asks
    for the actions of every frame. It brings its parts into the world, and it has limits.
    """

    @property
    def world(self) -> World:
        """World of the task, which itself has none."""

    @property
    def bounds(self) -> Bounds:
        """Limits of the coordinates, which every planner keeps."""

    def excess(self, knots: Array) -> npt.NDArray[np.float64]:
        """How far the motions [B, K, D] are beyond a limit of the machine itself, 0 where they are
        not [B]: plans beyond it are worse than all that keep it."""


class _Trajectories:
    """Spaces in which control points follow the coordinates linearly."""

    start: Array
    _coordinates: ClassVar[planning_pb2.ActionSpace.Coordinates.ValueType]

    @property
    def dims(self) -> int:
        raise NotImplementedError

    def _offsets(self, knots: Array) -> Array:
        """Displacements [B, K, C or 1, 3]."""
        raise NotImplementedError

    def actions(self, knots: Array) -> dict[str, Any]:
        """Arguments of `Twin.rollout` for knots [B, K, D]."""
        return {"trajectories": (self.start + self._offsets(knots)).astype(np.float32)}

    def to_proto(self) -> planning_pb2.ActionSpace:
        """The same space at the server."""
        start = pack_floats("start", self.start, (None, 3))
        return planning_pb2.ActionSpace(coordinates=self._coordinates, start=start)


class Together(_Trajectories):
    """All control points move by the same offset, as one gripper that does not turn: D = 3."""

    _coordinates = planning_pb2.ActionSpace.TOGETHER

    def __init__(self, start: npt.ArrayLike) -> None:
        """`start`: control points [C, 3] in metres."""
        self.start: Array = _points(start)

    @property
    def dims(self) -> int:
        """3: x, y, z."""
        return 3

    def _offsets(self, knots: Array) -> Array:
        return knots[:, :, None]

    def gradients(self, knots: Array, by_actions: Array) -> Array:
        """d cost / d knots, [B, K, 3]."""
        return np.asarray(by_actions.sum(axis=2), dtype=np.float64)


class PerHand(_Trajectories):
    """Each hand moves its control points by a separate offset: D = 3 H."""

    _coordinates = planning_pb2.ActionSpace.PER_GROUP

    def __init__(self, start: npt.ArrayLike, hand_of_control: npt.ArrayLike) -> None:
        """`start`: control points [C, 3] in metres; `hand_of_control`: the hand of each, [C]."""
        self.start: Array = _points(start)
        self.hand_of_control: npt.NDArray[np.int64] = _owners(
            "hand_of_control", hand_of_control, len(self.start)
        )
        self.hands: int = int(self.hand_of_control.max()) + 1

    @property
    def dims(self) -> int:
        """3 for each hand."""
        return 3 * self.hands

    def _offsets(self, knots: Array) -> Array:
        return knots.reshape(*knots.shape[:2], self.hands, 3)[:, :, self.hand_of_control]

    def gradients(self, knots: Array, by_actions: Array) -> Array:
        """d cost / d knots, [B, K, 3 H]."""
        sums = np.zeros((*knots.shape[:2], self.hands, 3))
        for hand in range(self.hands):
            sums[:, :, hand] = by_actions[:, :, self.hand_of_control == hand].sum(axis=2)
        return sums.reshape(knots.shape)

    def to_proto(self) -> planning_pb2.ActionSpace:
        """The same space at the server."""
        space = super().to_proto()
        groups = pack_indices("hand_of_control", self.hand_of_control)
        space.group_of_control.CopyFrom(groups)
        return space


class Points(_Trajectories):
    """Every control point moves by a separate offset: D = 3 C."""

    _coordinates = planning_pb2.ActionSpace.POINTS

    def __init__(self, start: npt.ArrayLike) -> None:
        """`start`: control points [C, 3] in metres."""
        self.start: Array = _points(start)

    @property
    def dims(self) -> int:
        """3 for each control point."""
        return int(self.start.size)

    def _offsets(self, knots: Array) -> Array:
        return knots.reshape(*knots.shape[:2], len(self.start), 3)

    def gradients(self, knots: Array, by_actions: Array) -> Array:
        """d cost / d knots, [B, K, 3 C]."""
        return np.asarray(by_actions, dtype=np.float64).reshape(knots.shape)


@dataclass(frozen=True)
class Grippers:
    """Rigid grippers that carry their control points: D = 6 G.

    The coordinates of a gripper are x, y, z [m] and a rotation vector [rad] along the world's
    axes, both from its pose in `start`.
    """

    #: Poses [G, 7]: x, y, z, quaternion x, y, z, w.
    start: npt.ArrayLike
    #: The gripper of each control point [C]; None means that gripper 0 has all.
    gripper_of_control: npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        start = np.array(self.start, dtype=np.float64)
        if start.ndim != 2 or start.shape[1] != 7 or not len(start):
            raise ValueError(f"start has shape {start.shape}: give poses [G, 7]")
        norms = np.linalg.norm(start[:, 3:], axis=-1, keepdims=True)
        if not np.isfinite(start).all() or (norms < 1e-6).any():
            raise ValueError("start has values that are not finite, or a quaternion of zeros")
        start[:, 3:] /= norms
        object.__setattr__(self, "start", start)

    @classmethod
    def around(
        cls, controls: npt.ArrayLike, gripper_of_control: npt.ArrayLike | None = None
    ) -> Grippers:
        """Grippers that turn about the middle of the control points [C, 3] that they hold."""
        points = _points(controls)
        owners = np.zeros(len(points), np.int64)
        if gripper_of_control is not None:
            owners = _owners("gripper_of_control", gripper_of_control, len(points))
        start = np.zeros((int(owners.max()) + 1, 7))
        start[:, 6] = 1.0
        for gripper in np.unique(owners):
            start[gripper, :3] = points[owners == gripper].mean(axis=0)
        return cls(start, None if gripper_of_control is None else owners)

    @property
    def dims(self) -> int:
        """6 for each gripper."""
        return 6 * len(np.asarray(self.start))

    def actions(self, knots: Array) -> dict[str, Any]:
        """Arguments of `Twin.rollout` for knots [B, K, D]."""
        start = np.asarray(self.start)
        moves = self._split(knots)
        turned = rotations.product(rotations.exponential(moves[..., 3:]), start[:, 3:])
        poses = np.concatenate([start[:, :3] + moves[..., :3], turned], axis=-1)
        named: dict[str, Any] = {"poses": poses.astype(np.float32)}
        if self.gripper_of_control is not None:
            named["gripper_of_control"] = self.gripper_of_control
        return named

    def gradients(self, knots: Array, by_actions: Array) -> Array:
        """d cost / d knots [B, K, D] from d cost / d poses [B, K, G, 7]."""
        moves = self._split(knots)
        jacobian = rotations.exponential_jacobian(moves[..., 3:])
        # q = exp(r) q0 is linear in exp(r): its columns are the products of the units with q0.
        start = np.asarray(self.start)[:, 3:]
        units = rotations.product(np.eye(4), start[:, None, :])
        by_exponential = np.einsum("...gj,guj->...gu", by_actions[..., 3:], units)
        by_vector = np.einsum("...u,...uv->...v", by_exponential, jacobian)
        joined = np.concatenate([by_actions[..., :3], by_vector], axis=-1)
        return np.asarray(joined, dtype=np.float64).reshape(knots.shape)

    def to_proto(self) -> planning_pb2.ActionSpace:
        """The same space at the server; the actions say which control points a gripper has."""
        start = pack_floats("start", self.start, (None, 7))
        return planning_pb2.ActionSpace(coordinates=planning_pb2.ActionSpace.RIGID, start=start)

    def _split(self, knots: Array) -> Array:
        return knots.reshape(*knots.shape[:-1], len(np.asarray(self.start)), 6)


def _points(values: npt.ArrayLike) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3 or not len(array):
        raise ValueError(f"start has shape {array.shape}: give control points [C, 3]")
    if not np.isfinite(array).all():
        raise ValueError("start has values that are not finite")
    return array


def _owners(name: str, values: npt.ArrayLike, count: int) -> npt.NDArray[np.int64]:
    array = np.asarray(values)
    if array.shape != (count,) or not np.issubdtype(array.dtype, np.integer) or array.min() < 0:
        raise ValueError(f"{name} must be one index for each of {count} control points")
    return array.astype(np.int64)
