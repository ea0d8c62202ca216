"""A robot: joints that move links, and tips that carry grippers."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from bendtwin.robots import transforms
from bendtwin.robots.description import Description, Joint, Limits, Link, RobotError
from bendtwin.robots.inverse import Descent, Inverse, starts
from bendtwin.robots.kinematics import Tree
from bendtwin.robots.transforms import Array
from bendtwin.robots.urdf import read_urdf
from bendtwin.rotations import conjugate, logarithm, product


class Robot:
    """A tree of L links on J joints, with T tips: the links whose poses are those of grippers 0 to
    T - 1.

    Joints are in radians, metres for prismatic ones, and in the order of `joints`. Poses are x, y,
    z in metres and a quaternion x, y, z, w, in the coordinates of the twin's world.
    """

    def __init__(
        self,
        description: Description,
        *,
        tip: str | Sequence[str] | None = None,
        base_pose: npt.ArrayLike | None = None,
        limits: Mapping[str, Limits] | None = None,
    ) -> None:
        """See `from_urdf`."""
        tree = Tree.of(description)
        self._tree: Tree = tree
        #: Name in the description.
        self.name: str = description.name
        #: Names of the links [L], parents before children.
        self.links: tuple[str, ...] = tree.links
        self._parts: dict[str, Link] = {link.name: link for link in description.links}
        #: Joints that move by themselves [J].
        self.joints: tuple[Joint, ...] = _limited(tree.joints, limits or {})
        #: Names of the links that carry grippers [T].
        self.tips: tuple[str, ...] = self._tips(tip)
        #: Pose of the root link [7].
        self.base_pose: Array = (
            transforms.IDENTITY
            if base_pose is None
            else transforms.checked_poses("base_pose", base_pose, (7,))
        )

    @classmethod
    def from_urdf(
        cls,
        path_or_text: str | os.PathLike[str],
        *,
        package_dirs: Sequence[str | os.PathLike[str]] = (),
        tip: str | Sequence[str] | None = None,
        base_pose: npt.ArrayLike | None = None,
        limits: Mapping[str, Limits] | None = None,
    ) -> Robot:
        """Reads a URDF: kinematics, limits and collision shapes. Meshes are read when a `Workcell`
        needs them.

        Args:
            path_or_text: A file, or the text itself.
            package_dirs: Folders that contain packages, for files at `package://`.
            tip: The link that carries gripper 0, or those that carry grippers 0, 1, ...; None: the
                only link without children.
            base_pose: Pose of the root link in the twin's world; None: its origin.
            limits: Limits of joints by name, in the place of those of the description.

        Raises:
            RobotError: If the description is faulty; the message says what to change.
            OSError: If the file cannot be read.
        """
        description = read_urdf(path_or_text, package_dirs)
        return cls(description, tip=tip, base_pose=base_pose, limits=limits)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints [J]."""
        return tuple(joint.name for joint in self.joints)

    @property
    def low(self) -> Array:
        """Least positions [J]; -inf where there is no limit."""
        return np.array([joint.limits.low for joint in self.joints])

    @property
    def high(self) -> Array:
        """Largest positions [J]; +inf where there is no limit."""
        return np.array([joint.limits.high for joint in self.joints])

    @property
    def speed(self) -> Array:
        """Highest speeds [J] per second; +inf where there is no limit."""
        return np.array([joint.limits.speed for joint in self.joints])

    def positions(self, by_name: Mapping[str, float] | None = None) -> Array:
        """Joint positions [J] by name; others are 0, or in the middle of limits that exclude 0.

        Raises:
            RobotError: If there is no joint of a name.
        """
        middle = np.zeros(len(self.joints))
        beyond = (self.low > 0.0) | (self.high < 0.0)
        middle[beyond] = 0.5 * (self.low[beyond] + self.high[beyond])
        for name, position in (by_name or {}).items():
            middle[self.joint_index(name)] = position
        return middle

    def joint_index(self, name: str) -> int:
        """Number of a joint.

        Raises:
            RobotError: If there is no joint of this name, or it does not move by itself.
        """
        if name not in self.joint_names:
            raise RobotError(f"no joint {name!r} moves by itself: there are {self.joint_names}")
        return self.joint_names.index(name)

    def link_index(self, name: str) -> int:
        """Number of a link.

        Raises:
            RobotError: If there is no link of this name.
        """
        if name not in self.links:
            raise RobotError(f"there is no link {name!r}: there are {', '.join(self.links)}")
        return self.links.index(name)

    def link_poses(self, joints: npt.ArrayLike) -> Array:
        """Poses of all links [..., L, 7] for joints [..., J]: forward kinematics."""
        rows = self.checked(joints)
        poses = self._tree.forward(_flat(rows), self.base_pose)
        return poses.reshape(*rows.shape[:-1], len(self.links), 7)

    def tip_poses(self, joints: npt.ArrayLike) -> Array:
        """Poses of the tips [..., T, 7] for joints [..., J]."""
        return self.link_poses(joints)[..., [self.link_index(tip) for tip in self.tips], :]

    def jacobian(self, joints: npt.ArrayLike, link: str | None = None) -> Array:
        """The geometric Jacobian [..., 6, J] of a link, by default of the first tip: its velocity
        and angular velocity along the world's axes, by the velocities of joints."""
        rows = self.checked(joints)
        number = self.link_index(self.tips[0] if link is None else link)
        poses = self._tree.forward(_flat(rows), self.base_pose)
        slopes = self._tree.jacobian(poses, number)
        return slopes.reshape(*rows.shape[:-1], 6, len(self.joints))

    def gradients(self, link_poses: Array, by_poses: Array) -> Array:
        """d cost / d joints [..., J] where `link_poses` returned these poses [..., L, 7], by the
        gradient d cost / d poses in the same shape."""
        poses, slopes = (a.reshape(-1, len(self.links), 7) for a in (link_poses, by_poses))
        # A turn by w changes the quaternion q by (w, 0) q / 2.
        units = product(np.eye(4)[:3], poses[..., None, 3:])
        torques = 0.5 * np.einsum("nlj,nluj->nlu", slopes[..., 3:], units)
        by_joints = self._tree.back(poses, slopes[..., :3], torques)
        return by_joints.reshape(*link_poses.shape[:-2], len(self.joints))

    def inverse(
        self,
        poses: npt.ArrayLike,
        start: npt.ArrayLike,
        *,
        rotation_weight: float = 0.3,
        tolerance_m: float = 1e-4,
        tolerance: float = 1e-3,
        iterations: int = 100,
        restarts: int = 8,
        seed: int = 0,
    ) -> Inverse:
        """Joints that bring the tips to poses [T, 7], to a path of them [K, T, 7], or to several
        paths [B, K, T, 7]: inverse kinematics within the limits.

        A path is followed from pose to pose, so that it does not jump between ways to reach it;
        only its first pose is tried from other starts.

        Args:
            poses: Those of all tips; the actions of `bendtwin.planners.Grippers` are such.
            start: Joints [J] near which the first pose is sought.
            rotation_weight: Metres that a radian counts for; 0 reaches for positions alone.
            tolerance_m: Distance within which a pose counts as reached.
            tolerance: Angle within which it does [rad].
            iterations: Of one pose and start at most.
            restarts: Other starts for the first pose, if it is not reached from `start`.
            seed: Of these starts.

        Raises:
            ValueError: If shapes do not fit. Poses out of reach are no error: `Inverse.reached`.
        """
        given = np.asarray(poses, dtype=np.float64)
        if given.ndim not in (2, 3, 4):
            raise ValueError(f"poses have shape {given.shape}: give [T, 7], [K, T, 7] or more")
        wanted = transforms.checked_poses(
            "poses", given, (*(None,) * (given.ndim - 2), len(self.tips), 7)
        )
        first = self.checked(start)
        if first.ndim != 1:
            raise ValueError(f"start has shape {first.shape}: give joints [{len(self.joints)}]")
        if rotation_weight < 0.0 or tolerance_m <= 0.0 or tolerance <= 0.0:
            raise ValueError("give tolerances above 0, and a weight of 0 or more")
        search = _Search(self, rotation_weight, tolerance_m, tolerance, iterations)
        paths = wanted.reshape(-1, *((1, 1, *wanted.shape)[-3:]))
        joints = np.zeros((*paths.shape[:2], len(self.joints)))
        for b, path in enumerate(paths):
            now = first
            for k, pose in enumerate(path):
                others = starts(now, self.low, self.high, restarts if k == 0 else 0, seed)
                joints[b, k] = now = search.best(pose, others)
        joints = joints.reshape(*wanted.shape[:-2], len(self.joints))
        apart, turned = search.errors_of(wanted, self.tip_poses(joints))
        within = (apart <= tolerance_m) & ((turned <= tolerance) | (rotation_weight == 0.0))
        return Inverse(joints, apart, turned, within)

    def checked(self, joints: npt.ArrayLike) -> Array:
        """Joints [..., J] as an array.

        Raises:
            ValueError: If they have another shape, or are not finite.
        """
        rows = np.asarray(joints, dtype=np.float64)
        if rows.ndim < 1 or rows.shape[-1] != len(self.joints):
            raise ValueError(
                f"joints have shape {rows.shape}: give [..., {len(self.joints)}], in the order "
                f"{', '.join(self.joint_names)}"
            )
        if not np.isfinite(rows).all():
            raise ValueError("joints have values that are not finite")
        return rows

    def moving_joints(self, links: Sequence[str]) -> npt.NDArray[np.bool_]:
        """Whether each joint [J] moves one of some links."""
        numbers = [self.link_index(link) for link in links]
        moves = self._tree.moves[numbers].any(axis=0)
        return np.asarray((self._tree.factors[moves] != 0.0).any(axis=0))

    def rigid_with(self, link: str) -> str:
        """The link nearest to the root that moves with a link as one body."""
        number = self.link_index(link)
        while self._tree.parents[number] >= 0 and number not in self._tree.moving:
            number = int(self._tree.parents[number])
        return self.links[number]

    def is_carried_by(self, link: str, by: str) -> bool:
        """True if a link is another one, or is carried by it through joints."""
        number, other = self.link_index(link), self.link_index(by)
        while number >= 0 and number != other:
            number = int(self._tree.parents[number])
        return number == other

    def link(self, name: str) -> Link:
        """The collision shapes of a link."""
        return self._parts[self.links[self.link_index(name)]]

    def _tips(self, tip: str | Sequence[str] | None) -> tuple[str, ...]:
        if tip is None:
            parents = {self.links[p] for p in self._tree.parents if p >= 0}
            ends = [name for name in self.links if name not in parents]
            if len(ends) != 1:
                raise RobotError(f"name the link that carries the gripper, tip=...: one of {ends}?")
            return (ends[0],)
        tips = (tip,) if isinstance(tip, str) else tuple(tip)
        if not tips or len(set(tips)) < len(tips):
            raise RobotError("give one link as tip, or several that differ")
        for name in tips:
            self.link_index(name)
        return tips


