"""Result of a coupled frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bendtwin.simulation.rollout import RolloutResult
from bendtwin.simulation.state import State

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Times:
    """Where the time of a frame went, seconds."""

    #: Steps of the model.
    model_s: float
    #: Physics of the twin, at the worker.
    twin_s: float
    #: The rest of the calls: messages, gRPC, the server's routing.
    calls_s: float
    #: The whole frame.
    total_s: float


@dataclass(frozen=True)
class Frame:
    """The model and the twin after a frame."""

    #: Frames since the start, this one included.
    number: int
    #: Steps that the model took in this frame.
    steps: int
    #: Wrench of the twin on each body or site by name: force, then torque about the origin of the
    #: body or site, along the axes of the model's world, newtons and newton metres, mean over the
    #: frame. Those of bodies that nothing moves are among them; empty without `feedback`.
    wrenches: dict[str, FloatArray]
    #: Positions of the nodes [N, 3] in the model's world, metres.
    positions: FloatArray
    #: Nodes that each gripper holds, by its name.
    held: dict[str, npt.NDArray[np.int64]]
    #: State of the twin, in its own coordinates.
    state: State
    #: Evaluations of the frame: 1 unless `iterations` is larger.
    iterations: int
    #: Displacement of a body by the difference between the wrenches that were applied and those
    #: that came back, metres.
    residual_m: float
    #: The reply of the twin.
    result: RolloutResult
    times: Times
