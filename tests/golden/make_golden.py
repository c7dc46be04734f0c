"""Remakes the expected output of the golden recording: `make golden`, after an intended change of behaviour.

Look at the difference of identification.jsonl before keeping it. The recorded inputs stay as they are. `--record`
records them again: it runs a short session with simulated devices and cuts out the part around the contact.
`--surfaces` replaces the recorded table of surfaces by the shipped one. The recording holds the exact inputs of both
sites and, at 20 Hz, what they compute from the cut inputs alone: the sites of the session also knew earlier inputs.
"""

import json
import shutil
import sys
import tempfile
import tomllib
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import Channel, Schema
from mcap.writer import CompressionType, Writer

from common.wire.messages import TOUCH_COLUMN, Touch
from teletaction.recordings.recorded_session import RecordedSession
from teletaction.replay.replay import open_operator, open_remote, replay
from teletaction.session.demo import run_demo
from teletaction.session.demo_files import SURFACES, DemoOptions

FOLDER = Path(__file__).parent
SECONDS = 6.3
SEED = 2
"""Seed of a session whose contact is identified within the recording."""
BEFORE_S = 0.7
WARMING_S = 5.0
OUTPUT_EVERY = 25
STREAMS = ("remote/sensed", "remote/touch", "operator/touch", "operator/input", "operator/rendered")
Message = tuple[str, str, int, bytes]


def make_golden(record: bool, surfaces: bool) -> None:
    """Write recording and identification beside this file."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        source = record_session(out) if record else FOLDER / "session.mcap"
        if surfaces:
            source = with_shipped_surfaces(source, out / "surfaces.mcap")
        with source.open("rb") as file:
            session = RecordedSession(source, file)
            messages = messages_around_contact(session) if record else list(session.messages(STREAMS))
            write(session, recomputed(session, messages), out / "golden.mcap")
        replay(out / "golden.mcap", out / "golden")
        shutil.copy(out / "golden.mcap", FOLDER / "session.mcap")
        shutil.copy(out / "golden" / "identification.jsonl", FOLDER)


def record_session(out: Path) -> Path:
    """Run the session; its recording, of which a replay is identical."""
    scene = str(FOLDER / "materials.toml")
    options = DemoOptions(seconds=WARMING_S + SECONDS, scene=scene, seed=SEED, fingers=2, out=out)
    failure = run_demo(options)
    if failure:
        sys.exit(failure)
    result = replay(out / "session.mcap", out / "replay")
    for site in (*result["remote"].values(), *result["operator"].values()):
        if site["first_difference"] is not None:
            sys.exit(f"the replay differs from the recording: {site['first_difference']}")
    return out / "session.mcap"


def with_shipped_surfaces(source: Path, out: Path) -> Path:
    """A copy of a recording with the shipped table of surfaces in place of its own."""
    table = json.loads(SURFACES.read_text("utf-8"))
    with source.open("rb") as file, out.open("wb") as copy:
        reader, writer = make_reader(file), Writer(copy, chunk_size=2**30, compression=CompressionType.ZSTD)
        writer.start(profile="teletaction", library="teletaction")
        for entry in reader.iter_metadata():
            known = {"surfaces": table["content_hash"]} if "surfaces" in entry.metadata else {}
            writer.add_metadata(entry.name, {**entry.metadata, **known})
        for entry in reader.iter_attachments():
            data = SURFACES.read_bytes() if entry.name == f"remote/{SURFACES.name}" else entry.data
            writer.add_attachment(0, 0, entry.name, entry.media_type, data)
        channels: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            if channel.id not in channels:
                channels[channel.id] = registered(writer, schema, channel)
            writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
        writer.finish()  # type: ignore[no-untyped-call]  # the library leaves it untyped
    return out


def write(session: RecordedSession, messages: list[Message], out: Path) -> None:
    """Write `messages` of a session with its tables, and without what names the machine that recorded."""
    with session.path.open("rb") as recorded:
        summary = make_reader(recorded).get_summary()
    assert summary is not None
    with out.open("wb") as file:
        # One chunk: the packets of both sites are nearly the same, and compress together.
        writer = Writer(file, chunk_size=2**30, compression=CompressionType.ZSTD)
        writer.start(profile="teletaction", library="teletaction")
        for name, facts in session.reader.metadata.items():
            if name in ("remote/session", "operator/session"):
                configuration = without_addresses(facts["configuration"])
                hashes = {table: facts[table] for table in ("materials", "surfaces") if table in facts}
                writer.add_metadata(name, {"configuration": configuration, **hashes})
        for table in session.reader.attachments.values():
            writer.add_attachment(0, 0, table.name, table.media_type, table.data)
        channels = {
            channel.topic: registered(writer, summary.schemas[channel.schema_id], channel)
            for channel in summary.channels.values()
            if channel.topic in STREAMS
        }
        for stream, _, time_ns, payload in messages:
            writer.add_message(channels[stream], time_ns, payload, time_ns)
        writer.finish()  # type: ignore[no-untyped-call]  # the library leaves it untyped


def registered(writer: Writer, schema: Schema, channel: Channel) -> int:
    """The channel's number in the cut recording."""
    schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
    return writer.register_channel(channel.topic, channel.message_encoding, schema_id, channel.metadata)


def messages_around_contact(session: RecordedSession) -> list[Message]:
    """From shortly before the first contact, beginning at the operator with a touch packet that its input can name."""
    column = TOUCH_COLUMN["contact"]
    first_ns = next(
        time_ns
        for _, _, time_ns, packet in session.messages(("remote/touch",))
        if Touch.decode(packet).block[:, column].any()
    )
    start_ns = first_ns - round(BEFORE_S * 1e9)
    end_ns = start_ns + round(SECONDS * 1e9)
    kept: list[Message] = []
    named = False
    for message in session.messages(STREAMS):
        stream, _, time_ns, _ = message
        if start_ns <= time_ns < end_ns:
            named = named or stream == "operator/touch"
            if named or not stream.startswith("operator/"):
                kept.append(message)
    return kept


def recomputed(session: RecordedSession, messages: list[Message]) -> list[Message]:
    """The inputs, and at 20 Hz what both sites compute from these inputs alone."""
    remote, operator = open_remote(session, "remote"), open_operator(session, "operator")
    kept: list[Message] = []
    due = 0
    for stream, origin, time_ns, payload in messages:
        match stream:
            case "remote/sensed":
                remote.sensed(0.0, payload)
                kept.append((stream, origin, time_ns, payload))
            case "operator/touch":
                operator.touch(payload)
                kept.append((stream, origin, time_ns, payload))
            case "operator/input":
                operator.input(payload)
                kept.append((stream, origin, time_ns, payload))
            case "remote/touch" if remote.ticks >= due:  # not each tick has a packet
                due = remote.ticks + OUTPUT_EVERY
                kept.append((stream, origin, time_ns, remote.touch(0.0, payload)))
            case "operator/rendered" if operator.ticks % OUTPUT_EVERY == 0:
                kept.append((stream, origin, time_ns, operator.rendered(0.0, payload)))
    return kept


def without_addresses(configuration: str) -> str:
    """Only what computing depends on."""
    values = tomllib.loads(configuration)
    lines = [f"fingers = {json.dumps(values['fingers'])}"]
    if "rendering" in values:
        lines += ["[link]", f"gap_s = {values['link']['gap_s']}", "[rendering]"]
        lines += [f"{name} = {json.dumps(value)}" for name, value in values["rendering"].items()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    make_golden(record="--record" in sys.argv[1:], surfaces="--surfaces" in sys.argv[1:])
