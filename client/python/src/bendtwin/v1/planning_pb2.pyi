from bendtwin.v1 import options_pb2 as _options_pb2
from bendtwin.v1 import rollout_pb2 as _rollout_pb2
from bendtwin.v1 import tensor_pb2 as _tensor_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class PlanRequest(_message.Message):
    __slots__ = ("rollout", "space", "method", "samples", "iterations", "sigma", "correlation", "finest", "bounds", "seed", "deadline_s", "shift_frames")
    ROLLOUT_FIELD_NUMBER: _ClassVar[int]
    SPACE_FIELD_NUMBER: _ClassVar[int]
    METHOD_FIELD_NUMBER: _ClassVar[int]
    SAMPLES_FIELD_NUMBER: _ClassVar[int]
    ITERATIONS_FIELD_NUMBER: _ClassVar[int]
    SIGMA_FIELD_NUMBER: _ClassVar[int]
    CORRELATION_FIELD_NUMBER: _ClassVar[int]
    FINEST_FIELD_NUMBER: _ClassVar[int]
    BOUNDS_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    DEADLINE_S_FIELD_NUMBER: _ClassVar[int]
    SHIFT_FRAMES_FIELD_NUMBER: _ClassVar[int]
    rollout: _rollout_pb2.RollOutRequest
    space: ActionSpace
    method: PlanMethod
    samples: int
    iterations: int
    sigma: _tensor_pb2.Tensor
    correlation: float
    finest: float
    bounds: PlanBounds
    seed: int
    deadline_s: float
    shift_frames: float
    def __init__(self, rollout: _Optional[_Union[_rollout_pb2.RollOutRequest, _Mapping]] = ..., space: _Optional[_Union[ActionSpace, _Mapping]] = ..., method: _Optional[_Union[PlanMethod, _Mapping]] = ..., samples: _Optional[int] = ..., iterations: _Optional[int] = ..., sigma: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., correlation: _Optional[float] = ..., finest: _Optional[float] = ..., bounds: _Optional[_Union[PlanBounds, _Mapping]] = ..., seed: _Optional[int] = ..., deadline_s: _Optional[float] = ..., shift_frames: _Optional[float] = ...) -> None: ...

