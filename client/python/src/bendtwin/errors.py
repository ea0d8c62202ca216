"""Errors as the server reports them: category, reason, message."""

from __future__ import annotations

import enum
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

import grpc
from google.protobuf.message import DecodeError
from google.rpc import error_details_pb2, status_pb2

from bendtwin.connection.transport import http1_fault, tls_fault

if TYPE_CHECKING:
    from bendtwin.resources import Capture, Fit

_DETAILS_KEY = "grpc-status-details-bin"


class Category(str, enum.Enum):
    """The kind of an error; the names of the gRPC codes."""

    INVALID_ARGUMENT = "INVALID_ARGUMENT"
    NOT_FOUND = "NOT_FOUND"
    ALREADY_EXISTS = "ALREADY_EXISTS"
    FAILED_PRECONDITION = "FAILED_PRECONDITION"
    UNAUTHENTICATED = "UNAUTHENTICATED"
    PERMISSION_DENIED = "PERMISSION_DENIED"
    RESOURCE_EXHAUSTED = "RESOURCE_EXHAUSTED"
    ABORTED = "ABORTED"
    DEADLINE_EXCEEDED = "DEADLINE_EXCEEDED"
    CANCELLED = "CANCELLED"
    UNAVAILABLE = "UNAVAILABLE"
    DATA_LOSS = "DATA_LOSS"
    INTERNAL = "INTERNAL"

    @property
    def is_transient(self) -> bool:
        """True if the same call may succeed a little later."""
        return self in (Category.UNAVAILABLE, Category.RESOURCE_EXHAUSTED, Category.ABORTED)


_OTHER_CODES = {"OUT_OF_RANGE": Category.INVALID_ARGUMENT}


def category_named(name: str) -> Category:
    """The category of that name; one that this version does not know counts as INTERNAL."""
    try:
        return Category(name)
    except ValueError:
        return _OTHER_CODES.get(name, Category.INTERNAL)


class BendTwinError(Exception):
    """A call that failed. `str(error)` says what happened and what to do about it."""

    def __init__(
        self, category: Category, reason: str, message: str, request_id: str | None = None
    ) -> None:
        super().__init__(message)
        #: The kind of error.
        self.category = category
        #: Stable UPPER_SNAKE_CASE word to branch on.
        self.reason = reason
        #: What happened and what to do about it.
        self.message = message
        #: Names the call in the server's log, where the server gave one.
        self.request_id = request_id

    def __str__(self) -> str:
        return f"{self.message} [{self.reason}]"


class FitFailed(BendTwinError):
    """A fit that ended without a twin; `fit` has its whole record."""

    def __init__(self, fit: Fit) -> None:
        if fit.fault is None:
            super().__init__(Category.CANCELLED, "FIT_CANCELLED", f"{fit.name} was cancelled")
        else:
            super().__init__(fit.fault.category, fit.fault.reason, fit.fault.message)
        #: The fit as it ended.
        self.fit = fit


class IngestFailed(BendTwinError):
    """A capture that cannot be fitted, or was not read to its end; its report says more."""

    def __init__(self, capture: Capture) -> None:
        fault = capture.ingest.fault if capture.ingest else None
        if fault is None:
            message = f"the ingest of {capture.name} was cancelled"
            super().__init__(Category.CANCELLED, "INGEST_CANCELLED", message)
        else:
            super().__init__(fault.category, fault.reason, fault.message)
        #: The capture as its ingest ended.
        self.capture = capture


def from_rpc_error(error: grpc.RpcError) -> BendTwinError:
    """The error that a gRPC status carries."""
    category = category_named(error.code().name)
    reason, request_id = category.value, None
    info, request = error_details_pb2.ErrorInfo(), error_details_pb2.RequestInfo()
    for detail in _details(error):
        if detail.Is(info.DESCRIPTOR) and detail.Unpack(info):
            reason = info.reason
        elif detail.Is(request.DESCRIPTOR) and detail.Unpack(request):
            request_id = request.request_id
    details = error.details() or category.value
    fault = None
    if category is Category.UNAVAILABLE:
        fault = tls_fault(details) or http1_fault(details)
    if fault is not None:
        return BendTwinError(Category.FAILED_PRECONDITION, *fault)
    return BendTwinError(category, reason, details, request_id)


def _details(error: grpc.RpcError) -> list[Any]:
    for key, value in error.trailing_metadata() or ():
        if key == _DETAILS_KEY:
            status = status_pb2.Status()
            with suppress(DecodeError):
                status.ParseFromString(value)
            return list(status.details)
    return []


@contextmanager
def translated() -> Iterator[None]:
    """Turns gRPC errors within into BendTwinError."""
    try:
        yield
    except grpc.RpcError as error:
        raise from_rpc_error(error) from error
