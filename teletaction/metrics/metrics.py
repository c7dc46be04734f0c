"""Converts the status files of a session's processes to Prometheus metrics.

Only status files are read, so that no scrape disturbs a loop. A missing or old file gives only `up` with value 0
and, for an old file, its age.
"""

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from prometheus_client import Metric
from prometheus_client.registry import Collector

from common.health import NoStatus, read_status, young
from common.link.session_display import CONNECTED, DISCONNECTED, ENDED, ENGAGED, ENGAGING, FAULT, LOST, shown_state

Sample = tuple[str, Mapping[str, str], float]
"""Name of a metric without its prefix, its labels and its value."""

PREFIX = "teletaction_"
METRICS: dict[str, tuple[str, str]] = {
    "up": ("gauge", "1 while the process keeps its status file up to date."),
    "status_age_seconds": ("gauge", "Time since the status file was written."),
    "loop_period_seconds": ("gauge", "Nominal period of the loop."),
    "loop_late_seconds": ("gauge", "Lateness of ticks since the start, by quantile (1 is the maximum)."),
    "loop_rate_hertz": ("gauge", "Ticks a second, over the last seconds."),
    "loop_behind": ("gauge", "1 while the loop does not hold its rate."),
    "loop_works_ratio": ("gauge", "Busy share of the loop's thread, over the last seconds."),
    "loop_real_time": ("gauge", "1 while the loop has real-time priority."),
    "loop_behind_seconds": ("counter", "Time during which the loop did not hold its rate."),
    "loop_ticks": ("counter", "Ticks of the loop."),
    "loop_overruns": ("counter", "Ticks that started more than one period late."),
    "loop_missed": ("counter", "Ticks skipped because they were more than one period late."),
    "loop_ticks_held_back": (
        "counter",
        "Ticks whose commands were discarded because they were too old at the end of the tick.",
    ),
    "cpu_ratio": ("gauge", "Processor time used per second since the start."),
    "resident_memory_peak_bytes": ("gauge", "Largest resident memory so far."),
    "session_state": ("gauge", "1 for the displayed state of the session; lost: the far site is silent."),
    "fault": ("gauge", "1 while a fault is latched."),
    "devices_missing": ("gauge", "1 while a device is missing."),
    "packets_sent": ("counter", "Packets sent."),
    "packets_spared": ("counter", "Ticks without a packet because the change was not perceptible."),
    "packets_received": ("counter", "Packets accepted."),
    "packets_superseded": ("counter", "Packets that never arrived: superseded on the way, or lost."),
    "packets_refused": ("counter", "Packets refused, by reason."),
    "packets_damaged": ("counter", "Packets that could not be read."),
    "packet_age_seconds": ("gauge", "Age of the last accepted packet when it was accepted."),
    "packet_age_limit_seconds": ("gauge", "Largest accepted age of a packet."),
    "clock_uncertainty_seconds": ("gauge", "Uncertainty of the far clock's offset."),
    "handshakes": ("counter", "Sites that asked to connect, by outcome."),
    "device_connected": ("gauge", "1 while the device is connected."),
    "device_lost": ("counter", "Times that a device was lost."),
    "device_frames_damaged": ("counter", "Invalid serial frames, or refused CAN frames."),
    "device_frames_missed": ("counter", "Frames that a device sent and that never arrived."),
    "device_commands_unsent": ("counter", "Commands dropped because the output buffer was full."),
    "recording_written": ("counter", "Messages recorded."),
    "recording_lost": ("counter", "Messages that could not be recorded."),
    "recording_failed": ("gauge", "1 after the recording has stopped permanently."),
}
"""Type and help of each metric."""

_MOST = 2.0**63
"""Values of this magnitude or more, and not-a-number, are left out."""
_STATES = (DISCONNECTED, CONNECTED, ENGAGING, ENGAGED, LOST, FAULT)


class StatusCollector(Collector):
    """Reads the status files again at each scrape."""

    def __init__(self, status_files: Sequence[Path]) -> None:
        """Serve these files. The label `process` is a file's name without its extension.

        Raises:
            ValueError: two files have the same name.
        """
        self._files = {path.stem: path for path in status_files}
        if len(self._files) < len(status_files):
            raise ValueError("--status: two files have one name, which labels their metrics: rename one")

    def collect(self) -> Iterable[Metric]:
        """Return the current metrics of all processes."""
        now_ns = time.monotonic_ns()
        families = {name: Metric(PREFIX + name, text, kind) for name, (kind, text) in METRICS.items()}
        for process, path in self._files.items():
            for name, labels, value in process_samples(path, now_ns):
                ending = "_total" if METRICS[name][0] == "counter" else ""
                families[name].add_sample(PREFIX + name + ending, {"process": process, **labels}, value)
        return [family for family in families.values() if family.samples]


