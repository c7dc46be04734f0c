"""An observer against a remote site and an operator on a real link, all stepped by the test."""

import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from common.config.link_models import ObserverConfig, OperatorLinkConfig
from common.fingers import FINGERS
from common.link.capabilities import OBSERVER, capabilities
from common.link.keys import KeyProblem, Role, TrustedKeys, load_keys
from common.link.link import OperatorLink, RemoteLink
from common.wire.messages import ExplorationMode, ThermalStatus, Touch
from operator_site.session.read_only_client import measured, opinion, run_observer
from operator_site.session.session_client import SessionClient
from remote_site.session.session_server import SessionServer
from tests.conftest import Keys
from tests.unit.operator_site.touches import touch
from tests.waiting import PATIENCE_S, wait_until

AT_REST = (0.0, 0.0, (0.0,) * 5)


def pressed(**more: float) -> Touch:
    """The index finger strokes pine; the ring finger is in the air and nothing is known of it."""
    known = {
        "mode": ExplorationMode.STROKING,
        "contact": 1,
        "thermal_status": ThermalStatus.IDENTIFIED,
        "probability": 0.9876,
        "object_c": 23.456,
        "contact_force_n": 1.234,
    }
    return touch(materials=("", "pine", "", "steel", ""), **known | more)


def test_the_summary_has_words_instead_of_noisy_numbers() -> None:
    said = opinion(pressed())
    assert said["state"] == "engaged"
    assert list(said["fingers"]) == list(FINGERS)
    assert said["fingers"]["index"] == {"mode": "stroking", "contact": True, "status": "identified", "material": "pine"}
    assert said == opinion(pressed(contact_force_n=2.0, object_c=30.0, probability=0.5))
    assert said != opinion(pressed(contact=0))


@pytest.mark.parametrize("status", [status for status in ThermalStatus if status is not ThermalStatus.IDENTIFIED])
def test_a_material_is_named_only_when_it_is_identified(status: ThermalStatus) -> None:
    fingers = opinion(pressed(thermal_status=status))["fingers"]
    assert (fingers["index"]["status"], fingers["index"]["material"]) == (status.name.lower(), None)
    assert fingers["ring"]["material"] is None


def test_numbers_are_reported_for_touching_fingers() -> None:
    assert measured(pressed()) == {
        "index": {"force_n": 1.23, "object_c": 23.5, "object_c_sd": 0.0, "probability": 0.988}
    }
    assert measured(pressed(contact=0)) == {}


class Session:
    """A remote site with an operator, who sends what the test wants to be touched."""

    def __init__(self, keys: Keys, base_port: int) -> None:
        self.keys, self.base_port = keys, base_port
        remote = load_keys(keys.remote)
        self.link = RemoteLink("127.0.0.1", base_port, remote, TrustedKeys(keys.remote))
        able = capabilities(("index",), 500.0, calibration="abc")
        self.server = SessionServer(self.link, able, 0.15)
        self.operator_link = OperatorLink("127.0.0.1", base_port, load_keys(keys.operator), remote.public)
        self.operator = SessionClient(self.operator_link, dict(able), 0.15, True)
        self.touch = pressed()
        self.observed = True
        """Whether observers are sent what is touched."""
        self._sequence = 0

    def turn(self) -> None:
        now_ns = time.monotonic_ns()
        self.server.step(now_ns, "")
        session = self.server.session
        if session.ident:
            self._sequence += 1
            content = self.touch.floats, self.touch.materials, self.touch.events
            packet = Touch(session.ident, self._sequence, now_ns, session.state, *content).encode()
            self.link.send_latest("touch", packet)
            if self.observed:
                self.link.send_latest("observed", packet)
        self.operator.step(time.monotonic_ns(), "")
        self.operator.send_motion(time.monotonic_ns(), *AT_REST)

    def until(self, done: Callable[[], object]) -> None:
        """Take turns until something is reached; between two the sockets' own threads get the processor."""

        def reached() -> object:
            return done() or self.turn()

        wait_until(reached, lambda: (self.server.session, self.operator.refusal), every_s=0.001)

    def engaged(self) -> bool:
        return self.server.both_engaged and self.operator.both_engaged

    def observe(
        self, *scenes: Callable[[list[dict[str, Any]]], object], folder: Path | None = None
    ) -> list[dict[str, Any]]:
        """Run an observer until each scene in turn, given the lines so far, says that it is over; returns the lines."""
        remote_key = load_keys(self.keys.remote).public
        link = OperatorLinkConfig(base_port=self.base_port, keys=folder or self.keys.stranger, remote_key=remote_key)
        lines: list[dict[str, Any]] = []
        left = list(scenes)
        deadline_s = time.monotonic() + PATIENCE_S

        def over() -> bool:
            assert time.monotonic() < deadline_s, lines
            self.turn()
            while left and left[0](lines):
                left.pop(0)
            return not left

        run_observer(ObserverConfig(link=link), over, lambda line: lines.append(json.loads(line)))
        return lines

    def close(self) -> None:
        self.operator_link.close()
        self.link.close()


@pytest.fixture
def session(keys: Keys, base_port: int) -> Iterator[Session]:
    """A key that is unknown elsewhere is trusted as read-only here."""
    TrustedKeys(keys.remote).trust("student", load_keys(keys.stranger).public, Role.OBSERVER)
    made = Session(keys, base_port)
    yield made
    made.close()


