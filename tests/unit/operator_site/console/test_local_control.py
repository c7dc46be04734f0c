"""Requests to a site: answers arrive, a silent site is reported in time, and a stop waits for its answer."""

import time
from collections.abc import Iterator
from contextlib import suppress

import pytest

from common.link.keys import load_keys
from common.link.session_state import Refused
from operator_site.console.local_control import PATIENCE_S, LocalControlClient, LocalControlSilent
from tests.conftest import Keys
from tests.unit.operator_site.console.stub_site import Site
from tests.waiting import wait_until


@pytest.fixture
def line(base_port: int, keys: Keys) -> Iterator[LocalControlClient]:
    made = LocalControlClient(base_port, load_keys(keys.operator))
    yield made
    made.close()


@pytest.fixture
def site(base_port: int, keys: Keys) -> Iterator[Site]:
    made = Site(base_port, keys)
    yield made
    made.close()


def reached(line: LocalControlClient) -> None:
    """Ask until the two have found each other."""

    def answered() -> bool:
        with suppress(LocalControlSilent):
            return bool(line.ask("status").result(5.0))
        return False

    wait_until(answered)


def test_what_is_asked_is_answered_or_refused(site: Site, line: LocalControlClient) -> None:
    reached(line)
    assert line.ask("attend", {"seen": True}).result(5.0)["seen"] is True
    with pytest.raises(Refused, match="a fault is latched"):
        line.ask("engage").result(5.0)
    with pytest.raises(Refused, match="longer than"):
        line.ask("annotate", {"text": "x" * 10_000}).result(5.0)


def test_a_missing_site_is_reported_in_time(line: LocalControlClient) -> None:
    began_s = time.monotonic()
    with pytest.raises(LocalControlSilent):
        line.ask("engage").result(5.0)
    assert PATIENCE_S <= time.monotonic() - began_s < 4.0 * PATIENCE_S


def test_a_request_to_nobody_is_not_kept_for_later_but_a_stop_is(
    base_port: int, keys: Keys, line: LocalControlClient
) -> None:
    engage, stop = line.ask("engage"), line.ask("estop")
    with pytest.raises(LocalControlSilent):
        engage.result(5.0)
    site = Site(base_port, keys)
    try:
        assert stop.result(10.0)["verb"] == "estop"
        reached(line)
        assert "engage" not in site.asked
        assert site.asked[0] == "estop"
    finally:
        site.close()


def test_a_stop_is_asked_for_again_until_it_is_answered(site: Site, line: LocalControlClient) -> None:
    reached(line)
    site.mute = True
    stop = line.ask("estop")
    with pytest.raises(TimeoutError):
        stop.result(3.0 * PATIENCE_S)
    site.mute = False
    assert stop.result(5.0)["verb"] == "estop"
    reached(line)
    asked = site.asked.count("estop")
    assert asked > 5, "the site was mute, not deaf"
    reached(line)
    assert site.asked.count("estop") == asked


def test_what_still_waits_when_the_line_is_closed_is_cancelled(base_port: int, keys: Keys) -> None:
    line = LocalControlClient(base_port, load_keys(keys.operator))
    stop = line.ask("estop")
    line.close()
    assert stop.cancelled()
