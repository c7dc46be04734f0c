"""Each tool's own reader of a live outlet, with what it received by name."""

import json
import os
import signal
import struct
import subprocess
import threading
import warnings
from abc import ABC, abstractmethod
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import pytest

from teletaction.export.columns import columns_of, row_of
from teletaction.outlets.detached import Outlet
from teletaction.outlets.live_messages import FED_TOPICS
from tests.waiting import wait_until

NUMBERS = ("number", "integer", "boolean")
PATIENCE_S = 20.0
EVERY_S = 0.1
"""Between two looks at a file, s."""
LSL_SETTINGS = """
[ports]
IPv6 = disable
[multicast]
ResolveScope = machine
AddressesOverride = {127.0.0.1}
[lab]
KnownPeers = {127.0.0.1}
[log]
level = -3
"""
"""Settings with which LSL sends to this machine only, and logs nothing but its end."""

_TYPES = {topic: {each["type"] for each in columns_of(topic).values()} for topic in FED_TOPICS}
LSL_NAMES = {
    topic: [topic] * bool(types & {*NUMBERS}) + [f"{topic}/text"] * bool(types - {*NUMBERS})
    for topic, types in _TYPES.items()
}
"""Names of the LSL streams of each topic: of its numbers, and of its texts."""


def numbers(topic: str, fields: dict[str, Any]) -> dict[str, float]:
    """Known numbers of a message by the path of their curve, such as `operator/touch/index/object_c`."""
    row = row_of(topic, fields)
    chosen = (name for name, schema in columns_of(topic).items() if schema["type"] in NUMBERS)
    return {f"{topic}/{name.replace('.', '/')}": float(row[name]) for name in chosen if row[name] is not None}


@dataclass
class Received:
    """What a reader received.

    Attributes:
        counts: messages of each topic.
        curves: values of each number by its path, oldest first; unknown ones are left out.
        times_ns: times of the messages of each topic.
        log: texts of the log.
    """

    counts: Counter[str] = field(default_factory=Counter)
    curves: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    times_ns: dict[str, list[int]] = field(default_factory=lambda: defaultdict(list))
    log: list[str] = field(default_factory=list)

    def add(self, topic: str, time_ns: int, fields: dict[str, Any]) -> None:
        """Add one message."""
        self.counts[topic] += 1
        self.times_ns[topic].append(time_ns)
        for path, value in numbers(topic, fields).items():
            self.curves[path].append(value)


class Reader(ABC):
    """A connected reader."""

    wall_clock = True
    """Whether times are of the wall clock; else of the monotonic one."""
    topics = frozenset(FED_TOPICS)
    """Topics whose messages it counts."""

    def __init__(self) -> None:
        self.received = Received()

    @abstractmethod
    def until(self, counts: Mapping[str, int]) -> None:
        """Wait until this number of messages of each topic is there, where the tool shows that while it runs."""

    @abstractmethod
    def finish(self, counts: Mapping[str, int], outlet: Outlet) -> Received:
        """Wait until this number of messages of each topic is there, and end the outlet."""

    @abstractmethod
    def stall(self) -> None:
        """Stay connected, and read nothing more."""

    def __enter__(self) -> Self:
        return self

    @abstractmethod
    def __exit__(self, *_: object) -> None: ...


