"""Failures of a coupled frame that are not the server's; those are `BendTwinError`."""

from __future__ import annotations

from typing import Literal

Reason = Literal["MODEL_DIVERGED", "TOO_FAST", "TWIN_DIVERGED"]


class CouplingError(Exception):
    """A frame that could not be simulated. The model and the twin are as they were before it."""

    def __init__(self, reason: Reason, message: str) -> None:
        super().__init__(message)
        #: Stable UPPER_SNAKE_CASE word to branch on.
        self.reason: Reason = reason
        #: What happened and what to do about it.
        self.message = message

    def __str__(self) -> str:
        return f"{self.message} [{self.reason}]"
