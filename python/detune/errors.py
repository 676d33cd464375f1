"""Faults in what the user gave."""

from __future__ import annotations

from typing import NamedTuple, Optional, Sequence


class Fault(NamedTuple):
    """One fault: its code (``detune explain CODE``), the message, and where it stands."""

    code: str
    message: str
    file: Optional[str] = None
    line: Optional[int] = None

    def __str__(self) -> str:
        return self.message


class DetuneError(ValueError):
    """Files or arguments that are wrong; ``faults`` holds every fault, each with file and line."""

    def __init__(self, faults: Sequence[Fault]):
        self.faults = list(faults)
        super().__init__("\n".join(fault.message for fault in self.faults))

    def __reduce__(self):
        return (type(self), (self.faults,))
