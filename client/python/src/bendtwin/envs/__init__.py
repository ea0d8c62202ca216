"""Environments of Gymnasium on twins: tasks for policies, with pictures if wanted.

from bendtwin.envs import ScriptedPolicy, evaluate, make

env = make("MoveTip", twin, num_envs=16)
observed, info = env.reset(seed=0)
observed, reward, terminated, truncated, info = env.step(env.action_space.sample())
print(evaluate(env, ScriptedPolicy(env), episodes=64))
"""

from bendtwin.envs.actions import Actions
from bendtwin.envs.body import Body
from bendtwin.envs.cameras import Camera
from bendtwin.envs.evaluation import Evaluation, evaluate
from bendtwin.envs.observations import Observations, PointCloud
from bendtwin.envs.policies import Policy, RandomPolicy, ScriptedPolicy
from bendtwin.envs.props import Marker
from bendtwin.envs.randomisation import Randomisation
from bendtwin.envs.registry import list_tasks, make, register
from bendtwin.envs.single_env import TwinEnv
from bendtwin.envs.tasks import (
    Draw,
    Fold,
    InsertEnd,
    Judgement,
    LayAlong,
    MoveTip,
    PutInBin,
    Task,
    Unsuitable,
    View,
    Waypoint,
)
from bendtwin.envs.vector_env import TwinVectorEnv

__all__ = [
    "Actions",
    "Body",
    "Camera",
    "Draw",
    "Evaluation",
    "Fold",
    "InsertEnd",
    "Judgement",
    "LayAlong",
    "Marker",
    "MoveTip",
    "Observations",
    "PointCloud",
    "Policy",
    "PutInBin",
    "RandomPolicy",
    "Randomisation",
    "ScriptedPolicy",
    "Task",
    "TwinEnv",
    "TwinVectorEnv",
    "Unsuitable",
    "View",
    "Waypoint",
    "evaluate",
    "list_tasks",
    "make",
    "register",
]
