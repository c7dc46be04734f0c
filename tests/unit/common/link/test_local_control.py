"""Local control over its real sockets: a site's side served in a thread, as its loop would."""

import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from common.link import local_control
from common.link.curve import LinkProblem
from common.link.keys import load_keys
from common.link.local_control import LocalControlSocket, ask_desk, stop_from_desk
from common.link.session_state import Refused
from tests.conftest import Keys


class Site:
    """Serves a desk until the test is over."""

    def __init__(self, desk: LocalControlSocket) -> None:
        self.desk = desk
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.estop = ""
        self.stop_ends_it = self.ended = False
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def do(self, verb: str, details: dict[str, Any]) -> dict[str, Any]:
        self.asked.append((verb, details))
        self.ended = self.stop_ends_it and verb == "estop"
        if verb == "engage":
            raise Refused("a fault is latched (hot plate): clear it first")
        return {"state": "connected", "estop": self.estop}

    def _serve(self) -> None:
        while not (self._over.wait(0.001) or self.ended):
            self.desk.serve(time.monotonic_ns(), self.do)

    def close(self) -> None:
        self._over.set()
        self._thread.join()


@pytest.fixture
def site(keys: Keys, base_port: int) -> Iterator[Site]:
    with LocalControlSocket(base_port, load_keys(keys.operator)) as desk:
        made = Site(desk)
        yield made
        made.close()


def test_a_request_reaches_the_site_and_its_answer_returns(site: Site, keys: Keys, base_port: int) -> None:
    answer = ask_desk(base_port, load_keys(keys.operator), "annotate", {"text": "a rough spot"})
    assert answer == {"state": "connected", "estop": ""}
    assert site.asked == [("annotate", {"text": "a rough spot"})]
    with pytest.raises(Refused, match="hot plate"):
        ask_desk(base_port, load_keys(keys.operator), "engage")


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who asks in vain gives up soon."""
    monkeypatch.setattr(local_control, "_PATIENCE_S", 0.2)
    monkeypatch.setattr(local_control, "_OUTCOME_S", 0.2)


@pytest.mark.usefixtures("impatient")
def test_a_missing_site_and_a_port_in_use_are_reported(keys: Keys, base_port: int) -> None:
    own = load_keys(keys.operator)
    with pytest.raises(LinkProblem, match="is it running"):
        ask_desk(base_port, own, "status")
    with LocalControlSocket(base_port, own), pytest.raises(LinkProblem, match="choose another desk_port"):
        LocalControlSocket(base_port, own)


@pytest.mark.usefixtures("impatient")
def test_another_key_reaches_nothing(site: Site, keys: Keys, base_port: int) -> None:
    with pytest.raises(LinkProblem, match="no site with this key answers"):
        ask_desk(base_port, load_keys(keys.stranger), "estop")
    assert site.asked == []


@pytest.mark.usefixtures("impatient")
def test_a_stop_waits_for_the_reports_of_the_devices(site: Site, keys: Keys, base_port: int) -> None:
    own = load_keys(keys.operator)
    assert "not confirmed" in stop_from_desk(base_port, own)
    site.estop = "here: stopped, confirmed by every device after 12 ms"
    assert stop_from_desk(base_port, own) == site.estop
    assert site.asked[0] == ("estop", {})


@pytest.mark.usefixtures("impatient")
def test_a_site_that_ends_after_a_stop_has_stopped(site: Site, keys: Keys, base_port: int) -> None:
    site.stop_ends_it = True
    assert stop_from_desk(base_port, load_keys(keys.operator)) == (
        "stopped, but not confirmed: the site says nothing of it"
    )
    assert site.asked == [("estop", {})]
