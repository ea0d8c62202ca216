"""The world and the grasps of a twin that a MuJoCo model gives it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import mujoco
import numpy as np
import numpy.typing as npt

from bendtwin.coupling import geoms
from bendtwin.coupling.gripper import Condition, Gripper
from bendtwin.coupling.model import Carrier, moves
from bendtwin.coupling.poses import XYZW, Change
from bendtwin.geometry import Geometry
from bendtwin.simulation.world import Collider, Grasp, Plane, World

#: Limits of a twin's world (proto/bendtwin/v1/world.proto).
MOST_COLLIDERS = 32
MOST_CARRIERS = 32

Ground = Plane | Literal["none"] | None


@dataclass(frozen=True)
class Surroundings:
    """What a session is opened with, and which parts of the model its numbers are."""

    #: Bodies and sites that are grippers of the twin, by number.
    carriers: list[Carrier]
    world: World
    #: Grasps of the twin.
    grasps: list[Grasp]
    #: The carrier of each grasp; -1 for hands that are open or held where they are.
    grasp_carriers: list[int]
    #: The condition of each grasp.
    conditions: list[Condition]
    #: The carrier of each collider; -1 for those that stand still.
    collider_carriers: list[int]
    #: The gripper of each control point; the last gripper, after all carriers, stands still.
    gripper_of_control: npt.NDArray[np.uint32]


def surroundings(
    model: Any,
    data: Any,
    geometry: Geometry,
    grippers: Mapping[str, Gripper | Grasp],
    *,
    colliders: Sequence[str] | None,
    ground: Ground,
    margin_m: float,
    held_hands: Sequence[int],
    change: Change,
) -> Surroundings:
    """The surroundings of a twin in a model, as it stands in the data.

    Raises:
        ValueError: If the model has no such names, or more parts than a twin's world may have.
    """
    carriers: list[Carrier] = []
    grasps: list[Grasp] = []
    of_grasps: list[int] = []
    conditions: list[Condition] = []
    for number, (name, given) in enumerate(grippers.items()):
        gripper = given if isinstance(given, Gripper) else Gripper(given)
        carriers.append(Carrier.named(model, name))
        condition = gripper.condition(model)
        for grasp in gripper.numbered(number):
            grasps.append(grasp)
            of_grasps.append(number)
            conditions.append(condition)
    moving, still, plane = _colliders(model, data, colliders, margin_m, change)
    numbers = {c.body: n for n, c in enumerate(carriers) if c.site < 0}
    for body in dict.fromkeys(body for body, _ in moving):
        if body not in numbers:
            numbers[body] = len(carriers)
            carriers.append(Carrier(_body_name(model, body), body))
    of_colliders = [numbers[body] for body, _ in moving]
    bodies = [replace(collider, gripper=numbers[body]) for body, collider in moving]
    _check_counts(len(bodies) + len(still), len(carriers))

    taken = {grasp.hand: grasp.gripper for grasp in grasps if grasp.hand is not None}
    hands = range(geometry.hand_count)
    wrong = [hand for hand in {*taken, *held_hands} if hand not in hands]
    if wrong:
        raise ValueError(f"the twin has no hand {wrong[0]}: it has {geometry.hand_count}")
    rest = len(carriers)
    gripper_of_hand = np.array([taken.get(hand, rest) for hand in hands], np.uint32)
    for hand in hands:
        if hand not in taken and hand not in held_hands:
            grasps.append(Grasp(hand=hand, gripper=rest, closed=False))
            of_grasps.append(-1)
            conditions.append(lambda *_: False)
    gravity = np.zeros(3)
    if not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY:
        gravity = change.vector(model.opt.gravity)
    return Surroundings(
        carriers=carriers,
        world=World(
            colliders=[*bodies, *still],
            gravity=gravity,
            ground=plane if ground is None else ground,
        ),
        grasps=grasps,
        grasp_carriers=of_grasps,
        conditions=conditions,
        collider_carriers=[*of_colliders, *[-1] * len(still)],
        gripper_of_control=gripper_of_hand[geometry.hands.astype(int)],
    )


def _colliders(
    model: Any, data: Any, names: Sequence[str] | None, margin_m: float, change: Change
) -> tuple[list[tuple[int, Collider]], list[Collider], Plane | None]:
    """Colliders that move, each with its body, those that stand still, and the ground."""
    moving: list[tuple[int, Collider]] = []
    still: list[Collider] = []
    plane: Plane | None = None
    quaternion = np.empty(4)
    for geom in geoms.colliding(model, names):
        body = int(model.geom_bodyid[geom])
        does_move, name = moves(model, body), geoms.name_of(model, geom)
        if geoms.is_plane(model, geom):
            if does_move or plane is not None:
                raise ValueError(
                    f"plane {name!r} cannot be the ground of the twin, which has one that stands "
                    "still: leave it out by naming others with colliders="
                )
            axes = change.rotation(data.geom_xmat[geom].reshape(3, 3))
            plane = geoms.plane(change.point(data.geom_xpos[geom]), axes)
            continue
        if does_move:
            pose = np.concatenate([model.geom_pos[geom], model.geom_quat[geom][XYZW]])
        else:
            mujoco.mju_mat2Quat(quaternion, data.geom_xmat[geom])
            pose = change.pose(data.geom_xpos[geom], quaternion)
        collider = Collider(
            shape=geoms.shape(model, geom),
            friction=float(min(model.geom_friction[geom][0], 2.0)),
            margin_m=margin_m,
            pose=pose,
            name=name,
        )
        if does_move:
            moving.append((body, collider))
        else:
            still.append(collider)
    return moving, still, plane


def _body_name(model: Any, body: int) -> str:
    return mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) or f"body{body}"


def _check_counts(colliders: int, carriers: int) -> None:
    advice = "name the geoms or bodies that come near the object with colliders="
    if colliders > MOST_COLLIDERS:
        raise ValueError(
            f"{colliders} geoms collide: a twin has at most {MOST_COLLIDERS} colliders; {advice}"
        )
    # One more stands still.
    if carriers + 1 > MOST_CARRIERS:
        raise ValueError(
            f"{carriers} bodies move colliders or grasps: a twin has at most {MOST_CARRIERS - 1}; "
            f"{advice}"
        )
