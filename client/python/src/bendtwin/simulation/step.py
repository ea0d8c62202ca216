"""Steps of a closed loop: a correction, a plan and an advance of a session in one call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy.typing as npt

from bendtwin.calls import Call
from bendtwin.resources import Fault
from bendtwin.simulation.plan import PlanArguments, PlanUpdate, plan_request
from bendtwin.simulation.registration import CorrectArguments, Correction, correct_session
from bendtwin.simulation.rollout import Returns, RolloutResult, warned
from bendtwin.simulation.state import State
from bendtwin.v1 import session_pb2


@dataclass(frozen=True, kw_only=True)
class Step:
    """A step of a closed loop."""

    #: The correction; None without points, or if it was refused.
    correction: Correction | None
    #: Reason if the correction was refused because the points are too far from the object. The step
    #: then started from the predicted state.
    refused: Fault | None
    #: True if the slot no longer follows its object: register it again.
    lost: bool
    #: The best plan.
    plan: PlanUpdate
    #: Rollout of the executed frames of the plan; None without any. If it `diverged`, the slot
    #: keeps the state in which the plan began.
    advanced: RolloutResult | None
    #: The current state of the slot.
    state: State
    #: The search of the next step: it starts from this plan, shifted by the executed frames.
    search: PlanArguments = field(repr=False)
    #: Times of the parts, seconds.
    correct_s: float
    plan_s: float
    advance_s: float
    total_s: float


def step_session(
    name: str,
    slot: int,
    points: npt.ArrayLike | None,
    search: PlanArguments,
    *,
    frames: int,
    correct: CorrectArguments | None,
    returns: Returns | None,
    deadline_s: float | None,
    see: Callable[[State], None],
) -> Call[Step]:
    """Takes a step with a slot of a session; `see` gets the final state.

    Raises:
        TypeError: If the search has what is not the search's.
        ValueError: If a setting, or an array's shape or content, is wrong.
    """
    for other in ("initial", "returns"):
        if other in search:
            raise TypeError(f"{other} does not belong to the search of a step: leave it out")
    if points is None and correct:
        raise TypeError("`correct` goes with points")
    if deadline_s is not None and not deadline_s > 0.0:
        raise ValueError(f"deadline_s is {deadline_s}: give more than 0, or None")
    if frames < 0:
        raise ValueError(f"frames is {frames}: give 0 or more")
    request = session_pb2.StepSessionRequest(
        name=name,
        slot=slot,
        search=plan_request("", search),
        execute_frames=frames,
        deadline_s=deadline_s or 0.0,
    )
    for of_session in ("initial", "returns"):
        request.search.rollout.ClearField(of_session)
    if "fidelity" not in search:
        request.search.rollout.ClearField("fidelity")
    if points is not None:
        request.correction.CopyFrom(correct_session("", (), points, correct or {}).request)
    if returns is not None:
        request.returns.CopyFrom(returns.to_proto())

    def read(reply: Any) -> Step:
        step = _read(reply, search, frames)
        see(step.state)
        return step

    return Call(lambda s: s.sessions.StepSession, request, read)


def _read(reply: Any, search: PlanArguments, frames: int) -> Step:
    plan = PlanUpdate.from_proto(reply.plan)
    has_advanced = reply.HasField("advanced")
    advanced = warned(RolloutResult.from_proto(reply.advanced)) if has_advanced else None
    executed = frames if advanced is not None and not advanced.diverged else 0
    # The place is taken: what follows begins there.
    following: Any = {k: v for k, v in search.items() if k != "grasp_search"}
    following.update(plan.actions, shift_frames=executed)
    corrections = [Correction.from_proto(one) for one in reply.corrected.corrections]
    return Step(
        correction=corrections[0] if corrections else None,
        refused=Fault.from_proto(reply.refused) if reply.HasField("refused") else None,
        lost=reply.lost,
        plan=plan,
        advanced=advanced,
        state=State.from_proto(reply.state),
        search=following,
        correct_s=reply.times.correct_s,
        plan_s=reply.times.plan_s,
        advance_s=reply.times.advance_s,
        total_s=reply.times.total_s,
    )
