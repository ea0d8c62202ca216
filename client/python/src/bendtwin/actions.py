"""Inputs of a rollout: actions and initial states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from bendtwin.tensors import pack_floats, pack_indices
from bendtwin.v1 import rollout_pb2, tensor_pb2

Interpolation = Literal["linear", "cubic"]

_INTERPOLATIONS: dict[str, rollout_pb2.Interpolation] = {
    "linear": rollout_pb2.LINEAR,
    "cubic": rollout_pb2.CUBIC,
}


@dataclass(frozen=True)
class Rest:
    """The twin's rest shape, not moving."""

    def to_proto(self) -> rollout_pb2.InitialState:
        """Makes the wire form."""
        return rollout_pb2.InitialState(rest=rollout_pb2.InitialState.Rest())


@dataclass(frozen=True)
class CaptureFrame:
    """The twin's state after following its capture's own controls up to a frame."""

    frame: int
    sequence: int = 0
    #: captures/{uuid}; empty means the twin's own capture.
    capture: str = ""

    def to_proto(self) -> rollout_pb2.InitialState:
        """Makes the wire form."""
        return rollout_pb2.InitialState(
            capture_frame=rollout_pb2.InitialState.CaptureFrame(
                capture=self.capture, sequence=self.sequence, frame=self.frame
            )
        )


@dataclass(frozen=True)
class GivenState:
    """Given positions [m] and velocities [m/s], shape [N, 3] for all instances or [B, N, 3], and
    twists of the twin's rods [rad], shape [rods] or [B, rods]."""

    positions: npt.ArrayLike
    #: None means at rest.
    velocities: npt.ArrayLike | None = None
    #: None means that no rod is twisted.
    twists: npt.ArrayLike | None = None

    def to_proto(self) -> rollout_pb2.InitialState:
        """Makes the wire form."""
        given = rollout_pb2.InitialState.GivenState(
            positions=_pack_nodes("initial positions", self.positions)
        )
        if self.velocities is not None:
            given.velocities.CopyFrom(_pack_nodes("initial velocities", self.velocities))
        if self.twists is not None:
            batched = np.ndim(self.positions) == 3
            shape = (None, None) if batched else (None,)
            given.twists.CopyFrom(pack_floats("initial twists", self.twists, shape))
        return rollout_pb2.InitialState(given=given)


InitialState = Rest | CaptureFrame | GivenState


def control_trajectories(
    positions: npt.ArrayLike, interpolation: Interpolation
) -> rollout_pb2.ControlTrajectories:
    """Positions [m] of every control point, shape [B, K, C, 3]."""
    return rollout_pb2.ControlTrajectories(
        positions=pack_floats("trajectories", positions, (None, None, None, 3)),
        interpolation=_INTERPOLATIONS[interpolation],
    )


def gripper_poses(
    poses: npt.ArrayLike,
    gripper_of_control: npt.ArrayLike | None,
    interpolation: Interpolation,
) -> rollout_pb2.GripperPoses:
    """Poses (x, y, z, quaternion x, y, z, w) of grippers, shape [B, K, G, 7]."""
    message = rollout_pb2.GripperPoses(
        poses=pack_floats("poses", poses, (None, None, None, 7)),
        interpolation=_INTERPOLATIONS[interpolation],
    )
    if gripper_of_control is not None:
        message.gripper_of_control.CopyFrom(pack_indices("gripper_of_control", gripper_of_control))
    return message


def _pack_nodes(name: str, values: npt.ArrayLike) -> tensor_pb2.Tensor:
    array = np.asarray(values)
    batch = (None,) if array.ndim == 3 else ()
    return pack_floats(name, array, (*batch, None, 3))
