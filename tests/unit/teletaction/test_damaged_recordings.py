"""A damaged recording is refused with one line that names the damage, or gives what is right."""

import resource
import time
from collections.abc import Callable
from pathlib import Path

import msgpack
import pytest
from mcap.writer import CompressionType

from operator_site.console.model import Console
from operator_site.console.playback.playback import Playback, Recording
from tests.commands import command
from tests.places import GOLDEN
from tests.unit.teletaction.damages import in_messages, in_the_file, messages, records, write
from tests.unit.teletaction.held_recordings import Message, held

pytestmark = pytest.mark.usefixtures("coarse")
MEMORY_MIB = 400.0
"""More than all commands together may take, beyond what they take with a sound recording."""
LONGEST_S = 20.0
Run = Callable[[str, Path], tuple[int, str]]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """One command on a recording: its exit code, and what it said."""

    def give(name: str, path: Path) -> tuple[int, str]:
        if name == "playback":
            return playback(path)
        if name == "recover":
            (tmp_path / "s-recovered.mcap").unlink(missing_ok=True)
        outcome = command(name, path, *([] if name == "recover" else ["--out", tmp_path / f"{name}.out"]))
        return outcome.code, outcome.err

    return give


def playback(path: Path) -> tuple[int, str]:
    """What the console does with a recording, from its beginning to its end and back."""
    try:
        recording = Recording(path)
    except (ValueError, OSError) as error:
        return 2, f"{error}\n"
    try:
        played = Playback(recording, lambda: Console(live=False))
        # Hours between two messages are no reason to stay away for hours.
        played.seek(min(played.length_s, 3.0), 0.0)
        played.seek(0.0, 0.0)
    except ValueError as error:
        return 2, f"{error}\n"
    finally:
        recording.close()
    return 0, ""


@pytest.fixture(scope="module")
def content() -> list[Message]:
    """Of every stream, but for those that nothing here reads."""
    made = messages()
    found = {message[0] for message in made}
    assert {"remote/sensed", "operator/input", "truth_event", "console/act"} <= found
    assert sum(stream.startswith("remote/") for stream in found) >= 6
    return made


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory, content: list[Message]) -> dict[str, bytes]:
    """As sites record, as merged, and as version 0.1.0 recorded: without a checksum of the whole."""
    folder = tmp_path_factory.mktemp("sound")
    return {
        "site": write(folder / "site.mcap", content).read_bytes(),
        "merged": write(folder / "merged.mcap", content, CompressionType.ZSTD).read_bytes(),
        "0.1.0": write(folder / "old.mcap", content, data_crcs=False).read_bytes(),
    }


def read_by(stream: str) -> tuple[str, ...]:
    """The commands that look into the messages of a stream."""
    if stream in ("remote/sensed", "operator/input"):
        return ("replay",)
    replayed = stream in ("remote/touch", "operator/touch", "operator/rendered") or stream.isdigit()
    return ("report", "replay", "playback") if replayed else ("report", "playback")


def peak_mib() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


@pytest.mark.long
@pytest.mark.parametrize("kind", ["site", "merged", "0.1.0"])
def test_a_sound_recording_is_read_as_before(sound: dict[str, bytes], kind: str, tmp_path: Path, run: Run) -> None:
    path = tmp_path / "s.mcap"
    path.write_bytes(sound[kind])
    for name in ("report", "replay", "playback", "recover"):
        assert run(name, path)[0] == 0, name
    assert "P-0417" in (tmp_path / "report.out").read_text("utf-8")
    assert "Messages that could not be read" not in (tmp_path / "report.out").read_text("utf-8")


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        ("site", 1),
        *(pytest.param(kind, seed, marks=pytest.mark.hardening) for kind, seed in (("merged", 2), ("0.1.0", 3))),
    ],
)
def test_damage_of_a_file_is_named_or_changes_nothing(
    sound: dict[str, bytes], content: list[Message], kind: str, seed: int, tmp_path: Path, run: Run
) -> None:
    whole, path = sound[kind], tmp_path / "s.mcap"
    path.write_bytes(whole)
    assert run("report", path)[0] == 0
    right = (tmp_path / "report.out").read_bytes()
    written, before_mib = {*content}, peak_mib()
    damages = {damage: damaged for damage, damaged in in_the_file(whole, seed) if damaged != whole}
    assert len(damages) >= 84
    named = 0
    for damage, damaged in damages.items():
        path.write_bytes(damaged)
        begin_s = time.monotonic()
        said = {name: run(name, path) for name in ("recover", "report", "replay", "playback")}
        assert time.monotonic() - begin_s < LONGEST_S, damage
        for name, (code, text) in said.items():
            if code:
                assert code == 2, (damage, name, text)
                (line,) = text.splitlines()
                assert str(path) in line, (damage, name)
        if not said["recover"][0]:
            recovered = tmp_path / "s-recovered.mcap"
            assert written.issuperset(held(recovered if recovered.exists() else path)), damage
        if said["report"][0]:
            named += 1
            assert "damaged" in said["report"][1] or "cut" in said["report"][1] or "MCAP" in said["report"][1], damage
        elif kind != "0.1.0":  # its metadata had no checksum
            assert (tmp_path / "report.out").read_bytes() == right, damage
    assert named >= 0.8 * len(damages)
    assert peak_mib() - before_mib < MEMORY_MIB


