"""Files of a session contain no key: searched byte by byte, and inside every packed file."""

import base64
import html
import io
import stat
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
import zmq.utils.z85
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from common.config import ObserverConfig, OperatorLinkConfig, RemoteConfig, load_config, to_toml
from common.link.curve import LinkProblem
from common.link.keys import Role, TrustedKeys, create_keys, fingerprint, load_keys
from common.link.link import OperatorLink
from common.link.local_control import ask_desk
from common.recording.truncated_mcap import TruncatedMcap
from robustness.fault_session import FaultSession
from tests.commands import command

pytestmark = [pytest.mark.session, pytest.mark.timeout(180)]

OWNERS = ("remote", "operator", "student", "stranger")


def written(key: bytes) -> set[bytes]:
    """Every way in which 32 bytes of key may stand in a file."""
    text, plain = zmq.utils.z85.encode(key), key.hex().encode()
    ways = {key, text, html.escape(text.decode()).encode(), plain, plain.upper()}
    for before in range(3):  # base64 reads differently at each place within what it encodes
        for encode in (base64.b64encode, base64.urlsafe_b64encode):
            padded = encode(bytes(before) + key)
            ways.add(padded[-(-before * 8 // 6) : (before + len(key)) * 8 // 6])
    return ways


def contents(path: Path) -> Iterator[bytes]:
    """A file's bytes as they are and, of a recording, what its chunks hold."""
    yield path.read_bytes()
    if path.suffix != ".mcap":
        return
    with path.open("rb") as file:
        for record in TruncatedMcap(file).records():
            match record:
                case Message() | Attachment() | Schema():
                    yield record.data
                case Metadata() | Channel():
                    yield repr(record.metadata).encode()


def found(keys: Iterable[bytes], folder: Path, besides: Path) -> list[str]:
    """Names of files below a folder that hold one of some keys in any way; `besides` is where keys belong."""
    ways = [way for key in keys for way in written(key)]
    names = []
    for path in sorted(folder.rglob("*")):
        if path.is_file() and besides not in path.parents:
            all_of_it = b"\n".join(contents(path))
            names += [str(path.relative_to(folder)) for way in ways if way in all_of_it]
    return names


@dataclass(frozen=True, slots=True)
class Left:
    """What a session left behind, and the keys of everybody who had to do with it, 32 bytes each."""

    folder: Path
    keys: Path
    secret: dict[str, bytes]
    public: dict[str, bytes]
    fingerprints: dict[str, str]


@pytest.fixture(scope="module")
def left(tmp_path_factory: pytest.TempPathFactory) -> Left:
    """A session with an observer, a stranger at every door, people at both desks, and its report."""
    folder = tmp_path_factory.mktemp("left")
    keys, said = folder / "keys", folder / "said"
    said.mkdir()
    with FaultSession.open(folder, log="json") as session:
        remote = load_config(session.configurations["remote"], RemoteConfig)
        for name in ("student", "stranger"):
            create_keys(keys / name)
            TrustedKeys(keys / name).trust("remote", load_keys(keys / "remote").public)
        TrustedKeys(keys / "remote").trust("student", load_keys(keys / "student").public, Role.OBSERVER)
        observers = []
        for name in ("student", "stranger"):
            link = OperatorLinkConfig(host=remote.link.bind, base_port=remote.link.base_port, keys=keys / name)
            config = folder / f"{name}.toml"
            config.write_text(to_toml(ObserverConfig(link=link)), "utf-8")
            with (said / f"{name}.out").open("wb") as out, (said / f"{name}.err").open("wb") as err:
                observers.append(
                    subprocess.Popen(
                        [sys.executable, "-m", "teletaction", "observe", "--config", str(config)],
                        stdout=out,
                        stderr=err,
                    )
                )
        try:
            session.wait_until_working()
            stranger = load_keys(keys / "stranger")
            with OperatorLink(
                remote.link.bind, remote.link.base_port, stranger, load_keys(keys / "remote").public
            ) as intruder:
                deadline_s = time.monotonic() + 10.0
                while not intruder.key_refused():
                    assert time.monotonic() < deadline_s
                    time.sleep(0.01)
            with pytest.raises(LinkProblem):
                ask_desk(remote.desk_port, stranger, "status")
            for site in ("remote", "operator"):
                for verb in ("status", "estop", "status", "clear", "engage", "disengage"):
                    outcome = command("session", verb, "--config", session.configurations[site])
                    (said / f"{site}-{verb}-{time.monotonic_ns()}").write_text(outcome.out + outcome.err, "utf-8")
            outcome = command("session", "note", "a rough spot", "--config", session.configurations["operator"])
            assert outcome.code == 0
            session.clear_and_engage()
            session.wait_until_working()
        finally:
            for observer in observers:
                observer.terminate()
                observer.wait()
    outcome = command(
        "summarise",
        "--recordings",
        folder,
        "--out",
        folder / "out",
        "--scene",
        folder / "materials.toml",
        "--fingers",
        2,
    )
    assert outcome.code == 0, outcome.err
    pairs = {name: load_keys(keys / name) for name in OWNERS}
    return Left(
        folder,
        keys,
        {name: zmq.utils.z85.decode(pair.secret) for name, pair in pairs.items()},
        {name: zmq.utils.z85.decode(pair.public) for name, pair in pairs.items()},
        {name: fingerprint(pair.public) for name, pair in pairs.items()},
    )


def test_the_session_left_every_file_that_could_hold_a_key(left: Left) -> None:
    for name in (
        "remote.mcap",
        "operator.mcap",
        "remote.log",
        "operator.log",
        "remote.json",
        "operator.json",
        "out/session.mcap",
        "out/summary.json",
        "out/report.html",
        "said/student.out",
        "said/stranger.err",
    ):
        assert (left.folder / name).stat().st_size > 50, name
    assert "does not trust this key" in (left.folder / "said" / "stranger.err").read_text("utf-8")
    assert b"a rough spot" in b"".join(contents(left.folder / "out" / "session.mcap"))


@pytest.mark.parametrize("kind", ["secret", "public"])
def test_no_key_is_outside_the_key_folders(kind: str, left: Left) -> None:
    keys: dict[str, bytes] = getattr(left, kind)
    assert all(len(key) == 32 for key in keys.values())
    assert found(keys.values(), left.folder, left.keys) == []
    assert found(keys.values(), left.folder, left.folder / "out") != [], "the key folders hold them"


def test_logs_name_keys_by_their_fingerprints(left: Left) -> None:
    log = (left.folder / "remote.log").read_text("utf-8")
    for name in ("remote", "operator", "stranger"):
        assert left.fingerprints[name] in log, name


def test_secret_keys_are_readable_by_their_owner_alone(left: Left) -> None:
    for name in OWNERS:
        assert stat.S_IMODE((left.keys / name / "site.key_secret").stat().st_mode) == 0o600


def recording(message: bytes = b"", metadata: str = "", attachment: bytes = b"") -> bytes:
    """A compressed recording with something in each of its places."""
    file = io.BytesIO()
    writer = Writer(file, compression=CompressionType.LZ4)
    writer.start(profile="", library="")
    channel = writer.register_channel("stream", "msgpack", writer.register_schema("stream", "jsonschema", b"{}"))
    writer.add_message(channel, 0, bytes(2000) + message, 0)
    writer.add_metadata("session", {"configuration": metadata})
    writer.add_attachment(0, 0, "table.json", "application/json", bytes(100) + attachment)
    writer.finish()  # type: ignore[no-untyped-call]  # the library leaves it untyped
    return file.getvalue()


KEY = bytes(range(100, 132))
"""Any 32 bytes; a key's text is Z85."""
TEXT = zmq.utils.z85.encode(KEY)


@pytest.mark.parametrize(
    "content",
    [
        b"key: " + KEY,
        b"key: " + TEXT,
        html.escape(TEXT.decode()).encode(),
        b"key: " + KEY.hex().encode(),
        b"key: " + KEY.hex().upper().encode(),
        base64.b64encode(KEY),
        base64.b64encode(b"1" + KEY + b"2"),
        base64.urlsafe_b64encode(b"12" + KEY),
        recording(message=KEY),
        recording(message=TEXT),
        recording(metadata=TEXT.decode()),
        recording(attachment=TEXT),
    ],
)
def test_the_search_finds_a_key_in_every_place_and_form(content: bytes, tmp_path: Path) -> None:
    for name in ("a.mcap", "b.log"):
        (tmp_path / name).write_bytes(content)
    assert "a.mcap" in found([KEY], tmp_path, tmp_path / "keys")
    other = bytes(reversed(KEY))
    assert found([other], tmp_path, tmp_path / "keys") == []


def test_the_search_leaves_key_folders_alone(tmp_path: Path) -> None:
    (tmp_path / "keys" / "remote").mkdir(parents=True)
    (tmp_path / "keys" / "remote" / "site.key").write_bytes(TEXT)
    assert found([KEY], tmp_path, tmp_path / "keys") == []
