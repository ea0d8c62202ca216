from google.protobuf import descriptor_pb2 as _descriptor_pb2
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Scope(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    SCOPE_UNSPECIFIED: _ClassVar[Scope]
    OPEN: _ClassVar[Scope]
    ANYONE: _ClassVar[Scope]
    WORKER: _ClassVar[Scope]
    ADMIN: _ClassVar[Scope]
    CAPTURES_READ: _ClassVar[Scope]
    CAPTURES_WRITE: _ClassVar[Scope]
    FITS_READ: _ClassVar[Scope]
    FITS_WRITE: _ClassVar[Scope]
    ROLLOUTS_RUN: _ClassVar[Scope]
    TWINS_READ: _ClassVar[Scope]
    TWINS_WRITE: _ClassVar[Scope]
    METRICS_READ: _ClassVar[Scope]
SCOPE_UNSPECIFIED: Scope
OPEN: Scope
ANYONE: Scope
WORKER: Scope
ADMIN: Scope
CAPTURES_READ: Scope
CAPTURES_WRITE: Scope
FITS_READ: Scope
FITS_WRITE: Scope
ROLLOUTS_RUN: Scope
TWINS_READ: Scope
TWINS_WRITE: Scope
METRICS_READ: Scope
SCOPE_OF_ALL_FIELD_NUMBER: _ClassVar[int]
scope_of_all: _descriptor.FieldDescriptor
SCOPE_FIELD_NUMBER: _ClassVar[int]
scope: _descriptor.FieldDescriptor
AUDITED_FIELD_NUMBER: _ClassVar[int]
audited: _descriptor.FieldDescriptor
ROUTE_FIELD_NUMBER: _ClassVar[int]
route: _descriptor.FieldDescriptor
JSON_FIELD_NUMBER: _ClassVar[int]
json: _descriptor.FieldDescriptor

class Route(_message.Message):
    __slots__ = ("get", "post", "patch", "delete", "put", "id", "status", "location", "secret", "tensors", "by_hand")
    GET_FIELD_NUMBER: _ClassVar[int]
    POST_FIELD_NUMBER: _ClassVar[int]
    PATCH_FIELD_NUMBER: _ClassVar[int]
    DELETE_FIELD_NUMBER: _ClassVar[int]
    PUT_FIELD_NUMBER: _ClassVar[int]
    ID_FIELD_NUMBER: _ClassVar[int]
    STATUS_FIELD_NUMBER: _ClassVar[int]
    LOCATION_FIELD_NUMBER: _ClassVar[int]
    SECRET_FIELD_NUMBER: _ClassVar[int]
    TENSORS_FIELD_NUMBER: _ClassVar[int]
    BY_HAND_FIELD_NUMBER: _ClassVar[int]
    get: str
    post: str
    patch: str
    delete: str
    put: str
    id: str
    status: int
    location: str
    secret: bool
    tensors: bool
    by_hand: bool
    def __init__(self, get: _Optional[str] = ..., post: _Optional[str] = ..., patch: _Optional[str] = ..., delete: _Optional[str] = ..., put: _Optional[str] = ..., id: _Optional[str] = ..., status: _Optional[int] = ..., location: _Optional[str] = ..., secret: bool = ..., tensors: bool = ..., by_hand: bool = ...) -> None: ...

class JsonField(_message.Message):
    __slots__ = ("form", "changeable", "required", "pattern", "max_length")
    class Form(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        FORM_UNSPECIFIED: _ClassVar[JsonField.Form]
        NESTED: _ClassVar[JsonField.Form]
        NULL: _ClassVar[JsonField.Form]
        ALWAYS: _ClassVar[JsonField.Form]
    FORM_UNSPECIFIED: JsonField.Form
    NESTED: JsonField.Form
    NULL: JsonField.Form
    ALWAYS: JsonField.Form
    FORM_FIELD_NUMBER: _ClassVar[int]
    CHANGEABLE_FIELD_NUMBER: _ClassVar[int]
    REQUIRED_FIELD_NUMBER: _ClassVar[int]
    PATTERN_FIELD_NUMBER: _ClassVar[int]
    MAX_LENGTH_FIELD_NUMBER: _ClassVar[int]
    form: JsonField.Form
    changeable: bool
    required: bool
    pattern: str
    max_length: int
    def __init__(self, form: _Optional[_Union[JsonField.Form, str]] = ..., changeable: bool = ..., required: bool = ..., pattern: _Optional[str] = ..., max_length: _Optional[int] = ...) -> None: ...
