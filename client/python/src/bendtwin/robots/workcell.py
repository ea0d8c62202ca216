"""A robot among the things around it, as the world of rollouts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from bendtwin.geometry import Geometry
from bendtwin.planners.knots import curve_matrix
from bendtwin.robots.bodies import Body, bodies_of, colliders_of, fingers, links_with_shapes
from bendtwin.robots.contacts import Contact, contacts_of
from bendtwin.robots.description import RobotError
from bendtwin.robots.obstacles import Obstacles, carried
from bendtwin.robots.robot import Robot
from bendtwin.robots.shapes import Cylinders, samples
from bendtwin.robots.transforms import Array
from bendtwin.rotations import compose
from bendtwin.simulation.costs import Clearance, Force, When
from bendtwin.simulation.interpolation import Interpolation
from bendtwin.simulation.rollout import RolloutResult
from bendtwin.simulation.world import Collider, Plane, World

#: Most colliders, and most bodies that carry any of them.
_MOST = 32


class Workcell:
    """A robot whose links are colliders of a world.

    The tips of the robot are grippers 0 to T - 1 of every rollout. Each other body, links that move
    together, follows as a further gripper that carries its colliders; links that do not move are
    static colliders.

    `world` has them behind the colliders that were given. A rollout, a session or a `Task` takes
    it, with the poses of this cell: `rollout_arguments`, or the actions of a `JointSpace`.
    """

    def __init__(
        self,
        robot: Robot,
        geometry: Geometry | None = None,
        *,
        world: World | None = None,
        links: Sequence[str] | None = None,
        merge: bool = False,
        cylinders: Cylinders = "auto",
        margin_m: float = 0.0,
        friction: float = 0.5,
        hands: Mapping[int, str | None] | None = None,
    ) -> None:
        """Reads the collision shapes of links.

        Args:
            robot: The robot.
            geometry: That of the twin, `Twin.geometry()`: its ground is an obstacle of the robot,
                and tips carry its hands.
            world: What else is around the object. Its colliders keep their numbers; no gripper
                carries them.
            links: Links that are colliders; None: all that have collision shapes, but those that
                a tip carries through joints, the fingers of a gripper, which hold the object.
            merge: Makes one convex collider of all shapes of a body: fewer, and larger.
            cylinders: How cylinders become colliders (`bendtwin.robots.shapes`).
            margin_m: Distance that nodes keep from links: about the radius of a cable.
            friction: Of the links.
            hands: The tip that carries the control points of each hand of the twin's capture, by
                its number; None: the hand stands still. By default hand h goes with tip h, and with
                the first tip if there is only one.

        Raises:
            RobotError: If a shape cannot be used, or there are too many.
        """
        self.robot: Robot = robot
        given = World() if world is None else world
        if any(collider.gripper is not None for collider in given.colliders):
            raise RobotError("a cell carries its own links: leave out colliders with a gripper")
        bodies = bodies_of(robot, links_with_shapes(robot, links))
        # What must not touch the ground: fingers as well, unless the links were named.
        hidden = bodies_of(robot, fingers(robot)) if links is None else []
        self._moving: list[Body] = [body for body in [*bodies, *hidden] if body.moves]
        #: Links whose poses are those of the grippers; None: a gripper that stands still.
        self.carriers: list[str | None] = list(robot.tips)
        #: Links of the colliders of the robot, by their number in the world.
        self.links_of_colliders: dict[int, tuple[str, ...]] = {}
        colliders = list(given.colliders)
        for body in bodies:
            for names, made in colliders_of(robot, body, self._gripper(body), merge, cylinders):
                self.links_of_colliders[len(colliders)] = names
                colliders.append(replace(made, margin_m=margin_m, friction=friction))
        #: The gripper of each control point [C]; None: gripper 0 has all.
        self.gripper_of_control: npt.NDArray[np.uint32] | None = self._owners(geometry, hands)
        _check(colliders, len(given.colliders), len(self.carriers))
        #: The world of rollouts, sessions and tasks with this robot.
        self.world: World = replace(given, colliders=tuple(colliders))
        self._obstacles = Obstacles(_ground(given, geometry), given.colliders)

    def poses(self, link_poses: Array) -> Array:
        """Poses [..., G, 7] of the grippers among poses of all links [..., L, 7]."""
        first = self.robot.links[0]
        numbers = [self.robot.link_index(name or first) for name in self.carriers]
        poses = link_poses[..., numbers, :]
        poses[..., self._is_still(), :] = self.robot.base_pose
        return np.asarray(poses)

    def gradients(self, link_poses: Array, by_poses: npt.NDArray[Any]) -> Array:
        """d cost / d joints [..., J] by d cost / d poses [..., G, 7] of the grippers."""
        by_links = np.zeros(link_poses.shape)
        for gripper, name in enumerate(self.carriers):
            if name is not None:
                by_links[..., self.robot.link_index(name), :] += by_poses[..., gripper, :]
        return self.robot.gradients(link_poses, by_links)

    def actions(self, path: Array) -> dict[str, Any]:
        """Poses of the grippers along joint paths [B, K, J], and who carries which control points,
        as arguments of a rollout."""
        poses = self.poses(self.robot.link_poses(path))
        named: dict[str, Any] = {"poses": poses.astype(np.float32)}
        if self.gripper_of_control is not None:
            named["gripper_of_control"] = self.gripper_of_control
        return named

    def rollout_arguments(
        self,
        joints: npt.ArrayLike,
        *,
        frames: int | None = None,
        interpolation: Interpolation = "linear",
    ) -> dict[str, Any]:
        """Arguments of `Twin.rollout`, `Session.rollout` and `Session.advance` that move the robot
        along joint paths [B, K, J]: poses of every frame, world, frames and who carries which
        control points. Closings of grasps and paths of colliders beside them are by frame boundary
        as well, [F + 1].

        Args:
            joints: Joints at every frame boundary, K = F + 1, of which row 0 is the start; or with
                `frames` any number of knots, spread evenly and interpolated as joints.
            frames: Horizon F.
            interpolation: Of joints between knots.
        """
        path = self.robot.checked(joints)
        if path.ndim != 3 or path.shape[1] < 2:
            raise ValueError(
                f"joints have shape {path.shape}: give paths [B, K, J] of two knots or more"
            )
        if frames is not None:
            if frames < 1:
                raise ValueError("the horizon must be one frame or more")
            times = np.arange(frames + 1) * (path.shape[1] - 1) / frames
            path = np.einsum("fk,bkj->bfj", curve_matrix(times, path.shape[1], interpolation), path)
        return {**self.actions(path), "world": self.world, "frames": path.shape[1] - 1}

    def depths(self, joints: npt.ArrayLike) -> Array:
        """How deep the robot is in the ground or in a static collider [...], metres, for joints
        [..., J]: its links that move, and its fingers, by their deepest point; 0 where it is free.

        It is measured at points of the links, 3 cm apart or, on large ones, more. Links inside of
        each other do not count.
        """
        rows = self.robot.checked(joints)
        poses = self.robot.link_poses(rows).reshape(-1, len(self.robot.links), 7)
        deepest = np.zeros(len(poses))
        for body in self._moving:
            at = poses[:, self.robot.link_index(body.link)]
            for _, solid, pose in body.solids:
                points, reach = samples(solid)
                depth = self._obstacles.depth(carried(compose(at, pose), points), reach)
                deepest = np.maximum(deepest, depth)
        return deepest.reshape(rows.shape[:-1])

    def colliders_of(self, link: str) -> list[int]:
        """Numbers of the colliders of a link in the world, as costs and results use them.

        Raises:
            RobotError: If the link has none.
        """
        numbers = [i for i, names in self.links_of_colliders.items() if link in names]
        if not numbers:
            known = [name for names in self.links_of_colliders.values() for name in names]
            raise RobotError(
                f"the link {link!r} has no collider: there are {', '.join(dict.fromkeys(known))}"
            )
        return numbers

    def clearance(
        self, *links: str, margin_m: float, weight: float = 1.0, when: When = "every_frame"
    ) -> list[Clearance]:
        """Costs of nodes nearer than a margin to links, by default to all with colliders: see
        `bendtwin.Clearance`. They are named `clearance of` and the collider."""
        return [
            Clearance(collider=i, margin_m=margin_m, weight=weight, when=when, name=name)
            for i, name in self._named("clearance", links)
        ]

    def force(
        self, *links: str, limit_n: float = 0.0, weight: float = 1.0, when: When = "every_frame"
    ) -> list[Force]:
        """Costs of forces between the object and links, by default all with colliders, beyond a
        limit: see `bendtwin.Force`. They are named `force of` and the collider."""
        return [
            Force(by=("collider", i), limit_n=limit_n, weight=weight, when=when, name=name)
            for i, name in self._named("force", links)
        ]

    def contacts(self, result: RolloutResult) -> dict[str, Contact]:
        """Forces between the object and each link with colliders, in a rollout in this world with
        `Returns(forces=True)`."""
        return contacts_of(result, self.links_of_colliders)

    def _named(self, what: str, links: Sequence[str]) -> list[tuple[int, str]]:
        chosen = [i for link in links for i in self.colliders_of(link)] or self.links_of_colliders
        return [(i, f"{what} of {self.world.colliders[i].name}") for i in dict.fromkeys(chosen)]

    def _gripper(self, body: Body) -> int | None:
        """The gripper that carries a body; None: the body is fixed."""
        if not body.moves or body.tip is not None:
            return body.tip
        self.carriers.append(body.link)
        return len(self.carriers) - 1

    def _is_still(self) -> npt.NDArray[np.bool_]:
        return np.array([name is None for name in self.carriers])

    def _owners(
        self, geometry: Geometry | None, hands: Mapping[int, str | None] | None
    ) -> npt.NDArray[np.uint32] | None:
        tips = self.robot.tips
        count = 0 if geometry is None else geometry.hand_count
        if hands is None:
            if len(tips) == 1 or not count:
                return None
            hands = {h: tips[h] if h < len(tips) else None for h in range(count)}
        elif geometry is None:
            raise RobotError("to say which tip carries which hand, give the twin's geometry")
        owner: list[int | None] = [None] * count
        for hand, tip in hands.items():
            if not 0 <= hand < count:
                raise RobotError(f"there is no hand {hand}: the twin has {count}, counted from 0")
            if tip is not None and tip not in tips:
                raise RobotError(f"{tip!r} is no tip of the robot: it has {', '.join(tips)}")
            owner[hand] = None if tip is None else tips.index(tip)
        if None in owner:
            self.carriers.append(None)
        still = len(self.carriers) - 1
        numbers = np.array([still if o is None else o for o in owner], np.uint32)
        return None if geometry is None else numbers[geometry.hands]


def _check(colliders: Sequence[Collider], given: int, grippers: int) -> None:
    names = [collider.name for collider in colliders if collider.name]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise RobotError(f"two colliders have the name {twice[0]!r}: rename that of the world")
    if len(colliders) > _MOST:
        raise RobotError(
            f"there are {len(colliders)} colliders, {given} of the world and "
            f"{len(colliders) - given} of links; at most {_MOST} are possible: merge the shapes of "
            "each body, merge=True, or name the links that matter, links=[...]"
        )
    moving = grippers + sum(collider.path is not None for collider in colliders)
    if moving > _MOST:
        raise RobotError(
            f"there are {moving} moving bodies; at most {_MOST} are possible: name the links that "
            "matter, links=[...]"
        )


def _ground(world: World, geometry: Geometry | None) -> Plane | None:
    """The ground of rollouts."""
    if isinstance(world.ground, Plane):
        return world.ground
    if world.ground == "none" or geometry is None or geometry.ground is None:
        return None
    return Plane(geometry.ground.offset_m, geometry.ground.normal)
