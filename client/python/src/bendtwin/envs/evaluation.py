"""Success rates of policies, with what is known about them after that many episodes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.envs.policies import Policy
from bendtwin.envs.vector_env import TwinVectorEnv

#: Quantile of the normal distribution for 95 %.
_QUANTILE = 1.959964


@dataclass(frozen=True)
class Evaluation:
    """Episodes of a policy, one for each seed."""

    #: [E].
    successes: npt.NDArray[np.bool_]
    #: Sums of rewards [E].
    returns: npt.NDArray[np.floating[Any]]
    #: Steps [E].
    steps: npt.NDArray[np.int64]
    #: Episodes that ended because their session was lost: they count as failures.
    lost: int

    @property
    def rate(self) -> float:
        """Share of successes."""
        return float(self.successes.mean())

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % confidence interval of the rate."""
        n, p, z = len(self.successes), self.rate, _QUANTILE
        middle = (p + z * z / (2 * n)) / (1 + z * z / n)
        half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
        return max(0.0, middle - half), min(1.0, middle + half)

    def __str__(self) -> str:
        low, high = self.interval
        count = len(self.successes)
        return (
            f"{self.rate:.0%} of {count} episodes succeed (95 % interval {low:.0%} to {high:.0%}), "
            f"return {self.returns.mean():.2f}, {self.steps.mean():.0f} steps"
        )


def evaluate(
    env: TwinVectorEnv, policy: Policy, episodes: int = 50, *, seed: int = 0
) -> Evaluation:
    """Runs a policy in episodes of the seeds `seed` to `seed + episodes - 1`.

    Every seed counts, however long its episode is: episodes are run in batches, and what slots do
    after their episode is left out.
    """
    if episodes < 1:
        raise ValueError(f"episodes is {episodes}: give at least 1")
    slots = env.num_envs
    successes, returns, steps, lost = [], [], [], 0
    for first in range(0, episodes, slots):
        observed, _ = env.reset(seed=seed + first)
        total, length = np.zeros(slots), np.zeros(slots, np.int64)
        done, success = np.zeros(slots, bool), np.zeros(slots, bool)
        # Slots beyond the last seed have nothing to do.
        done[episodes - first :] = True
        counted = ~done
        while not done.all():
            observed, reward, terminated, truncated, info = env.step(policy(observed))
            ended = (terminated | truncated) & ~done
            values = info.get("final_info", info)
            total += np.where(done, 0.0, reward)
            length += ~done
            success |= ended & values["is_success"]
            lost += int((ended & values["session_lost"]).sum())
            done |= ended
        successes.append(success[counted])
        returns.append(total[counted])
        steps.append(length[counted])
    return Evaluation(
        np.concatenate(successes), np.concatenate(returns), np.concatenate(steps), lost
    )
