"""Detects growth of a process in memory, open files and threads over each of its lives. Pure: samples in, numbers out.

A life of a process lasts from its start to its end or its next restart.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robustness.soak_watch import Sample

WARM_S = 60.0
"""Longest warm-up of a process, s, in which it may grow; half of its life if that is shorter."""
GROWTH_MIB_H = 30.0
"""Largest allowed growth of a process's memory, MiB/h; the index of its recording takes more than half of it."""
STEP_MIB = 4.0
"""Largest allowed one-time growth of a process's memory, MiB, for a first reconnection, fault or second thread."""
MORE_FILES, MORE_THREADS = 8, 4
"""Largest allowed increase of open files and of threads from the first to the second half of a life."""
_RATE_FROM_S = 120.0
_SHORTEST = 12
"""Fewest samples of a life that is judged."""


@dataclass(frozen=True, slots=True)
class Life:
    """One life of a process: times (n,), s, and its use of memory, files and threads, (n,)."""

    process: str
    pid: int
    time_s: NDArray[np.float64]
    rss_mib: NDArray[np.float64]
    open_files: NDArray[np.float64]
    threads: NDArray[np.float64]

    def growth(self) -> dict[str, Any]:
        """Return the first and last values after the warm-up, and the excessive ones.

        Memory is compared by the medians of the first and the last third. Files and threads are compared by the medians
        of the two halves. A fault opens some of them for a while, such as one thread for each missing device, or closes
        those of dead devices. A leak keeps them open.
        """
        time_s = self.time_s
        start_s = time_s[0] + min(WARM_S, 0.5 * (time_s[-1] - time_s[0]))
        settled = time_s >= start_s
        time_s = time_s[settled]

        def ends(values: NDArray[np.float64], parts: int) -> tuple[float, float]:
            """Return the medians of the first and the last of `parts` parts."""
            count = max(1, len(time_s) // parts)
            return float(np.median(values[settled][:count])), float(np.median(values[settled][-count:]))

        rss, files, threads = ends(self.rss_mib, 3), ends(self.open_files, 2), ends(self.threads, 2)
        first_s, last_s = ends(self.time_s, 3)
        span_s = last_s - first_s
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
    """Group samples into lives by process and process number, in order of start; leave out those of few samples."""
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
