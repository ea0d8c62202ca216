from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Optional as _Optional

DESCRIPTOR: _descriptor.FileDescriptor

class EvaluateTwinRequest(_message.Message):
    __slots__ = ("twin", "capture")
    TWIN_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    twin: str
    capture: str
    def __init__(self, twin: _Optional[str] = ..., capture: _Optional[str] = ...) -> None: ...

class Evaluation(_message.Message):
    __slots__ = ("twin", "capture", "quality_json", "worker")
    TWIN_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    QUALITY_JSON_FIELD_NUMBER: _ClassVar[int]
    WORKER_FIELD_NUMBER: _ClassVar[int]
    twin: str
    capture: str
    quality_json: str
    worker: str
    def __init__(self, twin: _Optional[str] = ..., capture: _Optional[str] = ..., quality_json: _Optional[str] = ..., worker: _Optional[str] = ...) -> None: ...
