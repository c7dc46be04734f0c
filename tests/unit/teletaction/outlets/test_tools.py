"""The contract of all live outlets, each tried with its tool's own reader: the names and values of the export."""

import json
import os
import socket
import struct
import subprocess
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from contextlib import closing, suppress
from pathlib import Path

import pytest

from teletaction.export.columns import columns_of
from teletaction.export.log_entries import log_entry
from teletaction.export.named_recording import NamedMessage
from teletaction.export.topics import TOPICS
from teletaction.outlets.detached import Outlet
from teletaction.outlets.live_messages import FED_TOPICS
from teletaction.outlets.outlet import TOOLS, chosen_place
from tests.unit.teletaction.outlets.readers import (
    NUMBERS,
    FoxgloveReader,
    LslReader,
    Reader,
    connected,
    lsl_on_this_machine,
    numbers,
)

pytestmark = [pytest.mark.exports, pytest.mark.timeout(120)]

SITE = "curve:test-of-outlets"
BATCH = 100
"""Messages that are offered at once, less than Foxglove's backlog."""
ROUNDS = 10
"""Times that the session is offered to a reader that does not read."""


@pytest.fixture(scope="session", autouse=True)
def only_this_machine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with lsl_on_this_machine(tmp_path_factory.mktemp("lsl")):
        yield


