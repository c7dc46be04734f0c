"""Repeats identification and rendering on a recording, and compares them with the recorded results.

The recording contains all their input: each tick's exact input, the accepted touch packets, configuration and
calibrated tables. On the machine that recorded, the results are identical to the last bit.
"""

import csv
import json
import math
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from io import TextIOWrapper
from pathlib import Path
from typing import IO, Annotated, Any

from pydantic import BaseModel, Field, ValidationError

from common.config.site_models import OperatorConfig, RenderingConfig
from common.faults.texts import fault_text
from common.files.private_file import create_private, replacing, write_private
from common.fingers import FINGERS
from common.limits import GAP_S
from common.privacy.recording_file import open_recording
from common.recording.reader import DamagedRecording
from common.runtime.parallel_map import Progress, unseen
from operator_site.safety.gated_output import GatedOutput
from remote_site.texture.surface_table import SurfaceTable
from remote_site.thermal.material_table import MaterialTable
from teletaction.recordings.recorded_session import RecordedSession
from teletaction.replay.replay_comparison import Comparison
from teletaction.replay.replay_sites import OperatorReplay, RemoteReplay

_SENSED = "remote/sensed"
_INPUTS = (_SENSED, "operator/input")
"""Streams of which each message advances a site's computation by one tick."""
_STREAMS = (*_INPUTS, "remote/touch", "operator/touch", "operator/coupling", "operator/rendered")
_PROGRESS_EVERY = 1000
COLUMNS = ("force_n", "motor_rpm", "plate_set_c", "peltier_drive")


def replay(path: Path, out: Path, progress: Progress = unseen) -> dict[str, Any]:
    """Replay a recording of one site or of a whole session; return the content of `replay.json`.

    Args:
        path: the recording.
        out: folder, created if it does not exist, for three files. `identification.jsonl` has events and materials,
            `rendering.csv` the output to the operator's devices. `replay.json` has the comparison, and the touches
            in which a solution that waited for a late tick changed the material or its time. Times count from the
            recording's first message.
        progress: function that receives the completed share, 0..1.

    Raises:
        ValueError: the file is truncated or damaged, or lacks data that a replay needs.
        OSError: `path` cannot be read or `out` cannot be written.
    """
    with ExitStack() as files:
        session = RecordedSession(path, files.enter_context(open_recording(path)))
        if not any(session.counts.get(stream) for stream in _INPUTS):
            raise ValueError(f"{path}: nothing to replay: has neither {' nor '.join(_INPUTS)}")
        out.mkdir(parents=True, exist_ok=True)
        replayed = _Replayed(
            session,
            files.enter_context(_private_text(out / "identification.jsonl")),
            files.enter_context(_private_text(out / "rendering.csv")),
        )
        done = _Done(sum(session.counts.get(stream, 0) for stream in (*_STREAMS, _SENSED)), progress)
        for stream, origin, time_ns, payload in session.messages(_STREAMS):
            try:
                replayed.open(stream, origin)
            except ValueError as error:
                why = session.reader.damaged(stream, time_ns, error)
                # Nothing is damaged, but a recording of another version is refused as such.
                raise (error if isinstance(why, DamagedRecording) else why) from None
            try:
                replayed.take(stream, origin, (time_ns - session.start_ns) * 1e-9, payload)
            except (ValueError, ArithmeticError) as error:
                raise session.reader.damaged(stream, time_ns, error) from None
            done.one_more()
        replayed.identify_without_waiting(done)
        progress(1.0)
    result = {"recording": path.name, **replayed.result()}
    write_private(out / "replay.json", json.dumps(result, indent=1).encode() + b"\n")
    return result


@contextmanager
def _private_text(path: Path) -> Iterator[TextIOWrapper]:
    with replacing(path) as made, TextIOWrapper(create_private(made, replace=True), "utf-8", newline="") as text:
        yield text


class _Done:
    """Counts the messages of both passes; the second is needed only if solutions waited."""

    def __init__(self, total: int, progress: Progress) -> None:
        self._total, self._progress, self._count = total, progress, 0

    def one_more(self) -> None:
        """Count a message, and report progress every _PROGRESS_EVERY messages."""
        self._count += 1
        if self._count % _PROGRESS_EVERY == 0:
            self._progress(self._count / self._total)


