"""Arguments of a rollout: one list of them for twins and sessions, and the message they make."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypedDict

import numpy.typing as npt

from bendtwin.simulation.actions import control_trajectories, gripper_poses, knot_times
from bendtwin.simulation.costs import Cost
from bendtwin.simulation.interpolation import Interpolation
from bendtwin.simulation.rollout import FIDELITIES, Fidelity, Returns
from bendtwin.simulation.state import InitialState, Rest
from bendtwin.simulation.world import (
    Ensemble,
    GradientOptions,
    Grasp,
    Plausibility,
    Surroundings,
    Vary,
    World,
)
from bendtwin.v1 import rollout_pb2


class RolloutArguments(TypedDict, total=False):
    """Arguments of a rollout. Give trajectories or poses; all others have a default."""

    #: Positions [m] of every control point, [B, K, C, 3]. With `frames` left out K = F + 1: row 0
    #: belongs to the initial state. Otherwise K >= 2 knots are spread evenly over the horizon.
    trajectories: npt.ArrayLike | None
    #: Instead of trajectories, poses of grippers that carry their control points rigidly,
    #: [B, K, G, 7]: x, y, z, quaternion x, y, z, w.
    poses: npt.ArrayLike | None
    #: The gripper of each control point [C]; None means gripper 0.
    gripper_of_control: npt.ArrayLike | None
    #: Curve between knots: "linear" (the default), "cubic", or "zero", where each holds until the
    #: next; `bendtwin.interpolate` computes the same.
    interpolation: Interpolation
    #: Times of the knots [K], seconds from the start, increasing from 0; the last holds until the
    #: end. Give `frames` too.
    at_s: npt.ArrayLike | None
    #: Instead, seconds from knot to knot: a controller's period, independent of the twin's frame
    #: rate.
    period_s: float | None
    #: State to start from; the rest shape by default.
    initial: InitialState
    #: Horizon F; 0, the default, means the horizon of the dense actions.
    frames: int
    #: Terms that are summed into `RolloutResult.costs`.
    costs: Iterable[Cost]
    #: Arrays to return in addition to the costs; no others by default.
    returns: Returns
    #: Model: "exact" (the default); "fast", the fast variant with fewer substeps; or "planner", the
    #: planner's twin, a small model. `RolloutResult.deviation` has the deviation of the latter two.
    fidelity: Fidelity
    #: Ground, gravity and colliders, where they differ from those of the twin.
    world: World | None
    #: Grasps of the object, which open and close; they need `poses`.
    grasps: Sequence[Grasp]
    #: Parameters by instance, as factors of the twin's parameters.
    vary: Vary | None
    #: Simulates every action under the sets of parameters of `vary`.
    ensemble: Ensemble | None
    #: Reach of gradients, and smoothing of contact.
    gradient: GradientOptions | None
    #: Limits of plausible motion. Instances beyond them are in `RolloutResult.implausible`, and one
    #: RuntimeWarning names the first.
    plausibility: Plausibility | None
    #: Seconds from the arrival of the request after which no further instances are simulated;
    #: `RolloutResult.unfinished` has the missing ones. After a call's `timeout_s`, in contrast,
    #: nothing is returned.
    time_limit_s: float | None


def rollout_request(twin: str, arguments: RolloutArguments) -> rollout_pb2.RollOutRequest:
    """The request message of a rollout of a twin.

    Raises:
        TypeError: If a rollout has no argument of a name.
        ValueError: If an array's shape or content is wrong.
    """
    unknown = sorted(arguments.keys() - RolloutArguments.__optional_keys__)
    if unknown:
        known = ", ".join(sorted(RolloutArguments.__optional_keys__))
        raise TypeError(f"a rollout has no argument {unknown[0]!r}; it has {known}")
    fidelity = arguments.get("fidelity", "exact")
    if fidelity not in FIDELITIES:
        raise ValueError(f"give either of {sorted(FIDELITIES)} as fidelity, not {fidelity!r}")
    request = rollout_pb2.RollOutRequest(
        twin=twin,
        initial=arguments.get("initial", Rest()).to_proto(),
        frames=arguments.get("frames", 0),
        costs=[cost.to_proto() for cost in arguments.get("costs", ())],
        returns=arguments.get("returns", Returns()).to_proto(),
        fidelity=FIDELITIES[fidelity],
    )
    time_limit_s = arguments.get("time_limit_s")
    if time_limit_s is not None:
        request.time_limit_s = time_limit_s
    _add_actions(request, arguments)
    Surroundings(
        world=arguments.get("world"),
        grasps=arguments.get("grasps", ()),
        vary=arguments.get("vary"),
        ensemble=arguments.get("ensemble"),
        gradient=arguments.get("gradient"),
        plausibility=arguments.get("plausibility"),
    ).add_to(request)
    return request


def _add_actions(request: rollout_pb2.RollOutRequest, arguments: RolloutArguments) -> None:
    trajectories, poses = arguments.get("trajectories"), arguments.get("poses")
    gripper_of_control = arguments.get("gripper_of_control")
    interpolation = arguments.get("interpolation", "linear")
    if (trajectories is None) == (poses is None):
        raise ValueError("give either trajectories or poses")
    if trajectories is not None and gripper_of_control is not None:
        raise ValueError("gripper_of_control goes with poses, not with trajectories")
    times = knot_times(arguments.get("at_s"), arguments.get("period_s"))
    if times is not None:
        request.knot_times.CopyFrom(times)
    if trajectories is not None:
        request.trajectories.CopyFrom(control_trajectories(trajectories, interpolation))
    elif poses is not None:
        request.poses.CopyFrom(gripper_poses(poses, gripper_of_control, interpolation))
