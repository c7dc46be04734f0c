"""Commands that people give at a site: output, exit code, and failures in one line."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import pytest

import common.link.local_control
from common.config.file import load_config, load_site, to_toml
from common.config.link_models import ObserverConfig, OperatorLinkConfig, RemoteLinkConfig
from common.config.site_models import OperatorConfig
from common.config.stream_models import VoiceConfig
from common.faults.fault import Fault, FaultCode, read_fault
from common.faults.texts import fault_text
from common.link.keys import create_keys, load_keys
from common.link.link import OperatorLink
from common.link.local_control import LocalControlSocket, ask_desk
from common.link.session_state import LONGEST_NOTE, Refused
from common.wire.packets import MAX_PACKET
from common.wire.session_messages import Request
from operator_site.devices.devices import OperatorDevices
from operator_site.session.session_client import SessionClient
from operator_site.site import OperatorSite, session_with
from tests.commands import Outcome, command, one_line
from tests.unit.operator_site.test_site import SilentLink
from tests.unit.operator_site.virtual_touch import CONFIG, Devices

VERBS = ("status", "engage", "disengage", "estop", "clear", "note")
KNOCKS = 100
"""More than a stranger's key would be allowed at once."""


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands wait a short time for an answer: there will be none."""
    monkeypatch.setattr(common.link.local_control, "_PATIENCE_S", 0.3)


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands wait a short time for what comes of them: nothing will. Their answer may take as long as it takes."""
    monkeypatch.setattr(common.link.local_control, "_OUTCOME_S", 0.3)


def ask(verb: str, config: Path) -> Outcome:
    """Give one of the session commands."""
    return command("session", verb, *(["a rough spot"] if verb == "note" else []), "--config", config)


@pytest.mark.parametrize("site", ["remote", "operator"])
@pytest.mark.parametrize("verb", VERBS)
def test_a_missing_site_is_reported(verb: str, site: str, configs: dict[str, Path], impatient: None) -> None:
    line = one_line(ask(verb, configs[site]), 2)
    assert "no site with this key answers; is it running?" in line
    assert str(load_site(configs[site]).desk_port) in line


@pytest.mark.parametrize("verb", VERBS)
def test_a_wrong_configuration_is_reported(verb: str, configs: dict[str, Path], tmp_path: Path) -> None:
    assert "absent.toml: No such file" in one_line(ask(verb, tmp_path / "absent.toml"), 2)
    (tmp_path / "bad.toml").write_text("desk_port = = 1\n", "utf-8")
    assert "bad.toml: not TOML" in one_line(ask(verb, tmp_path / "bad.toml"), 2)
    assert "sim-operator.toml:" in one_line(ask(verb, configs["sim-operator"]), 2)
    (tmp_path / "keys.toml").write_text(to_toml(ObserverConfig(link=OperatorLinkConfig(keys=tmp_path))), "utf-8")
    assert "keys.toml:" in one_line(ask(verb, tmp_path / "keys.toml"), 2)


@pytest.mark.parametrize("verb", VERBS)
def test_a_wrong_key_folder_is_reported(verb: str, configs: dict[str, Path], tmp_path: Path) -> None:
    secret = tmp_path / "keys" / "operator" / "site.key_secret"
    secret.chmod(0o640)
    assert "mode 0640 lets others read it" in one_line(ask(verb, configs["operator"]), 2)
    secret.unlink()
    assert "no key; make one with `teletaction keys init" in one_line(ask(verb, configs["operator"]), 2)


HOT = Fault(FaultCode.PLATE_TOO_HOT, "index", value=43.0, limit=42.0)
HOT_SENSOR = Fault(FaultCode.SENSOR_PLATE_TOO_HOT, "index", value=43.0, limit=42.0)


class Site:
    """Serves the desk of an operator's site until the test is over; `do` carries out what is asked."""

    def __init__(self, config: Path) -> None:
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.state: dict[str, Any] = {
            "state": "connected",
            "fault": None,
            "remote_fault": None,
            "refusal": "",
            "estop": "",
        }
        self.do: Callable[[str, dict[str, Any]], object] = lambda verb, details: None
        loaded = load_config(config, OperatorConfig)
        self._desk = LocalControlSocket(loaded.desk_port, load_keys(loaded.link.keys))
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _do(self, verb: str, details: dict[str, Any]) -> dict[str, Any]:
        self.asked.append((verb, details))
        self.do(verb, details)
        return dict(self.state)

    def _serve(self) -> None:
        while not self._over.wait(0.001):
            self._desk.serve(time.monotonic_ns(), self._do)

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        self._desk.close()