@pytest.fixture(params=TOOLS)
def tool(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def outlet(tool: str) -> Iterator[Outlet]:
    place = chosen_place(tool, SITE, None, None if TOOLS[tool].port is None else 0, open_to_network=True)
    with closing(TOOLS[tool].load()(place)) as outlet:
        yield outlet


@pytest.fixture
def reader(tool: str, outlet: Outlet, tmp_path: Path) -> Iterator[Reader]:
    with connected(tool, outlet.address, tmp_path) as reader:
        yield reader


def offer(outlet: Outlet, messages: Sequence[NamedMessage], reader: Reader) -> Counter[str]:
    """Offer messages at the reader's speed; their number by topic."""
    counts: Counter[str] = Counter()
    for start in range(0, len(messages), BATCH):
        batch = messages[start : start + BATCH]
        outlet.offer(batch)
        counts.update(message.topic for message in batch)
        reader.until(counts)
    return counts


def test_a_reader_receives_every_number_under_its_name(
    outlet: Outlet, reader: Reader, exported: list[NamedMessage]
) -> None:
    received = reader.finish(offer(outlet, exported, reader), outlet)
    expected: dict[str, list[float]] = defaultdict(list)
    for message in exported:
        for path, value in numbers(message.topic, message.fields).items():
            expected[path].append(value)
    assert received.curves == expected
    for topic, times_ns in received.times_ns.items():
        sent = [(each.wall_ns if reader.wall_clock else each.monotonic_ns) for each in exported if each.topic == topic]
        assert times_ns == pytest.approx(sent, abs=1000)


def test_the_log_has_the_entries_of_the_export(outlet: Outlet, reader: Reader, exported: list[NamedMessage]) -> None:
    events = [message for message in exported if log_entry(message) is not None]
    said = [f"{message.topic}: {entry['message']}" for message in events if (entry := log_entry(message))]
    assert len(said) >= 2
    received = reader.finish(offer(outlet, events, reader), outlet)
    assert len(received.log) == len(said)
    assert all(whole.endswith(text) for whole, text in zip(said, received.log, strict=True))


@pytest.mark.parametrize("tool", ["foxglove"], indirect=True)
def test_foxglove_has_the_schemas_of_the_export_and_accepts_nothing(outlet: Outlet, reader: FoxgloveReader) -> None:
    schemas = {each["topic"]: json.loads(each["schema"]) for each in reader.channels.values()}
    assert schemas.keys() == {f"/{topic}" for topic in (*FED_TOPICS, "log")}
    assert all(schemas[f"/{topic}"] == TOPICS[topic].schema for topic in FED_TOPICS)
    assert {(each["encoding"], each["schemaEncoding"]) for each in reader.channels.values()} == {("json", "jsonschema")}
    assert reader.info["capabilities"] == []


@pytest.mark.parametrize("tool", ["lsl"], indirect=True)
def test_an_lsl_stream_describes_its_channels(outlet: Outlet, reader: LslReader) -> None:
    for topic in FED_TOPICS:
        columns = columns_of(topic)
        for stream, texts in ((topic, False), (f"{topic}/text", True)):
            chosen = {name: each for name, each in columns.items() if (each["type"] not in NUMBERS) is texts}
            assert (stream in reader.inlets) is bool(chosen)
            if chosen:
                described = reader.description(stream)
                assert described.get_channel_labels() == list(chosen)
                assert described.get_channel_units() == [each.get("unit", "none") for each in chosen.values()]
                assert described.source_id() == f"{SITE} {stream}"
    assert reader.description("log").type() == "Markers"


@pytest.mark.parametrize("tool", ["lsl"], indirect=True)
def test_lsl_has_the_texts_of_a_message(outlet: Outlet, reader: LslReader, exported: list[NamedMessage]) -> None:
    touch = [message for message in exported if message.topic == "operator/touch"][-1]
    outlet.offer([touch])
    sample, _ = reader.inlets["operator/touch/text"].pull_sample(10.0)
    texts = dict(zip(reader.description("operator/touch/text").get_channel_labels(), sample, strict=True))
    assert texts["state"] == touch.fields["state"]
    assert texts["index.material"] == touch.fields["index"]["material"]


def ports(outlet: Outlet) -> list[int]:
    """Ports on which an outlet of this process listens."""
    lines = [line.split() for line in Path("/proc/self/net/tcp").read_text("ascii").splitlines()[1:]]
    own = {os.readlink(link) for link in Path("/proc/self/fd").iterdir() if link.is_symlink()}
    return [int(line[1].split(":")[1], 16) for line in lines if line[3] == "0A" and f"socket:[{line[9]}]" in own]


def test_what_a_reader_sends_changes_nothing(
    tool: str, outlet: Outlet, exported: list[NamedMessage], tmp_path: Path
) -> None:
    """Neither bytes of no protocol at any port, nor requests to act, end or alter the outlet."""
    asked = {"op": "advertise", "channels": [{"id": 1, "topic": "/cmd", "encoding": "json", "schemaName": ""}]}
    junk = (b"\x00" * 100_000, b"GET / HTTP/1.1\r\n\r\n", b"LSL:streamfeed/110 x\r\n\r\n", bytes(range(256)) * 100)
    found = ports(outlet)
    assert found
    for port in found:
        for sent in junk:
            with socket.create_connection(("127.0.0.1", port), timeout=5.0) as connection, suppress(OSError):
                connection.sendall(sent)
    with connected(tool, outlet.address, tmp_path) as reader:
        if isinstance(reader, FoxgloveReader):
            reader.socket.send(json.dumps(asked))
            reader.socket.send(struct.pack("<BI", 1, 1) + b"{}")
            reader.socket.send("{")
        counts = offer(outlet, exported[:BATCH], reader)
        counted = {topic: count for topic, count in counts.items() if topic in reader.topics}
        assert reader.finish(counts, outlet).counts == counted


def test_a_reader_that_stops_reading_delays_nobody(
    tool: str, outlet: Outlet, exported: list[NamedMessage], tmp_path: Path
) -> None:
    """The outlet takes messages faster than a session sends them, and another reader receives what comes then."""
    with connected(tool, outlet.address, tmp_path / "stalled") as stalled:
        stalled.stall()
        begun_s = time.monotonic()
        for _ in range(ROUNDS):
            outlet.offer(exported)
        took_s = time.monotonic() - begun_s
        assert took_s < ROUNDS * (exported[-1].monotonic_ns - exported[0].monotonic_ns) * 1e-9
        with connected(tool, outlet.address, tmp_path / "reading") as reader:
            counts = offer(outlet, exported, reader)
            received = reader.finish(counts, outlet)
            assert all(received.counts[topic] >= counts[topic] for topic in counts.keys() & reader.topics)


def test_a_missing_library_of_lsl_is_one_line(tmp_path: Path, configs: dict[str, Path]) -> None:
    broken = tmp_path / "liblsl.so"
    broken.write_text("no library", "utf-8")
    words = [sys.executable, "-m", "teletaction", "outlet", "--to", "lsl", "--open-to-network"]
    ended = subprocess.run(
        [*words, "--config", str(configs["operator"])],
        env=os.environ | {"PYLSL_LIB": str(broken)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ended.returncode == 2
    assert ended.stderr.splitlines()[-1].startswith("teletaction: needs liblsl")
