"""Pictures of the slots of a session, by all cameras in one call.

The server draws the object; what is around it goes there as props: obstacles, goals and grippers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bendtwin import rotations
from bendtwin.envs.body import Array, Indices
from bendtwin.envs.cameras import Camera
from bendtwin.envs.props import CLOSED, OBSTACLE, OPEN
from bendtwin.envs.randomisation import Look
from bendtwin.envs.simulation import Mask, Simulation
from bendtwin.envs.tasks.task import Task
from bendtwin.simulation.pictures import Light, PictureCamera, Prop
from bendtwin.simulation.world import Capsule

Pixels = dict[str, npt.NDArray[np.uint8]]

#: Most pixels and slots of a call.
_MOST_PIXELS, _MOST_SLOTS = 8_388_608, 1024


class Pictures:
    """Draws slots as cameras see them."""

    def __init__(
        self,
        simulation: Simulation,
        task: Task,
        cameras: Sequence[Camera],
        look: Literal["surface", "gaussians"] | None,
    ) -> None:
        self.cameras = list(cameras)
        self._simulation, self._task, self._look = simulation, task, look
        radius = 0.2 * task.body.grasp_radius_m + 0.012 * task.body.length_m
        self._finger = Capsule([0.0, 0.0, 0.0], [0.0, 0.0, 4.0 * radius], 0.5 * radius)
        self._palm = Capsule([0.0, 0.0, 4.0 * radius], [0.0, 0.0, 9.0 * radius], radius)
        self._apart = (2.4 * radius, 0.8 * radius)
        pixels = sum(camera.width * camera.height for camera in cameras)
        self._most = min(_MOST_SLOTS, _MOST_PIXELS // max(pixels, 1))
        if cameras and not self._most:
            raise ValueError(f"the cameras have {pixels} pixels, {_MOST_PIXELS} at most")

    def draw(
        self, slots: Indices, poses: Array, closed: Mask, goals: Array, looks: Sequence[Look]
    ) -> Pixels:
        """Pictures [R, height, width, 3] of slots [R] by the names of the cameras, of their poses
        [R, G, 7], openings [R, G], goals [R, D] and looks [R].

        Raises:
            SessionLost: If the session was lost.
        """
        parts = []
        for begin in range(0, len(slots), self._most):
            rows = slice(begin, begin + self._most)
            parts.append(
                self._draw(slots[rows], poses[rows], closed[rows], goals[rows], looks[rows])
            )
        names = [camera.name for camera in self.cameras]
        return {name: np.concatenate([part[i] for part in parts]) for i, name in enumerate(names)}

    def _draw(
        self, slots: Indices, poses: Array, closed: Mask, goals: Array, looks: Sequence[Look]
    ) -> list[npt.NDArray[np.uint8]]:
        light = Light(
            direction=_rows([look.light for look in looks]),
            ambient=_rows([look.ambient for look in looks]),
            brightness=_rows([look.brightness for look in looks]),
        )
        cameras = [self._camera(i, poses, looks) for i in range(len(self.cameras))]
        props = [*self._around(goals, looks), *self._grippers(poses, closed)]
        session = self._simulation.session
        pictures = self._simulation.run(
            lambda: session.render(
                cameras, slots=slots.tolist(), look=self._look, props=props, light=light
            )
        )
        return [np.array(one.colors) for one in pictures]

    def _camera(self, number: int, poses: Array, looks: Sequence[Look]) -> PictureCamera:
        camera = self.cameras[number]
        pose = np.broadcast_to(np.asarray(camera.pose, float), (len(looks), 7))
        if camera.gripper is not None:
            pose = rotations.compose(poses[:, camera.gripper], pose)
        shift = np.array([[*look.shift_m[number], *look.turn[number]] for look in looks])
        lens = np.broadcast_to(np.asarray(camera.intrinsics, float), (len(looks), 4)).copy()
        lens[:, :2] /= np.array([look.zoom[number] for look in looks])[:, None]
        background = camera.background
        if looks[0].background is not None and np.ndim(np.asarray(background)) < 2:
            background = np.array(
                [look.background[number] for look in looks if look.background is not None]
            )
        return PictureCamera(
            name=camera.name,
            width=camera.width,
            height=camera.height,
            intrinsics=lens,
            pose=rotations.compose(pose, shift),
            background=None if background is None else np.asarray(background, np.uint8),
        )

    def _around(self, goals: Array, looks: Sequence[Look]) -> list[Prop]:
        """Obstacles and goals."""
        props = []
        for number, collider in enumerate(self._task.colliders):
            tint = np.array([look.tint[number] for look in looks])
            color = np.clip(np.array(OBSTACLE) + tint, 0, 255).astype(np.uint8)
            props.append(Prop(collider.shape, pose=collider.pose, color=color))
        for marker in self._task.markers():
            pose = None if marker.pose is None else marker.pose(goals)
            props.append(Prop(marker.shape, pose=pose, color=np.array(marker.color, np.uint8)))
        return props

    def _grippers(self, poses: Array, closed: Mask) -> list[Prop]:
        """A palm and two fingers of each gripper."""
        props = []
        for gripper in range(poses.shape[1]):
            pose, shut = poses[:, gripper], closed[:, gripper]
            color = np.where(shut[:, None], CLOSED, OPEN).astype(np.uint8)
            props.append(Prop(self._palm, pose=pose, color=color))
            apart = np.where(shut, self._apart[1], self._apart[0])
            for side in (-1.0, 1.0):
                place = np.zeros((len(pose), 7))
                place[:, 1], place[:, 6] = side * apart, 1.0
                props.append(Prop(self._finger, pose=rotations.compose(pose, place), color=color))
        return props


def _rows(values: Sequence[Any]) -> npt.NDArray[np.float32]:
    return np.asarray(values, np.float32)