@pytest.fixture
def site(configs: dict[str, Path]) -> Iterator[Site]:
    made = Site(configs["operator"])
    yield made
    made.close()


def test_the_status_is_json(site: Site, configs: dict[str, Path]) -> None:
    code, out, err = command("session", "status", "--config", configs["operator"]).said
    assert (code, err) == (0, "")
    assert json.loads(out) == site.state
    site.state["fault"] = HOT
    said = json.loads(command("session", "status", "--config", configs["operator"]).out)["fault"]
    assert read_fault(said) == HOT
    assert (said["unit"], said["text"]) == ("C", fault_text(HOT))


@pytest.mark.parametrize(
    ("verb", "asked"),
    [
        ("engage", ("engage", {})),
        ("disengage", ("disengage", {})),
        ("clear", ("clear_fault", {})),
        ("restore-force", ("restore_force", {})),
        ("note", ("annotate", {"text": "a rough spot"})),
    ],
)
def test_success_prints_nothing_and_a_refusal_is_one_line_and_a_failure(
    verb: str, asked: tuple[str, dict[str, Any]], site: Site, configs: dict[str, Path]
) -> None:
    def refuse(asked: str, details: dict[str, Any]) -> None:
        raise Refused("a fault is latched (hot plate): clear it first")

    assert ask(verb, configs["operator"]).said == (0, "", "")
    assert site.asked[0] == asked
    site.do = refuse
    assert one_line(ask(verb, configs["operator"]), 1).endswith(
        f" {verb}: a fault is latched (hot plate): clear it first"
    )


@pytest.mark.parametrize("verb", ["mute-voice", "unmute-voice"])
def test_the_voice_is_muted_at_its_own_desk(verb: str, site: Site, configs: dict[str, Path], tmp_path: Path) -> None:
    operator = load_config(configs["operator"], OperatorConfig)
    voice = VoiceConfig(link=RemoteLinkConfig(keys=operator.link.keys), source="tone:440", desk_port=operator.desk_port)
    (tmp_path / "voice.toml").write_text(to_toml(voice))
    assert ask(verb, tmp_path / "voice.toml").said == (0, "", "")
    assert site.asked == [(verb.replace("-", "_"), {})]


def test_another_key_cannot_reach_local_control(
    site: Site, configs: dict[str, Path], tmp_path: Path, impatient: None
) -> None:
    create_keys(tmp_path / "other")
    config = load_config(configs["operator"], OperatorConfig)
    link = config.link.model_copy(update={"keys": tmp_path / "other"})
    configs["operator"].write_text(to_toml(config.model_copy(update={"link": link})), "utf-8")
    for verb in VERBS:
        assert "no site with this key answers" in one_line(ask(verb, configs["operator"]), 2)
    assert site.asked == []


HERE = "here: stopped, confirmed by every device after 8 ms"
CONFIRMED = f"{HERE}; remote site: stopped, confirmed by every device after 9 ms"
UNCONFIRMED = f"{HERE}; remote site: not confirmed by telemanipulator: no report"


def test_an_emergency_stop_waits_for_its_outcome(site: Site, configs: dict[str, Path]) -> None:
    def confirm_later(verb: str, details: dict[str, Any]) -> None:
        if len(site.asked) == 5:
            site.state["estop"] = CONFIRMED

    site.do = confirm_later
    assert command("session", "estop", "--config", configs["operator"]).said == (0, CONFIRMED + "\n", "")
    assert [verb for verb, _ in site.asked] == ["estop", *["status"] * 4]


def test_an_unconfirmed_emergency_stop_is_a_failure(site: Site, configs: dict[str, Path]) -> None:
    site.state["estop"] = UNCONFIRMED
    outcome = command("session", "estop", "--config", configs["operator"])
    assert outcome.said == (1, UNCONFIRMED + "\n", f"teletaction: {UNCONFIRMED}\n")


def test_a_site_that_never_reports_the_outcome_of_a_stop_has_not_confirmed_it(
    site: Site, configs: dict[str, Path], hasty: None
) -> None:
    code, out, _ = command("session", "estop", "--config", configs["operator"]).said
    assert (code, out) == (1, "stopped, but not confirmed: the site says nothing of it\n")


