"""Floods of every port and readers that pause, against real processes: none ends, and a stop is answered."""

import signal
import time
from collections.abc import Iterator

import pytest

from tests.adversary.attacked import Attacked, attacked_session

pytestmark = [pytest.mark.hardening, pytest.mark.timeout(300)]

FLOOD_S = 3.0
PAUSE_S = 5.0
MOST_GROWTH_MIB = 30.0
WHO = {"second": (), "observer": (), "stranger": (), "operator": ("--no-motion",)}
"""Whose key floods, with options; a copy of the operator's key that sends motion latches a fault, judged elsewhere."""


@pytest.fixture(scope="module")
def attacked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Attacked]:
    """A session at work; what its devices did is judged when all attacks are over."""
    with attacked_session(tmp_path_factory.mktemp("attacked")) as attacked:
        yield attacked
    print(attacked.judge_devices())


def judge(attacked: Attacked, before: dict[str, float]) -> None:
    """No process has ended, memory is bounded, a stop is answered by both sites, and the session works again."""
    session = attacked.session
    assert session.processes.ended() == {}
    grown = {name: mib - before[name] for name, mib in attacked.rss_mib().items()}
    stop = attacked.stop_and_engage()
    loops = {name: figures["loop"] for name, figures in attacked.figures().items()}
    print(f"{grown}; stop {stop.said} after {stop.answered_s - stop.asked_s:.3f} s; {loops}")
    assert max(grown.values()) < MOST_GROWTH_MIB
    assert "remote" in stop.said
    attacked.end_attacks()
    session.wait_until_working(30.0)


@pytest.mark.parametrize("who", WHO)
def test_a_flood_ends_no_process_and_a_stop_is_answered(attacked: Attacked, who: str) -> None:
    before = attacked.rss_mib()
    for what in ("small", "largest"):
        attacked.attack(what, who, *WHO[who])
    time.sleep(FLOOD_S)
    assert [attacker.poll() for attacker in attacked.attackers] == [None, None]
    judge(attacked, before)


def test_readers_that_pause_end_no_process(attacked: Attacked) -> None:
    """Clients of every port never read; then each site's own process pauses, and all its sockets with it."""
    before = attacked.rss_mib()
    for who, options in WHO.items():
        attacked.attack("small", who, "--deaf", *options)
    for name in ("operator", "remote"):
        attacked.session.signal(name, signal.SIGSTOP)
        time.sleep(PAUSE_S)
        attacked.session.signal(name, signal.SIGCONT)
        time.sleep(1.0)
    judge(attacked, before)
