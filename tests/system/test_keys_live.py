"""Keys of a session that works: in nothing that it leaves behind, revoked and trusted, and used for old packets."""

import base64
import html
import io
import json
import stat
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zmq.utils.z85
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from common.config.file import load_config, to_toml
from common.config.link_models import ObserverConfig, OperatorLinkConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from common.limits import FORCE_SAFE_S, MOTOR_SAFE_S, THERMAL_SAFE_S
from common.link.curve import LinkProblem
from common.link.keys import TrustedKeys, create_keys, fingerprint, load_keys
from common.link.link import OperatorLink
from common.link.local_control import ask_desk
from common.link.packet_filter import PacketFilter
from common.recording.truncated_mcap import TruncatedMcap
from common.wire.messages import Motion, Touch
from robustness.fault_session import FaultSession
from robustness.fault_table import STROKING
from tests.commands import Outcome, command
from tests.system.truth import FELT_N, HEATS, LATE_S, STROKES, Truth, between, packets, read_truth
from tests.waiting import wait_until

pytestmark = [pytest.mark.session, pytest.mark.timeout(400)]

OWNERS = ("remote", "operator", "student", "stranger")
KEYS_LOOKED_AT_S = 1.1
"""Once a second, and a tick to do it."""
PATIENCE_S = 20.0
UNTRUSTED = "the remote site does not trust this site's key as an observer's"


@dataclass(frozen=True, slots=True)
class Story:
    """A session whose operator was revoked and trusted again, twice, while others looked on; times in s."""

    folder: Path
    observed: list[dict[str, Any]]
    """Lines of the observing process while it was trusted."""
    revoked: Outcome
    state_then: dict[str, str]
    trusted: Outcome
    working_s: float
    replayed: tuple[int, int]
    """Motion that the remote site refused, before and after packets of the first session were sent to it."""
    observed_last: dict[str, Any]
    """Line of the observing process once its key was revoked."""
    ended: dict[str, int]
    """Processes of the session that had ended by then."""
    truth: Truth

    @property
    def said(self) -> Path:
        """Folder of all that commands printed."""
        return self.folder / "said"

    def keys(self, kind: str) -> dict[str, bytes]:
        """The `secret` or `public` keys of everybody who had to do with the session, 32 bytes each."""
        folders = {name: load_keys(self.folder / "keys" / name) for name in OWNERS}
        return {name: zmq.utils.z85.decode(getattr(pair, kind)) for name, pair in folders.items()}


def motion_refused(session: FaultSession) -> int:
    """Motion of another session that the remote site has refused so far."""
    return int(session.figures("remote")["refused"]["motion"].get("session", 0))


def send_again(session: FaultSession, remote: RemoteConfig, packet: bytes) -> tuple[int, int]:
    """Send a recorded motion packet to the remote site, with the operator's own key, until it was counted."""
    keys = load_keys(load_config(session.configurations["operator"], OperatorConfig).link.keys)
    before = motion_refused(session)
    with OperatorLink(remote.link.bind, remote.link.base_port, keys, load_keys(remote.link.keys).public) as link:

        def counted() -> bool:
            link.send_latest("motion", packet)
            return motion_refused(session) > before

        wait_until(counted, "the remote site does not report what it refused", PATIENCE_S)
    return before, motion_refused(session)


@contextmanager
def observing(session: FaultSession, remote: RemoteConfig, name: str) -> "Iterator[subprocess.Popen[bytes]]":
    """`teletaction observe` with somebody's key, writing to `said/NAME.out` and `.err`; ended at the end."""
    folder = session.out
    link = OperatorLinkConfig(host=remote.link.bind, base_port=remote.link.base_port, keys=folder / "keys" / name)
    config = folder / f"{name}.toml"
    config.write_text(to_toml(ObserverConfig(link=link)), "utf-8")
    words = [sys.executable, "-m", "teletaction", "observe", "--config", str(config)]
    with (folder / "said" / f"{name}.out").open("wb") as out, (folder / "said" / f"{name}.err").open("wb") as err:
        process = subprocess.Popen(words, stdout=out, stderr=err)
        try:
            yield process
        finally:
            process.terminate()
            process.wait()


def observed(folder: Path) -> list[dict[str, Any]]:
    """Whole lines that the observer was shown so far."""
    text = (folder / "said" / "student.out").read_text("utf-8")
    return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]


def strokes(line: dict[str, Any]) -> bool:
    """Whether an observer is shown a stroke."""
    finger = line["fingers"].get(STROKING, {})
    return line["state"] == "engaged" and finger.get("mode") == "stroking" and STROKING in line["measured"]


