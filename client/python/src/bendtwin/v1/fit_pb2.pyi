import datetime

from bendtwin.v1 import options_pb2 as _options_pb2
from bendtwin.v1 import job_pb2 as _job_pb2
from bendtwin.v1 import tensor_pb2 as _tensor_pb2
from google.protobuf import field_mask_pb2 as _field_mask_pb2
from google.protobuf import timestamp_pb2 as _timestamp_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Fit(_message.Message):
    __slots__ = ("name", "capture", "twin", "priority", "job", "display_name", "note", "tags", "error_m", "owner", "requirements", "measure")
    NAME_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    TWIN_FIELD_NUMBER: _ClassVar[int]
    PRIORITY_FIELD_NUMBER: _ClassVar[int]
    JOB_FIELD_NUMBER: _ClassVar[int]
    DISPLAY_NAME_FIELD_NUMBER: _ClassVar[int]
    NOTE_FIELD_NUMBER: _ClassVar[int]
    TAGS_FIELD_NUMBER: _ClassVar[int]
    ERROR_M_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    REQUIREMENTS_FIELD_NUMBER: _ClassVar[int]
    MEASURE_FIELD_NUMBER: _ClassVar[int]
    name: str
    capture: str
    twin: str
    priority: int
    job: _job_pb2.Job
    display_name: str
    note: str
    tags: _containers.RepeatedScalarFieldContainer[str]
    error_m: float
    owner: str
    requirements: _job_pb2.WorkerRequirements
    measure: str
    def __init__(self, name: _Optional[str] = ..., capture: _Optional[str] = ..., twin: _Optional[str] = ..., priority: _Optional[int] = ..., job: _Optional[_Union[_job_pb2.Job, _Mapping]] = ..., display_name: _Optional[str] = ..., note: _Optional[str] = ..., tags: _Optional[_Iterable[str]] = ..., error_m: _Optional[float] = ..., owner: _Optional[str] = ..., requirements: _Optional[_Union[_job_pb2.WorkerRequirements, _Mapping]] = ..., measure: _Optional[str] = ...) -> None: ...

class CreateFitRequest(_message.Message):
    __slots__ = ("capture", "settings_json", "priority", "request_id", "display_name", "requirements")
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_JSON_FIELD_NUMBER: _ClassVar[int]
    PRIORITY_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    DISPLAY_NAME_FIELD_NUMBER: _ClassVar[int]
    REQUIREMENTS_FIELD_NUMBER: _ClassVar[int]
    capture: str
    settings_json: str
    priority: int
    request_id: str
    display_name: str
    requirements: _job_pb2.WorkerRequirements
    def __init__(self, capture: _Optional[str] = ..., settings_json: _Optional[str] = ..., priority: _Optional[int] = ..., request_id: _Optional[str] = ..., display_name: _Optional[str] = ..., requirements: _Optional[_Union[_job_pb2.WorkerRequirements, _Mapping]] = ...) -> None: ...

class GetFitRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class ListFitsRequest(_message.Message):
    __slots__ = ("page_size", "page_token", "capture", "state", "search", "tag", "order_by", "owner")
    PAGE_SIZE_FIELD_NUMBER: _ClassVar[int]
    PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    SEARCH_FIELD_NUMBER: _ClassVar[int]
    TAG_FIELD_NUMBER: _ClassVar[int]
    ORDER_BY_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    page_size: int
    page_token: str
    capture: str
    state: _job_pb2.Job.State
    search: str
    tag: str
    order_by: str
    owner: str
    def __init__(self, page_size: _Optional[int] = ..., page_token: _Optional[str] = ..., capture: _Optional[str] = ..., state: _Optional[_Union[_job_pb2.Job.State, str]] = ..., search: _Optional[str] = ..., tag: _Optional[str] = ..., order_by: _Optional[str] = ..., owner: _Optional[str] = ...) -> None: ...

class ListFitsResponse(_message.Message):
    __slots__ = ("fits", "next_page_token", "total_size")
    FITS_FIELD_NUMBER: _ClassVar[int]
    NEXT_PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    TOTAL_SIZE_FIELD_NUMBER: _ClassVar[int]
    fits: _containers.RepeatedCompositeFieldContainer[Fit]
    next_page_token: str
    total_size: int
    def __init__(self, fits: _Optional[_Iterable[_Union[Fit, _Mapping]]] = ..., next_page_token: _Optional[str] = ..., total_size: _Optional[int] = ...) -> None: ...