class FoxgloveReader(Reader):
    """A client of the Foxglove WebSocket protocol."""

    HEAD = struct.Struct("<BIQ")
    """Head of a message: opcode 1, number of the subscription, log time in ns."""

    def __init__(self, address: str) -> None:
        from websockets.sync.client import connect
        from websockets.typing import Subprotocol

        super().__init__()
        self._opened = ExitStack()
        self.socket = self._opened.enter_context(connect(address, subprotocols=[Subprotocol("foxglove.sdk.v1")]))
        self.info = json.loads(self.socket.recv(PATIENCE_S))
        self.channels: dict[int, dict[str, Any]] = {}
        while len(self.channels) < len(FED_TOPICS) + 1:
            said = json.loads(self.socket.recv(PATIENCE_S))
            assert said["op"] == "advertise"
            self.channels |= {channel["id"]: channel for channel in said["channels"]}
        subscriptions = [{"id": number, "channelId": number} for number in self.channels]
        self.socket.send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))
        self._stalled = False
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self) -> None:
        from websockets.exceptions import ConnectionClosed

        try:
            for message in self.socket:
                if self._stalled:
                    return
                if isinstance(message, bytes):
                    self._take(message)
        except ConnectionClosed:
            return

    def _take(self, message: bytes) -> None:
        opcode, number, time_ns = self.HEAD.unpack_from(message)
        assert opcode == 1
        topic = self.channels[number]["topic"].removeprefix("/")
        fields = json.loads(message[self.HEAD.size :])
        if topic == "log":
            self.received.log.append(f"{fields['name']}: {fields['message']}")
        else:
            self.received.add(topic, time_ns, fields)

    def until(self, counts: Mapping[str, int]) -> None:
        wait_until(lambda: self.received.counts >= Counter(counts), lambda: str(self.received.counts), PATIENCE_S)

    def finish(self, counts: Mapping[str, int], outlet: Outlet) -> Received:
        self.until(counts)
        outlet.close()
        return self.received

    def stall(self) -> None:
        self._stalled = True

    def __exit__(self, *_: object) -> None:
        self._opened.close()
        self._thread.join()


class RerunReader(Reader):
    """Rerun's own command, which stores what a viewer would show."""

    topics = frozenset(
        topic for topic in FED_TOPICS if any(each["type"] in NUMBERS for each in columns_of(topic).values())
    )

    def __init__(self, address: str, folder: Path) -> None:
        import rerun_cli

        super().__init__()
        self._file = folder / "stored.rrd"
        words = [Path(rerun_cli.__file__).with_name("rerun"), "--save", self._file, address]
        # It also listens itself.
        words += ["--bind", "127.0.0.1", "--port", "0"]
        environment = os.environ | {"DO_NOT_TRACK": "1"}
        self._process = subprocess.Popen(words, env=environment, stderr=subprocess.DEVNULL)
        try:
            wait_until(self._read, "no connection", PATIENCE_S, EVERY_S)
        except AssertionError:
            self.__exit__()
            raise

    def _read(self) -> bool:
        """Read the file; whether the recording has begun in it."""
        try:
            chunks = rerun_chunks(self._file)
        except (OSError, RuntimeError, ValueError):
            return False  # Its last message is not whole yet.
        self.received = from_rerun(chunks)
        return bool(chunks)

    def until(self, counts: Mapping[str, int]) -> None:
        """An outlet sends groups: the last one is complete at its end."""

    def finish(self, counts: Mapping[str, int], outlet: Outlet) -> Received:
        outlet.close()
        wanted = Counter({topic: count for topic, count in counts.items() if topic in self.topics})
        wait_until(
            lambda: self._read() and self.received.counts >= wanted,
            lambda: f"{self.received.counts} of {wanted}",
            PATIENCE_S,
            EVERY_S,
        )
        return self.received

    def stall(self) -> None:
        self._process.send_signal(signal.SIGSTOP)

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()


def rerun_chunks(path: Path) -> list[Any]:
    """Read all chunks of a file of Rerun, which may still be written."""
    from rerun.chunk import RrdReader

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "RRD file has no footer")
        return list(RrdReader(path).stream().to_chunks())


