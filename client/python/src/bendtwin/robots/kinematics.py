"""Forward kinematics of a tree of links, its Jacobian, and the way back of gradients.

A link's pose is `p_parent + R_parent (o + R_o d)` with the origin `o`, `R_o` of its joint, and with
`d` the displacement of a prismatic joint, or no displacement and a turn about the axis. A joint
coordinate q moves link l, with a the axis of the joint in the world and c its position, by

    revolute   dp/dq = a x (p_l - c),  angular velocity a
    prismatic  dp/dq = a,              angular velocity 0

so that the gradient by q of a cost with force f and torque t at every link is the sum over the
links that it moves of `a . (t + (p - c) x f)`, or of `a . f`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bendtwin.robots.description import Attachment, Description, Joint, RobotError
from bendtwin.robots.transforms import IDENTITY, Array
from bendtwin.rotations import compose, product, rotated


@dataclass(frozen=True)
class Tree:
    """Links of a robot in an order in which parents come before their children; L links, M of them
    on a joint that moves, J joint coordinates."""

    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    #: Parent of each link, -1 for the root [L].
    parents: npt.NDArray[np.int64]
    #: Poses on the parents [L, 7].
    origins: Array
    #: Links on a joint that moves [M], the axes of these joints in the coordinates of the link
    #: [M, 3], and whether they turn [M].
    moving: npt.NDArray[np.int64]
    axes: Array
    turns: npt.NDArray[np.bool_]
    #: Positions of the M joints are `factors @ q + offsets`, [M, J] and [M].
    factors: Array
    offsets: Array
    #: Whether joint m moves link l, [L, M].
    moves: npt.NDArray[np.bool_]

    @classmethod
    def of(cls, description: Description) -> Tree:
        """Orders the links of a description.

        Raises:
            RobotError: If its joints do not make one tree.
        """
        names, by_child = _ordered(description)
        number = {name: i for i, name in enumerate(names)}
        attachments = [by_child.get(name) for name in names]
        moving = [i for i, a in enumerate(attachments) if a is not None and a.kind != "fixed"]
        chosen = [a for i in moving if (a := attachments[i]) is not None]
        own = [a for a in chosen if a.mimic is None]
        factors, offsets = _couplings(chosen, own)
        parents = np.array([-1 if a is None else number[a.parent] for a in attachments])
        moves = np.zeros((len(names), len(moving)), bool)
        for i, parent in enumerate(parents):
            if parent >= 0:
                moves[i] = moves[parent]
            if i in moving:
                moves[i, moving.index(i)] = True
        return cls(
            links=tuple(names),
            joints=tuple(Joint(a.name, a.kind, a.limits) for a in own),
            parents=parents,
            origins=np.array([IDENTITY if a is None else a.origin for a in attachments]),
            moving=np.array(moving, np.int64),
            axes=np.array([a.axis for a in chosen]).reshape(-1, 3),
            turns=np.array([a.kind != "prismatic" for a in chosen], bool),
            factors=factors,
            offsets=offsets,
            moves=moves,
        )

    def forward(self, joints: Array, base: Array) -> Array:
        """Poses of all links [N, L, 7] for joints [N, J], with the root at a pose [7]."""
        positions = joints @ self.factors.T + self.offsets
        poses = np.empty((len(joints), len(self.links), 7))
        number = {int(link): m for m, link in enumerate(self.moving)}
        for i, parent in enumerate(self.parents):
            outer = base if parent < 0 else poses[:, parent]
            pose = compose(outer, self.origins[i])
            m = number.get(i)
            if m is not None and self.turns[m]:
                half = 0.5 * positions[:, m, None]
                turn = np.concatenate([np.sin(half) * self.axes[m], np.cos(half)], axis=-1)
                pose[:, 3:] = product(pose[:, 3:], turn)
            elif m is not None:
                pose[:, :3] += rotated(pose[:, 3:], positions[:, m, None] * self.axes[m])
            poses[:, i] = pose
        return poses

    def back(self, poses: Array, forces: Array, torques: Array) -> Array:
        """d cost / d joints [N, J] from d cost / d positions of all links, and from the torque, d
        cost / d rotation about the world's axes, [N, L, 3] each."""
        moves = self.moves.astype(np.float64)
        force = np.einsum("nlx,lm->nmx", forces, moves)
        about_origin = torques + np.cross(poses[..., :3], forces)
        torque = np.einsum("nlx,lm->nmx", about_origin, moves)
        axes, centers = self._world_axes(poses)
        turned = torque - np.cross(centers, force)
        by_joint = (axes * np.where(self.turns[:, None], turned, force)).sum(axis=-1)
        return np.asarray(by_joint @ self.factors)

    def jacobian(self, poses: Array, link: int) -> Array:
        """Velocity and angular velocity of a link by joint velocities, along the world's axes,
        [N, 6, J]."""
        axes, centers = self._world_axes(poses)
        arms = poses[:, link, None, :3] - centers
        turns = self.turns[:, None]
        linear = np.where(turns, np.cross(axes, arms), axes)
        angular = np.where(turns, axes, 0.0)
        columns = np.concatenate([linear, angular], axis=-1) * self.moves[link][:, None]
        return np.asarray(np.einsum("nmx,mj->nxj", columns, self.factors))

    def _world_axes(self, poses: Array) -> tuple[Array, Array]:
        """Axes and positions of the joints in the world, [N, M, 3] each."""
        own = poses[:, self.moving]
        return rotated(own[..., 3:], np.broadcast_to(self.axes, own[..., :3].shape)), own[..., :3]


