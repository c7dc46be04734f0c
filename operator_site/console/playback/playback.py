"""Plays the messages of a recording to a console at a speed, with pause and jumps.

The shown state depends on all earlier messages. A jump restores the nearest earlier checkpoint of the console and plays
the messages since, which gives the same state as playing from the start. Where that takes long, a preview shows the
moment first: it has session, findings and the last messages, and lacks map and older signals until it is completed.
"""

import pickle
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from common.faults.texts import said_fault
from common.link.session_display import CONNECTED, DISCONNECTED, ENGAGED, FAULT, LOST, PAUSED, STOPPED
from common.link.session_state import Happening
from common.privacy.recording_file import open_recording
from common.recording.reader import RecordingReader
from common.recording.recorded_fields import map_of, read_map
from common.recording.recorded_row import Finite, Whole
from operator_site.console.model import Console

STREAMS = (
    "operator/touch",
    "operator/rendered",
    "operator/skin",
    "operator/clock",
    "operator/session",
    "operator/coupling",
    "operator/played",
    "operator/figures",
    "remote/patient",
    "console/session",
    "console/finding",
    "console/alarm",
    "console/act",
)
"""Streams that a console shows, live or from a recording."""
CAMERA = "console/camera"
"""Stream of the camera's pictures, which a console relays beside its own state."""
VOICE = "console/voice"
"""Stream of the sounds of both sides."""
SPEEDS = (0.5, 8.0)
"""Slowest and fastest speed, as multiples of the recorded one."""
CHECKPOINT_S = 2.0
"""Interval between two checkpoints, s; longer for more than MOST_CHECKPOINTS."""
MOST_CHECKPOINTS = 400
"""Maximum number of checkpoints."""
PREVIEW_S = 1.2
"""Part of the recording before a moment that a preview plays, s; the site's figures come once a second."""
_FEW = ("console/session", "console/finding", "operator/session", "operator/coupling", "remote/patient")
"""Streams of few messages, which a preview takes from the start."""
_COMPRESSION = 1
"""Level of compression of a checkpoint, 0..9."""


Message = tuple[str, int, bytes]
"""Stream, time, ns, and payload."""


class Mark(NamedTuple):
    """A target for a jump: `kind` is "alarm", "clutch", "fault", "finding" or "mode"; `at_s` is from the start, s.

    The text of a mode is the session's state from then on, a word of `session_display`.
    """

    at_s: float
    kind: str
    text: str


