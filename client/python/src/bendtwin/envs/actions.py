"""Actions of an environment: pose changes of its grippers and their openings.

A step moves every gripper by knots: each knot changes the pose of the one before, and says whether
the gripper is open. Changes are numbers from -1 to 1, in parts of the largest change, as policies
want them; limits keep the grippers in their workspace and out of the ground.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bendtwin import rotations
from bendtwin.envs.body import Body

Array = npt.NDArray[np.floating[Any]]

#: Coordinates of a knot by gripper: a translation, a rotation vector, an opening.
PER_GRIPPER = 7
#: Largest steps where nothing is said: in lengths of the object, and radians.
_TRANSLATION, _ROTATION = 0.08, 0.25
#: Steps a second where nothing is said.
_STEPS_S = 10.0


@dataclass(frozen=True, kw_only=True)
class Actions:
    """What an action means.

    An action has 7 numbers from -1 to 1 for each knot and gripper: x, y, z and a rotation vector,
    in parts of the largest change, and the opening, at which the gripper is closed below 0 and
    open from 0 on. A gripper closes before it moves.
    """

    #: Largest change of a coordinate between knots, metres. None: 0.08 lengths of the object.
    translation_m: float | None = None
    #: Largest change of a coordinate of the rotation vector between knots, radians.
    rotation_rad: float = _ROTATION
    #: The axes of changes: those of the world, or those of the gripper before the change.
    axes: Literal["world", "gripper"] = "world"
    #: Knots of an action.
    knots: int = 1
    #: Frames of a step. None: as many as a tenth of a second has.
    frames: int | None = None
    #: Force beyond which a grasp slips, newtons (per unit mass without a `mass_kg`); None: never.
    slip_force_n: float | None = None

    def __post_init__(self) -> None:
        if self.knots < 1 or (self.frames is not None and self.frames < self.knots):
            raise ValueError("give at least one knot, and a frame for each knot")


@dataclass(frozen=True)
class Workspace:
    """The box in which the middles of grippers stay, in metres."""

    low: Array
    high: Array

    @classmethod
    def around(cls, body: Body, floor_m: float) -> Workspace:
        """Room to move an object by more than its length to all sides, from a height on."""
        reach = 1.5 * body.length_m
        middle = body.middle
        low = np.array([*(middle[:2] - reach), floor_m])
        return cls(low, np.array([*(middle[:2] + reach), body.ground_m + 1.2 * body.length_m]))


class Mover:
    """Turns actions [B, K * G * 7] into poses of grippers."""

    def __init__(self, actions: Actions, body: Body, grippers: int, workspace: Workspace) -> None:
        self.settings, self.grippers, self.workspace = actions, grippers, workspace
        self.frames: int = actions.frames or max(actions.knots, round(body.geometry.fps / _STEPS_S))
        translation = actions.translation_m
        if translation is None:
            translation = _TRANSLATION * body.length_m
        #: Largest change of the coordinates of a pose [6].
        self.largest: Array = np.repeat([translation, actions.rotation_rad], 3)
        #: Numbers of an action.
        self.size: int = actions.knots * grippers * PER_GRIPPER

    def moved(self, poses: Array, actions: npt.ArrayLike) -> tuple[Array, npt.NDArray[np.bool_]]:
        """The poses of knots [B, K + 1, G, 7], beginning with the given ones [B, G, 7], and
        whether the grippers are closed from each knot on, [B, K + 1, G]."""
        given = np.clip(np.asarray(actions, np.float64), -1.0, 1.0)
        given = given.reshape(len(poses), self.settings.knots, self.grippers, PER_GRIPPER)
        changes = given[..., :6] * self.largest
        way: list[Array] = [np.asarray(poses, np.float64)]
        for knot in range(self.settings.knots):
            way.append(self._changed(way[-1], changes[:, knot]))
        closed = given[..., 6] < 0.0
        return np.stack(way, axis=1), np.concatenate([closed, closed[:, -1:]], axis=1)

    def towards(self, poses: Array, goals: Array, closed: npt.NDArray[np.bool_]) -> Array:
        """The actions [B, K * G * 7] that bring grippers [B, G, 7] nearest to goals [B, G, 7]."""
        knots = self.settings.knots
        shift = goals[..., :3] - poses[..., :3]
        turn = rotations.logarithm(
            rotations.product(goals[..., 3:], rotations.conjugate(poses[..., 3:]))
        )
        if self.settings.axes == "gripper":
            back = rotations.conjugate(poses[..., 3:])
            shift, turn = rotations.rotated(back, shift), rotations.rotated(back, turn)
        parts = np.concatenate([shift, turn], axis=-1) / (knots * self.largest)
        # All coordinates of a kind together, so that the way is straight.
        for kind in (slice(0, 3), slice(3, 6)):
            most = np.abs(parts[..., kind]).max(axis=-1, keepdims=True)
            parts[..., kind] /= np.maximum(most, 1.0)
        opening = np.where(closed, -1.0, 1.0)[..., None]
        one = np.concatenate([parts, opening], axis=-1)[:, None]
        return np.repeat(one, knots, axis=1).reshape(len(poses), -1).astype(np.float32)

    def inside(self, poses: Array) -> Array:
        """Poses [..., 7] with their places in the workspace."""
        places = np.clip(poses[..., :3], self.workspace.low, self.workspace.high)
        return np.concatenate([places, poses[..., 3:]], axis=-1)

    def _changed(self, poses: Array, changes: Array) -> Array:
        shift, turn = changes[..., :3], changes[..., 3:]
        if self.settings.axes == "gripper":
            shift = rotations.rotated(poses[..., 3:], shift)
            turn = rotations.rotated(poses[..., 3:], turn)
        turned = rotations.product(rotations.exponential(turn), poses[..., 3:])
        turned /= np.linalg.norm(turned, axis=-1, keepdims=True)
        return self.inside(np.concatenate([poses[..., :3] + shift, turned], axis=-1))
