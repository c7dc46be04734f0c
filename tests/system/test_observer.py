"""A read-only client of a running session has a key of its own, changes nothing, and is cut off alone."""

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgpack
import pytest
from mcap.reader import make_reader

from common.config import ObserverConfig, OperatorConfig, OperatorLinkConfig, RemoteConfig, load_config, to_toml
from common.limits import GAP_S
from common.link.capabilities import OBSERVER, capabilities
from common.link.keys import Role, TrustedKeys, create_keys, load_keys
from common.link.link import OperatorLink
from common.wire.session_messages import REQUESTS, Answer
from operator_site.session.session_client import SessionClient
from robustness.fault_session import FaultSession
from robustness.fault_table import STROKING
from tests.commands import Outcome, command

pytestmark = [pytest.mark.session, pytest.mark.timeout(400)]

CUT_OFF_S = 2.0
WATCHED_S = 3.0
"""After the observers were revoked: long enough for whatever follows from lost heartbeats."""


@dataclass(slots=True)
class Story:
    """A session, observed; times in s."""

    folder: Path
    lines: list[dict[str, Any]] = field(default_factory=list)
    """Lines of the observing process while it was trusted."""
    refused: dict[str, str] = field(default_factory=dict)
    """What the remote site said to each request of an observer."""
    before: dict[str, str] = field(default_factory=dict)
    after: dict[str, str] = field(default_factory=dict)
    """States of both sites before and after these requests."""
    revoke: Outcome | None = None
    ended: tuple[int, float, str] = (0, 0.0, "")
    """Exit code of the observing process, when it ended, and what it wrote to standard error."""
    packets_s: list[float] = field(default_factory=list)
    """Times at which a program that ignores its end got a packet."""
    operator: "subprocess.CompletedProcess[str] | None" = None
    """An operator's site with the observer's key."""


class Onlooker:
    """A program with an observer's key that asks for everything and does not care about refusals."""

    def __init__(self, link: OperatorLink) -> None:
        self.link = link
        self.client = SessionClient(link, capabilities((), 50.0), 0.15, False, role=OBSERVER)

    def join(self) -> None:
        deadline_s = time.monotonic() + 10.0
        while self.client.touch is None:
            assert time.monotonic() < deadline_s, self.client.refusal
            self.client.step(time.monotonic_ns(), "")
            time.sleep(0.005)

    def answer_to(self, verb: str) -> str:
        """What the remote site says to a request; empty when it was carried out."""
        self.client.request(verb, time.monotonic_ns(), {"text": "!", "max_age_s": 0.1, **self.client.capabilities})
        deadline_s = time.monotonic() + 10.0
        while time.monotonic() < deadline_s:
            for packet in self.link.receive("control"):
                return Answer.decode(packet).refused
            time.sleep(0.005)
        raise AssertionError(f"no answer to {verb}")

    def listen(self, seconds: float) -> list[float]:
        """When packets came in the next seconds, s."""
        end_s, found = time.monotonic() + seconds, []
        while (now_s := time.monotonic()) < end_s:
            before = self._came()
            self.client.step(time.monotonic_ns(), "")  # beats, so that it is not forgotten
            if self._came() > before:
                found.append(now_s)
            time.sleep(0.001)
        return found

    def _came(self) -> int:
        """Packets that came so far, whether they were of any use or not."""
        acceptance = self.client.acceptance
        return acceptance.received + acceptance.refused.total() + self.client.damaged["touch"]


@contextmanager
def observing(config: Path, folder: Path) -> "Iterator[subprocess.Popen[bytes]]":
    """`teletaction observe`, writing to `lines` and `errors`; killed at the end if it still runs."""
    with (folder / "lines").open("wb") as lines, (folder / "errors").open("wb") as errors:
        process = subprocess.Popen(
            [sys.executable, "-m", "teletaction", "observe", "--config", str(config)], stdout=lines, stderr=errors
        )
        try:
            yield process
        finally:
            process.kill()
            process.wait()


def printed(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "lines").read_text("utf-8").splitlines()]


def strokes(line: dict[str, Any]) -> bool:
    finger = line["fingers"].get(STROKING, {})
    return line["state"] == "engaged" and finger.get("mode") == "stroking" and STROKING in line["measured"]


