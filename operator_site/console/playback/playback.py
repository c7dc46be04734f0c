"""A recording as a source of the messages that a console gets live: played at a speed, paused, and entered anywhere.

What a console shows at a moment follows from all messages before it. To jump, the nearest earlier checkpoint of the
console is taken up again, and the messages since are given to it: it comes to the same state as by playing.
"""

import pickle
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from common.faults.texts import said_fault
from common.link.session_state import Happening
from common.recording.reader import RecordingReader
from common.recording.recorded_fields import Fits, maybe, number, read_map, text, whole

STREAMS = (
    "operator/touch",
    "operator/rendered",
    "operator/skin",
    "operator/clock",
    "operator/session",
    "operator/played",
    "operator/figures",
    "console/session",
    "console/finding",
    "console/alarm",
    "console/act",
)
"""What a console is made of, live or from a recording."""
SPEEDS = (0.5, 8.0)
CHECKPOINT_S = 2.0
MOST_CHECKPOINTS = 400
"""A longer recording has them farther apart."""
_COMPRESSION = 1


class Console(Protocol):
    """What is played to. It keeps nothing of the file or the clock, so that it can be pickled."""

    def take(self, stream: str, time_ns: int, payload: bytes) -> None:
        """Take one message of the recording's time."""


C = TypeVar("C", bound=Console)


class Mark(NamedTuple):
    """Something to jump to: `kind` is "alarm", "fault" or "finding"; `at_s` since the recording's start."""

    at_s: float
    kind: str
    text: str


