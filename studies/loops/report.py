"""Tables of episodes: what the loops reached, and where the time went."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import groupby
from typing import Any

import numpy as np

from studies.loops.episode import PARTS, Episode


def summary(episodes: Sequence[Episode]) -> list[dict[str, Any]]:
    """One row for each loop and variant, in the order of the episodes."""
    rows = []
    for (loop, variant), group in groupby(episodes, key=lambda e: (e.loop, e.variant)):
        of = list(group)
        errors = np.array([e.error_mm for e in of])
        parts = {part: [s for e in of for s in e.latencies_s[part]] for part in PARTS}
        rows.append(
            {
                "loop": loop,
                "variant": variant,
                "episodes": len(of),
                "successes": sum(e.success for e in of),
                "error_median_mm": float(np.median(errors)),
                "error_worst_mm": float(errors.max()),
                "largest_strain": max(e.largest_strain for e in of),
                "largest_force_n": max(e.largest_force_n for e in of),
                "corrections": sum(e.corrections for e in of),
                "refused_corrections": sum(e.refused_corrections for e in of),
                "lost": sum(e.lost for e in of),
                "ended_by": sorted({e.ended_by for e in of if e.ended_by}),
                "latency_ms": {part: _quantiles(times) for part, times in parts.items()},
            }
        )
    return rows


def document(episodes: Sequence[Episode]) -> dict[str, Any]:
    """All that is known, for a JSON file."""
    return {"loops": summary(episodes), "episodes": [asdict(e) for e in episodes]}


def markdown(episodes: Sequence[Episode]) -> str:
    """The tables in markdown."""
    rows = summary(episodes)
    reached = [
        [
            row["loop"],
            row["variant"].replace("_", " "),
            f"{row['successes']} of {row['episodes']}",
            f"{row['error_median_mm']:.1f} / {row['error_worst_mm']:.1f}",
            f"{row['largest_strain']:.2f}",
            f"{row['largest_force_n']:.1f}",
            f"{row['refused_corrections']} of {row['corrections']}" if row["corrections"] else "",
            ", ".join(f"`{reason}`" for reason in row["ended_by"]),
        ]
        for row in rows
    ]
    times = [
        [
            row["loop"],
            row["variant"].replace("_", " "),
            *(_shown(row["latency_ms"][part]) for part in PARTS),
        ]
        for row in rows
    ]
    heads = (
        ["loop", "variant", "success", "error, median / worst, mm", "largest strain"],
        ["largest force, N", "corrections refused", "ended by"],
    )
    return "\n\n".join(
        [
            table([*heads[0], *heads[1]], reached),
            table(["latency, median / p99, ms", "variant", *PARTS], times),
        ]
    )


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of markdown with aligned columns."""
    widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]
    lines = [head, ["-" * width for width in widths], *rows]
    return "\n".join(
        "| " + " | ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)) + " |"
        for line in lines
    )


def rows_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as a table of markdown."""
    names = list(rows[0])
    return table(names, [[_cell(row[name]) for name in names] for row in rows])


def _cell(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, (float, np.floating)) else str(value)


def _quantiles(times_s: Sequence[float]) -> dict[str, float] | None:
    if not times_s:
        return None
    ms = 1e3 * np.array(times_s)
    return {"median": float(np.median(ms)), "p99": float(np.quantile(ms, 0.99))}


def _shown(of: dict[str, float] | None) -> str:
    return f"{of['median']:.0f} / {of['p99']:.0f}" if of else ""
