"""Inputs of a rollout: actions, and what comes with them."""

from __future__ import annotations

import numpy.typing as npt

from bendtwin.simulation.interpolation import Interpolation
from bendtwin.simulation.state import CaptureFrame, GivenState, InitialState, Rest
from bendtwin.tensors import pack_floats, pack_indices
from bendtwin.v1 import rollout_pb2

__all__ = [
    "CaptureFrame",
    "GivenState",
    "InitialState",
    "Interpolation",
    "Rest",
    "control_trajectories",
    "gripper_poses",
    "knot_times",
]

_INTERPOLATIONS: dict[str, rollout_pb2.Interpolation.ValueType] = {
    "linear": rollout_pb2.LINEAR,
    "cubic": rollout_pb2.CUBIC,
    "zero": rollout_pb2.ZERO,
}


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


def knot_times(at_s: npt.ArrayLike | None, period_s: float | None) -> rollout_pb2.KnotTimes | None:
    """Times of the knots of actions; None: they are spread evenly over the horizon."""
    if at_s is not None and period_s is not None:
        raise ValueError("give either at_s or period_s")
    if at_s is not None:
        return rollout_pb2.KnotTimes(at_s=pack_floats("at_s", at_s, (None,)))
    return None if period_s is None else rollout_pb2.KnotTimes(period_s=period_s)