def knock(session: FaultSession, remote: RemoteConfig) -> None:
    """Be refused with a stranger's key, at the link and at the remote site's desk."""
    stranger = load_keys(session.out / "keys" / "stranger")
    with OperatorLink(
        remote.link.bind, remote.link.base_port, stranger, load_keys(remote.link.keys).public
    ) as intruder:
        wait_until(intruder.key_refused, "the stranger is not refused")
    with pytest.raises(LinkProblem):
        ask_desk(remote.desk_port, stranger, "status")


def use_desks(session: FaultSession) -> None:
    """Give each command at each desk, and keep what it prints."""
    for site in ("remote", "operator"):
        for verb in ("status", "estop", "status", "clear", "engage", "disengage"):
            answer = command("session", verb, "--config", session.configurations[site])
            (session.out / "said" / f"{site}-{verb}-{time.monotonic_ns()}").write_text(answer.out + answer.err, "utf-8")
    assert command("session", "note", "a rough spot", "--config", session.configurations["operator"]).code == 0
    session.clear_and_engage()


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


@pytest.fixture(scope="module")
def story(tmp_path_factory: pytest.TempPathFactory) -> Story:
    """The operator's key is revoked in the middle of the work, trusted again, and both at once; then the observer's."""
    folder = tmp_path_factory.mktemp("keys-live")
    (folder / "said").mkdir()
    with FaultSession.open(folder, log="json") as session:
        remote = load_config(session.configurations["remote"], RemoteConfig)
        operator_key = load_keys(folder / "keys" / "operator").public

        def revoke(name: str) -> Outcome:
            return command("keys", "revoke", name, "--keys", remote.link.keys)

        def trust(*words: str) -> Outcome:
            return command("keys", "trust", "--keys", remote.link.keys, *words)

        for name in ("student", "stranger"):
            create_keys(folder / "keys" / name)
            TrustedKeys(folder / "keys" / name).trust("remote", load_keys(remote.link.keys).public)
        trust("--observer", "--", "student", load_keys(folder / "keys" / "student").public)
        with observing(session, remote, "student") as student, observing(session, remote, "stranger"):
            session.wait_until_working()
            wait_until(lambda: any(map(strokes, observed(folder))), "the observer sees no stroke", PATIENCE_S)
            lines = observed(folder)
            knock(session, remote)
            use_desks(session)
            session.wait_until_working()

            revoked = revoke("operator")
            wait_until(lambda: "does not trust" in session.states()["operator"], "no word of the key", PATIENCE_S)
            time.sleep(3.0)  # what is said each second would be said thrice
            state_then = session.states()
            trusted = trust("--", "operator", operator_key)
            session.wait_until_working()
            working_s = time.monotonic()
            first = packets(folder / "operator.mcap", "operator/motion", may_be_cut=True)[0][1]
            replayed = send_again(session, remote, first)
            session.wait_until_working()

            revoke("operator")
            wait_until(lambda: session.states()["remote"] == "disconnected", "the remote site works on", PATIENCE_S)
            trust("--", "operator", operator_key)
            session.wait_until_working()
            revoke("student")
            wait_until(lambda: observed(folder)[-1]["state"] == "disconnected", "the observer sees on", PATIENCE_S)
            wait_until(lambda: UNTRUSTED in (folder / "said" / "student.err").read_text("utf-8"), "no reason")
            observed_last = observed(folder)[-1]
            session.wait_until_working()
            assert student.poll() is None, "the observing process asks on"
        ended = session.processes.ended()
    files = ("--recordings", folder, "--out", folder / "out", "--scene", folder / "materials.toml")
    merged = command("summarise", *files, "--fingers", 2)
    assert merged.code == 0, merged.err
    return Story(
        folder, lines, revoked, state_then, trusted, working_s, replayed, observed_last, ended, read_truth(folder)
    )


def test_outputs_are_safe_as_soon_as_the_operators_key_is_gone(story: Story) -> None:
    truth, begin_s, end_s = story.truth, story.revoked.done_s, story.trusted.begun_s
    assert end_s - begin_s > KEYS_LOOKED_AT_S + THERMAL_SAFE_S + 1.0
    for time_s, outputs, finger, hold_s in (
        (truth.finger_s, truth.force_n, STROKES, FORCE_SAFE_S),
        (truth.finger_s, truth.motor_mv, STROKES, MOTOR_SAFE_S),
        (truth.finger_s, truth.peltier, STROKES, THERMAL_SAFE_S),
        (truth.patient_s, truth.heater, HEATS, THERMAL_SAFE_S),
    ):
        assert between(time_s, outputs[:, finger], begin_s - 0.5, begin_s).any(), "it must act before"
        safe_s = begin_s + KEYS_LOOKED_AT_S + hold_s + LATE_S
        assert not between(time_s, outputs, safe_s, end_s).any()


