import datetime

from google.protobuf import timestamp_pb2 as _timestamp_pb2
from bendtwin.v1 import fault_pb2 as _fault_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Fit(_message.Message):
    __slots__ = ("name", "capture", "state", "settings_json", "progress", "twin", "fault", "attempt_faults", "attempts", "priority", "worker", "cancel_requested", "create_time", "start_time", "end_time", "revision")
    class State(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        STATE_UNSPECIFIED: _ClassVar[Fit.State]
        QUEUED: _ClassVar[Fit.State]
        RUNNING: _ClassVar[Fit.State]
        SUCCEEDED: _ClassVar[Fit.State]
        FAILED: _ClassVar[Fit.State]
        CANCELLED: _ClassVar[Fit.State]
    STATE_UNSPECIFIED: Fit.State
    QUEUED: Fit.State
    RUNNING: Fit.State
    SUCCEEDED: Fit.State
    FAILED: Fit.State
    CANCELLED: Fit.State
    NAME_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_JSON_FIELD_NUMBER: _ClassVar[int]
    PROGRESS_FIELD_NUMBER: _ClassVar[int]
    TWIN_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    ATTEMPT_FAULTS_FIELD_NUMBER: _ClassVar[int]
    ATTEMPTS_FIELD_NUMBER: _ClassVar[int]
    PRIORITY_FIELD_NUMBER: _ClassVar[int]
    WORKER_FIELD_NUMBER: _ClassVar[int]
    CANCEL_REQUESTED_FIELD_NUMBER: _ClassVar[int]
    CREATE_TIME_FIELD_NUMBER: _ClassVar[int]
    START_TIME_FIELD_NUMBER: _ClassVar[int]
    END_TIME_FIELD_NUMBER: _ClassVar[int]
    REVISION_FIELD_NUMBER: _ClassVar[int]
    name: str
    capture: str
    state: Fit.State
    settings_json: str
    progress: Progress
    twin: str
    fault: _fault_pb2.Fault
    attempt_faults: _containers.RepeatedCompositeFieldContainer[_fault_pb2.Fault]
    attempts: int
    priority: int
    worker: str
    cancel_requested: bool
    create_time: _timestamp_pb2.Timestamp
    start_time: _timestamp_pb2.Timestamp
    end_time: _timestamp_pb2.Timestamp
    revision: int
    def __init__(self, name: _Optional[str] = ..., capture: _Optional[str] = ..., state: _Optional[_Union[Fit.State, str]] = ..., settings_json: _Optional[str] = ..., progress: _Optional[_Union[Progress, _Mapping]] = ..., twin: _Optional[str] = ..., fault: _Optional[_Union[_fault_pb2.Fault, _Mapping]] = ..., attempt_faults: _Optional[_Iterable[_Union[_fault_pb2.Fault, _Mapping]]] = ..., attempts: _Optional[int] = ..., priority: _Optional[int] = ..., worker: _Optional[str] = ..., cancel_requested: bool = ..., create_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., start_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., end_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., revision: _Optional[int] = ...) -> None: ...

class Progress(_message.Message):
    __slots__ = ("stage", "variant", "iteration", "iterations", "fraction", "loss", "best_loss", "eta_s", "note")
    STAGE_FIELD_NUMBER: _ClassVar[int]
    VARIANT_FIELD_NUMBER: _ClassVar[int]
    ITERATION_FIELD_NUMBER: _ClassVar[int]
    ITERATIONS_FIELD_NUMBER: _ClassVar[int]
    FRACTION_FIELD_NUMBER: _ClassVar[int]
    LOSS_FIELD_NUMBER: _ClassVar[int]
    BEST_LOSS_FIELD_NUMBER: _ClassVar[int]
    ETA_S_FIELD_NUMBER: _ClassVar[int]
    NOTE_FIELD_NUMBER: _ClassVar[int]
    stage: str
    variant: str
    iteration: int
    iterations: int
    fraction: float
    loss: float
    best_loss: float
    eta_s: float
    note: str
    def __init__(self, stage: _Optional[str] = ..., variant: _Optional[str] = ..., iteration: _Optional[int] = ..., iterations: _Optional[int] = ..., fraction: _Optional[float] = ..., loss: _Optional[float] = ..., best_loss: _Optional[float] = ..., eta_s: _Optional[float] = ..., note: _Optional[str] = ...) -> None: ...

class CreateFitRequest(_message.Message):
    __slots__ = ("capture", "settings_json", "priority", "request_id")
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_JSON_FIELD_NUMBER: _ClassVar[int]
    PRIORITY_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    capture: str
    settings_json: str
    priority: int
    request_id: str
    def __init__(self, capture: _Optional[str] = ..., settings_json: _Optional[str] = ..., priority: _Optional[int] = ..., request_id: _Optional[str] = ...) -> None: ...

class GetFitRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class ListFitsRequest(_message.Message):
    __slots__ = ("page_size", "page_token", "capture")
    PAGE_SIZE_FIELD_NUMBER: _ClassVar[int]
    PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    page_size: int
    page_token: str
    capture: str
    def __init__(self, page_size: _Optional[int] = ..., page_token: _Optional[str] = ..., capture: _Optional[str] = ...) -> None: ...

class ListFitsResponse(_message.Message):
    __slots__ = ("fits", "next_page_token")
    FITS_FIELD_NUMBER: _ClassVar[int]
    NEXT_PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    fits: _containers.RepeatedCompositeFieldContainer[Fit]
    next_page_token: str
    def __init__(self, fits: _Optional[_Iterable[_Union[Fit, _Mapping]]] = ..., next_page_token: _Optional[str] = ...) -> None: ...

class CancelFitRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class DeleteFitRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class DeleteFitResponse(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class WatchFitRequest(_message.Message):
    __slots__ = ("name", "after_revision")
    NAME_FIELD_NUMBER: _ClassVar[int]
    AFTER_REVISION_FIELD_NUMBER: _ClassVar[int]
    name: str
    after_revision: int
    def __init__(self, name: _Optional[str] = ..., after_revision: _Optional[int] = ...) -> None: ...
