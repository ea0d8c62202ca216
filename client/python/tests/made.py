"""Twins by hand at a real server, ready without a fit."""

from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
from scenes import dragged
from server import running

from bendtwin import Client, Returns


@contextmanager
def sheet_at_rest(folder):
    """A sheet that two control points of one hand hold by its edge; most lies on the ground."""
    file, _ = dragged()
    (folder / "sheet.twin").write_bytes(file.encode())
    with running(folder) as address, Client(address) as client:
        twin = client.import_twin(folder / "sheet.twin")
        hold = np.repeat(twin.geometry().controls[None, None], 2, axis=1)
        end = twin.rollout(trajectories=hold, frames=20, returns=Returns(final_state=True))
        yield SimpleNamespace(client=client, twin=twin, hold=hold, start=end.state(0))