class Recording:
    """The messages of a merged recording that a console shows.

    Attributes:
        name: name of the file.
        start_ns, end_ns: times of the first and last message.
    """

    def __init__(self, path: Path) -> None:
        """Open a file.

        Raises:
            ValueError: it is no complete recording, is damaged, or has no stream that a console shows.
            OSError: it cannot be read.
        """
        self._file = open_recording(path)
        try:
            self._reader = RecordingReader(path, self._file)
            if not self._reader.counts.keys() & set(STREAMS):
                raise ValueError(f"{path}: has none of the streams that a console shows; give it a session.mcap")
        except ValueError:
            self._file.close()
            raise
        self.name = path.name
        self.start_ns = self._reader.start_ns
        self.end_ns = self._reader.end_ns

    @property
    def length_s(self) -> float:
        """Length of the recording, s."""
        return (self.end_ns - self.start_ns) * 1e-9

    def messages(self, from_ns: int, streams: tuple[str, ...] = STREAMS) -> Iterator[Message]:
        """Yield stream, time and payload of each message from `from_ns` on, in order of time."""
        for _, channel, message in self._reader.messages(streams, from_ns):
            yield channel.topic, message.log_time, message.data

    def has(self, stream: str) -> bool:
        """Return whether the recording has messages of a stream, such as CAMERA or VOICE."""
        return bool(self._reader.counts.get(stream))

    def marks(self) -> list[Mark]:
        """Return the readable alarms, faults, findings, changes of clutch and scale, and modes, in order of time.

        A finding has its mark's time.
        """
        marks: dict[object, Mark] = {}
        mode, examinations = DISCONNECTED, 0
        for stream, time_ns, payload in self.messages(self.start_ns, tuple(_MARKED)):
            with suppress(ValueError):  # the console counts unreadable messages
                entry = _MARKED[stream](payload)
                at_s = (time_ns - self.start_ns) * 1e-9
                match stream:
                    case "console/finding":
                        marked_s = entry["at_s"] - self.start_ns * 1e-9
                        text = f"{entry['id']}: {entry['text']}{', withdrawn' if entry.get('withdrawn') else ''}"
                        # Each examination numbers its findings from 1.
                        marks["finding", examinations, entry["id"]] = Mark(marked_s, "finding", text)
                    case "console/session":
                        examinations += entry["what"] == "begin"
                    case "console/alarm":
                        marks.setdefault(("alarm", entry["id"], entry["since_s"]), Mark(at_s, "alarm", entry["text"]))
                    case _:
                        if entry.what == "fault":
                            marks["fault", time_ns] = Mark(at_s, "fault", said_fault(entry.fault))
                        if entry.what in ("clutch", "scale"):
                            marks[entry.what, time_ns] = Mark(at_s, "clutch", f"{entry.what} {entry.text}")
                        # The outcome of a stop is noted later, also after the stop was cleared.
                        if entry.what in _MODES and (entry.what != "estop" or mode in (FAULT, STOPPED)):
                            mode = _MODES[entry.what]
                            marks["mode", time_ns] = Mark(at_s, "mode", mode)
        return sorted(marks.values())

    def examinations(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield the records of the begin and end of each examination with their times, ns."""
        for _, time_ns, payload in self.messages(self.start_ns, ("console/session",)):
            with suppress(ValueError):
                yield time_ns, read_map(payload, _EXAMINATION)

    def title(self) -> str:
        """Return pseudonym and begin of the examination, as far as recorded, or the name of the file."""
        for _, entry in self.examinations():
            if entry["what"] == "begin":
                return " ".join(entry[name] for name in ("pseudonym", "wall_clock") if entry.get(name))
        return self.name

    def close(self) -> None:
        """Close the file."""
        self._file.close()


_EXAMINATION = map_of(what=str, pseudonym=str | None, wall_clock=str | None)
_MARKED: dict[str, Callable[[bytes], Any]] = {
    "console/finding": partial(read_map, fields=map_of(id=Whole, at_s=Finite, text=str)),
    "console/alarm": partial(read_map, fields=map_of(id=str, since_s=Finite, text=str)),
    "console/session": partial(read_map, fields=_EXAMINATION),
    "operator/session": Happening.unpack,
}
_MODES = {
    "connected": CONNECTED,
    "engaged": ENGAGED,
    "heard": ENGAGED,
    "disengaged": PAUSED,
    "silent": LOST,
    "fault": FAULT,
    "estop": STOPPED,
    "cleared": PAUSED,
    "disconnected": DISCONNECTED,
    "left": DISCONNECTED,
}
"""State of the session after each happening."""


class Playback:
    """Plays a recording to a console. The wall clock is an argument, s, of any origin.

    Attributes:
        console: state of the console at the present moment; another object after each jump.
        jumps: number of jumps; after each one the whole console must be shown again.
        speed: speed of playing, within SPEEDS.
        playing: whether the recording plays.
        partial: whether the console shows a preview.
        length_s, marks, title: length, marks and title of the recording.
        checkpoints: state of the console at each multiple of the checkpoint interval after the start.
    """

    def __init__(self, recording: Recording, make: Callable[[], Console]) -> None:
        self._recording = recording
        self._make = make
        every_s = max(CHECKPOINT_S, recording.length_s / MOST_CHECKPOINTS)
        self._every_ns = round(every_s * 1e9)
        self.checkpoints: list[bytes] = []
        self._scout: tuple[Console, Iterator[Message], Message | None] | None = None
        self._waiting: Message | None = None
        self._coming: tuple[Console, Iterator[Message]] | None = None
        """The whole console on its way to the present moment, while a preview is shown."""
        self.length_s, self.marks, self.title = recording.length_s, recording.marks(), recording.title()
        self._few = list(recording.messages(recording.start_ns, _FEW))
        self.partial = False
        self.jumps = -1
        self.speed = 1.0
        self.playing = False
        self._anchor = (0.0, recording.start_ns)
        self._go_to(recording.start_ns)

    @property
    def now_ns(self) -> int:
        """Present moment on the clock of the recording, ns."""
        return self._now_ns

    @property
    def now_s(self) -> float:
        """Present moment on the clock of the recording, s."""
        return self._now_ns * 1e-9

    @property
    def at_s(self) -> float:
        """Present moment from the start, s."""
        return (self._now_ns - self._recording.start_ns) * 1e-9

    def play(self, wall_s: float, speed: float = 1.0) -> None:
        """Play from the present moment, at the end from the start; a speed outside SPEEDS becomes the nearest end."""
        self.step(wall_s)
        if self._now_ns >= self._recording.end_ns:
            self._go_to(self._recording.start_ns)
        self.speed = min(max(speed, SPEEDS[0]), SPEEDS[1])
        self.playing = True
        self._anchor = (wall_s, self._now_ns)

    def pause(self, wall_s: float) -> None:
        """Stop at the present moment."""
        self.step(wall_s)
        self.playing = False

    def seek(self, at_s: float, wall_s: float) -> None:
        """Jump to a moment, s from the start; a moment outside the recording becomes the nearest end."""
        self._go_to(self._moment_ns(at_s))
        self._anchor = (wall_s, self._now_ns)

    def _moment_ns(self, at_s: float) -> int:
        """Return a moment, s from the start, on the recording's clock and within it."""
        start_ns, end_ns = self._recording.start_ns, self._recording.end_ns
        return min(max(start_ns + round(at_s * 1e9), start_ns), end_ns)

    def preview(self, at_s: float, wall_s: float) -> None:
        """Jump to a moment as `seek` does, but show a preview of it."""
        recording, target = self._recording, self._moment_ns(at_s)
        from_ns = max(recording.start_ns, target - round(PREVIEW_S * 1e9))
        self.jumps += 1
        self.partial, self._coming = True, None
        self.console = self._make()
        for message in self._few:
            if message[1] < from_ns:
                self.console.take(*message)
        self._messages, self._waiting = recording.messages(from_ns), None
        self._take_until(target)
        self._anchor = (wall_s, self._now_ns)

    def complete(self, most: int) -> None:
        """Take up to `most` messages towards the whole state of the present moment, and show it once it is reached.

        All checkpoints before the present moment must exist.
        """
        if self._coming is None:
            console, from_ns = self._restore((self._now_ns - self._recording.start_ns) // self._every_ns)
            self._coming = console, self._recording.messages(from_ns)
        console, messages = self._coming
        for message in islice(messages, most):
            if message[1] > self._now_ns:
                self._show(console, messages, message)
                return
            console.take(*message)
            most -= 1
        if most:
            self._show(console, messages, None)  # the recording's end

    def _show(self, console: Console, messages: Iterator[Message], waiting: Message | None) -> None:
        self.console, self._messages, self._waiting = console, messages, waiting
        self.partial, self._coming = False, None
        self.jumps += 1

    def step(self, wall_s: float) -> None:
        """Play up to the present wall clock."""
        if not self.playing:
            return
        since_s, from_ns = self._anchor
        target = from_ns + round(max(0.0, wall_s - since_s) * self.speed * 1e9)
        self._take_until(min(target, self._recording.end_ns))
        self.playing = self._now_ns < self._recording.end_ns

    @property
    def dense(self) -> bool:
        """Whether a jump plays CHECKPOINT_S of the recording at most, once the checkpoints exist."""
        return self._every_ns <= round(CHECKPOINT_S * 1e9)

    def ready(self, at_s: float) -> bool:
        """Return whether all checkpoints before a moment exist; a jump then plays one interval at most."""
        return len(self.checkpoints) >= round(max(0.0, min(at_s, self.length_s)) * 1e9) // self._every_ns

    def prepare(self) -> bool:
        """Make the next checkpoint; return False if all exist.

        Another process may make them; its `checkpoints` are then appended here in order.
        """
        next_ns = self._recording.start_ns + (len(self.checkpoints) + 1) * self._every_ns
        if next_ns > self._recording.end_ns:
            self._scout = None
            return False
        if self._scout is None:
            console, from_ns = self._restore(len(self.checkpoints))
            self._scout = console, self._recording.messages(from_ns), None
        console, messages, waiting = self._scout
        waiting = _give(console, messages, waiting, next_ns)
        self._scout = console, messages, waiting
        self.checkpoints.append(zlib.compress(pickle.dumps(console, pickle.HIGHEST_PROTOCOL), _COMPRESSION))
        return True

    def _go_to(self, target_ns: int) -> None:
        """Bring the console to a moment by all messages up to and including it."""
        self.jumps += 1
        self.partial, self._coming = False, None
        number = (target_ns - self._recording.start_ns) // self._every_ns
        while len(self.checkpoints) < number and self.prepare():
            pass
        self.console, from_ns = self._restore(min(number, len(self.checkpoints)))
        self._messages = self._recording.messages(from_ns)
        self._waiting = None
        self._take_until(target_ns)

    def _restore(self, number: int) -> tuple[Console, int]:
        """Return the console at the time of checkpoint `number`, and that time, ns."""
        from_ns = self._recording.start_ns + number * self._every_ns
        if number == 0:
            return self._make(), from_ns
        console: Console = pickle.loads(zlib.decompress(self.checkpoints[number - 1]))
        return console, from_ns

    def _take_until(self, target_ns: int) -> None:
        self._waiting = _give(self.console, self._messages, self._waiting, target_ns + 1)
        self._now_ns = target_ns


def _give(console: Console, messages: Iterator[Message], waiting: Message | None, before_ns: int) -> Message | None:
    """Give a console all messages before a time, the waiting one first; return the next one, or None at the end."""
    while (message := waiting or next(messages, None)) is not None:
        if message[1] >= before_ns:
            return message
        console.take(*message)
        waiting = None
    return None
