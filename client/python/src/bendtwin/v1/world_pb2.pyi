from bendtwin.v1 import tensor_pb2 as _tensor_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class World(_message.Message):
    __slots__ = ("gravity", "ground", "no_ground", "ground_friction", "ground_restitution", "colliders")
    GRAVITY_FIELD_NUMBER: _ClassVar[int]
    GROUND_FIELD_NUMBER: _ClassVar[int]
    NO_GROUND_FIELD_NUMBER: _ClassVar[int]
    GROUND_FRICTION_FIELD_NUMBER: _ClassVar[int]
    GROUND_RESTITUTION_FIELD_NUMBER: _ClassVar[int]
    COLLIDERS_FIELD_NUMBER: _ClassVar[int]
    gravity: _containers.RepeatedScalarFieldContainer[float]
    ground: Plane
    no_ground: bool
    ground_friction: float
    ground_restitution: float
    colliders: _containers.RepeatedCompositeFieldContainer[Collider]
    def __init__(self, gravity: _Optional[_Iterable[float]] = ..., ground: _Optional[_Union[Plane, _Mapping]] = ..., no_ground: bool = ..., ground_friction: _Optional[float] = ..., ground_restitution: _Optional[float] = ..., colliders: _Optional[_Iterable[_Union[Collider, _Mapping]]] = ...) -> None: ...

class Plane(_message.Message):
    __slots__ = ("normal", "offset_m")
    NORMAL_FIELD_NUMBER: _ClassVar[int]
    OFFSET_M_FIELD_NUMBER: _ClassVar[int]
    normal: _containers.RepeatedScalarFieldContainer[float]
    offset_m: float
    def __init__(self, normal: _Optional[_Iterable[float]] = ..., offset_m: _Optional[float] = ...) -> None: ...

class Collider(_message.Message):
    __slots__ = ("name", "sphere", "capsule", "cuboid", "convex_mesh", "friction", "restitution", "margin_m", "fixed", "gripper", "path", "pose")
    class Fixed(_message.Message):
        __slots__ = ()
        def __init__(self) -> None: ...
    NAME_FIELD_NUMBER: _ClassVar[int]
    SPHERE_FIELD_NUMBER: _ClassVar[int]
    CAPSULE_FIELD_NUMBER: _ClassVar[int]
    CUBOID_FIELD_NUMBER: _ClassVar[int]
    CONVEX_MESH_FIELD_NUMBER: _ClassVar[int]
    FRICTION_FIELD_NUMBER: _ClassVar[int]
    RESTITUTION_FIELD_NUMBER: _ClassVar[int]
    MARGIN_M_FIELD_NUMBER: _ClassVar[int]
    FIXED_FIELD_NUMBER: _ClassVar[int]
    GRIPPER_FIELD_NUMBER: _ClassVar[int]
    PATH_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    name: str
    sphere: Sphere
    capsule: Capsule
    cuboid: Cuboid
    convex_mesh: ConvexMesh
    friction: float
    restitution: float
    margin_m: float
    fixed: Collider.Fixed
    gripper: int
    path: _tensor_pb2.Tensor
    pose: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, name: _Optional[str] = ..., sphere: _Optional[_Union[Sphere, _Mapping]] = ..., capsule: _Optional[_Union[Capsule, _Mapping]] = ..., cuboid: _Optional[_Union[Cuboid, _Mapping]] = ..., convex_mesh: _Optional[_Union[ConvexMesh, _Mapping]] = ..., friction: _Optional[float] = ..., restitution: _Optional[float] = ..., margin_m: _Optional[float] = ..., fixed: _Optional[_Union[Collider.Fixed, _Mapping]] = ..., gripper: _Optional[int] = ..., path: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., pose: _Optional[_Iterable[float]] = ...) -> None: ...

class Sphere(_message.Message):
    __slots__ = ("center", "radius_m")
    CENTER_FIELD_NUMBER: _ClassVar[int]
    RADIUS_M_FIELD_NUMBER: _ClassVar[int]
    center: _containers.RepeatedScalarFieldContainer[float]
    radius_m: float
    def __init__(self, center: _Optional[_Iterable[float]] = ..., radius_m: _Optional[float] = ...) -> None: ...

class Capsule(_message.Message):
    __slots__ = ("to", "radius_m")
    FROM_FIELD_NUMBER: _ClassVar[int]
    TO_FIELD_NUMBER: _ClassVar[int]
    RADIUS_M_FIELD_NUMBER: _ClassVar[int]
    to: _containers.RepeatedScalarFieldContainer[float]
    radius_m: float
    def __init__(self, to: _Optional[_Iterable[float]] = ..., radius_m: _Optional[float] = ..., **kwargs) -> None: ...

