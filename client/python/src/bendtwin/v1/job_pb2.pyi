import datetime

from bendtwin.v1 import options_pb2 as _options_pb2
from google.protobuf import timestamp_pb2 as _timestamp_pb2
from bendtwin.v1 import fault_pb2 as _fault_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Job(_message.Message):
    __slots__ = ("state", "settings_json", "progress", "fault", "attempt_faults", "attempts", "worker", "cancel_requested", "create_time", "start_time", "end_time", "revision", "run_s")
    class State(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        STATE_UNSPECIFIED: _ClassVar[Job.State]
        QUEUED: _ClassVar[Job.State]
        RUNNING: _ClassVar[Job.State]
        SUCCEEDED: _ClassVar[Job.State]
        FAILED: _ClassVar[Job.State]
        CANCELLED: _ClassVar[Job.State]
    STATE_UNSPECIFIED: Job.State
    QUEUED: Job.State
    RUNNING: Job.State
    SUCCEEDED: Job.State
    FAILED: Job.State
    CANCELLED: Job.State
    STATE_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_JSON_FIELD_NUMBER: _ClassVar[int]
    PROGRESS_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    ATTEMPT_FAULTS_FIELD_NUMBER: _ClassVar[int]
    ATTEMPTS_FIELD_NUMBER: _ClassVar[int]
    WORKER_FIELD_NUMBER: _ClassVar[int]
    CANCEL_REQUESTED_FIELD_NUMBER: _ClassVar[int]
    CREATE_TIME_FIELD_NUMBER: _ClassVar[int]
    START_TIME_FIELD_NUMBER: _ClassVar[int]
    END_TIME_FIELD_NUMBER: _ClassVar[int]
    REVISION_FIELD_NUMBER: _ClassVar[int]
    RUN_S_FIELD_NUMBER: _ClassVar[int]
    state: Job.State
    settings_json: str
    progress: Progress
    fault: _fault_pb2.Fault
    attempt_faults: _containers.RepeatedCompositeFieldContainer[_fault_pb2.Fault]
    attempts: int
    worker: str
    cancel_requested: bool
    create_time: _timestamp_pb2.Timestamp
    start_time: _timestamp_pb2.Timestamp
    end_time: _timestamp_pb2.Timestamp
    revision: int
    run_s: float
    def __init__(self, state: _Optional[_Union[Job.State, str]] = ..., settings_json: _Optional[str] = ..., progress: _Optional[_Union[Progress, _Mapping]] = ..., fault: _Optional[_Union[_fault_pb2.Fault, _Mapping]] = ..., attempt_faults: _Optional[_Iterable[_Union[_fault_pb2.Fault, _Mapping]]] = ..., attempts: _Optional[int] = ..., worker: _Optional[str] = ..., cancel_requested: bool = ..., create_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., start_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., end_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., revision: _Optional[int] = ..., run_s: _Optional[float] = ...) -> None: ...

class Progress(_message.Message):
    __slots__ = ("stage", "variant", "iteration", "iterations", "fraction", "loss", "best_loss", "eta_s", "note", "models", "error_m")
    STAGE_FIELD_NUMBER: _ClassVar[int]
    VARIANT_FIELD_NUMBER: _ClassVar[int]
    ITERATION_FIELD_NUMBER: _ClassVar[int]
    ITERATIONS_FIELD_NUMBER: _ClassVar[int]
    FRACTION_FIELD_NUMBER: _ClassVar[int]
    LOSS_FIELD_NUMBER: _ClassVar[int]
    BEST_LOSS_FIELD_NUMBER: _ClassVar[int]
    ETA_S_FIELD_NUMBER: _ClassVar[int]
    NOTE_FIELD_NUMBER: _ClassVar[int]
    MODELS_FIELD_NUMBER: _ClassVar[int]
    ERROR_M_FIELD_NUMBER: _ClassVar[int]
    stage: str
    variant: str
    iteration: int
    iterations: int
    fraction: float
    loss: float
    best_loss: float
    eta_s: float
    note: str
    models: _containers.RepeatedCompositeFieldContainer[ModelLoss]
    error_m: float
    def __init__(self, stage: _Optional[str] = ..., variant: _Optional[str] = ..., iteration: _Optional[int] = ..., iterations: _Optional[int] = ..., fraction: _Optional[float] = ..., loss: _Optional[float] = ..., best_loss: _Optional[float] = ..., eta_s: _Optional[float] = ..., note: _Optional[str] = ..., models: _Optional[_Iterable[_Union[ModelLoss, _Mapping]]] = ..., error_m: _Optional[float] = ...) -> None: ...

class ModelLoss(_message.Message):
    __slots__ = ("stage", "variant", "iteration", "loss", "best_loss", "error_m")
    STAGE_FIELD_NUMBER: _ClassVar[int]
    VARIANT_FIELD_NUMBER: _ClassVar[int]
    ITERATION_FIELD_NUMBER: _ClassVar[int]
    LOSS_FIELD_NUMBER: _ClassVar[int]
    BEST_LOSS_FIELD_NUMBER: _ClassVar[int]
    ERROR_M_FIELD_NUMBER: _ClassVar[int]
    stage: str
    variant: str
    iteration: int
    loss: float
    best_loss: float
    error_m: float
    def __init__(self, stage: _Optional[str] = ..., variant: _Optional[str] = ..., iteration: _Optional[int] = ..., loss: _Optional[float] = ..., best_loss: _Optional[float] = ..., error_m: _Optional[float] = ...) -> None: ...

class WorkerRequirements(_message.Message):
    __slots__ = ("backend", "memory_bytes", "labels")
    BACKEND_FIELD_NUMBER: _ClassVar[int]
    MEMORY_BYTES_FIELD_NUMBER: _ClassVar[int]
    LABELS_FIELD_NUMBER: _ClassVar[int]
    backend: str
    memory_bytes: int
    labels: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, backend: _Optional[str] = ..., memory_bytes: _Optional[int] = ..., labels: _Optional[_Iterable[str]] = ...) -> None: ...