def process_samples(status: Path, now_ns: int) -> Iterator[Sample]:
    """Yield whether the process that writes `status` is up, and its metrics if it is."""
    try:
        content, age_s = read_status(status, now_ns)
    except NoStatus:
        yield "up", {}, 0.0
        return
    up = young(age_s) and content.get("state") != ENDED
    yield "up", {}, float(up)
    yield "status_age_seconds", {}, age_s
    if up:
        yield from samples(content)


def samples(status: Mapping[str, Any]) -> Iterator[Sample]:
    """Yield the metrics of a status. Values that are missing or no numbers are left out."""
    for name, labels, value in _all(status):
        number = _number(value)
        if number is not None:
            yield name, labels, number


def _all(status: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, str], Any]]:
    yield from _of_process(status)
    if status.get("state") in _STATES:
        shown = shown_state(status["state"], link_silent=bool(status.get("stale")))
        for state in _STATES:
            yield "session_state", {"state": state}, shown == state
        yield "fault", {}, bool(status.get("fault"))
        yield "devices_missing", {}, bool(status.get("missing"))
    yield from _of_link(status)
    for device, figures in _table(status, "devices").items():
        yield from _of_device(device, figures if isinstance(figures, Mapping) else {})
    for stream, count in _table(status, "recorded").items():
        yield "recording_written", {"stream": stream}, count
    yield "recording_lost", {}, status.get("recording_lost")
    if "recording_failed" in status:
        yield "recording_failed", {}, bool(status["recording_failed"])


def _of_process(status: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, str], Any]]:
    loop = _table(status, "loop")
    yield "loop_period_seconds", {}, _scaled(loop.get("period_ms"), 1e-3)
    for quantile, field in (("0.5", "late_p50_us"), ("0.99", "late_p99_us"), ("1", "late_max_us")):
        yield "loop_late_seconds", {"quantile": quantile}, _scaled(loop.get(field), 1e-6)
    yield "loop_rate_hertz", {}, status.get("rate_hz")
    yield "loop_behind_seconds", {}, status.get("behind_s")
    if "behind" in status:
        yield "loop_behind", {}, bool(status["behind"])
    yield "loop_works_ratio", {}, status.get("works")
    if "real_time" in status:
        yield "loop_real_time", {}, bool(status["real_time"])
    yield "loop_ticks", {}, loop.get("ticks")
    yield "loop_overruns", {}, loop.get("overruns")
    yield "loop_missed", {}, loop.get("missed")
    yield "loop_ticks_held_back", {}, status.get("held_back")
    yield "cpu_ratio", {}, loop.get("cpu")
    yield "resident_memory_peak_bytes", {}, _scaled(status.get("rss_mib"), 2.0**20)


def _of_link(status: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, str], Any]]:
    for field in ("sent", "spared", "received", "superseded"):
        for stream, count in _table(status, field).items():
            yield f"packets_{field}", {"stream": stream}, count
    refused = _table(status, "refused")
    for stream in refused.keys() - {"damaged"}:
        for reason, count in _table(refused, stream).items():
            yield "packets_refused", {"stream": stream, "reason": reason}, count
    for stream, count in _table(refused, "damaged").items():
        yield "packets_damaged", {"stream": stream}, count
    yield "packet_age_seconds", {}, _scaled(status.get("age_ms"), 1e-3)
    yield "packet_age_limit_seconds", {}, _scaled(status.get("max_age_ms"), 1e-3)
    for outcome, count in _table(status, "handshakes").items():
        yield "handshakes", {"outcome": outcome}, count
    yield "clock_uncertainty_seconds", {}, _scaled(_table(status, "clock").get("uncertainty_ns"), 1e-9)


def _of_device(device: str, figures: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, str], Any]]:
    labels = {"device": device}
    yield "device_connected", labels, bool(figures.get("connected", figures.get("serial")))
    yield "device_lost", labels, figures.get("times_lost")
    yield "device_frames_damaged", labels, figures.get("damaged", _refused(figures))
    yield "device_frames_missed", labels, figures.get("missed")
    yield "device_commands_unsent", labels, figures.get("unsent")


def _refused(figures: Mapping[str, Any]) -> Any:
    counts = _table(figures, "refused").values()
    return sum(count for count in counts if isinstance(count, int)) if counts else None


def _table(status: Mapping[str, Any], field: str) -> Mapping[str, Any]:
    found = status.get(field)
    return found if isinstance(found, Mapping) else {}


def _scaled(value: Any, factor: float) -> float | None:
    number = _number(value)
    return None if number is None else number * factor


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and abs(value) < _MOST else None
