"""Keys are revoked and trusted while a session works, and packets of one session are sent into another."""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.records import Channel, Message

from common.config import OperatorConfig, RemoteConfig, load_config
from common.limits import FORCE_SAFE_S, MOTOR_SAFE_S, THERMAL_SAFE_S
from common.link.keys import fingerprint, load_keys
from common.link.link import OperatorLink
from common.link.packet_filter import PacketFilter
from common.recording.truncated_mcap import TruncatedMcap
from common.wire.messages import Motion, Touch
from robustness.fault_session import FaultSession
from tests.commands import Outcome, command
from tests.system.truth import FELT_N, HEATS, LATE_S, STROKES, Truth, between, read_truth

pytestmark = [pytest.mark.session, pytest.mark.timeout(400)]

KEYS_LOOKED_AT_S = 1.1
"""Once a second, and a tick to do it."""


@dataclass(frozen=True, slots=True)
class Story:
    """A session whose operator was revoked and trusted again, twice; times in s."""

    folder: Path
    revoked: Outcome
    state_then: dict[str, str]
    trusted: Outcome
    working_s: float
    replayed: tuple[int, int]
    """Motion that the remote site refused, before and after packets of the first session were sent to it."""
    ended: dict[str, int]
    """Processes that had ended by then."""
    truth: Truth


def status(folder: Path, site: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / f"{site}.json").read_text("utf-8"))
    return found


def until(done: Callable[[], object], what: str) -> None:
    deadline_s = time.monotonic() + 20.0
    while not done():
        assert time.monotonic() < deadline_s, what
        time.sleep(0.01)


def packets(path: Path, stream: str) -> list[bytes]:
    """Packets of a stream, from a recording that may still be written."""
    topics: dict[int, str] = {}
    found = []
    with path.open("rb") as file:
        for record in TruncatedMcap(file).records():
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Message) and topics[record.channel_id] == stream:
                found.append(record.data)
    return found


def send_again(session: FaultSession, packet: bytes) -> tuple[int, int]:
    """Send a recorded motion packet to the remote site, with the operator's own key, until it was counted."""
    remote = load_config(session.configurations["remote"], RemoteConfig).link
    keys = load_keys(load_config(session.configurations["operator"], OperatorConfig).link.keys)

    def refused() -> int:
        return int(status(session.out, "remote")["refused"]["motion"].get("session", 0))

    before = refused()
    with OperatorLink(remote.bind, remote.base_port, keys, load_keys(remote.keys).public) as link:

        def counted() -> bool:
            link.send_latest("motion", packet)
            return refused() > before

        until(counted, "the remote site does not say what it refused")
    return before, refused()


@pytest.fixture(scope="module")
def story(tmp_path_factory: pytest.TempPathFactory) -> Story:
    """The operator's key is revoked in the middle of the work, trusted again, and both in one breath."""
    folder = tmp_path_factory.mktemp("revoked")
    with FaultSession.open(folder) as session:
        remote_keys = folder / "keys" / "remote"
        operator_key = load_keys(folder / "keys" / "operator").public

        def revoke() -> Outcome:
            return command("keys", "revoke", "operator", "--keys", remote_keys)

        def trust() -> Outcome:
            return command("keys", "trust", "--keys", remote_keys, "--", "operator", operator_key)

        session.wait_until_working()
        revoked = revoke()
        until(lambda: "does not trust" in session.states()["operator"], "the operator's site gets no reason")
        time.sleep(3.0)  # what is said each second would be said thrice
        state_then = session.states()
        trusted = trust()
        session.wait_until_working()
        working_s = time.monotonic()
        replayed = send_again(session, packets(folder / "operator.mcap", "operator/motion")[0])
        session.wait_until_working()

        revoke()
        until(lambda: session.states()["remote"] == "disconnected", "the remote site does not let go")
        trust()
        session.wait_until_working()
        ended = session.processes.ended()
    return Story(folder, revoked, state_then, trusted, working_s, replayed, ended, read_truth(folder))


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
    assert story.ended == {}
    assert np.any(truth.force_n[truth.finger_s > truth.finger_s[-1] - 1.0, STROKES] > FELT_N), "and the second time"


def test_motion_of_an_earlier_session_is_refused_and_counted(story: Story) -> None:
    before, after = story.replayed
    assert after > before
    remote = [Motion.decode(packet) for packet in packets(story.folder / "remote.mcap", "remote/motion")]
    sessions = list(dict.fromkeys(motion.session for motion in remote))
    assert len(sessions) == 3
    assert [motion.session for motion in remote] == sorted((motion.session for motion in remote), key=sessions.index), (
        "once a session is over, none of its motion is acted on"
    )


def test_touch_of_an_earlier_session_is_refused_and_counted(story: Story) -> None:
    touches = [Touch.decode(packet) for packet in packets(story.folder / "remote.mcap", "remote/touch")]
    first, last = touches[0], touches[-1]
    assert first.session != last.session
    acceptance = PacketFilter(max_age_ns=10**18)
    assert acceptance.accept(last, last.session, last.time_ns, 0, 0)
    assert not acceptance.accept(first, last.session, last.time_ns, 0, 0)
    assert acceptance.refused == {"session": 1}
