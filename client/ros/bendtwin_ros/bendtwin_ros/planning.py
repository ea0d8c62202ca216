"""Planning: a goal of the action becomes a search at the server, and its plan becomes waypoints."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from bendtwin import (
    BendTwinError,
    Bounds,
    Geometry,
    Keypoints,
    PlanUpdate,
    Plausibility,
    Returns,
    Search,
    TargetCloud,
    World,
)
from bendtwin_ros import clouds, hulls
from bendtwin_ros.frames import Frames, MissingTransform
from bendtwin_ros.grippers import Hands
from bendtwin_ros.link import PLANNED
from bendtwin_ros.messages.basic import Header, PoseArray
from bendtwin_ros.messages.own import GripperPath, PlanFeedback, PlanGoal, PlanResult
from bendtwin_ros.messages.scene import AttachedCollisionObject
from bendtwin_ros.parameters import Settings
from bendtwin_ros.poses import (
    Array,
    applied,
    between,
    duration_of,
    inverse,
    points_of,
    time_of,
    to_pose,
)
from bendtwin_ros.scene import Obstacles, SceneFault
from bendtwin_ros.tracker import Estimate

_MOST_TARGETS = 20_000
_MOST_HULLS = 64
#: Times at which the hull takes the object's points.
_HULL_TIMES = 24


class GoalFault(ValueError):
    """A goal that cannot be planned for; the message says what to change."""

    reason = "INVALID_GOAL"


@dataclass(frozen=True)
class Plan:
    """A search at the server: arguments of `Session.stream_plan`."""

    arguments: dict[str, Any]
    horizon_s: float
    #: Numbers of the grippers that move.
    moving: tuple[int, ...]


def plan_of(
    goal: PlanGoal,
    settings: Settings,
    geometry: Geometry,
    hands: Hands,
    estimate: Estimate,
    obstacles: Obstacles,
    frames: Frames,
) -> Plan:
    """The search for a goal, from where object and grippers are.

    Raises:
        GoalFault: If the goal, its scene or its frames are wrong.
    """
    try:
        world = obstacles.and_of(goal.scene).world(
            settings["twin_frame"],
            frames,
            friction=settings["plan.friction"],
            margin_m=settings["plan.margin_m"],
        )
        costs = _costs(goal, settings, geometry, frames)
    except (SceneFault, MissingTransform, clouds.CloudFault) as fault:
        raise GoalFault(str(fault)) from fault
    horizon_s = _within("horizon_s", goal.horizon_s or 2.0, settings["plan.max_horizon_s"])
    frames_count = max(math.ceil(horizon_s * geometry.fps), 1)
    knots = _default(goal.knots, settings["plan.knots"], "knots", 64)
    moving = _moving(goal, hands)
    return Plan(
        arguments={
            "slot": PLANNED,
            "poses": np.repeat(estimate.poses[None, None], knots, axis=1),
            "gripper_of_control": hands.gripper_of_control,
            "grasps": hands.grasps([hands.holds()]),
            "frames": frames_count,
            "costs": costs,
            "world": world,
            "space": "rigid",
            "search": _search(goal, settings, hands, moving),
            "plausibility": _limits(world),
            "returns": _returns(goal, frames_count),
        },
        horizon_s=frames_count / geometry.fps,
        moving=moving,
    )


def search(
    session: Any,
    plan: Plan,
    cancelled: Callable[[], bool],
    feedback: Callable[[PlanFeedback], None],
) -> PlanUpdate | None:
    """Runs a search; None if it was cancelled.

    Raises:
        BendTwinError: If the server refuses the request, or every plan diverges.
    """
    best = None
    # The server ends the search at its deadline; this ends a call that hangs.
    timeout_s = 2.0 * plan.arguments["search"].deadline_s + 10.0
    updates = session.stream_plan(timeout_s=timeout_s, **plan.arguments)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            for best in updates:
                numbers = (best.iterations, best.cost, best.nominal_cost, best.time_s)
                feedback(PlanFeedback(*numbers))
                if cancelled():
                    return None
    except BendTwinError as error:
        names = [collider.name for collider in plan.arguments["world"].colliders]
        if error.reason != "EVERY_PLAN_DIVERGED" or not names:
            raise
        message = f"{error.message}; or an obstacle is where a gripper is: {', '.join(names[:20])}"
        raise BendTwinError(error.category, error.reason, message) from error
    finally:
        with suppress(BendTwinError):
            updates.close()
    return best


def result_of(
    goal: PlanGoal, plan: Plan, best: PlanUpdate, settings: Settings, hands: Hands, at_ns: int
) -> PlanResult:
    """The waypoints of a plan, in the twin's frame, and the hulls that were asked for."""
    header = Header(time_of(at_ns), settings["twin_frame"])
    poses = np.asarray(best.knots[0], dtype=np.float64)
    times = np.linspace(0.0, plan.horizon_s, len(poses))
    result = PlanResult(
        success=True,
        cost=best.cost,
        nominal_cost=best.nominal_cost,
        paths=[
            GripperPath(
                gripper=hands.grippers[i].settings.frame,
                waypoints=PoseArray(header, [to_pose(pose) for pose in poses[:, i]]),
                times_from_start=[duration_of(t) for t in times],
                closed=any(hands.holds()[i]),
            )
            for i in plan.moving
        ],
    )
    if goal.hull != PlanGoal.HULL_NONE and best.rollout is not None:
        _add_hulls(result, goal, plan, best, poses, hands, header)
    return result