class _Replayed:
    """All sites of a recording; a restarted site starts again in the replay, too."""

    def __init__(self, session: RecordedSession, identification: IO[str], rendering: IO[str]):
        self._session = session
        self._identification = identification
        self._rendering = csv.writer(rendering, lineterminator="\n")
        self._fingers: list[str] = []
        self._remotes: dict[str, RemoteReplay] = {}
        self._operators: dict[str, OperatorReplay] = {}
        self._changed: dict[str, list[dict[str, object]]] = {}

    def open(self, stream: str, origin: str) -> None:
        """Open the site that recorded a stream, unless it is open.

        Raises:
            ValueError: the recording has no valid configuration or table.
        """
        if stream.startswith("remote/"):
            self._remote(origin)
        else:
            self._operator(origin)

    def take(self, stream: str, origin: str, time_s: float, payload: bytes) -> None:
        """Take one message of an open site, in order of time."""
        match stream:
            case "remote/sensed":
                for line in self._remote(origin).sensed(time_s, payload):
                    self._identification.write(json.dumps(line) + "\n")
            case "remote/touch":
                self._remote(origin).touch(time_s, payload)
            case "operator/touch":
                self._operator(origin).touch(payload)
            case "operator/coupling":
                self._operator(origin).coupling(payload)
            case "operator/input":
                self._write(time_s, self._operator(origin).input(payload))
            case "operator/rendered":
                self._operator(origin).rendered(time_s, payload)

    def identify_without_waiting(self, done: _Done) -> None:
        """Identify again without waiting if solutions waited for late ticks, and find the touches that differ."""
        whole = {
            origin: open_remote(self._session, origin, waits=False)
            for origin, site in self._remotes.items()
            if site.postponed
        }
        if not whole:
            return
        for _, origin, time_ns, payload in self._session.messages((_SENSED,)):
            if origin in whole:
                whole[origin].sensed((time_ns - self._session.start_ns) * 1e-9, payload)
            done.one_more()
        self._changed = {origin: self._remotes[origin].named.changed(site.named) for origin, site in whole.items()}

    def result(self) -> dict[str, Any]:
        """Return the results for each recording of the session."""
        return {
            "remote": {
                origin or "remote": {
                    "ticks": site.ticks,
                    **_compared("touch_packets", site.packets),
                    "postponed": site.postponed,
                    "changed_by_waiting": self._changed.get(origin, []),
                }
                for origin, site in self._remotes.items()
            },
            "operator": {
                origin or "operator": {
                    "ticks": site.ticks,
                    **_compared("rendered_rows", site.rows),
                    "missing_touch_packets": len(site.missing_touches),
                }
                for origin, site in self._operators.items()
            },
        }

    def _remote(self, origin: str) -> RemoteReplay:
        if origin not in self._remotes:
            self._remotes[origin] = open_remote(self._session, origin)
        return self._remotes[origin]

    def _operator(self, origin: str) -> OperatorReplay:
        if origin not in self._operators:
            self._operators[origin] = open_operator(self._session, origin)
            if not self._fingers:
                self._fingers = _fingers(self._session, origin)
                columns = [f"{finger}_{column}" for finger in self._fingers for column in COLUMNS]
                self._rendering.writerow(["time_s", *columns, "fault"])
        return self._operators[origin]

    def _write(self, time_s: float, output: GatedOutput) -> None:
        row: list[object] = [time_s]
        for finger in map(FINGERS.index, self._fingers):
            row += [output.force_n[finger], output.motor_rpm[finger], output.plate_set_c[finger]]
            row.append(output.peltier_drive[finger])
        self._rendering.writerow([*row, fault_text(output.fault)])


def open_remote(session: RecordedSession, origin: str, *, waits: bool = True) -> RemoteReplay:
    """Return the replay of a remote site with its recorded configuration and calibration.

    Args:
        session: the recording.
        origin: origin of the site's part of it.
        waits: whether solutions wait for late ticks, as in the session.

    Raises:
        ValueError: the recording has no valid configuration or table.
    """
    materials = session.table(origin, "materials", MaterialTable)
    surfaces = session.table(origin, "surfaces", SurfaceTable)
    period_s = 1.0 / _configured(session, origin).rate_hz if waits else math.inf
    return RemoteReplay(_fingers(session, origin), materials, surfaces, period_s)


def open_operator(session: RecordedSession, origin: str) -> OperatorReplay:
    """Return the replay of an operator site; raises ValueError if the recording has no valid configuration."""
    configured = _configured(session, origin)
    return OperatorReplay(configured.rendering, 1.0 / configured.rate_hz, configured.link.gap_s)


class _Link(BaseModel):
    gap_s: Annotated[float, Field(gt=0.0)] = GAP_S


class _Configured(BaseModel):
    """Fields of a site's configuration that its computation depends on."""

    fingers: list[str] = list(FINGERS)
    rate_hz: Annotated[float, Field(gt=0.0)] = OperatorConfig.model_fields["rate_hz"].default
    rendering: RenderingConfig = RenderingConfig()
    link: _Link = _Link()


def _configured(session: RecordedSession, origin: str) -> _Configured:
    try:
        return _Configured.model_validate(session.configuration(origin))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise ValueError(f"{session.path}: its configuration cannot be used: {where}: {first['msg']}") from None


def _fingers(session: RecordedSession, origin: str) -> list[str]:
    chosen = _configured(session, origin).fingers
    return [finger for finger in FINGERS if finger in chosen]


def _compared(what: str, comparison: Comparison) -> dict[str, object]:
    return {
        what: comparison.compared,
        "identical": comparison.identical,
        "first_difference": comparison.first_difference,
    }