class ActionSpace(_message.Message):
    __slots__ = ("coordinates", "group_of_control", "start")
    class Coordinates(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        COORDINATES_UNSPECIFIED: _ClassVar[ActionSpace.Coordinates]
        TOGETHER: _ClassVar[ActionSpace.Coordinates]
        PER_GROUP: _ClassVar[ActionSpace.Coordinates]
        POINTS: _ClassVar[ActionSpace.Coordinates]
        TRANSLATION: _ClassVar[ActionSpace.Coordinates]
        RIGID: _ClassVar[ActionSpace.Coordinates]
    COORDINATES_UNSPECIFIED: ActionSpace.Coordinates
    TOGETHER: ActionSpace.Coordinates
    PER_GROUP: ActionSpace.Coordinates
    POINTS: ActionSpace.Coordinates
    TRANSLATION: ActionSpace.Coordinates
    RIGID: ActionSpace.Coordinates
    COORDINATES_FIELD_NUMBER: _ClassVar[int]
    GROUP_OF_CONTROL_FIELD_NUMBER: _ClassVar[int]
    START_FIELD_NUMBER: _ClassVar[int]
    coordinates: ActionSpace.Coordinates
    group_of_control: _tensor_pb2.Tensor
    start: _tensor_pb2.Tensor
    def __init__(self, coordinates: _Optional[_Union[ActionSpace.Coordinates, str]] = ..., group_of_control: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., start: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...

class PlanMethod(_message.Message):
    __slots__ = ("mppi", "cem", "predictive_sampling", "gradient")
    class Mppi(_message.Message):
        __slots__ = ("temperature",)
        TEMPERATURE_FIELD_NUMBER: _ClassVar[int]
        temperature: float
        def __init__(self, temperature: _Optional[float] = ...) -> None: ...
    class Cem(_message.Message):
        __slots__ = ("elites", "memory", "smallest")
        ELITES_FIELD_NUMBER: _ClassVar[int]
        MEMORY_FIELD_NUMBER: _ClassVar[int]
        SMALLEST_FIELD_NUMBER: _ClassVar[int]
        elites: int
        memory: float
        smallest: float
        def __init__(self, elites: _Optional[int] = ..., memory: _Optional[float] = ..., smallest: _Optional[float] = ...) -> None: ...
    class PredictiveSampling(_message.Message):
        __slots__ = ()
        def __init__(self) -> None: ...
    class Gradient(_message.Message):
        __slots__ = ("rate",)
        RATE_FIELD_NUMBER: _ClassVar[int]
        rate: _tensor_pb2.Tensor
        def __init__(self, rate: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...
    MPPI_FIELD_NUMBER: _ClassVar[int]
    CEM_FIELD_NUMBER: _ClassVar[int]
    PREDICTIVE_SAMPLING_FIELD_NUMBER: _ClassVar[int]
    GRADIENT_FIELD_NUMBER: _ClassVar[int]
    mppi: PlanMethod.Mppi
    cem: PlanMethod.Cem
    predictive_sampling: PlanMethod.PredictiveSampling
    gradient: PlanMethod.Gradient
    def __init__(self, mppi: _Optional[_Union[PlanMethod.Mppi, _Mapping]] = ..., cem: _Optional[_Union[PlanMethod.Cem, _Mapping]] = ..., predictive_sampling: _Optional[_Union[PlanMethod.PredictiveSampling, _Mapping]] = ..., gradient: _Optional[_Union[PlanMethod.Gradient, _Mapping]] = ...) -> None: ...

class PlanBounds(_message.Message):
    __slots__ = ("low", "high", "speed")
    LOW_FIELD_NUMBER: _ClassVar[int]
    HIGH_FIELD_NUMBER: _ClassVar[int]
    SPEED_FIELD_NUMBER: _ClassVar[int]
    low: _tensor_pb2.Tensor
    high: _tensor_pb2.Tensor
    speed: _tensor_pb2.Tensor
    def __init__(self, low: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., high: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., speed: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...

class PlanUpdate(_message.Message):
    __slots__ = ("knots", "coordinates", "cost", "cost_names", "cost_terms", "origin", "nominal_cost", "iterations", "simulated", "diverged", "stopped_by_deadline", "time_s", "last", "rollout", "strain", "strain_limit", "overstrained")
    class Origin(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        ORIGIN_UNSPECIFIED: _ClassVar[PlanUpdate.Origin]
        NOMINAL: _ClassVar[PlanUpdate.Origin]
        MEAN: _ClassVar[PlanUpdate.Origin]
        SAMPLE: _ClassVar[PlanUpdate.Origin]
    ORIGIN_UNSPECIFIED: PlanUpdate.Origin
    NOMINAL: PlanUpdate.Origin
    MEAN: PlanUpdate.Origin
    SAMPLE: PlanUpdate.Origin
    KNOTS_FIELD_NUMBER: _ClassVar[int]
    COORDINATES_FIELD_NUMBER: _ClassVar[int]
    COST_FIELD_NUMBER: _ClassVar[int]
    COST_NAMES_FIELD_NUMBER: _ClassVar[int]
    COST_TERMS_FIELD_NUMBER: _ClassVar[int]
    ORIGIN_FIELD_NUMBER: _ClassVar[int]
    NOMINAL_COST_FIELD_NUMBER: _ClassVar[int]
    ITERATIONS_FIELD_NUMBER: _ClassVar[int]
    SIMULATED_FIELD_NUMBER: _ClassVar[int]
    DIVERGED_FIELD_NUMBER: _ClassVar[int]
    STOPPED_BY_DEADLINE_FIELD_NUMBER: _ClassVar[int]
    TIME_S_FIELD_NUMBER: _ClassVar[int]
    LAST_FIELD_NUMBER: _ClassVar[int]
    ROLLOUT_FIELD_NUMBER: _ClassVar[int]
    STRAIN_FIELD_NUMBER: _ClassVar[int]
    STRAIN_LIMIT_FIELD_NUMBER: _ClassVar[int]
    OVERSTRAINED_FIELD_NUMBER: _ClassVar[int]
    knots: _tensor_pb2.Tensor
    coordinates: _tensor_pb2.Tensor
    cost: float
    cost_names: _containers.RepeatedScalarFieldContainer[str]
    cost_terms: _tensor_pb2.Tensor
    origin: PlanUpdate.Origin
    nominal_cost: float
    iterations: int
    simulated: int
    diverged: int
    stopped_by_deadline: bool
    time_s: float
    last: bool
    rollout: _rollout_pb2.RollOutResponse
    strain: float
    strain_limit: float
    overstrained: int
    def __init__(self, knots: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., coordinates: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., cost: _Optional[float] = ..., cost_names: _Optional[_Iterable[str]] = ..., cost_terms: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., origin: _Optional[_Union[PlanUpdate.Origin, str]] = ..., nominal_cost: _Optional[float] = ..., iterations: _Optional[int] = ..., simulated: _Optional[int] = ..., diverged: _Optional[int] = ..., stopped_by_deadline: bool = ..., time_s: _Optional[float] = ..., last: bool = ..., rollout: _Optional[_Union[_rollout_pb2.RollOutResponse, _Mapping]] = ..., strain: _Optional[float] = ..., strain_limit: _Optional[float] = ..., overstrained: _Optional[int] = ...) -> None: ...
