"""Rigid bodies of a robot: links that move as one, with their collision shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bendtwin.robots.description import RobotError
from bendtwin.robots.robot import Robot
from bendtwin.robots.shapes import Cylinders, Solid, merged, shape_of, solid_of
from bendtwin.robots.transforms import Array, relative
from bendtwin.rotations import compose
from bendtwin.simulation.world import Collider


@dataclass(frozen=True)
class Body:
    """Links that move as one."""

    #: The link whose pose is that of the body: the tip, if it is among them.
    link: str
    #: Number of the tip; None: it has none.
    tip: int | None
    #: False if it is fixed to the world.
    moves: bool
    #: Collision shapes: the name of each one's link, the shape, and its pose [7] on the body.
    solids: tuple[tuple[str, Solid, Array], ...]


def bodies_of(robot: Robot, links: Sequence[str]) -> list[Body]:
    """Bodies of links that have shapes, in the order of the robot's links; meshes are read."""
    # Of tips in one body the first carries it.
    tips = {robot.rigid_with(tip): i for i, tip in reversed(list(enumerate(robot.tips)))}
    members: dict[str, list[str]] = {}
    for name in sorted(links, key=robot.link_index):
        members.setdefault(robot.rigid_with(name), []).append(name)
    at_zero = robot.link_poses(np.zeros(len(robot.joints)))
    bodies = []
    for first, names in members.items():
        moves = first != robot.links[0]
        tip = tips.get(first) if moves else None
        carrier = first if tip is None else robot.tips[tip]
        origin = at_zero[robot.link_index(carrier)]
        solids = []
        for name in names:
            pose = relative(origin, at_zero[robot.link_index(name)])
            for part in robot.link(name).parts:
                solid = solid_of(part, f"link {name!r}")
                solids.append((name, solid, compose(pose, part.pose)))
        bodies.append(Body(carrier, tip, moves, tuple(solids)))
    return bodies


def links_with_shapes(robot: Robot, links: Sequence[str] | None) -> list[str]:
    """The links that were chosen, or by default all that have shapes, without fingers.

    Raises:
        RobotError: If a chosen one has no shape.
    """
    if links is None:
        hidden = fingers(robot)
        return [n for n in robot.links if robot.link(n).parts and n not in hidden]
    for name in links:
        if not robot.link(name).parts:
            raise RobotError(f"the link {name!r} has no collision shape: leave it out of links")
    return list(dict.fromkeys(links))


def fingers(robot: Robot) -> list[str]:
    """Links with shapes that a tip carries through joints, and that carry no tip."""
    hands = {robot.rigid_with(tip) for tip in robot.tips}

    def is_finger(name: str) -> bool:
        return (
            robot.rigid_with(name) not in hands
            and any(robot.is_carried_by(name, hand) for hand in hands)
            and not any(robot.is_carried_by(tip, name) for tip in robot.tips)
        )

    if robot.links[0] in hands:
        return []
    return [name for name in robot.links if robot.link(name).parts and is_finger(name)]


def colliders_of(
    robot: Robot, body: Body, gripper: int | None, merge: bool, cylinders: Cylinders
) -> list[tuple[tuple[str, ...], Collider]]:
    """Colliders of a body that a gripper carries, or that is fixed, with the links that each is
    made of."""
    base = robot.link_poses(np.zeros(len(robot.joints)))[robot.link_index(body.link)]

    def placed(pose: Array) -> Array:
        return pose if gripper is not None else compose(base, pose)

    if merge and len(body.solids) > 1:
        links = tuple(dict.fromkeys(name for name, _, _ in body.solids))
        shape = merged([s for _, s, _ in body.solids], [pose for _, _, pose in body.solids])
        origin = None if gripper is not None else base
        return [(links, Collider(shape=shape, gripper=gripper, pose=origin, name=links[0]))]
    made: list[tuple[tuple[str, ...], Collider]] = []
    count: dict[str, int] = {}
    for link, solid, pose in body.solids:
        count[link] = count.get(link, 0) + 1
        name = link if count[link] == 1 else f"{link}/{count[link]}"
        shape = shape_of(solid, cylinders)
        collider = Collider(shape=shape, gripper=gripper, pose=placed(pose), name=name)
        made.append(((link,), collider))
    return made