@pytest.mark.hardening
def test_damage_of_a_message_is_named(content: list[Message], tmp_path: Path, run: Run) -> None:
    """Every checksum is right: what is in the messages is wrong."""
    path = tmp_path / "s.mcap"
    damages = dict(in_messages(content, 4))
    before_mib = peak_mib()
    refused: set[str] = set()
    for damage, damaged in damages.items():
        write(path, damaged)
        for name in read_by(damage.split()[-1]):
            code, text = run(name, path)
            assert code in (0, 2), (damage, name)
            if code:
                refused.add(damage)
                (line,) = text.splitlines()
                assert str(path) in line, (damage, name, line)
                assert "damaged: " in line, (damage, name, line)
    assert len(refused) >= 0.3 * len(damages)
    assert peak_mib() - before_mib < MEMORY_MIB


@pytest.mark.parametrize(
    "configuration",
    [
        "fingers = 5",
        "fingers = ['index']\nrate_hz = 0",
        "rate_hz = 'x'\nfingers = []",
        "rendering = 3",
        "link = []",
        "[",
    ],
)
def test_an_unusable_configuration_is_reported(
    content: list[Message], tmp_path: Path, run: Run, configuration: str
) -> None:
    path = write(tmp_path / "s.mcap", content, configuration=configuration)
    code, text = run("replay", path)
    assert code == 2
    (line,) = text.splitlines()
    assert "its configuration" in line


def test_a_flipped_bit_in_a_recorded_force_is_neither_reported_nor_blamed_on_the_program(
    sound: dict[str, bytes], content: list[Message], tmp_path: Path, run: Run
) -> None:
    stream, time_ns, payload = next(m for m in content if m[0] == "operator/rendered")
    whole = bytearray(sound["site"])
    place = sound["site"].index(payload) + payload.index(msgpack.packb(msgpack.unpackb(payload)[2])) + 3
    whole[place] ^= 1
    path = tmp_path / "s.mcap"
    path.write_bytes(whole)
    for name in ("report", "replay", "playback"):
        code, text = run(name, path)
        assert code == 2
        assert all(words in text for words in ("damaged: byte ", "chunk with the messages of ", "teletaction recover"))
    assert run("recover", path)[0] == 0
    left = held(tmp_path / "s-recovered.mcap")
    assert (stream, time_ns, payload) not in left
    assert len(left) > 0.5 * len(content)


def test_recovery_continues_with_the_next_sound_chunk_after_a_damaged_length(
    sound: dict[str, bytes], content: list[Message], tmp_path: Path, run: Run
) -> None:
    whole = bytearray(sound["site"])
    chunk = [record for record in records(sound["site"]) if record.opcode == 6][2]
    whole[chunk.offset + 5] ^= 0x40
    path = tmp_path / "s.mcap"
    path.write_bytes(whole)
    code, text = run("recover", path)
    assert code == 0
    left = held(tmp_path / "s-recovered.mcap")
    assert left[-1] == content[-1]
    assert f"{len(left)} messages" in text
    assert len(left) > 0.5 * len(content)


def test_a_damaged_message_is_named_with_its_stream_and_time(content: list[Message], tmp_path: Path, run: Run) -> None:
    number = next(n for n, m in enumerate(content) if m[0] == "operator/rendered" and n > len(content) / 2)
    stream, time_ns, payload = content[number]
    row = msgpack.unpackb(payload)
    row[2] = [float("nan"), *row[2][1:]]
    path = write(
        tmp_path / "s.mcap", [*content[:number], (stream, time_ns, msgpack.packb(row)), *content[number + 1 :]]
    )
    code, text = run("report", path)
    assert code == 2
    at_s = (time_ns - content[0][1]) * 1e-9
    assert f"damaged: operator/rendered at {at_s:.3f} s: field force_n: Expected `float` " in text


@pytest.mark.long
def test_a_damaged_recording_is_merged_as_far_as_it_is_sound_and_this_is_reported(
    sound: dict[str, bytes], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    whole = bytearray(sound["site"])
    whole[next(record for record in records(sound["site"]) if record.opcode == 6).offset + 200] ^= 1
    (tmp_path / "operator.mcap").write_bytes(whole)
    (tmp_path / "remote.mcap").write_bytes(GOLDEN.read_bytes())
    files = [tmp_path / f"{name}.mcap" for name in ("operator", "remote")]
    assert command("report", *files, "--out", tmp_path / "r.html").code == 0
    (line,) = caplog.messages
    assert f"{tmp_path / 'operator.mcap'}: damaged: byte " in line
