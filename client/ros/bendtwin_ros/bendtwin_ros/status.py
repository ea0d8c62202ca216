"""Status of the node: what was dropped and why, how well the twin follows, and what is wrong."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from bendtwin_ros.messages.basic import Header
from bendtwin_ros.messages.shown import DiagnosticArray, DiagnosticStatus, KeyValue

#: Longest text of a fact: faults may name what a message had.
_LONGEST = 500


@dataclass
class Status:
    """Facts for diagnostics. Counts are by reason and only grow."""

    #: Messages that were left out, and other events.
    counts: Counter[str] = field(default_factory=Counter)
    #: The last event of each reason in words.
    last: dict[str, str] = field(default_factory=dict)
    #: Why the server cannot be used now, and whether only a person can change that.
    down: str = ""
    needs_person: bool = False
    #: True once the object was found, and while the twin follows it.
    follows: bool = False
    lost: bool = False
    misfit: float = 0.0
    median_mm: float = 0.0
    #: From the stamp of a cloud to the end of its correction; and of the correction alone.
    latency_s: float = 0.0
    compute_s: float = 0.0
    #: Stamp of the last cloud that was used.
    seen_ns: int | None = None
    #: Reasons since the last report.
    recent: Counter[str] = field(default_factory=Counter)

    def count(self, reason: str, message: str = "") -> None:
        """Counts an event."""
        self.counts[reason] += 1
        self.recent[reason] += 1
        self.last[reason] = message[:_LONGEST]

    def report(self, header: Header, twin: str) -> DiagnosticArray:
        """The message for /diagnostics, which begins a new period of `recent`."""
        level, message = self._verdict()
        facts = {
            "follows": self.follows,
            "lost": self.lost,
            "misfit": f"{self.misfit:.3f}",
            "median residual [mm]": f"{self.median_mm:.2f}",
            "latency [s]": f"{self.latency_s:.3f}",
            "time of a correction [s]": f"{self.compute_s:.3f}",
            **{f"count: {reason}": n for reason, n in sorted(self.counts.items())},
            **{f"last: {reason}": text for reason, text in sorted(self.last.items()) if text},
        }
        self.recent.clear()
        status = DiagnosticStatus(
            level=level,
            name="bendtwin: tracking",
            message=message[:_LONGEST],
            hardware_id=twin,
            values=[KeyValue(key, str(value)) for key, value in facts.items()],
        )
        return DiagnosticArray(header, [status])

    def _verdict(self) -> tuple[bytes, str]:
        if self.down:
            return DiagnosticStatus.ERROR if self.needs_person else DiagnosticStatus.WARN, self.down
        if self.lost:
            message = "the twin lost its object: it registers again with the next clouds"
            return DiagnosticStatus.ERROR, message
        recent = ""
        for reason, number in self.recent.most_common(1):
            recent = f"{number} x {reason}: {self.last[reason]}".rstrip(": ")
        if not self.follows:
            return DiagnosticStatus.WARN, recent or "waiting for the first cloud of the object"
        if self.misfit > 1.0:
            return DiagnosticStatus.WARN, f"misfit {self.misfit:.2f}: above 1 the object gets lost"
        return (DiagnosticStatus.WARN, recent) if recent else (DiagnosticStatus.OK, "follows")
