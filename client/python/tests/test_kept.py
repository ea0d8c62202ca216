"""Tests of the state that a client keeps of a session."""

import numpy as np

from bendtwin import Ensemble, RolloutResult, State
from bendtwin.kept import Kept
from bendtwin.simulation.arguments import rollout_request
from bendtwin.simulation.rollout import Divergence

ROLLOUT = rollout_request("", {"trajectories": np.zeros((1, 4, 1, 3))})


def result(*xs, **fields):
    """A result whose instances end at these places, if any."""
    final = np.array([[[x, 0, 0]] for x in xs], np.float32) if xs else None
    arrays = dict.fromkeys(RolloutResult.__dataclass_fields__)
    return RolloutResult(**{**arrays, "final_positions": final, "diverged": [], **fields})


def places(kept):
    return {
        slot: float(np.asarray(state.positions)[0, 0])
        for state, slots in kept.resets()
        for slot in slots
    }


def test_the_last_state_of_each_slot_is_kept():
    kept = Kept(4)
    kept.advanced([], ROLLOUT, result(1))
    kept.advanced([3, 1], ROLLOUT, result(2, 3))
    assert (places(kept), kept.behind) == ({0: 1, 3: 2, 1: 3}, [0, 0, 0, 0])
    # Without final states slots go on unseen, and nowhere where an instance diverged.
    kept.advanced([1], ROLLOUT, result())
    kept.advanced(
        [1], rollout_request("", {"poses": np.zeros((1, 3, 1, 7)), "frames": 9}), result()
    )
    kept.advanced([0], ROLLOUT, result(7, diverged=[Divergence(0, 1, 0)]))
    assert (places(kept), kept.behind) == ({0: 1, 3: 2, 1: 3}, [0, 12, 0, 0])
    # Of a mean a member may diverge, as long as one comes through.
    mean = Ensemble(2, "mean_prediction")
    of_mean = rollout_request("", {"trajectories": np.zeros((1, 4, 1, 3)), "ensemble": mean})
    lost = {"diverged": [Divergence(1, 1, 0)]}
    kept.advanced([0], of_mean, result(7, **lost, costs=np.array([np.inf])))
    assert places(kept)[0] == 1
    kept.advanced([0], of_mean, result(7, **lost, costs=np.zeros(1)))
    assert places(kept)[0] == 7
    kept.advanced([0], ROLLOUT, result(1))
    kept.forked(1, [2])
    assert (places(kept), kept.behind) == ({0: 1, 3: 2, 1: 3, 2: 3}, [0, 12, 12, 0])
    kept.told([1], [State(np.full((1, 3), 5.0))])
    kept.reset([0], None)
    kept.reset([2, 3], State(np.arange(6.0).reshape(2, 1, 3)))
    assert (places(kept), kept.behind) == ({1: 5, 2: 0, 3: 3}, [0, 0, 0, 0])


def test_slots_in_one_state_are_reset_together():
    kept = Kept(3)
    kept.advanced([], ROLLOUT, result(1))
    kept.forked(0, [])
    [(_, slots)] = kept.resets()
    assert slots == [0, 1, 2]