class Recording:
    """The messages of a merged recording that concern a console.

    Attributes:
        name: of the file.
        start_ns, end_ns: times of its first and last message.
    """

    def __init__(self, path: Path) -> None:
        """Open it.

        Raises:
            ValueError: it is no whole recording, is damaged, or has nothing that a console shows.
            OSError: it cannot be read.
        """
        self._file = path.open("rb")
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
        """How long it is, s."""
        return (self.end_ns - self.start_ns) * 1e-9

    def messages(self, from_ns: int, streams: tuple[str, ...] = STREAMS) -> Iterator[tuple[str, int, bytes]]:
        """Stream, time and payload of each message from `from_ns` on, in order of time."""
        for _, channel, message in self._reader.messages(streams, from_ns):
            yield channel.topic, message.log_time, message.data

    def marks(self) -> list[Mark]:
        """Alarms, faults and findings that can be read, in order of time; each finding at the time of its mark."""
        marks: dict[object, Mark] = {}
        for stream, time_ns, payload in self.messages(self.start_ns, tuple(_MARKED)):
            with suppress(ValueError):  # the console that it is played to says so
                entry = _MARKED[stream](payload)
                at_s = (time_ns - self.start_ns) * 1e-9
                match stream:
                    case "console/finding":
                        marked_s = entry["at_s"] - self.start_ns * 1e-9
                        marks["finding", entry["id"]] = Mark(marked_s, "finding", entry["text"])
                    case "console/alarm":
                        marks.setdefault(("alarm", entry["id"], entry["since_s"]), Mark(at_s, "alarm", entry["text"]))
                    case _ if entry.what == "fault":
                        marks["fault", time_ns] = Mark(at_s, "fault", said_fault(entry.fault))
        return sorted(marks.values())

    def examinations(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """What was recorded of the begin and end of each examination, with its time, ns."""
        for _, time_ns, payload in self.messages(self.start_ns, ("console/session",)):
            with suppress(ValueError):
                yield time_ns, read_map(payload, _EXAMINATION)

    def title(self) -> str:
        """Whose examination it is and when it began, as far as that was recorded; else the file's name."""
        for _, entry in self.examinations():
            if entry["what"] == "begin":
                return " ".join(entry[name] for name in ("pseudonym", "wall_clock") if entry.get(name))
        return self.name

    def close(self) -> None:
        """Close the file."""
        self._file.close()


_MARKED: dict[str, Callable[[bytes], Any]] = {
    "console/finding": lambda payload: read_map(payload, {"id": whole, "at_s": number, "text": text}),
    "console/alarm": lambda payload: read_map(payload, {"id": text, "since_s": number, "text": text}),
    "operator/session": Happening.unpack,
}
_EXAMINATION: dict[str, Fits] = {"what": text, "pseudonym": maybe(text), "wall_clock": maybe(text)}


class Playback(Generic[C]):
    """Plays a recording to a console. The wall clock is an argument, s, of any origin.

    Attributes:
        console: as it was at this moment of the recording; another object after each jump.
        jumps: how often there was a jump; who has shown the console before one has to show all of it anew.
        speed: of playing, within SPEEDS.
        playing: whether time goes on.
        length_s, marks, title: of the recording.
        checkpoints: the console before each multiple of so many seconds after the start, from the first on.
    """

    def __init__(self, recording: Recording, make: Callable[[], C]) -> None:
        """At the start, paused.

        Args:
            recording: what is played.
            make: an empty console.
        """
        self._recording = recording
        self._make = make
        every_s = max(CHECKPOINT_S, recording.length_s / MOST_CHECKPOINTS)
        self._every_ns = round(every_s * 1e9)
        self.checkpoints: list[bytes] = []
        self._scout: tuple[C, Iterator[tuple[str, int, bytes]], tuple[str, int, bytes] | None] | None = None
        self.length_s, self.marks, self.title = recording.length_s, recording.marks(), recording.title()
        self.jumps = -1
        self.speed = 1.0
        self.playing = False
        self._anchor = (0.0, recording.start_ns)
        self._go_to(recording.start_ns)

    @property
    def now_ns(self) -> int:
        """Moment of the recording, on the clock it was recorded by."""
        return self._now_ns

    @property
    def time_s(self) -> float:
        """The same, s."""
        return self._now_ns * 1e-9

    @property
    def at_s(self) -> float:
        """The same since its start, s."""
        return (self._now_ns - self._recording.start_ns) * 1e-9

    def play(self, wall_s: float, speed: float | None = None) -> None:
        """Go on from here; at the end, from the start.

        Raises:
            ValueError: a speed out of range.
        """
        if speed is not None and not SPEEDS[0] <= speed <= SPEEDS[1]:
            raise ValueError(f"speed {speed:g}: choose {SPEEDS[0]:g} to {SPEEDS[1]:g}")
        self.step(wall_s)
        if self._now_ns >= self._recording.end_ns:
            self._go_to(self._recording.start_ns)
        self.speed = self.speed if speed is None else speed
        self.playing = True
        self._anchor = (wall_s, self._now_ns)

    def pause(self, wall_s: float) -> None:
        """Stop here."""
        self.step(wall_s)
        self.playing = False

    def seek(self, at_s: float, wall_s: float) -> None:
        """Jump to a moment, s since the start; one outside the recording is its nearest end."""
        target = self._recording.start_ns + round(at_s * 1e9)
        self._go_to(min(max(target, self._recording.start_ns), self._recording.end_ns))
        self._anchor = (wall_s, self._now_ns)

    def step(self, wall_s: float) -> None:
        """Give the console what has come to pass by now."""
        if not self.playing:
            return
        since_s, from_ns = self._anchor
        target = from_ns + round(max(0.0, wall_s - since_s) * self.speed * 1e9)
        self._take_until(min(target, self._recording.end_ns))
        self.playing = self._now_ns < self._recording.end_ns

    def ready(self, at_s: float) -> bool:
        """Whether all checkpoints before a moment are made: a jump there then takes one checkpoint's messages."""
        return len(self.checkpoints) >= round(max(0.0, min(at_s, self.length_s)) * 1e9) // self._every_ns

    def prepare(self) -> bool:
        """Make the next checkpoint ahead of what is played; returns whether there is more to prepare.

        Where another process does that, its `checkpoints` are put into those here, in order.
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
        """Bring the console to a moment: all messages up to and with it."""
        self.jumps += 1
        number = (target_ns - self._recording.start_ns) // self._every_ns
        while len(self.checkpoints) < number and self.prepare():
            pass
        self.console, from_ns = self._restore(min(number, len(self.checkpoints)))
        self._messages = self._recording.messages(from_ns)
        self._waiting: tuple[str, int, bytes] | None = None
        self._take_until(target_ns)

    def _restore(self, number: int) -> tuple[C, int]:
        """A console as it was before the `number`th checkpoint's time, and that time."""
        from_ns = self._recording.start_ns + number * self._every_ns
        if number == 0:
            return self._make(), from_ns
        console: C = pickle.loads(zlib.decompress(self.checkpoints[number - 1]))
        return console, from_ns

    def _take_until(self, target_ns: int) -> None:
        self._waiting = _give(self.console, self._messages, self._waiting, target_ns + 1)
        self._now_ns = target_ns


def _give(
    console: Console,
    messages: Iterator[tuple[str, int, bytes]],
    waiting: tuple[str, int, bytes] | None,
    before_ns: int,
) -> tuple[str, int, bytes] | None:
    """Give a console all messages before a time, the waiting one first; returns the one that waits then."""
    while (message := waiting or next(messages, None)) is not None:
        if message[1] >= before_ns:
            return message
        console.take(*message)
        waiting = None
    return None
