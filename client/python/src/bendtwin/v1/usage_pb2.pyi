from bendtwin.v1 import key_pb2 as _key_pb2
from bendtwin.v1 import options_pb2 as _options_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class OwnerUsage(_message.Message):
    __slots__ = ("owner", "captures", "fits", "twins", "stored_bytes", "queued_jobs", "running_jobs", "quotas")
    OWNER_FIELD_NUMBER: _ClassVar[int]
    CAPTURES_FIELD_NUMBER: _ClassVar[int]
    FITS_FIELD_NUMBER: _ClassVar[int]
    TWINS_FIELD_NUMBER: _ClassVar[int]
    STORED_BYTES_FIELD_NUMBER: _ClassVar[int]
    QUEUED_JOBS_FIELD_NUMBER: _ClassVar[int]
    RUNNING_JOBS_FIELD_NUMBER: _ClassVar[int]
    QUOTAS_FIELD_NUMBER: _ClassVar[int]
    owner: str
    captures: int
    fits: int
    twins: int
    stored_bytes: StoredBytes
    queued_jobs: int
    running_jobs: int
    quotas: _key_pb2.KeyQuotas
    def __init__(self, owner: _Optional[str] = ..., captures: _Optional[int] = ..., fits: _Optional[int] = ..., twins: _Optional[int] = ..., stored_bytes: _Optional[_Union[StoredBytes, _Mapping]] = ..., queued_jobs: _Optional[int] = ..., running_jobs: _Optional[int] = ..., quotas: _Optional[_Union[_key_pb2.KeyQuotas, _Mapping]] = ...) -> None: ...

class StoredBytes(_message.Message):
    __slots__ = ("total", "captures", "derived", "twins", "checkpoints", "uploads")
    TOTAL_FIELD_NUMBER: _ClassVar[int]
    CAPTURES_FIELD_NUMBER: _ClassVar[int]
    DERIVED_FIELD_NUMBER: _ClassVar[int]
    TWINS_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINTS_FIELD_NUMBER: _ClassVar[int]
    UPLOADS_FIELD_NUMBER: _ClassVar[int]
    total: int
    captures: int
    derived: int
    twins: int
    checkpoints: int
    uploads: int
    def __init__(self, total: _Optional[int] = ..., captures: _Optional[int] = ..., derived: _Optional[int] = ..., twins: _Optional[int] = ..., checkpoints: _Optional[int] = ..., uploads: _Optional[int] = ...) -> None: ...

class GetUsageRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ListOwnerUsageRequest(_message.Message):
    __slots__ = ("page_size", "page_token")
    PAGE_SIZE_FIELD_NUMBER: _ClassVar[int]
    PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    page_size: int
    page_token: str
    def __init__(self, page_size: _Optional[int] = ..., page_token: _Optional[str] = ...) -> None: ...

class ListOwnerUsageResponse(_message.Message):
    __slots__ = ("owners", "next_page_token")
    OWNERS_FIELD_NUMBER: _ClassVar[int]
    NEXT_PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    owners: _containers.RepeatedCompositeFieldContainer[OwnerUsage]
    next_page_token: str
    def __init__(self, owners: _Optional[_Iterable[_Union[OwnerUsage, _Mapping]]] = ..., next_page_token: _Optional[str] = ...) -> None: ...
