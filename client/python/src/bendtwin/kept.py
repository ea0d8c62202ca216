"""State of a session at its client, from which another is opened where that one was lost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bendtwin.simulation.rollout import RolloutResult
from bendtwin.simulation.state import InitialState, State, state_of
from bendtwin.v1 import rollout_pb2


class Kept:
    """The last state of each slot that a reply brought, and how far slots have gone since."""

    def __init__(self, slots: int) -> None:
        # None: the session's first state.
        self._states: list[InitialState | None] = [None] * slots
        #: Frames by which each slot has been advanced since the state that is kept of it.
        self.behind: list[int] = [0] * slots

    def advanced(
        self, slots: Sequence[int], rollout: rollout_pb2.RollOutRequest, result: RolloutResult
    ) -> None:
        """Slots (none: slot 0) were advanced, unless an instance diverged; of a mean, all of it."""
        statistic = rollout.ensemble.statistic
        is_mean = statistic == rollout_pb2.Ensemble.MEAN_PREDICTION
        if result.diverged and not (is_mean and np.isfinite(result.costs).all()):
            return
        for row, slot in enumerate(slots or [0]):
            if result.final_positions is None:
                self.behind[slot] += frames_of(rollout)
            else:
                self._keep(slot, result.state(row))

    def told(self, slots: Sequence[int], states: Sequence[State]) -> None:
        """States of slots, or of all of them, were asked for."""
        for slot, state in zip(slots or range(len(self.behind)), states, strict=True):
            self._keep(slot, state)

    def forked(self, source: int, to: Sequence[int]) -> None:
        """The state of a slot was copied to others, or to all others."""
        for slot in to or range(len(self.behind)):
            self._states[slot] = self._states[source]
            self.behind[slot] = self.behind[source]

    def reset(self, slots: Sequence[int], initial: InitialState | None) -> None:
        """Slots, or all of them, were set back to the first state, or to a given one."""
        for row, slot in enumerate(slots or range(len(self.behind))):
            if isinstance(initial, State) and np.ndim(initial.positions) == 3:
                self._keep(slot, state_of(initial, row))
            else:
                self._keep(slot, initial)

    def resets(self) -> list[tuple[InitialState, list[int]]]:
        """States that are no first ones, each with the slots that are in it."""
        slots_of: dict[int, tuple[InitialState, list[int]]] = {}
        for slot, state in enumerate(self._states):
            if state is not None:
                slots_of.setdefault(id(state), (state, []))[1].append(slot)
        return list(slots_of.values())

    def _keep(self, slot: int, state: InitialState | None) -> None:
        self._states[slot] = state
        self.behind[slot] = 0


def frames_of(rollout: rollout_pb2.RollOutRequest) -> int:
    """The horizon of a rollout; without one said it is that of its dense actions."""
    if rollout.frames:
        return int(rollout.frames)
    actions = rollout.poses.poses if rollout.HasField("poses") else rollout.trajectories.positions
    return int(actions.shape[1]) - 1
