from bendtwin.v1 import options_pb2 as _options_pb2
from bendtwin.v1 import rollout_pb2 as _rollout_pb2
from bendtwin.v1 import tensor_pb2 as _tensor_pb2
from bendtwin.v1 import world_pb2 as _world_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Observation(_message.Message):
    __slots__ = ("points", "nodes", "places", "weights", "velocities", "cameras")
    class Places(_message.Message):
        __slots__ = ("points", "node_positions")
        POINTS_FIELD_NUMBER: _ClassVar[int]
        NODE_POSITIONS_FIELD_NUMBER: _ClassVar[int]
        points: _tensor_pb2.Tensor
        node_positions: _tensor_pb2.Tensor
        def __init__(self, points: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., node_positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
    POINTS_FIELD_NUMBER: _ClassVar[int]
    NODES_FIELD_NUMBER: _ClassVar[int]
    PLACES_FIELD_NUMBER: _ClassVar[int]
    WEIGHTS_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    CAMERAS_FIELD_NUMBER: _ClassVar[int]
    points: _tensor_pb2.Tensor
    nodes: _tensor_pb2.Tensor
    places: Observation.Places
    weights: _tensor_pb2.Tensor
    velocities: _tensor_pb2.Tensor
    cameras: _tensor_pb2.Tensor
    def __init__(self, points: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., places: _Optional[_Union[Observation.Places, _Mapping]] = ..., weights: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., velocities: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., cameras: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...

class RegisterStateRequest(_message.Message):
    __slots__ = ("twin", "observation", "initial", "controls", "world", "options", "grippers")
    TWIN_FIELD_NUMBER: _ClassVar[int]
    OBSERVATION_FIELD_NUMBER: _ClassVar[int]
    INITIAL_FIELD_NUMBER: _ClassVar[int]
    CONTROLS_FIELD_NUMBER: _ClassVar[int]
    WORLD_FIELD_NUMBER: _ClassVar[int]
    OPTIONS_FIELD_NUMBER: _ClassVar[int]
    GRIPPERS_FIELD_NUMBER: _ClassVar[int]
    twin: str
    observation: Observation
    initial: _rollout_pb2.InitialState
    controls: _tensor_pb2.Tensor
    world: _world_pb2.World
    options: RegisterOptions
    grippers: _tensor_pb2.Tensor
    def __init__(self, twin: _Optional[str] = ..., observation: _Optional[_Union[Observation, _Mapping]] = ..., initial: _Optional[_Union[_rollout_pb2.InitialState, _Mapping]] = ..., controls: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., world: _Optional[_Union[_world_pb2.World, _Mapping]] = ..., options: _Optional[_Union[RegisterOptions, _Mapping]] = ..., grippers: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...

class RegisterOptions(_message.Message):
    __slots__ = ("near", "noise_m", "give", "settle_frames", "max_residual_m", "least_explained")
    NEAR_FIELD_NUMBER: _ClassVar[int]
    NOISE_M_FIELD_NUMBER: _ClassVar[int]
    GIVE_FIELD_NUMBER: _ClassVar[int]
    SETTLE_FRAMES_FIELD_NUMBER: _ClassVar[int]
    MAX_RESIDUAL_M_FIELD_NUMBER: _ClassVar[int]
    LEAST_EXPLAINED_FIELD_NUMBER: _ClassVar[int]
    near: bool
    noise_m: float
    give: float
    settle_frames: int
    max_residual_m: float
    least_explained: float
    def __init__(self, near: bool = ..., noise_m: _Optional[float] = ..., give: _Optional[float] = ..., settle_frames: _Optional[int] = ..., max_residual_m: _Optional[float] = ..., least_explained: _Optional[float] = ...) -> None: ...

class RegisteredState(_message.Message):
    __slots__ = ("state", "before", "after", "explained", "motion", "drift_mm", "worker")
    STATE_FIELD_NUMBER: _ClassVar[int]
    BEFORE_FIELD_NUMBER: _ClassVar[int]
    AFTER_FIELD_NUMBER: _ClassVar[int]
    EXPLAINED_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    DRIFT_MM_FIELD_NUMBER: _ClassVar[int]
    WORKER_FIELD_NUMBER: _ClassVar[int]
    state: _rollout_pb2.InitialState.GivenState
    before: Residual
    after: Residual
    explained: Explained
    motion: _containers.RepeatedScalarFieldContainer[float]
    drift_mm: float
    worker: str
    def __init__(self, state: _Optional[_Union[_rollout_pb2.InitialState.GivenState, _Mapping]] = ..., before: _Optional[_Union[Residual, _Mapping]] = ..., after: _Optional[_Union[Residual, _Mapping]] = ..., explained: _Optional[_Union[Explained, _Mapping]] = ..., motion: _Optional[_Iterable[float]] = ..., drift_mm: _Optional[float] = ..., worker: _Optional[str] = ...) -> None: ...

class Residual(_message.Message):
    __slots__ = ("median_mm", "mean_mm", "p95_mm")
    MEDIAN_MM_FIELD_NUMBER: _ClassVar[int]
    MEAN_MM_FIELD_NUMBER: _ClassVar[int]
    P95_MM_FIELD_NUMBER: _ClassVar[int]
    median_mm: float
    mean_mm: float
    p95_mm: float
    def __init__(self, median_mm: _Optional[float] = ..., mean_mm: _Optional[float] = ..., p95_mm: _Optional[float] = ...) -> None: ...

class Explained(_message.Message):
    __slots__ = ("points", "surface", "within_mm")
    POINTS_FIELD_NUMBER: _ClassVar[int]
    SURFACE_FIELD_NUMBER: _ClassVar[int]
    WITHIN_MM_FIELD_NUMBER: _ClassVar[int]
    points: float
    surface: float
    within_mm: float
    def __init__(self, points: _Optional[float] = ..., surface: _Optional[float] = ..., within_mm: _Optional[float] = ...) -> None: ...

class CorrectOptions(_message.Message):
    __slots__ = ("noise_m", "give", "velocity_noise_m_s", "velocity_gain_per_s", "most_added_strain", "max_residual_m", "carry", "world", "grippers", "register_if_lost", "omit_state")
    NOISE_M_FIELD_NUMBER: _ClassVar[int]
    GIVE_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_NOISE_M_S_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_GAIN_PER_S_FIELD_NUMBER: _ClassVar[int]
    MOST_ADDED_STRAIN_FIELD_NUMBER: _ClassVar[int]
    MAX_RESIDUAL_M_FIELD_NUMBER: _ClassVar[int]
    CARRY_FIELD_NUMBER: _ClassVar[int]
    WORLD_FIELD_NUMBER: _ClassVar[int]
    GRIPPERS_FIELD_NUMBER: _ClassVar[int]
    REGISTER_IF_LOST_FIELD_NUMBER: _ClassVar[int]
    OMIT_STATE_FIELD_NUMBER: _ClassVar[int]
    noise_m: float
    give: float
    velocity_noise_m_s: float
    velocity_gain_per_s: float
    most_added_strain: float
    max_residual_m: float
    carry: float
    world: _world_pb2.World
    grippers: _tensor_pb2.Tensor
    register_if_lost: bool
    omit_state: bool
    def __init__(self, noise_m: _Optional[float] = ..., give: _Optional[float] = ..., velocity_noise_m_s: _Optional[float] = ..., velocity_gain_per_s: _Optional[float] = ..., most_added_strain: _Optional[float] = ..., max_residual_m: _Optional[float] = ..., carry: _Optional[float] = ..., world: _Optional[_Union[_world_pb2.World, _Mapping]] = ..., grippers: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., register_if_lost: bool = ..., omit_state: bool = ...) -> None: ...
