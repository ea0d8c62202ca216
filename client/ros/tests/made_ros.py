"""A robot that moves a cable, and what a camera and TF report of it, without ROS."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy_twin import NONE
from scenes import twisted

from bendtwin import Returns
from bendtwin_ros.clouds import cloud_of
from bendtwin_ros.frames import MissingTransform
from bendtwin_ros.messages.basic import Header
from bendtwin_ros.parameters import GRIPPER_PARAMETERS, PARAMETERS, settings_of
from bendtwin_ros.poses import IDENTITY, SECOND, applied, inverse, time_of

#: Moment at which every recording begins.
START_NS = 1_000 * SECOND
PARTS = 4


def cable_file():
    """A cable between two clamps whose skin lies along it."""
    file, _ = twisted()
    count = len(file.tensors["nodes.rest_position"])
    at = np.linspace(0, count - 1, PARTS * (count - 1) + 1)
    first = np.minimum(at.astype(int), count - 2)
    share = at - first
    file.tensors["skin.observed_point"] = np.full(len(at), NONE, "<u4")
    file.tensors["skin.weight_count"] = np.full(len(at), 2, "<u4")
    file.tensors["skin.weight_node"] = np.stack([first, first + 1], 1).ravel().astype("<u4")
    file.tensors["skin.weight"] = np.stack([1 - share, share], 1).ravel().astype("<f4")
    file.tensors["skin.frame"] = np.full((len(at), 3), NONE, "<u4")
    file.tensors["skin.offset"] = np.zeros((len(at), 3), "<f4")
    return file


def settings(**given):
    """Settings of a node; `__` in a name stands for its dot."""
    named = {name.replace("__", "."): value for name, value in given.items()}
    grippers = [name for name in named.get("grippers", [""]) if name]
    values = {parameter.name: parameter.default for parameter in PARAMETERS}
    for name in grippers:
        values |= {
            f"{name}.{parameter.name}": parameter.default for parameter in GRIPPER_PARAMETERS
        }
    unknown = named.keys() - values.keys()
    assert not unknown, unknown
    return settings_of((values | named).__getitem__)


@dataclass
class FakeFrames:
    """TF: frames with fixed poses, and paths as functions of the time in nanoseconds."""

    poses: dict = field(default_factory=dict)

    def pose(self, target, source, at_ns):
        """See `bendtwin_ros.frames.Frames`."""
        if target == source:
            return IDENTITY
        if source not in self.poses or target != "twin":
            raise MissingTransform(f"from `{source}` to `{target}`: there is no such frame")
        pose = self.poses[source]
        found = pose(at_ns) if callable(pose) else pose
        if found is None:
            raise MissingTransform(f"from `{source}` to `{target}`: not at that time")
        return np.asarray(found, dtype=np.float64)


def shifted(by):
    """A pose that is moved and not turned."""
    return np.array([*by, 0.0, 0.0, 0.0, 1.0])


#: A camera that looks at the cable from the side.
CAMERA = np.array([0.1, -0.6, 0.4, 0.7071068, 0.0, 0.0, 0.7071068])
STEP = 3


def cloud_at(points, at_ns, frame="camera", camera=CAMERA):
    """A cloud of points of the twin's frame, as a camera sees them."""
    header = Header(time_of(at_ns), frame)
    return cloud_of(applied(inverse(camera), points), header)


class Cable:
    """The cable itself: a twin whose two ends two grippers carry along paths."""

    def __init__(self, twin, noise_m=0.001):
        self.twin = twin
        self.geometry = twin.geometry()
        self.fps = self.geometry.fps
        self._noise = np.random.default_rng(0)
        self._noise_m = noise_m

    def left(self, at_ns):
        """Where the left gripper is: it moves sideways and up, and back."""
        t = (at_ns - START_NS) / SECOND
        way = [0.05 * np.sin(2.0 * t), 0.08 * np.sin(1.5 * t), 0.03 * (1 - np.cos(t))]
        return shifted(self.geometry.controls[0] + way)

    def right(self, at_ns):
        """Where the right gripper is: it moves less, and to the other side."""
        t = (at_ns - START_NS) / SECOND
        return shifted(self.geometry.controls[1] + np.array([0.0, -0.05 * np.sin(t), 0.0]))

    def frames(self):
        """TF with the camera and the grippers."""
        poses = {"camera": CAMERA, "left_tcp": self.left, "right_tcp": self.right}
        return FakeFrames(poses)

    def settings(self, address, **given):
        """Settings of a node that follows the cable."""
        own = {
            "twin": self.twin.name,
            "server__address": address,
            "grippers": ["left", "right"],
            "left__frame": "left_tcp",
            "left__hand": 0,
            "right__frame": "right_tcp",
            "right__hand": 1,
            "cloud__min_points": 10,
            "mass_kg": 0.1,
        }
        values = {**own, **given}
        if values["grippers"] == [""]:
            values = {k: v for k, v in values.items() if not k.startswith(("left", "right"))}
        return settings(**values)

    def motion(self, steps, vary=None):
        """The skin [S + 1, M, 3] and the nodes after every `STEP` frames, and their stamps."""
        count = steps * STEP
        stamps = [START_NS + round(k * SECOND / self.fps) for k in range(count + 1)]
        result = self.twin.rollout(
            poses=np.array([[self.left(at), self.right(at)] for at in stamps])[None],
            gripper_of_control=self.geometry.hands,
            frames=count,
            vary=vary,
            returns=Returns(every_frames=STEP),
        )
        nodes = np.concatenate([self.geometry.rest_positions[None], result.positions[0]])
        return self.geometry.skin.positions(nodes), nodes, stamps[::STEP]

    def noisy(self, points):
        """Points with the noise of a camera."""
        return points + self._noise.normal(0.0, self._noise_m, points.shape)