class Cuboid(_message.Message):
    __slots__ = ("low", "high")
    LOW_FIELD_NUMBER: _ClassVar[int]
    HIGH_FIELD_NUMBER: _ClassVar[int]
    low: _containers.RepeatedScalarFieldContainer[float]
    high: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, low: _Optional[_Iterable[float]] = ..., high: _Optional[_Iterable[float]] = ...) -> None: ...

class ConvexMesh(_message.Message):
    __slots__ = ("points",)
    POINTS_FIELD_NUMBER: _ClassVar[int]
    points: _tensor_pb2.Tensor
    def __init__(self, points: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...

class Grasp(_message.Message):
    __slots__ = ("gripper", "sphere", "cuboid", "nodes", "hand", "attachment", "stiffness", "damping", "closed", "max_force_n")
    class Attachment(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        ATTACHMENT_UNSPECIFIED: _ClassVar[Grasp.Attachment]
        PIN: _ClassVar[Grasp.Attachment]
        SPRINGS: _ClassVar[Grasp.Attachment]
    ATTACHMENT_UNSPECIFIED: Grasp.Attachment
    PIN: Grasp.Attachment
    SPRINGS: Grasp.Attachment
    class CaptureHand(_message.Message):
        __slots__ = ("hand",)
        HAND_FIELD_NUMBER: _ClassVar[int]
        hand: int
        def __init__(self, hand: _Optional[int] = ...) -> None: ...
    GRIPPER_FIELD_NUMBER: _ClassVar[int]
    SPHERE_FIELD_NUMBER: _ClassVar[int]
    CUBOID_FIELD_NUMBER: _ClassVar[int]
    NODES_FIELD_NUMBER: _ClassVar[int]
    HAND_FIELD_NUMBER: _ClassVar[int]
    ATTACHMENT_FIELD_NUMBER: _ClassVar[int]
    STIFFNESS_FIELD_NUMBER: _ClassVar[int]
    DAMPING_FIELD_NUMBER: _ClassVar[int]
    CLOSED_FIELD_NUMBER: _ClassVar[int]
    MAX_FORCE_N_FIELD_NUMBER: _ClassVar[int]
    gripper: int
    sphere: Sphere
    cuboid: Cuboid
    nodes: _tensor_pb2.Tensor
    hand: Grasp.CaptureHand
    attachment: Grasp.Attachment
    stiffness: float
    damping: float
    closed: _tensor_pb2.Tensor
    max_force_n: float
    def __init__(self, gripper: _Optional[int] = ..., sphere: _Optional[_Union[Sphere, _Mapping]] = ..., cuboid: _Optional[_Union[Cuboid, _Mapping]] = ..., nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., hand: _Optional[_Union[Grasp.CaptureHand, _Mapping]] = ..., attachment: _Optional[_Union[Grasp.Attachment, str]] = ..., stiffness: _Optional[float] = ..., damping: _Optional[float] = ..., closed: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., max_force_n: _Optional[float] = ...) -> None: ...

class Grasping(_message.Message):
    __slots__ = ("phases", "holders", "places")
    PHASES_FIELD_NUMBER: _ClassVar[int]
    HOLDERS_FIELD_NUMBER: _ClassVar[int]
    PLACES_FIELD_NUMBER: _ClassVar[int]
    phases: _tensor_pb2.Tensor
    holders: _tensor_pb2.Tensor
    places: _tensor_pb2.Tensor
    def __init__(self, phases: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., holders: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., places: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...

class Vary(_message.Message):
    __slots__ = ("stiffness", "damping", "bending", "friction", "mass", "fits", "ground_restitution", "object_restitution")
    STIFFNESS_FIELD_NUMBER: _ClassVar[int]
    DAMPING_FIELD_NUMBER: _ClassVar[int]
    BENDING_FIELD_NUMBER: _ClassVar[int]
    FRICTION_FIELD_NUMBER: _ClassVar[int]
    MASS_FIELD_NUMBER: _ClassVar[int]
    FITS_FIELD_NUMBER: _ClassVar[int]
    GROUND_RESTITUTION_FIELD_NUMBER: _ClassVar[int]
    OBJECT_RESTITUTION_FIELD_NUMBER: _ClassVar[int]
    stiffness: _tensor_pb2.Tensor
    damping: _tensor_pb2.Tensor
    bending: _tensor_pb2.Tensor
    friction: _tensor_pb2.Tensor
    mass: _tensor_pb2.Tensor
    fits: bool
    ground_restitution: _tensor_pb2.Tensor
    object_restitution: _tensor_pb2.Tensor
    def __init__(self, stiffness: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., damping: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., bending: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., friction: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., mass: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., fits: bool = ..., ground_restitution: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., object_restitution: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