def _ordered(description: Description) -> tuple[list[str], dict[str, Attachment]]:
    """Names of the links, parents before children, and the joint of each child."""
    known = {link.name for link in description.links}
    by_child: dict[str, Attachment] = {}
    children: dict[str, list[str]] = {}
    for joint in description.attachments:
        for end in (joint.parent, joint.child):
            if end not in known:
                raise RobotError(f"joint {joint.name!r} names a link {end!r}, which is missing")
        if joint.child in by_child:
            raise RobotError(
                f"link {joint.child!r} has two parents, by the joints "
                f"{by_child[joint.child].name!r} and {joint.name!r}: a URDF is a tree, open the "
                "loop at one of them"
            )
        by_child[joint.child] = joint
        children.setdefault(joint.parent, []).append(joint.child)
    roots = [link.name for link in description.links if link.name not in by_child]
    if not roots:
        raise RobotError("every link has a parent, so that they form a loop: remove one joint")
    if len(roots) > 1:
        raise RobotError(f"the links {roots[:5]} have no parent: only one may, join the others")
    names: list[str] = []
    waiting = [roots[0]]
    while waiting:
        names.append(waiting.pop())
        waiting.extend(reversed(children.get(names[-1], [])))
    if len(names) < len(known):
        lost = sorted(known - set(names))
        raise RobotError(f"the links {lost[:5]} form a loop apart from {roots[0]!r}")
    return names, by_child


def _couplings(chosen: Sequence[Attachment], own: Sequence[Attachment]) -> tuple[Array, Array]:
    """Factors [M, J] and offsets [M] of joints, along chains of mimics."""
    column = {joint.name: j for j, joint in enumerate(own)}
    by_name = {joint.name: joint for joint in chosen}
    factors, offsets = np.zeros((len(chosen), len(own))), np.zeros(len(chosen))
    for m, joint in enumerate(chosen):
        factor, offset, leader = 1.0, 0.0, joint
        for _ in range(len(chosen)):
            if leader.mimic is None:
                break
            offset += factor * leader.mimic.offset
            factor *= leader.mimic.factor
            follows = by_name.get(leader.mimic.joint)
            if follows is None:
                raise RobotError(
                    f"joint {leader.name!r} mimics {leader.mimic.joint!r}, which does not move"
                )
            leader = follows
        if leader.mimic is not None:
            raise RobotError(f"joint {joint.name!r} mimics itself, through others")
        factors[m, column[leader.name]] = factor
        offsets[m] = offset
    return factors, offsets
