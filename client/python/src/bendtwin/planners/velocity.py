"""Velocities of a task's coordinates as controls, for libraries whose model is MuJoCo's.

They ask a model for its number of actuators, their limits and its time step: `model_xml` describes
one that has these and nothing else. The twin simulates all motion, in one call.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.planners.knots import Array
from bendtwin.planners.task import Task
from bendtwin.simulation.rollout import Returns
from bendtwin.simulation.state import InitialState
from bendtwin.simulation.world import Ensemble


@dataclass(frozen=True)
class Motion:
    """Effect of N sequences of controls, by frame."""

    #: Weighted costs [N, F]: row f is what frame f + 1 adds, to the statistic of an ensemble;
    #: infinite where an instance diverged.
    costs: Array
    #: Positions [N, F, M, 3] of the nodes that were asked for, metres, in the first member of an
    #: ensemble, or in the mean; zeros after a divergence.
    nodes: Array
    #: Coordinates [N, F, D] at the end of each frame.
    coordinates: Array


def simulate(
    task: Task,
    now: npt.ArrayLike,
    velocities: npt.ArrayLike,
    initial: InitialState | None,
    nodes: Sequence[int] = (),
) -> Motion:
    """Moves the coordinates from where they are now [D] by velocities [N, F, D] per second.

    The horizon is F frames, independent of that of the task. Costs of the state that it starts from
    are left out: no control changes them.
    """
    steps = np.asarray(velocities, dtype=np.float64) * task.frame_s
    start = np.broadcast_to(np.asarray(now, dtype=np.float64), (len(steps), 1, task.dims))
    path = np.concatenate([start, start + steps.cumsum(axis=1)], axis=1)
    frames = steps.shape[1]
    returns = Returns(every_frames=1 if nodes else 0, nodes=nodes or None, frame_costs=True)
    result = task.rollout(path, initial, frames=frames, returns=returns)
    if result.frame_costs is None or (nodes and result.positions is None):
        raise ValueError("the server returned no costs by frame: is it older than this client?")
    # A row for each member of an ensemble, or one for their mean motion.
    costs = result.frame_costs[:, 1:].sum(axis=2).astype(np.float64).reshape(len(steps), -1, frames)
    by_member = task.ensemble is not None and task.ensemble.statistic != "mean_prediction"
    if by_member and task.ensemble is not None and result.member_costs is not None:
        shares = _shares(task.ensemble, result.member_costs)[:, :, None]
        costs = np.where(shares > 0.0, shares * costs, 0.0)
    costs = costs.sum(axis=1)
    costs[~np.isfinite(result.costs)] = np.inf
    places = np.zeros((len(steps), frames, len(nodes), 3))
    if result.positions is not None:
        places[:] = np.nan_to_num(result.positions.reshape(len(steps), -1, *places.shape[1:])[:, 0])
    return Motion(costs, places, path[:, 1:])


def _shares(ensemble: Ensemble, costs: npt.NDArray[Any]) -> Array:
    """Shares of the members' costs [N, E] in the statistic: the worst count alike."""
    members = ensemble.members
    counted = {"mean": members, "worst": 1, "cvar": math.ceil(ensemble.share * members - 1e-9)}
    rank = np.argsort(np.argsort(-costs, axis=1, kind="stable"), axis=1, kind="stable")
    worst = min(max(counted[ensemble.statistic], 1), members)
    return np.asarray((rank < worst) / worst)


def model_xml(
    dims: int,
    frame_s: float,
    fastest: npt.ArrayLike,
    nodes: Sequence[int] = (),
    *,
    has_sensors: bool = False,
) -> str:
    """MJCF with a slide joint and a velocity actuator for each coordinate.

    Args:
        dims: Number of coordinates D.
        frame_s: Its time step [s].
        fastest: Limits of the velocities: a number or [D], per second.
        nodes: Nodes that have a site, "node_{node}".
        has_sensors: With sensors of the sites' positions, "trace_{node}", and of a "cost".
    """
    limits = np.broadcast_to(np.asarray(fastest, dtype=np.float64), (dims,))
    if not (np.isfinite(limits).all() and (limits > 0).all()):
        raise ValueError("fastest must be finite and above 0")
    bodies = "".join(
        f'<body><joint name="c{d}" type="slide" axis="1 0 0"/>'
        f'<geom type="sphere" size="0.01" contype="0" conaffinity="0"/></body>'
        for d in range(dims)
    )
    actuators = "".join(
        f'<velocity joint="c{d}" kv="1" ctrllimited="true" ctrlrange="{-limit} {limit}"/>'
        for d, limit in enumerate(limits)
    )
    sites = "".join(f'<site name="node_{node}"/>' for node in nodes)
    traces = "".join(
        f'<framepos name="trace_{node}" objtype="site" objname="node_{node}"/>' for node in nodes
    )
    sensors = f'<sensor>{traces}<user name="cost" dim="1"/></sensor>' if has_sensors else ""
    return (
        f'<mujoco model="coordinates of a twin"><option timestep="{frame_s!r}" gravity="0 0 0"/>'
        f"<worldbody>{sites}{bodies}</worldbody><actuator>{actuators}</actuator>{sensors}</mujoco>"
    )