def from_rerun(chunks: list[Any]) -> Received:
    """The curves and texts of chunks."""
    found = Received()
    points: dict[str, list[tuple[int, float]]] = defaultdict(list)
    texts: list[tuple[int, str]] = []
    for chunk in chunks:
        batch = chunk.to_record_batch()
        columns = dict(zip(batch.schema.names, batch.columns, strict=True))
        if "time" not in columns:
            continue
        times_ns = columns["time"].cast("int64").to_pylist()
        for name, column in columns.items():
            if name.endswith("Scalars:scalars"):
                cells = [cell[0] for cell in column.to_pylist()]
                points[str(chunk.entity_path).removeprefix("/")] += zip(times_ns, cells, strict=True)
            elif name.endswith("TextLog:text"):
                texts += zip(times_ns, (cell[0] for cell in column.to_pylist()), strict=True)
    for path, values in points.items():
        values.sort(key=lambda point: point[0])
        found.curves[path] = [value for _, value in values]
        topic = next(topic for topic in FED_TOPICS if path.startswith(f"{topic}/"))
        found.times_ns[topic] = max(found.times_ns[topic], [time_ns for time_ns, _ in values], key=len)
        found.counts[topic] = len(found.times_ns[topic])
    found.log = [text for _, text in sorted(texts, key=lambda text: text[0])]
    return found


class LslReader(Reader):
    """An inlet for each stream."""

    wall_clock = False

    def __init__(self, site: str) -> None:
        import pylsl

        super().__init__()
        names = {name for topic in FED_TOPICS for name in LSL_NAMES[topic]} | {"log"}
        infos = pylsl.resolve_bypred(f"starts-with(source_id,'{site} ')", len(names), PATIENCE_S)
        found = {info.name(): info for info in infos}
        assert found.keys() == names
        self.inlets = {name: pylsl.StreamInlet(info, recover=False) for name, info in found.items()}
        for inlet in self.inlets.values():
            inlet.open_stream(PATIENCE_S)

    def description(self, name: str) -> Any:
        """The description of a stream."""
        return self.inlets[name].info(PATIENCE_S)

    def until(self, counts: Mapping[str, int]) -> None:
        """Samples wait in the inlets."""

    def finish(self, counts: Mapping[str, int], outlet: Outlet) -> Received:
        for topic, count in counts.items():
            stream = LSL_NAMES[topic][0]
            samples, times_s = self._samples(stream, count)
            self.received.counts[topic] = len(samples)
            self.received.times_ns[topic] = [round(time_s * 1e9) for time_s in times_s]
            if stream == topic:
                labels = self.description(stream).get_channel_labels()
                for name, values in zip(labels, zip(*samples, strict=True), strict=True):
                    known = [value for value in values if value == value]
                    if known:
                        self.received.curves[f"{topic}/{name.replace('.', '/')}"] = known
        samples, _ = self.inlets["log"].pull_chunk(1.0)
        self.received.log = [text for (text,) in samples]
        outlet.close()
        return self.received

    def _samples(self, stream: str, count: int) -> tuple[list[list[Any]], list[float]]:
        samples: list[list[Any]] = []
        times_s: list[float] = []

        def complete() -> bool:
            some, at_s = self.inlets[stream].pull_chunk(0.2, 4096)
            samples.extend(some)
            times_s.extend(at_s)
            return len(samples) >= count

        wait_until(complete, lambda: f"{stream}: {len(samples)} of {count}", PATIENCE_S)
        return samples, times_s

    def stall(self) -> None:
        """Nothing pulls samples until then."""

    def __exit__(self, *_: object) -> None:
        for inlet in self.inlets.values():
            inlet.close_stream()


def connected(tool: str, address: str, folder: Path) -> Reader:
    """A reader of a tool's outlet; it writes only into `folder`."""
    folder.mkdir(exist_ok=True)
    match tool:
        case "foxglove":
            return FoxgloveReader(address)
        case "rerun":
            return RerunReader(address, folder)
    return LslReader(address)


@contextmanager
def lsl_on_this_machine(folder: Path) -> Iterator[None]:
    """Keep LSL of this process and of those that it starts on loopback, and quiet. LSL reads its settings once."""
    settings = folder / "lsl_api.cfg"
    settings.write_text(LSL_SETTINGS, "utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LSLAPICFG", str(settings))
        yield