def _add_hulls(
    result: PlanResult,
    goal: PlanGoal,
    plan: Plan,
    best: PlanUpdate,
    poses: Array,
    hands: Hands,
    header: Header,
) -> None:
    rollout = best.rollout
    assert rollout is not None
    assert rollout.positions is not None
    assert rollout.frames is not None
    positions = np.asarray(rollout.positions[0], dtype=np.float64)
    count = min(goal.hulls or 1, _MOST_HULLS)
    if goal.hull == PlanGoal.HULL_WORLD:
        for i, points in enumerate(hulls.swept(positions, count)):
            one = hulls.collision_object(f"bendtwin_swept_{i}", points)
            one.header = header
            result.hulls.append(one)
        return
    carrier = hands.grippers[plan.moving[0]].settings
    total = plan.arguments["frames"]
    path = _path(poses[:, plan.moving[0]], rollout.frames / total)
    carried = np.stack([applied(inverse(p), x) for p, x in zip(path, positions, strict=True)])
    for i, points in enumerate(hulls.swept(carried, count)):
        one = hulls.collision_object(f"bendtwin_carried_{i}", points)
        one.header = Header(header.stamp, carrier.frame)
        result.attached_hulls.append(
            AttachedCollisionObject(carrier.frame, one, list(goal.touch_links))
        )


def _path(knots: Array, shares: Any) -> list[Array]:
    """Poses at shares 0..1 of the way along knots."""
    at = np.asarray(shares, dtype=np.float64) * (len(knots) - 1)
    first = np.minimum(at.astype(int), len(knots) - 2)
    return [between(knots[i], knots[i + 1], a - i) for a, i in zip(at, first, strict=True)]


