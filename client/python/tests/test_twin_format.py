"""docs/formats/twin.md is complete: a simulator written from it agrees with a server's rollouts, of
twins whose files were written from it too."""

import numpy as np
import pytest
from numpy_twin import Simulator, TwinFile, norm, skin
from scenes import borne, dragged, dropped, folded, ignored, twisted
from server import needs_server, running

from bendtwin import Client, Returns

#: Largest distance of a node from the engine's after any of the frames, metres.
TOLERANCE_M = 2.5e-4

pytestmark = needs_server


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    with running(tmp_path_factory.mktemp("bendtwin")) as address, Client(address) as client:
        yield client


SCENES = {
    "dragged": (dragged, {"ground_friction": 0.0}),
    "borne": (borne, {"skin": False}),
    "ignored": (ignored, {"ground_restitution": 0.9}),
    "dropped": (dropped, {"between_objects": False}),
    "folded": (folded, {"within_object": False}),
    "twisted": (twisted, None),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_document_says_all_that_a_simulator_needs(client, tmp_path, name):
    scene, other_contact = SCENES[name]
    file, path = scene()
    (tmp_path / "twin.safetensors").write_bytes(file.encode())
    twin = client.import_twin(tmp_path / "twin.safetensors")
    path = path.astype(np.float32)
    of_nodes, of_skin = (
        twin.rollout(
            trajectories=path[None], returns=Returns(every_frames=1, point_set=points)
        ).positions[0]
        for points in ("nodes", "skin")
    )
    # What the server exports is read, not what was written here.
    client.export_twin(twin.name, tmp_path / "exported.safetensors")
    file = TwinFile.decode((tmp_path / "exported.safetensors").read_bytes())
    mine = Simulator(file).roll_out(path)
    difference = norm(mine - of_nodes).max()
    print(f"{name}: {1e3 * difference:.4f} mm")
    assert difference < TOLERANCE_M
    assert norm(skin(file, mine) - of_skin).max() < 2 * TOLERANCE_M
    # The scene shows the rule: without it the motion is another.
    if other_contact:
        other = Simulator(file.without(**other_contact))
    else:
        other = Simulator(file)
        other.rods = []
    assert norm(other.roll_out(path) - of_nodes).max() > 10 * TOLERANCE_M
