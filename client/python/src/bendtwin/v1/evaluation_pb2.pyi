from bendtwin.v1 import options_pb2 as _options_pb2
from bendtwin.v1 import tensor_pb2 as _tensor_pb2
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class EvaluateTwinRequest(_message.Message):
    __slots__ = ("twin", "capture", "motion")
    TWIN_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    twin: str
    capture: str
    motion: MotionRequest
    def __init__(self, twin: _Optional[str] = ..., capture: _Optional[str] = ..., motion: _Optional[_Union[MotionRequest, _Mapping]] = ...) -> None: ...

class MotionRequest(_message.Message):
    __slots__ = ("sequence",)
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    sequence: int
    def __init__(self, sequence: _Optional[int] = ...) -> None: ...

class PredictedMotion(_message.Message):
    __slots__ = ("sequence", "recording", "name", "fps", "frame_count", "start_frame", "train_frame_count", "every_frames", "positions", "track_m", "chamfer_l1_m")
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    RECORDING_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    FPS_FIELD_NUMBER: _ClassVar[int]
    FRAME_COUNT_FIELD_NUMBER: _ClassVar[int]
    START_FRAME_FIELD_NUMBER: _ClassVar[int]
    TRAIN_FRAME_COUNT_FIELD_NUMBER: _ClassVar[int]
    EVERY_FRAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    TRACK_M_FIELD_NUMBER: _ClassVar[int]
    CHAMFER_L1_M_FIELD_NUMBER: _ClassVar[int]
    sequence: int
    recording: str
    name: str
    fps: float
    frame_count: int
    start_frame: int
    train_frame_count: int
    every_frames: int
    positions: _tensor_pb2.Tensor
    track_m: _tensor_pb2.Tensor
    chamfer_l1_m: _tensor_pb2.Tensor
    def __init__(self, sequence: _Optional[int] = ..., recording: _Optional[str] = ..., name: _Optional[str] = ..., fps: _Optional[float] = ..., frame_count: _Optional[int] = ..., start_frame: _Optional[int] = ..., train_frame_count: _Optional[int] = ..., every_frames: _Optional[int] = ..., positions: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., track_m: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ..., chamfer_l1_m: _Optional[_Union[_tensor_pb2.Tensor, _Mapping]] = ...) -> None: ...

class Evaluation(_message.Message):
    __slots__ = ("twin", "capture", "quality_json", "worker", "motion")
    TWIN_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    QUALITY_JSON_FIELD_NUMBER: _ClassVar[int]
    WORKER_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    twin: str
    capture: str
    quality_json: str
    worker: str
    motion: PredictedMotion
    def __init__(self, twin: _Optional[str] = ..., capture: _Optional[str] = ..., quality_json: _Optional[str] = ..., worker: _Optional[str] = ..., motion: _Optional[_Union[PredictedMotion, _Mapping]] = ...) -> None: ...
