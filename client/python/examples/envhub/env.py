"""An environment for LeRobot's EnvHub.

Upload this file to a repository of the hub, with the file of a twin (`bendtwin twin export`) beside
it as `object.twin`, and a `requirements.txt` with `bendtwin[gymnasium]`. To evaluate a policy, run
`bendtwin server`, or name a server in BENDTWIN_SERVER.
"""

import hashlib
import os
from pathlib import Path
from typing import Any

from gymnasium.vector import VectorEnv

from bendtwin import Client
from bendtwin.envs import Observations, make

#: The repository that this file is uploaded to.
REPOSITORY = "you/your-object"
TASK = "MoveTip"
#: LeRobot calls these observations `observation.images.front` and `observation.state`.
CAMERAS = ["front"]


def make_env(
    n_envs: int = 1, use_async_envs: bool = False, cfg: Any = None
) -> dict[str, dict[int, VectorEnv]]:
    """Environments of a task, which the server simulates together in any case."""
    address = os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")
    file = twin_file()
    with Client(address) as client:
        digest = hashlib.blake2b(file.read_bytes(), digest_size=16).hexdigest()
        # The same file is imported once.
        twin = client.import_twin(file, request_id=digest).name
    task = getattr(cfg, "task", None) or TASK
    env = make(
        task,
        twin,
        num_envs=n_envs,
        address=address,
        observations=Observations(cameras=CAMERAS, flat=True),
        render_mode="rgb_array" if CAMERAS else None,
    )
    return {"bendtwin": {0: env}}


def twin_file() -> Path:
    """The file of the twin: beside this one, or from the hub, which brings this one alone."""
    beside = Path(__file__).with_name("object.twin")
    if beside.is_file():
        return beside
    from huggingface_hub import hf_hub_download

    return Path(hf_hub_download(REPOSITORY, "object.twin"))
