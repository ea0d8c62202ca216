"""Trains a policy to imitate the script of a task, and compares their success rates."""

import os
import sys
import time
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
import torch.nn.functional as F

from bendtwin import Client
from bendtwin.envs import Policy, RandomPolicy, ScriptedPolicy, TwinVectorEnv, evaluate, make

Array = npt.NDArray[np.float32]

TASK = sys.argv[1] if len(sys.argv) > 1 else "MoveTip"
SLOTS, BATCHES, EPOCHS = 32, 4, 120
#: Distances that a network is to tell apart far from the object and near it, metres.
FAR_M, NEAR_M = 0.1, 0.01


def features(observed: dict[str, Any]) -> Array:
    """A vector for each observation: the grippers, and all points as seen from each of them."""
    grippers = observed["agent_pos"].reshape(len(observed["agent_pos"]), -1, 8)
    goal = observed["goal"].reshape(len(grippers), -1, 3)
    points = np.concatenate([observed["keypoints"], goal], axis=1)
    apart = (points[:, None] - grippers[:, :, None, :3]).reshape(*grippers.shape[:2], -1)
    parts = [grippers, apart / FAR_M, np.tanh(apart / NEAR_M)]
    return np.concatenate(parts, axis=2).reshape(len(grippers), -1)


def demonstrations(env: TwinVectorEnv) -> tuple[Array, Array]:
    """Features and actions of successful episodes, disturbed so that they show ways back."""
    expert = ScriptedPolicy(env, noise=0.4)
    inputs, outputs = [], []
    for batch in range(BATCHES):
        observed, _ = env.reset(seed=10_000 + batch * SLOTS)
        steps, ended, success = [], np.zeros(SLOTS, bool), np.zeros(SLOTS, bool)
        while not ended.all():
            actions = expert(observed)
            steps.append((features(observed), expert.clean, ~ended))
            observed, _, terminated, truncated, info = env.step(actions)
            finished = (terminated | truncated) & ~ended
            success |= finished & info.get("final_info", info)["is_success"]
            ended |= finished
        for seen, done, running in steps:
            inputs.append(seen[running & success])
            outputs.append(done[running & success])
    return np.concatenate(inputs), np.concatenate(outputs)


def trained(inputs: Array, outputs: Array) -> Any:
    """A network from features to actions."""
    torch.manual_seed(0)
    torch.set_num_threads(1)
    network = torch.nn.Sequential(
        torch.nn.Linear(inputs.shape[1], 256),
        torch.nn.ReLU(),
        torch.nn.Linear(256, 256),
        torch.nn.ReLU(),
        torch.nn.Linear(256, outputs.shape[1]),
    )
    x, y = torch.from_numpy(inputs), torch.from_numpy(outputs)
    is_opening = torch.arange(y.shape[1]) % 7 == 6
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, EPOCHS)
    for _ in range(EPOCHS):
        for rows in torch.randperm(len(x)).split(128):
            optimizer.zero_grad()
            given, wanted = network(x[rows]), y[rows]
            moved = F.smooth_l1_loss(given[:, ~is_opening], wanted[:, ~is_opening], beta=0.1)
            opened = F.soft_margin_loss(given[:, is_opening], wanted[:, is_opening])
            (moved + opened).backward()
            optimizer.step()
        schedule.step()
    return network


with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    twin = next(client.twins())  # the newest
    env = make(TASK, twin, num_envs=SLOTS)
    begin = time.monotonic()
    inputs, outputs = demonstrations(env)
    print(f"{len(inputs)} steps of demonstrations in {time.monotonic() - begin:.0f} s")
    begin = time.monotonic()
    network = trained(inputs, outputs)
    print(f"trained in {time.monotonic() - begin:.0f} s")

    def imitation(observed: dict[str, Any]) -> Any:
        """Actions of the network."""
        with torch.inference_mode():
            return network(torch.from_numpy(features(observed))).numpy()

    policies: dict[str, Policy] = {
        "random": RandomPolicy(env),
        "script": ScriptedPolicy(env),
        "imitation": imitation,
    }
    for name, policy in policies.items():
        print(f"{name}: {evaluate(env, policy, episodes=2 * SLOTS)}")
    env.close()
