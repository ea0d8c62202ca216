"""Coupling with MuJoCo: bodies of an MJCF model hold and push a twin, and feel its weight.

    from bendtwin.coupling import ClosedWhen, Coupling, Gripper

    hand = Gripper(Grasp(region=Sphere(0.02)), closed=ClosedWhen(joint="finger", below=0.01))
    with Coupling(model, data, client, twin, grippers={"hand": hand}) as coupling:
        while data.time < 5.0:
            data.ctrl[:] = policy(data)
            frame = coupling.step()

It needs `pip install 'bendtwin[mujoco]'`; docs/use/mujoco.md leads from a twin to a coupled
simulation, and states latency and limits of stability.
"""

from bendtwin.coupling.coupling import Coupling, Snapshot
from bendtwin.coupling.errors import CouplingError
from bendtwin.coupling.frame import Frame, Times
from bendtwin.coupling.gripper import ClosedWhen, Gripper

__all__ = [
    "ClosedWhen",
    "Coupling",
    "CouplingError",
    "Frame",
    "Gripper",
    "Snapshot",
    "Times",
]
