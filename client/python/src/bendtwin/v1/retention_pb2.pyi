import datetime

from bendtwin.v1 import options_pb2 as _options_pb2
from google.protobuf import timestamp_pb2 as _timestamp_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class RetentionRule(_message.Message):
    __slots__ = ("name", "display_name", "collection", "min_age_days", "owner", "tag", "verdict", "create_time")
    NAME_FIELD_NUMBER: _ClassVar[int]
    DISPLAY_NAME_FIELD_NUMBER: _ClassVar[int]
    COLLECTION_FIELD_NUMBER: _ClassVar[int]
    MIN_AGE_DAYS_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    TAG_FIELD_NUMBER: _ClassVar[int]
    VERDICT_FIELD_NUMBER: _ClassVar[int]
    CREATE_TIME_FIELD_NUMBER: _ClassVar[int]
    name: str
    display_name: str
    collection: str
    min_age_days: float
    owner: str
    tag: str
    verdict: str
    create_time: _timestamp_pb2.Timestamp
    def __init__(self, name: _Optional[str] = ..., display_name: _Optional[str] = ..., collection: _Optional[str] = ..., min_age_days: _Optional[float] = ..., owner: _Optional[str] = ..., tag: _Optional[str] = ..., verdict: _Optional[str] = ..., create_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ...) -> None: ...

class CreateRetentionRuleRequest(_message.Message):
    __slots__ = ("display_name", "collection", "min_age_days", "owner", "tag", "verdict")
    DISPLAY_NAME_FIELD_NUMBER: _ClassVar[int]
    COLLECTION_FIELD_NUMBER: _ClassVar[int]
    MIN_AGE_DAYS_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    TAG_FIELD_NUMBER: _ClassVar[int]
    VERDICT_FIELD_NUMBER: _ClassVar[int]
    display_name: str
    collection: str
    min_age_days: float
    owner: str
    tag: str
    verdict: str
    def __init__(self, display_name: _Optional[str] = ..., collection: _Optional[str] = ..., min_age_days: _Optional[float] = ..., owner: _Optional[str] = ..., tag: _Optional[str] = ..., verdict: _Optional[str] = ...) -> None: ...

class GetRetentionRuleRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class ListRetentionRulesRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ListRetentionRulesResponse(_message.Message):
    __slots__ = ("rules",)
    RULES_FIELD_NUMBER: _ClassVar[int]
    rules: _containers.RepeatedCompositeFieldContainer[RetentionRule]
    def __init__(self, rules: _Optional[_Iterable[_Union[RetentionRule, _Mapping]]] = ...) -> None: ...

class DeleteRetentionRuleRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class DeleteRetentionRuleResponse(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class PreviewRetentionRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class PreviewRetentionResponse(_message.Message):
    __slots__ = ("outcomes", "truncated")
    OUTCOMES_FIELD_NUMBER: _ClassVar[int]
    TRUNCATED_FIELD_NUMBER: _ClassVar[int]
    outcomes: _containers.RepeatedCompositeFieldContainer[RetentionOutcome]
    truncated: bool
    def __init__(self, outcomes: _Optional[_Iterable[_Union[RetentionOutcome, _Mapping]]] = ..., truncated: bool = ...) -> None: ...

class RetentionOutcome(_message.Message):
    __slots__ = ("name", "display_name", "owner", "create_time", "size_bytes", "rule", "kept_because")
    NAME_FIELD_NUMBER: _ClassVar[int]
    DISPLAY_NAME_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    CREATE_TIME_FIELD_NUMBER: _ClassVar[int]
    SIZE_BYTES_FIELD_NUMBER: _ClassVar[int]
    RULE_FIELD_NUMBER: _ClassVar[int]
    KEPT_BECAUSE_FIELD_NUMBER: _ClassVar[int]
    name: str
    display_name: str
    owner: str
    create_time: _timestamp_pb2.Timestamp
    size_bytes: int
    rule: str
    kept_because: str
    def __init__(self, name: _Optional[str] = ..., display_name: _Optional[str] = ..., owner: _Optional[str] = ..., create_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., size_bytes: _Optional[int] = ..., rule: _Optional[str] = ..., kept_because: _Optional[str] = ...) -> None: ...