def test_both_sites_report_the_reason_once(story: Story) -> None:
    assert story.state_then["remote"] == "disconnected"
    assert story.state_then["operator"].startswith("disconnected: ")
    assert "the remote site does not trust this site's key" in story.state_then["operator"]
    lines = [line for line in (story.folder / "operator.log").read_text("utf-8").splitlines() if "not trust" in line]
    revocations = 2
    assert 1 <= len(lines) <= revocations
    own = load_keys(story.folder / "keys" / "operator").public
    assert f"revoked: {fingerprint(own)}" in (story.folder / "remote.log").read_text("utf-8")


def test_the_session_resumes_by_itself_once_the_key_is_trusted_again(story: Story) -> None:
    truth = story.truth
    force_n = between(truth.finger_s, truth.force_n[:, STROKES], story.trusted.done_s, story.working_s)
    motor_mv = between(truth.finger_s, truth.motor_mv[:, STROKES], story.trusted.done_s, story.working_s)
    assert ((force_n > FELT_N) & (motor_mv > 0.0)).any()
    assert np.any(truth.force_n[truth.finger_s > truth.finger_s[-1] - 1.0, STROKES] > FELT_N), "and the second time"


def test_motion_of_an_earlier_session_is_refused_and_counted(story: Story) -> None:
    before, after = story.replayed
    assert after > before
    remote = [Motion.decode(packet) for _, packet in packets(story.folder / "remote.mcap", "remote/motion")]
    sessions = list(dict.fromkeys(motion.session for motion in remote))
    assert len(sessions) == 3
    assert [motion.session for motion in remote] == sorted((motion.session for motion in remote), key=sessions.index), (
        "once a session is over, none of its motion is acted on"
    )


def test_touch_of_an_earlier_session_is_refused_and_counted(story: Story) -> None:
    touches = [Touch.decode(packet) for _, packet in packets(story.folder / "remote.mcap", "remote/touch")]
    first, last = touches[0], touches[-1]
    assert first.session != last.session
    acceptance = PacketFilter(max_age_ns=10**18)
    assert acceptance.accept(last, last.session, last.time_ns, 0, 0)
    assert not acceptance.accept(first, last.session, last.time_ns, 0, 0)
    assert acceptance.refused == {"session": 1}


def test_an_observer_is_shown_the_stroke_until_it_alone_is_cut_off(story: Story) -> None:
    seen = next(filter(strokes, story.observed))
    assert seen["fingers"][STROKING].keys() == {"mode", "contact", "status", "material"}
    assert seen["measured"][STROKING]["force_n"] > 0.0
    assert story.observed_last["fingers"] == story.observed_last["measured"] == {}
    errors = (story.said / "student.err").read_text("utf-8")
    assert errors.count(UNTRUSTED) == 1
    assert "Traceback" not in errors
    assert story.ended == {}


def test_the_session_left_every_file_that_could_hold_a_key(story: Story) -> None:
    recorded = [f"{site}.{kind}" for site in ("remote", "operator") for kind in ("mcap", "log", "json")]
    reported = [f"out/{name}" for name in ("session.mcap", "summary.json", "report.html")]
    for name in (*recorded, *reported, "said/student.out", "said/stranger.err"):
        assert (story.folder / name).stat().st_size > 50, name
    assert UNTRUSTED in (story.said / "stranger.err").read_text("utf-8")
    assert b"a rough spot" in b"".join(contents(story.folder / "out" / "session.mcap"))


@pytest.mark.parametrize("kind", ["secret", "public"])
def test_no_key_is_outside_the_key_folders(kind: str, story: Story) -> None:
    keys = story.keys(kind).values()
    assert all(len(key) == 32 for key in keys)
    assert found(keys, story.folder, story.folder / "keys") == []
    assert found(keys, story.folder, story.folder / "out") != [], "the key folders hold them"


def test_logs_name_keys_by_their_fingerprints(story: Story) -> None:
    log = (story.folder / "remote.log").read_text("utf-8")
    for name in ("remote", "operator", "stranger"):
        assert fingerprint(load_keys(story.folder / "keys" / name).public) in log, name


def test_secret_keys_are_readable_by_their_owner_alone(story: Story) -> None:
    for name in OWNERS:
        assert stat.S_IMODE((story.folder / "keys" / name / "site.key_secret").stat().st_mode) == 0o600


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
