from bendtwin.v1 import tensor_pb2 as _tensor_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Fidelity(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    FIDELITY_UNSPECIFIED: _ClassVar[Fidelity]
    EXACT: _ClassVar[Fidelity]
    FAST: _ClassVar[Fidelity]

class Interpolation(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    INTERPOLATION_UNSPECIFIED: _ClassVar[Interpolation]
    LINEAR: _ClassVar[Interpolation]
    CUBIC: _ClassVar[Interpolation]
FIDELITY_UNSPECIFIED: Fidelity
EXACT: Fidelity
FAST: Fidelity
INTERPOLATION_UNSPECIFIED: Interpolation
LINEAR: Interpolation
CUBIC: Interpolation

class RollOutRequest(_message.Message):
    __slots__ = ("twin", "trajectories", "poses", "initial", "frames", "costs", "returns", "fidelity")
    TWIN_FIELD_NUMBER: _ClassVar[int]
    TRAJECTORIES_FIELD_NUMBER: _ClassVar[int]
    POSES_FIELD_NUMBER: _ClassVar[int]
    INITIAL_FIELD_NUMBER: _ClassVar[int]
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    COSTS_FIELD_NUMBER: _ClassVar[int]
    RETURNS_FIELD_NUMBER: _ClassVar[int]
    FIDELITY_FIELD_NUMBER: _ClassVar[int]
    twin: str
    trajectories: ControlTrajectories
    poses: GripperPoses
    initial: InitialState
    frames: int
    costs: _containers.RepeatedCompositeFieldContainer[Cost]
    returns: Returns
    fidelity: Fidelity
    def __init__(self, twin: _Optional[str] = ..., trajectories: _Optional[_Union[ControlTrajectories, _Mapping]] = ..., poses: _Optional[_Union[GripperPoses, _Mapping]] = ..., initial: _Optional[_Union[InitialState, _Mapping]] = ..., frames: _Optional[int] = ..., costs: _Optional[_Iterable[_Union[Cost, _Mapping]]] = ..., returns: _Optional[_Union[Returns, _Mapping]] = ..., fidelity: _Optional[_Union[Fidelity, str]] = ...) -> None: ...

class ControlTrajectories(_message.Message):
    __slots__ = ("positions", "interpolation")
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    INTERPOLATION_FIELD_NUMBER: _ClassVar[int]
    positions: _tensor_pb2.Tensor
    interpolation: Interpolation
    def __init__(self, positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., interpolation: _Optional[_Union[Interpolation, str]] = ...) -> None: ...

class GripperPoses(_message.Message):
    __slots__ = ("poses", "gripper_of_control", "interpolation")
    POSES_FIELD_NUMBER: _ClassVar[int]
    GRIPPER_OF_CONTROL_FIELD_NUMBER: _ClassVar[int]
    INTERPOLATION_FIELD_NUMBER: _ClassVar[int]
    poses: _tensor_pb2.Tensor
    gripper_of_control: _tensor_pb2.Tensor
    interpolation: Interpolation
    def __init__(self, poses: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., gripper_of_control: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., interpolation: _Optional[_Union[Interpolation, str]] = ...) -> None: ...

class InitialState(_message.Message):
    __slots__ = ("rest", "capture_frame", "given")
    class Rest(_message.Message):
        __slots__ = ()
        def __init__(self) -> None: ...
    class CaptureFrame(_message.Message):
        __slots__ = ("capture", "sequence", "frame")
        CAPTURE_FIELD_NUMBER: _ClassVar[int]
        SEQUENCE_FIELD_NUMBER: _ClassVar[int]
        FRAME_FIELD_NUMBER: _ClassVar[int]
        capture: str
        sequence: int
        frame: int
        def __init__(self, capture: _Optional[str] = ..., sequence: _Optional[int] = ..., frame: _Optional[int] = ...) -> None: ...
    class GivenState(_message.Message):
        __slots__ = ("positions", "velocities", "twists")
        POSITIONS_FIELD_NUMBER: _ClassVar[int]
        VELOCITIES_FIELD_NUMBER: _ClassVar[int]
        TWISTS_FIELD_NUMBER: _ClassVar[int]
        positions: _tensor_pb2.Tensor
        velocities: _tensor_pb2.Tensor
        twists: _tensor_pb2.Tensor
        def __init__(self, positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., velocities: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., twists: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
    REST_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FRAME_FIELD_NUMBER: _ClassVar[int]
    GIVEN_FIELD_NUMBER: _ClassVar[int]
    rest: InitialState.Rest
    capture_frame: InitialState.CaptureFrame
    given: InitialState.GivenState
    def __init__(self, rest: _Optional[_Union[InitialState.Rest, _Mapping]] = ..., capture_frame: _Optional[_Union[InitialState.CaptureFrame, _Mapping]] = ..., given: _Optional[_Union[InitialState.GivenState, _Mapping]] = ...) -> None: ...

class Cost(_message.Message):
    __slots__ = ("name", "weight", "when", "target_cloud", "keypoints", "smoothness")
    class When(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        WHEN_UNSPECIFIED: _ClassVar[Cost.When]
        LAST_FRAME: _ClassVar[Cost.When]
        EVERY_FRAME: _ClassVar[Cost.When]
    WHEN_UNSPECIFIED: Cost.When
    LAST_FRAME: Cost.When
    EVERY_FRAME: Cost.When
    class TargetCloud(_message.Message):
        __slots__ = ("points",)
        POINTS_FIELD_NUMBER: _ClassVar[int]
        points: _tensor_pb2.Tensor
        def __init__(self, points: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
    class Keypoints(_message.Message):
        __slots__ = ("nodes", "targets", "squared")
        NODES_FIELD_NUMBER: _ClassVar[int]
        TARGETS_FIELD_NUMBER: _ClassVar[int]
        SQUARED_FIELD_NUMBER: _ClassVar[int]
        nodes: _tensor_pb2.Tensor
        targets: _tensor_pb2.Tensor
        squared: bool
        def __init__(self, nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., targets: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., squared: bool = ...) -> None: ...
    class Smoothness(_message.Message):
        __slots__ = ()
        def __init__(self) -> None: ...
    NAME_FIELD_NUMBER: _ClassVar[int]
    WEIGHT_FIELD_NUMBER: _ClassVar[int]
    WHEN_FIELD_NUMBER: _ClassVar[int]
    TARGET_CLOUD_FIELD_NUMBER: _ClassVar[int]
    KEYPOINTS_FIELD_NUMBER: _ClassVar[int]
    SMOOTHNESS_FIELD_NUMBER: _ClassVar[int]
    name: str
    weight: float
    when: Cost.When
    target_cloud: Cost.TargetCloud
    keypoints: Cost.Keypoints
    smoothness: Cost.Smoothness
    def __init__(self, name: _Optional[str] = ..., weight: _Optional[float] = ..., when: _Optional[_Union[Cost.When, str]] = ..., target_cloud: _Optional[_Union[Cost.TargetCloud, _Mapping]] = ..., keypoints: _Optional[_Union[Cost.Keypoints, _Mapping]] = ..., smoothness: _Optional[_Union[Cost.Smoothness, _Mapping]] = ...) -> None: ...

class Returns(_message.Message):
    __slots__ = ("every_frames", "nodes", "encoding", "best", "final_state", "diagnostics", "control_gradients")
    class Encoding(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        ENCODING_UNSPECIFIED: _ClassVar[Returns.Encoding]
        FLOAT32: _ClassVar[Returns.Encoding]
        INT16: _ClassVar[Returns.Encoding]
    ENCODING_UNSPECIFIED: Returns.Encoding
    FLOAT32: Returns.Encoding
    INT16: Returns.Encoding
    EVERY_FRAMES_FIELD_NUMBER: _ClassVar[int]
    NODES_FIELD_NUMBER: _ClassVar[int]
    ENCODING_FIELD_NUMBER: _ClassVar[int]
    BEST_FIELD_NUMBER: _ClassVar[int]
    FINAL_STATE_FIELD_NUMBER: _ClassVar[int]
    DIAGNOSTICS_FIELD_NUMBER: _ClassVar[int]
    CONTROL_GRADIENTS_FIELD_NUMBER: _ClassVar[int]
    every_frames: int
    nodes: _tensor_pb2.Tensor
    encoding: Returns.Encoding
    best: int
    final_state: bool
    diagnostics: bool
    control_gradients: bool
    def __init__(self, every_frames: _Optional[int] = ..., nodes: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., encoding: _Optional[_Union[Returns.Encoding, str]] = ..., best: _Optional[int] = ..., final_state: bool = ..., diagnostics: bool = ..., control_gradients: bool = ...) -> None: ...

class RollOutResponse(_message.Message):
    __slots__ = ("first_instance", "costs", "cost_names", "cost_terms", "instances", "frames", "positions", "final_positions", "final_velocities", "control_gradients", "diagnostics", "diverged", "timing", "worker", "fidelity", "substeps", "deviation", "final_twists")
    class Diagnostics(_message.Message):
        __slots__ = ("max_strain", "max_speed_m_s", "kinetic_energy", "elastic_energy", "ground_contacts")
        MAX_STRAIN_FIELD_NUMBER: _ClassVar[int]
        MAX_SPEED_M_S_FIELD_NUMBER: _ClassVar[int]
        KINETIC_ENERGY_FIELD_NUMBER: _ClassVar[int]
        ELASTIC_ENERGY_FIELD_NUMBER: _ClassVar[int]
        GROUND_CONTACTS_FIELD_NUMBER: _ClassVar[int]
        max_strain: float
        max_speed_m_s: float
        kinetic_energy: float
        elastic_energy: float
        ground_contacts: int
        def __init__(self, max_strain: _Optional[float] = ..., max_speed_m_s: _Optional[float] = ..., kinetic_energy: _Optional[float] = ..., elastic_energy: _Optional[float] = ..., ground_contacts: _Optional[int] = ...) -> None: ...
    class Divergence(_message.Message):
        __slots__ = ("instance", "frame", "node")
        INSTANCE_FIELD_NUMBER: _ClassVar[int]
        FRAME_FIELD_NUMBER: _ClassVar[int]
        NODE_FIELD_NUMBER: _ClassVar[int]
        instance: int
        frame: int
        node: int
        def __init__(self, instance: _Optional[int] = ..., frame: _Optional[int] = ..., node: _Optional[int] = ...) -> None: ...
    class Timing(_message.Message):
        __slots__ = ("queue_s", "compute_s")
        QUEUE_S_FIELD_NUMBER: _ClassVar[int]
        COMPUTE_S_FIELD_NUMBER: _ClassVar[int]
        queue_s: float
        compute_s: float
        def __init__(self, queue_s: _Optional[float] = ..., compute_s: _Optional[float] = ...) -> None: ...
    class Deviation(_message.Message):
        __slots__ = ("mean_m", "max_m", "mean_travel_m", "frames")
        MEAN_M_FIELD_NUMBER: _ClassVar[int]
        MAX_M_FIELD_NUMBER: _ClassVar[int]
        MEAN_TRAVEL_M_FIELD_NUMBER: _ClassVar[int]
        FRAMES_FIELD_NUMBER: _ClassVar[int]
        mean_m: float
        max_m: float
        mean_travel_m: float
        frames: int
        def __init__(self, mean_m: _Optional[float] = ..., max_m: _Optional[float] = ..., mean_travel_m: _Optional[float] = ..., frames: _Optional[int] = ...) -> None: ...
    FIRST_INSTANCE_FIELD_NUMBER: _ClassVar[int]
    COSTS_FIELD_NUMBER: _ClassVar[int]
    COST_NAMES_FIELD_NUMBER: _ClassVar[int]
    COST_TERMS_FIELD_NUMBER: _ClassVar[int]
    INSTANCES_FIELD_NUMBER: _ClassVar[int]
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    FINAL_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    FINAL_VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    CONTROL_GRADIENTS_FIELD_NUMBER: _ClassVar[int]
    DIAGNOSTICS_FIELD_NUMBER: _ClassVar[int]
    DIVERGED_FIELD_NUMBER: _ClassVar[int]
    TIMING_FIELD_NUMBER: _ClassVar[int]
    WORKER_FIELD_NUMBER: _ClassVar[int]
    FIDELITY_FIELD_NUMBER: _ClassVar[int]
    SUBSTEPS_FIELD_NUMBER: _ClassVar[int]
    DEVIATION_FIELD_NUMBER: _ClassVar[int]
    FINAL_TWISTS_FIELD_NUMBER: _ClassVar[int]
    first_instance: int
    costs: _tensor_pb2.Tensor
    cost_names: _containers.RepeatedScalarFieldContainer[str]
    cost_terms: _tensor_pb2.Tensor
    instances: _tensor_pb2.Tensor
    frames: _tensor_pb2.Tensor
    positions: _tensor_pb2.Tensor
    final_positions: _tensor_pb2.Tensor
    final_velocities: _tensor_pb2.Tensor
    control_gradients: _tensor_pb2.Tensor
    diagnostics: _containers.RepeatedCompositeFieldContainer[RollOutResponse.Diagnostics]
    diverged: _containers.RepeatedCompositeFieldContainer[RollOutResponse.Divergence]
    timing: RollOutResponse.Timing
    worker: str
    fidelity: Fidelity
    substeps: int
    deviation: RollOutResponse.Deviation
    final_twists: _tensor_pb2.Tensor
    def __init__(self, first_instance: _Optional[int] = ..., costs: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., cost_names: _Optional[_Iterable[str]] = ..., cost_terms: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., instances: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., frames: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., final_positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., final_velocities: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., control_gradients: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., diagnostics: _Optional[_Iterable[_Union[RollOutResponse.Diagnostics, _Mapping]]] = ..., diverged: _Optional[_Iterable[_Union[RollOutResponse.Divergence, _Mapping]]] = ..., timing: _Optional[_Union[RollOutResponse.Timing, _Mapping]] = ..., worker: _Optional[str] = ..., fidelity: _Optional[_Union[Fidelity, str]] = ..., substeps: _Optional[int] = ..., deviation: _Optional[_Union[RollOutResponse.Deviation, _Mapping]] = ..., final_twists: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
