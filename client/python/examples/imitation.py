"""Trains a policy to imitate the script of a task, and compares their success rates."""

import os
import sys
import time

import numpy as np
import torch

from bendtwin import Client
from bendtwin.envs import RandomPolicy, ScriptedPolicy, evaluate, make

TASK = sys.argv[1] if len(sys.argv) > 1 else "MoveTip"
SLOTS, BATCHES, EPOCHS = 32, 4, 150


def features(observed):
    """One vector by observation: the grippers, and all points as seen from the first of them."""
    agent = observed["agent_pos"]
    points = [observed["keypoints"], observed["goal"].reshape(len(agent), -1, 3)]
    seen = np.concatenate(points, axis=1) - agent[:, None, :3]
    return np.concatenate([agent, 10.0 * seen.reshape(len(agent), -1)], axis=1)


def demonstrations(env):
    """Features and actions of successful episodes, disturbed so that they show ways back."""
    expert = ScriptedPolicy(env, noise=0.3)
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


def trained(inputs, outputs):
    """A network from features to actions."""
    torch.manual_seed(0)
    network = torch.nn.Sequential(
        torch.nn.Linear(inputs.shape[1], 256),
        torch.nn.ReLU(),
        torch.nn.Linear(256, 256),
        torch.nn.ReLU(),
        torch.nn.Linear(256, outputs.shape[1]),
    )
    x, y = torch.from_numpy(inputs), torch.from_numpy(outputs)
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, EPOCHS)
    for _ in range(EPOCHS):
        for rows in torch.randperm(len(x)).split(256):
            optimizer.zero_grad()
            loss = torch.nn.functional.smooth_l1_loss(network(x[rows]), y[rows], beta=0.1)
            loss.backward()
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

    @torch.inference_mode()
    def imitation(observed):
        """Actions of the network."""
        return network(torch.from_numpy(features(observed))).numpy()

    policies = {
        "random": RandomPolicy(env),
        "script": ScriptedPolicy(env),
        "imitation": imitation,
    }
    for name, policy in policies.items():
        print(f"{name}: {evaluate(env, policy, episodes=2 * SLOTS)}")
    env.close()
