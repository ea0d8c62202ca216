import datetime

from bendtwin.v1 import key_pb2 as _key_pb2
from bendtwin.v1 import options_pb2 as _options_pb2
from google.protobuf import timestamp_pb2 as _timestamp_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class GetSignInOptionsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class SignInOptions(_message.Message):
    __slots__ = ("enabled", "display_name", "public_url")
    ENABLED_FIELD_NUMBER: _ClassVar[int]
    DISPLAY_NAME_FIELD_NUMBER: _ClassVar[int]
    PUBLIC_URL_FIELD_NUMBER: _ClassVar[int]
    enabled: bool
    display_name: str
    public_url: str
    def __init__(self, enabled: bool = ..., display_name: _Optional[str] = ..., public_url: _Optional[str] = ...) -> None: ...

class StartSignInRequest(_message.Message):
    __slots__ = ("state", "nonce", "code_challenge")
    STATE_FIELD_NUMBER: _ClassVar[int]
    NONCE_FIELD_NUMBER: _ClassVar[int]
    CODE_CHALLENGE_FIELD_NUMBER: _ClassVar[int]
    state: str
    nonce: str
    code_challenge: str
    def __init__(self, state: _Optional[str] = ..., nonce: _Optional[str] = ..., code_challenge: _Optional[str] = ...) -> None: ...

class StartSignInResponse(_message.Message):
    __slots__ = ("authorization_url",)
    AUTHORIZATION_URL_FIELD_NUMBER: _ClassVar[int]
    authorization_url: str
    def __init__(self, authorization_url: _Optional[str] = ...) -> None: ...

class StartDeviceSignInRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class StartDeviceSignInResponse(_message.Message):
    __slots__ = ("device_code", "user_code", "verification_uri", "verification_uri_complete", "interval_s", "expires_in_s")
    DEVICE_CODE_FIELD_NUMBER: _ClassVar[int]
    USER_CODE_FIELD_NUMBER: _ClassVar[int]
    VERIFICATION_URI_FIELD_NUMBER: _ClassVar[int]
    VERIFICATION_URI_COMPLETE_FIELD_NUMBER: _ClassVar[int]
    INTERVAL_S_FIELD_NUMBER: _ClassVar[int]
    EXPIRES_IN_S_FIELD_NUMBER: _ClassVar[int]
    device_code: str
    user_code: str
    verification_uri: str
    verification_uri_complete: str
    interval_s: float
    expires_in_s: float
    def __init__(self, device_code: _Optional[str] = ..., user_code: _Optional[str] = ..., verification_uri: _Optional[str] = ..., verification_uri_complete: _Optional[str] = ..., interval_s: _Optional[float] = ..., expires_in_s: _Optional[float] = ...) -> None: ...

class CreateSignInRequest(_message.Message):
    __slots__ = ("code", "code_verifier", "nonce", "device_code")
    CODE_FIELD_NUMBER: _ClassVar[int]
    CODE_VERIFIER_FIELD_NUMBER: _ClassVar[int]
    NONCE_FIELD_NUMBER: _ClassVar[int]
    DEVICE_CODE_FIELD_NUMBER: _ClassVar[int]
    code: str
    code_verifier: str
    nonce: str
    device_code: str
    def __init__(self, code: _Optional[str] = ..., code_verifier: _Optional[str] = ..., nonce: _Optional[str] = ..., device_code: _Optional[str] = ...) -> None: ...

class CreateSignInResponse(_message.Message):
    __slots__ = ("key", "secret_key")
    KEY_FIELD_NUMBER: _ClassVar[int]
    SECRET_KEY_FIELD_NUMBER: _ClassVar[int]
    key: _key_pb2.Key
    secret_key: str
    def __init__(self, key: _Optional[_Union[_key_pb2.Key, _Mapping]] = ..., secret_key: _Optional[str] = ...) -> None: ...

class DeleteSignInRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class DeleteSignInResponse(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class GetCallerRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class Caller(_message.Message):
    __slots__ = ("owner", "scopes", "key", "is_sign_in", "expire_time")
    OWNER_FIELD_NUMBER: _ClassVar[int]
    SCOPES_FIELD_NUMBER: _ClassVar[int]
    KEY_FIELD_NUMBER: _ClassVar[int]
    IS_SIGN_IN_FIELD_NUMBER: _ClassVar[int]
    EXPIRE_TIME_FIELD_NUMBER: _ClassVar[int]
    owner: str
    scopes: _containers.RepeatedScalarFieldContainer[str]
    key: str
    is_sign_in: bool
    expire_time: _timestamp_pb2.Timestamp
    def __init__(self, owner: _Optional[str] = ..., scopes: _Optional[_Iterable[str]] = ..., key: _Optional[str] = ..., is_sign_in: bool = ..., expire_time: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ...) -> None: ...
