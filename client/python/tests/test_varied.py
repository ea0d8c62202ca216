"""Parameters by instance, as large and as small as they may be, on a real server."""

import numpy as np
from server import make_rope, needs_server, running

from bendtwin import Client, Returns, Vary

pytestmark = needs_server
SETTINGS = {
    "graph": {"max_nodes": 30},
    "search": {"generations": 2, "population": 4},
    "refine": {"passes": 1},
}


def test_what_varies_has_the_substeps_that_it_needs(tmp_path):
    make_rope(tmp_path / "rope.zip")
    with running(tmp_path) as address, Client(address) as client:
        capture = client.wait_for_capture(client.upload_capture(tmp_path / "rope.zip"))
        twin = client.twin(client.wait(client.fit(capture.name, SETTINGS), timeout_s=120).twin)
        geometry = twin.geometry()
        hold = np.stack([geometry.controls, geometry.controls + np.array([0.02, 0.0, 0.02])])

        def run(stiffness, mass):
            return twin.rollout(
                trajectories=np.stack([hold] * len(mass)),
                frames=5,
                vary=Vary(stiffness=stiffness, mass=mass),
                returns=Returns(final_state=True),
            )

        stiffness, mass = [1.0, 100.0, 0.01, 1.0], [1.0, 1.0, 100.0, 0.01]
        together = run(stiffness, mass)
        assert together.diverged == []
        assert together.substeps > geometry.substeps
        # The same bits alone and beside others.
        for i in range(4):
            apart = run(stiffness[i : i + 1], mass[i : i + 1])
            np.testing.assert_array_equal(apart.final_positions[0], together.final_positions[i])