def _costs(goal: PlanGoal, settings: Settings, geometry: Geometry, frames: Frames) -> list[Any]:
    to_twin = _to_twin(goal.header.frame_id, settings, frames)
    costs: list[Any] = []
    targets = points_of(goal.targets)
    if not np.isfinite(targets).all():
        raise GoalFault("targets have numbers that are not finite")
    if goal.nodes and goal.skin_points:
        raise GoalFault("give targets for nodes or for skin_points, not for both")
    chosen = goal.nodes or goal.skin_points
    if len(chosen) != len(targets):
        raise GoalFault(f"there are {len(targets)} targets for {len(chosen)} points")
    if chosen:
        count = len(geometry.rest_positions) if goal.nodes else len(geometry.skin)
        if min(chosen) < 0 or max(chosen) >= count:
            raise GoalFault(f"points are numbered from 0 to {count - 1} in this twin")
        places = applied(to_twin, targets)
        if goal.nodes:
            costs.append(Keypoints(nodes=goal.nodes, targets=places))
        else:
            costs.append(Keypoints(skin_points=goal.skin_points, targets=places))
    if goal.target_cloud.width * goal.target_cloud.height:
        points = clouds.positions(goal.target_cloud).astype(np.float64)
        if not len(points):
            raise GoalFault("target_cloud has no points that are finite")
        of_cloud = _to_twin(goal.target_cloud.header.frame_id, settings, frames)
        cell_m = settings["cloud.cell_m"]
        points = clouds.thinned(applied(of_cloud, points), cell_m, _MOST_TARGETS)
        costs.append(TargetCloud(points=points))
    if not costs:
        raise GoalFault("there is no target: give targets with nodes or skin_points, or a cloud")
    return costs


def _to_twin(frame: str, settings: Settings, frames: Frames) -> Array:
    own = settings["twin_frame"]
    return frames.pose(own, frame or own, 0)


def _moving(goal: PlanGoal, hands: Hands) -> tuple[int, ...]:
    frames = [gripper.settings.frame for gripper in hands.grippers]
    names = [gripper.settings.name for gripper in hands.grippers]
    moving = []
    for wanted in goal.grippers or names:
        if wanted not in names and wanted not in frames:
            raise GoalFault(f"there is no gripper {wanted!r}, only {', '.join(names) or 'none'}")
        moving.append(names.index(wanted) if wanted in names else frames.index(wanted))
    moving = [i for i in moving if hands.grippers[i].pose is not None]
    if not moving:
        raise GoalFault("no gripper whose pose is known can move: see the parameter `grippers`")
    return tuple(dict.fromkeys(moving))


def _search(goal: PlanGoal, settings: Settings, hands: Hands, moving: tuple[int, ...]) -> Search:
    sigma, speed = np.zeros((hands.count, 6)), np.zeros((hands.count, 6))
    for i in moving:
        sigma[i] = [settings["plan.sigma_m"]] * 3 + [settings["plan.sigma_rad"]] * 3
        speed[i] = [settings["plan.speed_m_s"]] * 3 + [settings["plan.turn_rad_s"]] * 3
    most_s = settings["plan.deadline_s"]
    samples = _default(goal.samples, settings["plan.samples"], "samples", 4096)
    return Search(
        method="cem",
        samples=samples,
        iterations=_default(goal.iterations, settings["plan.iterations"], "iterations", 1000),
        elites=max(samples // 8, 1),
        sigma=sigma.ravel(),
        bounds=Bounds(speed=speed.ravel()),
        deadline_s=_within("deadline_s", goal.deadline_s or most_s, most_s),
        seed=goal.seed,
    )


def _limits(world: World) -> Plausibility:
    """Held nodes follow a gripper through a wall: with obstacles such plans are refused."""
    return Plausibility(refuse=bool(world.colliders))


def _returns(goal: PlanGoal, frames: int) -> Returns:
    if goal.hull == PlanGoal.HULL_NONE:
        return Returns()
    return Returns(every_frames=max(frames // _HULL_TIMES, 1), point_set="skin")


def _default(given: int, default: float, name: str, most: int) -> int:
    if not 0 <= given <= most:
        raise GoalFault(f"{name} is {given}: give 1 to {most}, or 0 for the node's default")
    return int(given or default)


def _within(name: str, value: float, most: float) -> float:
    if not (math.isfinite(value) and 0.0 < value <= most):
        raise GoalFault(f"{name} is {value}: give more than 0, and at most {most}")
    return float(value)
