"""What the processes of a session tell in their status files, as Prometheus metrics.

Status files are all that is read, so however often somebody scrapes, no loop is touched. Of a file that is missing or
old nothing is told but that its process is down.
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
"""Name of a metric without its prefix, labels, value."""

PREFIX = "teletaction_"
METRICS: dict[str, tuple[str, str]] = {
    "up": ("gauge", "Whether the process keeps its status file up to date."),
    "status_age_seconds": ("gauge", "Since the status file was written."),
    "loop_period_seconds": ("gauge", "Nominal period of the loop."),
    "loop_late_seconds": ("gauge", "Lateness of the loop's ticks since the start, by quantile (1 is the maximum)."),
    "loop_rate_hertz": ("gauge", "Ticks a second, over the last seconds."),
    "loop_behind": ("gauge", "Whether the loop does not hold its rate."),
    "loop_works_ratio": ("gauge", "Share of the time that the loop's thread works, over the last seconds."),
    "loop_real_time": ("gauge", "Whether the loop comes before all ordinary work on its machine."),
    "loop_behind_seconds": ("counter", "For how long the loop has not held its rate."),
    "loop_ticks": ("counter", "Ticks of the loop."),
    "loop_overruns": ("counter", "Ticks that came more than one period late."),
    "loop_missed": ("counter", "Ticks that were left out, since they were more than one period late."),
    "loop_ticks_held_back": ("counter", "Ticks whose commands were too old to be sent to the devices when they ended."),
    "cpu_ratio": ("gauge", "Processor time used per second since the start."),
    "resident_memory_peak_bytes": ("gauge", "Largest resident memory so far."),
    "session_state": ("gauge", "1 for the state that may be shown of the session; lost: the far site is silent."),
    "fault": ("gauge", "Whether a fault is latched."),
    "devices_missing": ("gauge", "Whether a device is missing."),
    "packets_sent": ("counter", "Packets sent."),
    "packets_spared": ("counter", "Ticks that were not worth a packet: the far side would have felt no difference."),
    "packets_received": ("counter", "Packets accepted."),
    "packets_superseded": ("counter", "Packets that never came: superseded on the way, or lost."),
    "packets_refused": ("counter", "Packets refused, by reason."),
    "packets_damaged": ("counter", "Packets that could not be read."),
    "packet_age_seconds": ("gauge", "Age of the last accepted packet when it was accepted."),
    "packet_age_limit_seconds": ("gauge", "Age that packets are refused above."),
    "clock_uncertainty_seconds": ("gauge", "Of the far clock's offset."),
    "handshakes": ("counter", "Sites that asked to connect, by outcome."),
    "device_connected": ("gauge", "Whether the device is there."),
    "device_lost": ("counter", "Times that a device was lost."),
    "device_frames_damaged": ("counter", "Pieces of a serial line that were no frame, or CAN frames refused."),
    "device_frames_missed": ("counter", "Frames that a device sent and that never came."),
    "device_commands_unsent": ("counter", "Commands dropped because the line was full."),
    "recording_written": ("counter", "Messages recorded."),
    "recording_lost": ("counter", "Messages that could not be recorded."),
    "recording_failed": ("gauge", "Whether the recording has stopped for good."),
}
"""Type and help of each metric."""

_MOST = 2.0**63
"""No figure is larger; not-a-number is no smaller either."""
_STATES = (DISCONNECTED, CONNECTED, ENGAGING, ENGAGED, LOST, FAULT)


class StatusCollector(Collector):
    """Reads the status files anew at each scrape."""

    def __init__(self, status_files: Sequence[Path]) -> None:
        """Serve these files; the label `process` of each is its name without the ending.

        Raises:
            ValueError: two files have one name.
        """
        self._files = {path.stem: path for path in status_files}
        if len(self._files) < len(status_files):
            raise ValueError("--status: two files have one name, which is the label of their metrics: rename one")

    def collect(self) -> Iterable[Metric]:
        """All metrics of all processes now."""
        now_ns = time.monotonic_ns()
        families = {name: Metric(PREFIX + name, text, kind) for name, (kind, text) in METRICS.items()}
        for process, path in self._files.items():
            for name, labels, value in process_samples(path, now_ns):
                ending = "_total" if METRICS[name][0] == "counter" else ""
                families[name].add_sample(PREFIX + name + ending, {"process": process, **labels}, value)
        return [family for family in families.values() if family.samples]


def process_samples(status: Path, now_ns: int) -> Iterator[Sample]:
    """Whether the process that writes `status` is up, and if so what it tells."""
    try:
        told, age_s = read_status(status, now_ns)
    except NoStatus:
        yield "up", {}, 0.0
        return
    up = young(age_s) and told.get("state") != ENDED
    yield "up", {}, float(up)
    yield "status_age_seconds", {}, age_s
    if up:
        yield from samples(told)


def samples(told: Mapping[str, Any]) -> Iterator[Sample]:
    """What a status tells; what it does not, or not as a number, is left out."""
    for name, labels, value in _all(told):
        number = _number(value)
        if number is not None:
            yield name, labels, number


def _all(told: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, str], Any]]:
    yield from _of_process(told)
    if told.get("state") in _STATES:
        shown = shown_state(told["state"], link_silent=bool(told.get("stale")))
        for state in _STATES:
            yield "session_state", {"state": state}, shown == state
        yield "fault", {}, bool(told.get("fault"))
        yield "devices_missing", {}, bool(told.get("missing"))
    yield from _of_link(told)
    for device, figures in _table(told, "devices").items():
        yield from _of_device(device, figures if isinstance(figures, Mapping) else {})
    for stream, count in _table(told, "recorded").items():
        yield "recording_written", {"stream": stream}, count
    yield "recording_lost", {}, told.get("recording_lost")
    if "recording_failed" in told:
        yield "recording_failed", {}, bool(told["recording_failed"])


def _of_process(told: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, str], Any]]:
    loop = _table(told, "loop")
    yield "loop_period_seconds", {}, _scaled(loop.get("period_ms"), 1e-3)
    for quantile, field in (("0.5", "late_p50_us"), ("0.99", "late_p99_us"), ("1", "late_max_us")):
        yield "loop_late_seconds", {"quantile": quantile}, _scaled(loop.get(field), 1e-6)
    yield "loop_rate_hertz", {}, told.get("rate_hz")
    yield "loop_behind_seconds", {}, told.get("behind_s")
    if "behind" in told:
        yield "loop_behind", {}, bool(told["behind"])
    yield "loop_works_ratio", {}, told.get("works")
    if "real_time" in told:
        yield "loop_real_time", {}, bool(told["real_time"])
    yield "loop_ticks", {}, loop.get("ticks")
    yield "loop_overruns", {}, loop.get("overruns")
    yield "loop_missed", {}, loop.get("missed")
    yield "loop_ticks_held_back", {}, told.get("held_back")
    yield "cpu_ratio", {}, loop.get("cpu")
    yield "resident_memory_peak_bytes", {}, _scaled(told.get("rss_mib"), 2.0**20)


def _of_link(told: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, str], Any]]:
    for field in ("sent", "spared", "received", "superseded"):
        for stream, count in _table(told, field).items():
            yield f"packets_{field}", {"stream": stream}, count
    refused = _table(told, "refused")
    for stream in refused.keys() - {"damaged"}:
        for reason, count in _table(refused, stream).items():
            yield "packets_refused", {"stream": stream, "reason": reason}, count
    for stream, count in _table(refused, "damaged").items():
        yield "packets_damaged", {"stream": stream}, count
    yield "packet_age_seconds", {}, _scaled(told.get("age_ms"), 1e-3)
    yield "packet_age_limit_seconds", {}, _scaled(told.get("max_age_ms"), 1e-3)
    for outcome, count in _table(told, "handshakes").items():
        yield "handshakes", {"outcome": outcome}, count
    yield "clock_uncertainty_seconds", {}, _scaled(_table(told, "clock").get("uncertainty_ns"), 1e-9)


def _of_device(device: str, figures: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, str], Any]]:
    labels = {"device": device}
    yield "device_connected", labels, bool(figures.get("connected", figures.get("serial")))
    yield "device_lost", labels, figures.get("times_lost")
    yield "device_frames_damaged", labels, figures.get("damaged", _total(figures, "refused"))
    yield "device_frames_missed", labels, figures.get("missed")
    yield "device_commands_unsent", labels, figures.get("unsent")


def _total(figures: Mapping[str, Any], field: str) -> Any:
    counts = _table(figures, field).values()
    return sum(count for count in counts if isinstance(count, int)) if counts else None


def _table(told: Mapping[str, Any], field: str) -> Mapping[str, Any]:
    found = told.get(field)
    return found if isinstance(found, Mapping) else {}


def _scaled(value: Any, factor: float) -> float | None:
    number = _number(value)
    return None if number is None else number * factor


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and abs(value) < _MOST else None
