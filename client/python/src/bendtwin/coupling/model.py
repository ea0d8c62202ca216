"""The side of MuJoCo: bodies and sites that carry parts of a twin's world, and steps of the model
under the wrenches on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from bendtwin.coupling.errors import CouplingError
from bendtwin.coupling.gripper import find
from bendtwin.coupling.poses import Change

FloatArray = npt.NDArray[np.float64]
Control = Callable[[Any, Any], None]

#: Everything that decides how a model moves on.
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
_UNSTABLE = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)


@dataclass(frozen=True)
class Carrier:
    """A body or site whose pose is that of a gripper of the twin."""

    name: str
    #: The body, or that of the site.
    body: int
    #: The site; -1: the body itself.
    site: int = -1

    @classmethod
    def named(cls, model: Any, name: str) -> Carrier:
        """The site or body of a name.

        Raises:
            ValueError: If the model has neither, or both.
        """
        body, site = find(model, "body", name), find(model, "site", name)
        if body >= 0 and site >= 0:
            raise ValueError(f"{name!r} is a body and a site of the model: rename one")
        if body < 0 and site < 0:
            raise ValueError(f"the model has neither a body nor a site {name!r}")
        return cls(name, body) if site < 0 else cls(name, int(model.site_bodyid[site]), site)


def moves(model: Any, body: int) -> bool:
    """True unless a body stands still in the world: its own joints, those of a body that carries
    it, or a caller, by mocap, move it."""
    return bool(model.body_weldid[body] != 0 or model.body_mocapid[model.body_rootid[body]] >= 0)


def yields(model: Any, body: int) -> bool:
    """True if a force moves a body: it, or a body that carries it, has a joint."""
    while body != 0:
        if model.body_dofnum[body] > 0:
            return True
        body = int(model.body_parentid[body])
    return False


class Model:
    """A model and its data, with its carriers."""

    def __init__(self, model: Any, data: Any, carriers: list[Carrier], change: Change) -> None:
        self.model, self.data = model, data
        self._carriers, self._change = carriers, change
        self._bodies = np.array([carrier.body for carrier in carriers], int)
        self._sites = np.array([carrier.site for carrier in carriers], int)
        self._is_site = self._sites >= 0
        self._size = mujoco.mj_stateSize(model, _STATE)
        self.settle()

    def settle(self) -> None:
        """Computes positions of bodies from those of joints."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)

    def save(self) -> FloatArray:
        """The state, for `restore`."""
        state = np.empty(self._size)
        mujoco.mj_getState(self.model, self.data, state, _STATE)
        return state

    def restore(self, state: FloatArray) -> None:
        """Sets a saved state."""
        mujoco.mj_setState(self.model, self.data, state, _STATE)
        self.settle()

    def poses(self, ahead_s: float = 0.0) -> FloatArray:
        """Poses of the carriers in the twin's world [G, 7], a little later at their velocities."""
        data = self.data
        if ahead_s > 0.0:
            mujoco.mj_comVel(self.model, data)
        rows = np.empty((len(self._carriers), 7))
        quaternion, velocity = np.empty(4), np.empty(6)
        for row, carrier in zip(rows, self._carriers, strict=True):
            if carrier.site < 0:
                position = data.xpos[carrier.body]
                quaternion[:] = data.xquat[carrier.body]
                kind, number = mujoco.mjtObj.mjOBJ_XBODY, carrier.body
            else:
                position = data.site_xpos[carrier.site]
                mujoco.mju_mat2Quat(quaternion, data.site_xmat[carrier.site])
                kind, number = mujoco.mjtObj.mjOBJ_SITE, carrier.site
            if ahead_s > 0.0:
                mujoco.mj_objectVelocity(self.model, data, kind, number, velocity, 0)
                position = position + ahead_s * velocity[3:]
                _turn(quaternion, velocity[:3], ahead_s)
            row[:] = self._change.pose(position, quaternion)
        return rows

    def mobility(self, carriers: npt.NDArray[np.intp]) -> FloatArray:
        """What a force, and a torque, accelerate some carriers by, 1/kg and 1/(kg m²), [n, 2]:
        means over directions, of all bodies and joints that take part."""
        model, data, size = self.model, self.data, self.model.nv
        found = np.zeros((len(carriers), 2))
        if len(carriers) == 0:
            return found
        mujoco.mj_makeM(model, data)
        mujoco.mj_factorM(model, data)
        jacobian, moved = np.zeros((6, size)), np.zeros((6, size))
        for row, number in zip(found, carriers, strict=True):
            carrier = self._carriers[number]
            at = data.xpos[carrier.body] if carrier.site < 0 else data.site_xpos[carrier.site]
            mujoco.mj_jac(model, data, jacobian[:3], jacobian[3:], at, carrier.body)
            mujoco.mj_solveM(model, data, moved, jacobian)
            row[:] = np.einsum("av,av->a", jacobian, moved).reshape(2, 3).mean(axis=1)
        return found

    def run(self, steps: int, wrenches: FloatArray | None, control: Control | None) -> None:
        """Takes steps under wrenches [G, 6] about the carriers' origins, along the world's axes.

        Raises:
            CouplingError: If the model diverges; its state is then undefined.
        """
        model, data = self.model, self.data
        # A model that diverges resets itself, counters included.
        counted = [int(data.warning[kind].number) for kind in _UNSTABLE]
        for kind in _UNSTABLE:
            data.warning[kind].number = 0
        added = self._at_centres(wrenches)
        if control is None:
            own = data.xfrc_applied.copy()
            data.xfrc_applied[:] += added
            mujoco.mj_step(model, data, steps)
            data.xfrc_applied[:] = own
        else:
            for _ in range(steps):
                control(model, data)
                own = data.xfrc_applied.copy()
                data.xfrc_applied[:] += added
                mujoco.mj_step(model, data)
                data.xfrc_applied[:] = own
        faults = [int(data.warning[kind].number) for kind in _UNSTABLE]
        for kind, before, more in zip(_UNSTABLE, counted, faults, strict=True):
            data.warning[kind].number = before + more
        if any(faults):
            raise CouplingError(
                "MODEL_DIVERGED",
                f"the MuJoCo model diverged in the frame before {data.time:.3f} s: a body that the "
                "twin pulls is too light for this coupling; raise iterations, or its mass or "
                "armature",
            )
        self.settle()

    def _at_centres(self, wrenches: FloatArray | None) -> FloatArray:
        """Wrenches about the centres of mass of all bodies [bodies, 6]."""
        total = np.zeros((self.model.nbody, 6))
        if wrenches is None:
            return total
        data = self.data
        origins = data.xpos[self._bodies]
        origins[self._is_site] = data.site_xpos[self._sites[self._is_site]]
        arms = origins - data.xipos[self._bodies]
        shifted = wrenches.copy()
        shifted[:, 3:] += np.cross(arms, wrenches[:, :3])
        np.add.at(total, self._bodies, shifted)
        return total


def _turn(quaternion: FloatArray, angular: FloatArray, time_s: float) -> None:
    """Turns a quaternion w, x, y, z by an angular velocity along the world's axes."""
    speed = float(np.linalg.norm(angular))
    if speed > 0.0:
        turn = np.empty(4)
        mujoco.mju_axisAngle2Quat(turn, angular / speed, speed * time_s)
        mujoco.mju_mulQuat(quaternion, turn, quaternion.copy())
