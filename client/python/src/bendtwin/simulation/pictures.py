"""Pictures of the states of a session: cameras, things beside the object, and light.

Poses are x, y, z in metres and a quaternion x, y, z, w. Arrays may have a row for each slot in
front, in the order of the slots.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bendtwin.calls import Call
from bendtwin.rotations import quaternions
from bendtwin.simulation.world import Collider, Shape
from bendtwin.tensors import pack_bytes, pack_floats, unpack
from bendtwin.v1 import picture_pb2, tensor_pb2

Look = Literal["surface", "gaussians"]

_LOOKS: dict[str, picture_pb2.RenderSessionRequest.Look.ValueType] = {
    "surface": picture_pb2.RenderSessionRequest.SURFACE,
    "gaussians": picture_pb2.RenderSessionRequest.GAUSSIANS,
}


@dataclass(frozen=True, eq=False)
class PictureCamera:
    """A pinhole camera without distortion, with axes as in OpenCV: x to the right, y down, z
    forward; the centre of the first pixel is at (0, 0)."""

    #: Size of the pictures, pixels.
    width: int
    height: int
    #: fx, fy, cx, cy in pixels, [4] or [S, 4].
    intrinsics: npt.ArrayLike
    #: Pose in the world, [7] or [S, 7].
    pose: npt.ArrayLike
    #: What is seen where there is nothing else (sRGB): an image, uint8 [height, width, 3] or
    #: [S, height, width, 3], or a colour, [3] or [S, 3]. None for a light grey.
    background: npt.ArrayLike | None = None
    #: Name in errors.
    name: str = ""

    @classmethod
    def looking_at(
        cls,
        eye: npt.ArrayLike,
        target: npt.ArrayLike,
        *,
        width: int,
        height: int,
        field_of_view_deg: float,
        up: npt.ArrayLike = (0.0, 0.0, 1.0),
        background: npt.ArrayLike | None = None,
        name: str = "",
    ) -> PictureCamera:
        """A camera at `eye` [3] or [S, 3] with `target` [3] or [S, 3] in the middle of its
        pictures, and the direction `up` [3] towards their upper edge.

        `field_of_view_deg` is the angle between the left and the right edge.

        Raises:
            ValueError: If there is no such camera: it is at its target, or looks along `up`.
        """
        if not 0.0 < field_of_view_deg < 180.0:
            raise ValueError(f"field_of_view_deg is {field_of_view_deg}, not between 0 and 180")
        focal = width / 2 / np.tan(np.deg2rad(field_of_view_deg) / 2)
        return cls(
            width=width,
            height=height,
            intrinsics=(focal, focal, (width - 1) / 2, (height - 1) / 2),
            pose=looking(np.asarray(eye, float), np.asarray(target, float), np.asarray(up, float)),
            background=background,
            name=name,
        )

    def to_proto(self) -> picture_pb2.PictureCamera:
        """Makes the wire form."""
        message = picture_pb2.PictureCamera(
            name=self.name,
            width=self.width,
            height=self.height,
            intrinsics=_rows("intrinsics", self.intrinsics, 4),
            pose=_rows("pose", self.pose, 7),
        )
        if self.background is not None:
            message.background.CopyFrom(pack_bytes("background", self.background))
        return message


@dataclass(frozen=True, eq=False)
class Prop:
    """A rigid thing in pictures: a table, a bin, a gripper, a goal. The simulation does not know
    it."""

    shape: Shape
    #: Pose in the world, [7] or [S, 7]; None for the origin.
    pose: npt.ArrayLike | None = None
    #: Colour (sRGB), uint8 [3] or [S, 3]; None for grey.
    color: npt.ArrayLike | None = None

    def to_proto(self) -> picture_pb2.Prop:
        """Makes the wire form."""
        of = Collider(shape=self.shape).to_proto()
        message = picture_pb2.Prop()
        shape = of.WhichOneof("shape")
        assert shape is not None
        getattr(message, shape).CopyFrom(getattr(of, shape))
        if self.pose is not None:
            message.pose.CopyFrom(_rows("pose", self.pose, 7))
        if self.color is not None:
            message.color.CopyFrom(pack_bytes("color", self.color))
        return message


@dataclass(frozen=True, eq=False)
class Light:
    """A distant light and an even one. Gaussians keep the light of their recording: of these, only
    the brightness applies to them."""

    #: Direction from which the light comes, [3] or [S, 3]; None for above and behind the first
    #: camera.
    direction: npt.ArrayLike | None = None
    #: Share of the even light, 0..1, a number or [S]; None for 0.5.
    ambient: npt.ArrayLike | None = None
    #: Factor of all light but that of backgrounds, 0..4, a number or [S]; None for 1.
    brightness: npt.ArrayLike | None = None

    def to_proto(self) -> picture_pb2.Light:
        """Makes the wire form."""
        message = picture_pb2.Light()
        if self.direction is not None:
            message.direction.CopyFrom(_rows("direction", self.direction, 3))
        for name in ("ambient", "brightness"):
            value = getattr(self, name)
            if value is not None:
                packed = pack_floats(name, np.atleast_1d(value), (None,))
                getattr(message, name).CopyFrom(packed)
        return message


@dataclass(frozen=True, eq=False)
class Pictures:
    """Pictures that a camera took, a row for each of S slots. Arrays are read-only."""

    #: Colours (sRGB), [S, height, width, 3].
    colors: npt.NDArray[np.uint8]
    #: Distance along the camera's axis of what the label names, metres; 0 for the background.
    #: [S, height, width]; None unless asked for.
    depths: npt.NDArray[np.float32] | None = None
    #: What covers most of a pixel: 0 the background, 1 the object, 2 + i prop i.
    #: [S, height, width]; None unless asked for.
    labels: npt.NDArray[np.uint8] | None = None


def render_session(
    name: str,
    slots: Sequence[int],
    cameras: Sequence[PictureCamera],
    look: Look | None,
    props: Sequence[Prop],
    light: Light | None,
    depths: bool,
    labels: bool,
) -> Call[list[Pictures]]:
    """Takes pictures of slots."""
    request = picture_pb2.RenderSessionRequest(
        name=name,
        slots=slots,
        cameras=[camera.to_proto() for camera in cameras],
        props=[prop.to_proto() for prop in props],
        depths=depths,
        labels=labels,
    )
    if look is not None:
        if look not in _LOOKS:
            raise ValueError(f"look is {look!r}, not one of {', '.join(_LOOKS)}")
        request.look = _LOOKS[look]
    if light is not None:
        request.light.CopyFrom(light.to_proto())
    return Call(lambda s: s.sessions.RenderSession, request, _read)


def _read(reply: picture_pb2.RenderedSession) -> list[Pictures]:
    def array(tensor: tensor_pb2.Tensor) -> Any:
        return unpack(tensor)

    return [
        Pictures(array(one.colors), array(one.depths), array(one.labels)) for one in reply.cameras
    ]


def _rows(name: str, values: npt.ArrayLike, width: int) -> tensor_pb2.Tensor:
    """Packs numbers [width] or [S, width]."""
    array = np.asarray(values, float)
    shape: tuple[int | None, ...] = (width,) if array.ndim == 1 else (None, width)
    return pack_floats(name, array, shape)


def looking(
    eye: npt.NDArray[np.float64], target: npt.NDArray[np.float64], up: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Poses of cameras, [7] or [S, 7]."""
    eye, target = np.broadcast_arrays(eye, target)
    forward = target - eye
    right = np.cross(forward, np.broadcast_to(up, forward.shape))
    lengths = [np.linalg.norm(axis, axis=-1, keepdims=True) for axis in (forward, right)]
    if not all((length > 1e-9).all() for length in lengths):
        raise ValueError("a camera must not be at its target, nor look along `up`")
    forward, right = forward / lengths[0], right / lengths[1]
    down = np.cross(forward, right)
    rotation = np.stack([right, down, forward], axis=-1)
    return np.concatenate([eye, quaternions(rotation)], axis=-1)