def test_an_emergency_stop_succeeds_beside_many_other_requests(site: Site, configs: dict[str, Path]) -> None:
    config = load_config(configs["operator"], OperatorConfig)
    keys = load_keys(config.link.keys)
    for _ in range(KNOCKS):
        ask_desk(config.desk_port, keys, "status")
    site.state["estop"] = CONFIRMED
    assert command("session", "estop", "--config", configs["operator"]).code == 0


def test_clearing_waits_until_both_sites_are_clear(site: Site, configs: dict[str, Path]) -> None:
    site.state |= {"fault": HOT, "remote_fault": HOT_SENSOR}

    def clear_later(verb: str, details: dict[str, Any]) -> None:
        if len(site.asked) == 3:
            site.state["fault"] = None
        if len(site.asked) == 5:
            site.state["remote_fault"] = None

    site.do = clear_later
    assert command("session", "clear", "--config", configs["operator"]).said == (0, "", "")
    assert [verb for verb, _ in site.asked] == ["clear_fault", *["status"] * 4]


def test_the_reason_of_the_other_site_for_not_clearing_is_reported(site: Site, configs: dict[str, Path]) -> None:
    site.state |= {"remote_fault": Fault(FaultCode.REMOTE_STOP), "refusal": "to be cleared where it was latched"}
    line = one_line(command("session", "clear", "--config", configs["operator"]), 1)
    assert line == "teletaction: clear: the far site says: to be cleared where it was latched"


@pytest.mark.parametrize(
    ("state", "words"),
    [
        ({"fault": HOT}, f"still latched: {fault_text(HOT)}"),
        ({"remote_fault": HOT_SENSOR}, f"still latched: {fault_text(HOT_SENSOR)} (at the far site)"),
    ],
)
def test_a_fault_that_returns_at_once_is_reported(
    state: dict[str, Fault], words: str, site: Site, configs: dict[str, Path], hasty: None
) -> None:
    site.state |= state
    assert one_line(command("session", "clear", "--config", configs["operator"]), 1) == f"teletaction: clear: {words}"


class Taker(SilentLink):
    """A link that takes everything, for nobody."""

    def send(self, stream: str, packet: bytes) -> bool:
        return True

    def send_latest(self, stream: str, packet: bytes) -> None:
        pass


class Mouthpiece:
    """A desk at which the test asks."""

    def __init__(self) -> None:
        self.asks: list[tuple[str, dict[str, Any]]] = []
        self.refused: list[str] = []

    def serve(self, now_ns: int, do: Callable[[str, dict[str, Any]], dict[str, Any]]) -> None:
        for verb, details in self.asks:
            try:
                do(verb, details)
            except Refused as refusal:
                self.refused.append(str(refusal))
        self.asks.clear()


def test_a_note_that_cannot_be_recorded_is_refused_instead_of_lost() -> None:
    desk = Mouthpiece()
    client = session_with(cast(OperatorLink, Taker()), CONFIG)
    operator = OperatorSite(CONFIG, client, cast(OperatorDevices, Devices()), desk=cast(LocalControlSocket, desk))
    desk.asks = [("annotate", {"text": "a rough spot"}), ("hello", {})]
    operator.tick(1_000_000_000)
    assert desk.refused == [
        "there is no session to note anything in",
        "only the remote site can do this: give its --config",
    ]
    operator.client.session.connect(7)
    desk.asks = [("annotate", {"text": text}) for text in ("", "x" * (LONGEST_NOTE + 1), 7, "x" * LONGEST_NOTE)]
    operator.tick(1_002_000_000)
    assert desk.refused[2:] == ["a note needs a text of 1 to 1000 characters"] * 3


def test_a_note_too_long_for_the_link_is_refused_and_the_site_lives(site: Site, configs: dict[str, Path]) -> None:
    client = SessionClient(cast(OperatorLink, Taker()), {}, 0.15, want_engaged=False)
    client.session.connect(2**62)
    site.do = lambda verb, details: client.request(verb, 2**62, details)
    room = MAX_PACKET - len(Request(0, 1, time.monotonic_ns(), "annotate", {"text": "x" * 1000}).encode()) + 1000
    fits_the_desk_only = "x" * (room - 2)
    line = one_line(command("session", "note", fits_the_desk_only, "--config", configs["operator"]), 1)
    assert f"is longer than {MAX_PACKET}" in line
    assert command("session", "note", "short", "--config", configs["operator"]).said == (0, "", "")
    too_long_for_the_desk = one_line(command("session", "note", "x" * MAX_PACKET, "--config", configs["operator"]), 2)
    assert f"is longer than {MAX_PACKET}" in too_long_for_the_desk
