"""Reads the recordings of a session: times of the loops' ticks, and age of packets, over any interval."""

from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from common.limits import GAP_S
from common.recording.truncated_mcap import TruncatedMcap
from common.wire.messages import Motion, Touch

Times = NDArray[np.float64]
TICKS = {"remote": "remote/gate", "operator": "operator/input"}
"""Stream that each site records in every tick."""
ARRIVALS = {"motion": "remote/motion", "touch": "operator/touch"}
"""Stream that a site records in the tick in which it first acts on a packet."""
_PACKETS: dict[str, type[Motion | Touch]] = {"remote/motion": Motion, "operator/touch": Touch}


@dataclass(frozen=True, slots=True)
class Recorded:
    """Times by stream, s of the machine's monotonic clock.

    Attributes:
        times_s: time of each tick or arrival, (n,).
        sources_s: for arrivals, time at which the far site made the packet, (n,).
    """

    times_s: dict[str, Times]
    sources_s: dict[str, Times]

    @classmethod
    def read(cls, folder: Path) -> "Recorded":
        """Read both sites' recordings as far as they are intact; a site that never started has none."""
        times: dict[str, list[int]] = defaultdict(list)
        sources: dict[str, list[int]] = defaultdict(list)
        for path in (folder / f"{site}.mcap" for site in TICKS):
            if not path.exists():
                continue
            with path.open("rb") as file:
                for topic, message in TruncatedMcap(file).messages():
                    times[topic].append(message.log_time)
                    if topic in _PACKETS:
                        sources[topic].append(_PACKETS[topic].decode(message.data).time_ns)
        return cls(*({topic: np.array(ns) * 1e-9 for topic, ns in each.items()} for each in (times, sources)))

    def lateness(self, site: str, begin_s: float, end_s: float, period_s: float) -> dict[str, float | None]:
        """Return the deviation of tick intervals from the period, us: median and 99 %; None if not recorded."""
        times_s, _ = self._between(TICKS.get(site, ""), begin_s, end_s)
        off_us = np.abs(np.diff(times_s) - period_s) * 1e6
        return {f"off_p{percent}_us": _quantile(off_us, percent) for percent in (50, 99)}

    def arrivals(self, stream: str, begin_s: float, end_s: float) -> dict[str, Any]:
        """Return the age of packets when they took effect, ms: median and 99 %, and the longest gap, ms.

        `gap_share` is the share of time in which the last packet was older than GAP_S. Outputs are safe in that time.
        """
        times_s, sources_s = self._between(ARRIVALS[stream], begin_s, end_s)
        age_ms = (times_s - sources_s) * 1e3
        gaps_ms = np.diff(np.concatenate(([begin_s], times_s, [end_s]))) * 1e3
        return {
            **{f"age_p{percent}_ms": _quantile(age_ms, percent) for percent in (50, 99)},
            "longest_gap_ms": round(float(gaps_ms.max()), 1),
            "gap_share": round(float(np.maximum(0.0, gaps_ms - 1e3 * GAP_S).sum() / (1e3 * (end_s - begin_s))), 4),
        }

    def _between(self, topic: str, begin_s: float, end_s: float) -> tuple[Times, Times]:
        nothing = np.zeros(0)
        times_s = self.times_s.get(topic, nothing)
        kept = (begin_s <= times_s) & (times_s < end_s)
        sources_s = self.sources_s.get(topic, nothing)
        return times_s[kept], sources_s[kept] if len(sources_s) else nothing


def _quantile(values: Times, percent: int) -> float | None:
    return round(float(np.percentile(values, percent)), 2) if len(values) else None
