"""LeRobot's evaluation against environments: its own loop if it is installed, and its contract."""

import importlib.util
import warnings
from pathlib import Path

import numpy as np
import pytest
from scenes import dragged
from server import needs_server, running

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.vector import AutoresetMode, VectorEnv  # noqa: E402

from bendtwin.envs import ScriptedPolicy  # noqa: E402

ENV = Path(__file__).parents[1] / "examples" / "envhub" / "env.py"
MISSING = "LeRobot is missing: pip install 'lerobot[dataset]>=0.6' to run its own evaluation"

pytestmark = [needs_server, pytest.mark.skipif(not ENV.is_file(), reason="no examples here")]


@pytest.fixture(scope="module")
def hub(tmp_path_factory):
    """The folder of a hub's repository, with a sheet."""
    folder = tmp_path_factory.mktemp("hub")
    (folder / "env.py").write_text(ENV.read_text())
    (folder / "object.twin").write_bytes(dragged()[0].encode())
    with running(folder) as address, pytest.MonkeyPatch.context() as patch:
        patch.setenv("BENDTWIN_SERVER", f"http://{address}")
        yield folder


def module_of(hub):
    """The module of the hub, as LeRobot imports it; without pictures, which have their own test."""
    spec = importlib.util.spec_from_file_location("hub_env", hub / "env.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.CAMERAS = []
    return module


def test_the_published_contract_holds(hub):
    """What lerobot.scripts.lerobot_eval of versions 0.4 to 0.6 reads."""
    made = module_of(hub).make_env(n_envs=3, use_async_envs=False)
    [(suite, by_task)] = made.items()
    assert isinstance(suite, str)
    env = by_task[0]
    assert isinstance(env, VectorEnv)
    assert env.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert env.unwrapped.metadata["render_fps"] == 10
    assert env.call("_max_episode_steps")[0] == env.horizon
    for name in ("task", "task_description"):
        assert hasattr(env.envs[0], name)
        assert env.call(name) == env.get_attr(name)
        assert all(isinstance(value, str) and value for value in env.call(name))
    assert len({type(one) for one in env.envs}) == 1
    observed, _ = env.reset(seed=[4, 5, 6], options={"lerobot_new_rollout": True})
    assert observed["agent_pos"].dtype == np.float32
    assert observed["agent_pos"].shape == (3, 8)
    assert observed["environment_state"].dtype == np.float32
    policy, done, successes = ScriptedPolicy(env), np.zeros(3, bool), np.zeros(3, bool)
    while not done.all():
        observed, reward, terminated, truncated, info = env.step(policy(observed))
        assert reward.shape == terminated.shape == (3,)
        if "final_info" in info:
            successes |= np.array(info["final_info"]["is_success"].tolist()) & ~done
        done |= terminated | truncated
    assert successes.all()
    env.close()
    # The same file is not imported a second time.
    again = module_of(hub).make_env(n_envs=1)["bendtwin"][0]
    assert again.twin.name == env.twin.name
    again.close()


def test_lerobot_evaluates_a_policy(hub):
    pytest.importorskip("lerobot", reason=MISSING)
    pytest.importorskip("datasets", reason=MISSING)
    import torch
    from lerobot.envs.utils import _call_make_env, _normalize_hub_result
    from lerobot.policies import PreTrainedPolicy
    from lerobot.processor import PolicyProcessorPipeline
    from lerobot.scripts.lerobot_eval import eval_policy

    made = _normalize_hub_result(_call_make_env(module_of(hub), 4, False, None))
    env = made["bendtwin"][0]
    script = ScriptedPolicy(env)

    class Scripted(PreTrainedPolicy):
        """The script, as LeRobot wants its policies."""

        config_class, name = object, "scripted"

        def __init__(self):
            torch.nn.Module.__init__(self)

        def reset(self):
            pass

        def select_action(self, batch):
            assert batch["task"] == [env.envs[0].task_description] * 4
            assert batch["observation.state"].shape == (4, 8)
            assert batch["observation.environment_state"].shape[0] == 4
            return torch.from_numpy(script(None))

        forward = get_optim_params = predict_action_chunk = None

    same = PolicyProcessorPipeline(steps=[])
    Scripted.__abstractmethods__ = frozenset()
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        results = eval_policy(
            env, Scripted(), same, same, same, lambda action: action, n_episodes=8, start_seed=0
        )
    assert results["aggregated"]["pc_success"] == 100.0
    assert len(results["per_episode"]) == 8
    env.close()
