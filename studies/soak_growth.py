"""Whether a process grows: memory, open files and threads over each of its lives. Pure: samples in, numbers out."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.soak_watch import Sample

WARM_S = 60.0
"""A process may grow for this long after it was started; for half of its life when that is shorter."""
GROWTH_MIB_H = 30.0
"""Most that a process may grow in an hour of work. The index of its recording takes a good half of it."""
STEP_MIB = 4.0
"""And once, for what it does for the first time: a reconnection, a fault, a second thread."""
MORE_FILES, MORE_THREADS = 8, 4
"""More of them at the end of a life than at its beginning is a leak; faster coming and going is none."""
_RATE_FROM_S = 120.0
_SHORTEST = 12
"""Samples of a life that is looked at."""


@dataclass(frozen=True, slots=True)
class Life:
    """One process from its start to its end: times (n,), s, and what it used, (n,)."""

    process: str
    pid: int
    time_s: NDArray[np.float64]
    rss_mib: NDArray[np.float64]
    open_files: NDArray[np.float64]
    threads: NDArray[np.float64]

    def growth(self) -> dict[str, Any]:
        """First and last values after the warm-up, and what is wrong with them.

        Of memory the medians of first and last third count; of files and threads those of the two halves: a fault
        keeps some open for a while (whoever looks for five devices has five threads that look) or closes some (those
        of dead devices), a leak keeps them for good.
        """
        time_s = self.time_s
        start_s = time_s[0] + min(WARM_S, 0.5 * (time_s[-1] - time_s[0]))
        settled = time_s >= start_s
        time_s = time_s[settled]
        third = max(1, len(time_s) // 3)

        def ends(values: NDArray[np.float64]) -> tuple[float, float]:
            return float(np.median(values[settled][:third])), float(np.median(values[settled][-third:]))

        # Between the middles of the two thirds.
        span_s = float(np.median(time_s[-third:]) - np.median(time_s[:third]))
        half = max(1, len(time_s) // 2)

        def halves(values: NDArray[np.float64]) -> tuple[float, float]:
            return float(np.median(values[settled][:half])), float(np.median(values[settled][-half:]))

        rss, files, threads = ends(self.rss_mib), halves(self.open_files), halves(self.threads)
        enough = time_s[-1] - time_s[0] >= _RATE_FROM_S
        rate = float(np.polyfit(time_s - time_s[0], self.rss_mib[settled], 1)[0]) * 3600.0 if enough else None
        allowed_mib = STEP_MIB + GROWTH_MIB_H * span_s / 3600.0
        wrong = []
        if rss[1] - rss[0] > allowed_mib:
            wrong.append(f"grew by {rss[1] - rss[0]:.1f} MiB in {span_s:.0f} s, allowed {allowed_mib:.1f}")
        for what, (first, last), more in (("files", files, MORE_FILES), ("threads", threads, MORE_THREADS)):
            if last - first > more:
                wrong.append(f"{last:.0f} {what} open at its end, {first:.0f} at its beginning")
        return {
            "process": self.process,
            "seconds": round(float(self.time_s[-1] - self.time_s[0]), 1),
            "rss_mib": [round(value, 1) for value in rss],
            "rss_mib_h": None if rate is None else round(rate, 1),
            "open_files": [round(value) for value in files],
            "threads": [round(value) for value in threads],
            "wrong": [f"{self.process}: {each}" for each in wrong],
        }


def lives(samples: Sequence[Sample]) -> list[Life]:
    """Samples by process and process number, those that were looked at often enough; in order of their beginnings."""
    by_pid: dict[tuple[str, int], list[Sample]] = {}
    for sample in samples:
        by_pid.setdefault((sample.process, sample.pid), []).append(sample)
    return [
        Life(
            process,
            pid,
            np.array([s.time_s for s in seen]),
            np.array([s.rss_mib for s in seen]),
            np.array([s.open_files for s in seen], dtype=np.float64),
            np.array([s.threads for s in seen], dtype=np.float64),
        )
        for (process, pid), seen in by_pid.items()
        if len(seen) >= _SHORTEST
    ]