class UpdateFitRequest(_message.Message):
    __slots__ = ("fit", "update_mask", "add_tags", "remove_tags")
    FIT_FIELD_NUMBER: _ClassVar[int]
    UPDATE_MASK_FIELD_NUMBER: _ClassVar[int]
    ADD_TAGS_FIELD_NUMBER: _ClassVar[int]
    REMOVE_TAGS_FIELD_NUMBER: _ClassVar[int]
    fit: Fit
    update_mask: _field_mask_pb2.FieldMask
    add_tags: _containers.RepeatedScalarFieldContainer[str]
    remove_tags: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, fit: _Optional[_Union[Fit, _Mapping]] = ..., update_mask: _Optional[_Union[_field_mask_pb2.FieldMask, _Mapping]] = ..., add_tags: _Optional[_Iterable[str]] = ..., remove_tags: _Optional[_Iterable[str]] = ...) -> None: ...

class GetFitLossesRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class FitLosses(_message.Message):
    __slots__ = ("curves",)
    class LossCurve(_message.Message):
        __slots__ = ("stage", "variant", "iterations", "losses", "best_losses", "errors_m")
        STAGE_FIELD_NUMBER: _ClassVar[int]
        VARIANT_FIELD_NUMBER: _ClassVar[int]
        ITERATIONS_FIELD_NUMBER: _ClassVar[int]
        LOSSES_FIELD_NUMBER: _ClassVar[int]
        BEST_LOSSES_FIELD_NUMBER: _ClassVar[int]
        ERRORS_M_FIELD_NUMBER: _ClassVar[int]
        stage: str
        variant: str
        iterations: _containers.RepeatedScalarFieldContainer[int]
        losses: _containers.RepeatedScalarFieldContainer[float]
        best_losses: _containers.RepeatedScalarFieldContainer[float]
        errors_m: _containers.RepeatedScalarFieldContainer[float]
        def __init__(self, stage: _Optional[str] = ..., variant: _Optional[str] = ..., iterations: _Optional[_Iterable[int]] = ..., losses: _Optional[_Iterable[float]] = ..., best_losses: _Optional[_Iterable[float]] = ..., errors_m: _Optional[_Iterable[float]] = ...) -> None: ...
    CURVES_FIELD_NUMBER: _ClassVar[int]
    curves: _containers.RepeatedCompositeFieldContainer[FitLosses.LossCurve]
    def __init__(self, curves: _Optional[_Iterable[_Union[FitLosses.LossCurve, _Mapping]]] = ...) -> None: ...

class GetFitPreviewRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class FitPreview(_message.Message):
    __slots__ = ("stage", "variant", "iteration", "create_time", "sequence", "frames", "positions", "measure", "error_m", "held_back_m", "baseline_m")
    STAGE_FIELD_NUMBER: _ClassVar[int]
    VARIANT_FIELD_NUMBER: _ClassVar[int]
    ITERATION_FIELD_NUMBER: _ClassVar[int]
    CREATE_TIME_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    MEASURE_FIELD_NUMBER: _ClassVar[int]
    ERROR_M_FIELD_NUMBER: _ClassVar[int]
    HELD_BACK_M_FIELD_NUMBER: _ClassVar[int]
    BASELINE_M_FIELD_NUMBER: _ClassVar[int]
    stage: str
    variant: str
    iteration: int
    create_time: _timestamp_pb2.Timestamp
    sequence: int
    frames: _tensor_pb2.Tensor
    positions: _tensor_pb2.Tensor
    measure: str
    error_m: float
    held_back_m: float
    baseline_m: float
    def __init__(self, stage: _Optional[str] = ..., variant: _Optional[str] = ..., iteration: _Optional[int] = ..., create_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., sequence: _Optional[int] = ..., frames: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., measure: _Optional[str] = ..., error_m: _Optional[float] = ..., held_back_m: _Optional[float] = ..., baseline_m: _Optional[float] = ...) -> None: ...

class CancelFitRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class DeleteFitRequest(_message.Message):
    __slots__ = ("name", "purge")
    NAME_FIELD_NUMBER: _ClassVar[int]
    PURGE_FIELD_NUMBER: _ClassVar[int]
    name: str
    purge: bool
    def __init__(self, name: _Optional[str] = ..., purge: bool = ...) -> None: ...

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