@pytest.fixture(scope="module")
def story(tmp_path_factory: pytest.TempPathFactory) -> Story:
    """A session at which a process and a program look on, until both are revoked in the middle of the work."""
    folder = tmp_path_factory.mktemp("observed")
    story = Story(folder)
    with FaultSession.open(folder) as session:
        remote = load_config(session.configurations["remote"], RemoteConfig).link
        remote_key = load_keys(remote.keys).public
        for name in ("student", "program"):
            public_key = create_keys(folder / "keys" / name)
            command("keys", "trust", "--observer", "--keys", remote.keys, "--", name, public_key)
        config = folder / "observer.toml"
        link = OperatorLinkConfig(
            host=remote.bind, base_port=remote.base_port, keys=folder / "keys" / "student", remote_key=remote_key
        )
        config.write_text(to_toml(ObserverConfig(link=link)), "utf-8")
        with (
            observing(config, folder) as process,
            OperatorLink(
                remote.bind, remote.base_port, load_keys(folder / "keys" / "program"), remote_key, Role.OBSERVER
            ) as program,
        ):
            session.wait_until_working()
            deadline_s = time.monotonic() + 20.0
            while not any(strokes(line) for line in printed(folder)):
                assert process.poll() is None, (folder / "errors").read_text()
                assert time.monotonic() < deadline_s, printed(folder)
                time.sleep(0.02)
            onlooker = Onlooker(program)
            onlooker.join()
            story.before = session.states()
            for verb in REQUESTS:
                story.refused[verb] = onlooker.answer_to(verb)
            session.wait_until_working()
            story.after = session.states()
            story.lines = printed(folder)
            trusted = TrustedKeys(remote.keys)
            trusted.revoke("program")
            with ThreadPoolExecutor() as beside:
                revoking = beside.submit(command, "keys", "revoke", "student", "--keys", remote.keys)
                story.packets_s = onlooker.listen(WATCHED_S)
                story.revoke = revoking.result()
            code = process.wait(20.0)
            story.ended = (code, time.monotonic(), (folder / "errors").read_text("utf-8"))
        session.processes.running["operator"].terminate()
        session.processes.running["operator"].wait()
        trusted.trust("student", load_keys(link.keys).public, Role.OBSERVER)
        operator = load_config(session.configurations["operator"], OperatorConfig)
        keys = operator.link.model_copy(update={"keys": link.keys, "remote_key": remote_key})
        config.write_text(to_toml(operator.model_copy(update={"link": keys, "record": None, "status": None})), "utf-8")
        story.operator = subprocess.run(
            [sys.executable, "-m", "teletaction", "operator", "--config", str(config)],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
    return story


def recorded(path: Path, stream: str) -> list[tuple[float, Any]]:
    """Entries of a stream with their times, s."""
    with path.open("rb") as file:
        return [
            (message.log_time * 1e-9, msgpack.unpackb(message.data))
            for _, _, message in make_reader(file).iter_messages(topics=[stream])
        ]


def test_a_read_only_client_gets_each_change_of_the_identification(story: Story) -> None:
    assert story.lines
    opinions = [(line["state"], line["fingers"]) for line in story.lines]
    assert all(now != then for then, now in pairwise(opinions))
    seen = next(line for line in story.lines if strokes(line))
    assert seen["fingers"][STROKING].keys() == {"mode", "contact", "status", "material"}
    assert seen["measured"][STROKING]["force_n"] > 0.0
    assert 0.0 <= seen["time_s"] <= time.monotonic()


def test_requests_of_a_read_only_client_change_nothing(story: Story) -> None:
    for verb in set(REQUESTS) - {"hello", "status"}:
        assert "observers look on" in story.refused[verb], verb
    assert "observer's only" in story.refused["hello"]
    assert story.refused["status"] == ""
    assert story.before == story.after == {"remote": "engaged", "operator": "engaged"}
    events = [entry[0] for _, entry in recorded(story.folder / "remote.mcap", "remote/session")]
    assert events[:2] == ["connected", "engaged"]
    assert not {"fault", "estop", "cleared"} & set(events)
    assert not recorded(story.folder / "remote.mcap", "remote/note")


def test_a_revoked_read_only_client_gets_nothing_and_ends_with_one_line(story: Story) -> None:
    assert story.revoke is not None
    assert story.revoke.err == "revoked 1 key of student\n"
    assert story.packets_s, "packets came until it was cut off"
    assert story.packets_s[-1] - story.revoke.begun_s < CUT_OFF_S
    code, _, errors = story.ended
    assert code == 2
    assert errors.splitlines()[-1].endswith("the remote site does not trust this key")
    assert "Traceback" not in errors
    last = printed(story.folder)[-1]
    assert last["time_s"] is None or last["time_s"] - story.revoke.begun_s < CUT_OFF_S


def test_the_operators_session_continues_while_read_only_clients_are_cut_off(story: Story) -> None:
    assert story.revoke is not None
    from_s, to_s = story.revoke.begun_s - 0.5, story.revoke.begun_s + WATCHED_S
    rendered = recorded(story.folder / "operator.mcap", "operator/rendered")
    during = [entry for time_s, entry in rendered if from_s < time_s < to_s]
    assert len(during) > 500
    assert all(engaged for engaged, *_ in during)
    assert max(gap_s for _, gap_s, *_ in during) < GAP_S
    sessions = recorded(story.folder / "operator.mcap", "operator/session")
    # A machine may hold a simulator back for 0.1 s. Its devices are then missing, and the session continues.
    happened = [entry[0] for time_s, entry in sessions if time_s < to_s and entry[0] not in ("missing", "complete")]
    assert happened == ["connected", "engaged"]


def test_a_read_only_key_runs_no_operator(story: Story) -> None:
    assert story.operator is not None
    assert story.operator.returncode == 2
    assert "does not trust this site's key as an operator's" in story.operator.stderr.splitlines()[-1]
    assert "Traceback" not in story.operator.stderr
    sessions = recorded(story.folder / "remote.mcap", "remote/session")
    assert [entry[0] for _, entry in sessions].count("connected") == 1