def test_a_line_is_printed_when_the_identification_changes_or_ends(session: Session) -> None:
    session.until(session.engaged)

    def identified(lines: list[dict[str, Any]]) -> bool:
        return bool(lines) and lines[-1]["fingers"]["index"]["material"] == "pine"

    def presses_harder(lines: list[dict[str, Any]]) -> bool:
        session.touch = pressed(contact_force_n=3.0)
        return session.server.acceptance.received > 30

    def lifts(lines: list[dict[str, Any]]) -> bool:
        session.touch = pressed(contact=0, mode=ExplorationMode.FREE)
        return not lines[-1]["measured"]

    def ends(lines: list[dict[str, Any]]) -> bool:
        session.operator.goodbye(time.monotonic_ns())
        session.operator.want_engaged = False
        session.operator.session.disconnect()
        session.operator.capabilities["fingers"] = ["thumb"]  # and is not let in again
        return "disconnected" in lines[-1].values()

    lines = session.observe(identified, presses_harder, lifts, ends)
    first, lifted, silent, last = lines
    assert len({json.dumps([line["state"], line["fingers"]]) for line in lines}) == 4
    assert silent["state"] == "silent", "its end is noticed later than that nothing comes"
    assert first["measured"]["index"]["force_n"] == 1.23
    assert first["state"] == "engaged"
    assert 0.0 < first["time_s"] <= time.monotonic()
    assert lifted["fingers"]["index"]["mode"] == "free"
    assert last == {"time_s": None, "age_ms": None, "state": "disconnected", "fingers": {}, "measured": {}}


def test_an_old_identification_counts_as_none(session: Session) -> None:
    session.until(session.engaged)

    def identified(lines: list[dict[str, Any]]) -> bool:
        session.observed = not (bool(lines) and lines[-1]["fingers"]["index"]["material"] == "pine")
        return not session.observed

    def silent(lines: list[dict[str, Any]]) -> bool:
        return lines[-1]["state"] not in ("connected", "engaged")

    lines = session.observe(identified, silent)
    assert session.server.session.ident, "the session is alive: only what is observed has stopped"
    assert lines[-1] == {"time_s": None, "age_ms": None, "state": "silent", "fingers": {}, "measured": {}}


def test_nothing_is_reported_without_an_operator(session: Session) -> None:
    session.operator.capabilities["fingers"] = ["thumb"]  # the remote site does not want it
    beginning_s = time.monotonic()
    assert session.observe(lambda _: time.monotonic() - beginning_s > 0.5) == []


def test_an_untrusted_client_reports_the_reason_once_and_observes_as_soon_as_it_is_trusted(
    session: Session, keys: Keys, caplog: pytest.LogCaptureFixture
) -> None:
    session.until(session.engaged)
    trusted = TrustedKeys(keys.remote)
    trusted.revoke("student")
    begin_s = time.monotonic()

    def asked_thrice(lines: list[dict[str, Any]]) -> bool:
        assert not lines
        return time.monotonic() - begin_s > 3.0

    def trust(lines: list[dict[str, Any]]) -> bool:
        trusted.trust("student", load_keys(keys.stranger).public, Role.OBSERVER)
        return True

    assert session.observe(asked_thrice, trust, bool)[0]["state"] == "engaged"
    refusals = [text for text in caplog.messages if "does not trust this site's key as an observer's" in text]
    assert len(refusals) == 1


def test_nothing_is_observed_without_the_remote_sites_key(keys: Keys) -> None:
    with pytest.raises(KeyProblem, match="no key named `remote`"):
        run_observer(ObserverConfig(link=OperatorLinkConfig(keys=keys.stranger)), lambda: False)


def test_the_operators_own_key_does_not_observe_beside_it(session: Session, keys: Keys, base_port: int) -> None:
    """Heartbeats of both would be taken for one and the same clock."""
    session.until(session.engaged)
    remote_key = load_keys(keys.remote).public
    with OperatorLink("127.0.0.1", base_port, load_keys(keys.operator), remote_key, Role.OBSERVER) as link:
        second = SessionClient(link, capabilities((), 50.0), 0.15, want_engaged=False, role=OBSERVER)

        def reported() -> bool:
            second.step(time.monotonic_ns(), "")
            return "an observer needs one of its own" in second.refusal

        session.until(reported)
        assert second.session.ident == 0
    assert session.server.observers == {}
    assert session.engaged()


def test_a_read_only_key_is_refused_on_operator_streams(session: Session, keys: Keys, base_port: int) -> None:
    session.until(session.engaged)
    remote_key = load_keys(keys.remote).public
    with OperatorLink("127.0.0.1", base_port, load_keys(keys.stranger), remote_key) as link:
        session.until(link.key_refused)
        for _ in range(50):
            link.send_latest("motion", b"harm")
            session.turn()
    assert session.server.damaged["motion"] == 0
    assert session.engaged()


def test_cutting_off_a_read_only_client_closes_the_socket_only_briefly(session: Session, keys: Keys) -> None:
    """The operator's own heartbeats and requests come through the sockets that are bound again."""
    session.until(session.engaged)
    ident = session.server.session.ident
    trusted, student = TrustedKeys(keys.remote), load_keys(keys.stranger).public
    for _ in range(5):
        trusted.trust("student", student, Role.OBSERVER)
        session.observe(lambda lines: lines)
        trusted.revoke("student")
        assert session.link.recheck_keys() == {student}  # and once only: nobody looks again for a second
        before = session.operator.clock.round_trip_ns
        session.until(lambda before=before: session.operator.clock.round_trip_ns != before)  # type: ignore[misc]
    session.until(session.engaged)
    assert session.server.session.ident == ident