class _Search:
    """The search for joints of a pose of all tips."""

    def __init__(
        self, robot: Robot, weight: float, tolerance_m: float, tolerance: float, iterations: int
    ) -> None:
        self._robot, self._weight = robot, weight
        self._numbers = [robot.link_index(tip) for tip in robot.tips]
        # Well inside the tolerances, so that rounding does not decide.
        least = 0.5 * np.array([tolerance_m, tolerance * weight if weight else np.inf])

        def is_near(errors: Array) -> bool:
            parts = np.linalg.norm(errors.reshape(-1, 2, 3), axis=-1)
            return bool((parts <= least).all())

        self._descent = Descent(
            low=robot.low, high=robot.high, iterations=iterations, is_near=is_near
        )

    def best(self, pose: Array, others: list[Array]) -> Array:
        """The best joints from several starts; the first ones that are near enough."""

        def errors(joints: Array) -> tuple[Array, Array]:
            return self._errors(pose, joints)

        best, least = others[0], np.inf
        for start in others:
            found = self._descent.from_start(start, errors)
            error, _ = errors(found)
            if error @ error < least:
                best, least = found, float(error @ error)
            if self._descent.is_near(error):
                break
        return best

    def errors_of(self, wanted: Array, poses: Array) -> tuple[Array, Array]:
        """Largest distance and angle between tips [..., T, 7], each [...]."""
        apart = np.linalg.norm(wanted[..., :3] - poses[..., :3], axis=-1)
        turned = np.linalg.norm(_turns(wanted, poses), axis=-1)
        return apart.max(axis=-1), turned.max(axis=-1)

    def _errors(self, wanted: Array, joints: Array) -> tuple[Array, Array]:
        tree = self._robot._tree
        poses = tree.forward(joints[None], self._robot.base_pose)
        slopes = np.stack([tree.jacobian(poses, n)[0] for n in self._numbers])
        tips = poses[0, self._numbers]
        scale = np.array([1.0, 1.0, 1.0, *[self._weight] * 3])
        errors = np.concatenate([wanted[:, :3] - tips[:, :3], _turns(wanted, tips)], axis=-1)
        return (errors * scale).ravel(), (slopes * scale[:, None]).reshape(-1, len(joints))


def _turns(wanted: Array, poses: Array) -> Array:
    """Rotation vectors [..., 3] from poses to wanted ones, along the world's axes."""
    return logarithm(product(wanted[..., 3:], conjugate(poses[..., 3:])))


def _flat(rows: Array) -> Array:
    """Rows [N, J] of joints [..., J], of which there may be none."""
    return rows.reshape(math.prod(rows.shape[:-1]), rows.shape[-1])


def _limited(joints: Sequence[Joint], limits: Mapping[str, Limits]) -> tuple[Joint, ...]:
    names = [joint.name for joint in joints]
    for name, own in limits.items():
        if name not in names:
            raise RobotError(f"limits name the joint {name!r}, but the joints are {names}")
        if not own.low <= own.high or not own.speed >= 0.0:
            raise RobotError(f"the limits of {name!r} must have low below high, and a speed")
    return tuple(replace(j, limits=limits.get(j.name, j.limits)) for j in joints)
