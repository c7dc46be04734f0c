"""Second operators, read-only clients and copies of the operator's key reach no actuator."""

import logging
from collections.abc import Callable
from typing import Any

import pytest

from common.faults.fault import Fault, FaultCode
from common.wire.packets import LinkState
from teletaction.testbed.network import OBSERVER_KEY, OPERATOR_KEY
from tests.robustness.adversary.attacker import Attacker, attack
from tests.robustness.adversary.conftest import attacker_of, judged_session
from tests.virtual.session import TICK_S, Truth, VirtualSession

pytestmark = pytest.mark.long

SECOND_KEY = "another operator's public key"
REFUSED = "motion has been refused for 1.5 s: overtaken"
ATTACK_S = 0.25
ROUNDING = 1e-6
"""In the unit of each; two sessions of one seed differ by less."""
CASES = [
    (SECOND_KEY, "motion"),
    (SECOND_KEY, "hello, then motion"),
    (SECOND_KEY, "motion far ahead"),
    (SECOND_KEY, "requests"),
    (SECOND_KEY, "heartbeats"),
    (SECOND_KEY, "small"),
    (SECOND_KEY, "largest"),
    (OBSERVER_KEY, "looks on"),
    (OBSERVER_KEY, "requests"),
    (OBSERVER_KEY, "small"),
    (OBSERVER_KEY, "largest"),
    (OPERATOR_KEY, "requests but a stop"),
    (OPERATOR_KEY, "heartbeats"),
]
"""Key and attack; each leaves the rightful operator's session as it is."""


@pytest.fixture(scope="module")
def undisturbed() -> list[Truth]:
    """What is at the actuators at each tick of the same session without attackers."""
    with judged_session() as session:
        session.run(len(CASES) * ATTACK_S)
        return session.truth


@pytest.mark.parametrize(("key", "what"), CASES)
def test_an_attack_changes_nothing_at_any_actuator(
    undisturbed: list[Truth], shared: VirtualSession, key: str, what: str
) -> None:
    attacker = attacker_of(shared, key)
    steps = attack(attacker, what)
    ident = shared.remote.server.session.ident
    for _ in range(round(ATTACK_S / TICK_S)):
        next(steps)
        shared.tick()
        expected = undisturbed[len(shared.truth) - 1]
        assert max(abs(a - b) for a, b in zip(shared.now, expected, strict=True)) < ROUNDING, (shared.now, expected)
    shared.network.visitors.clear()
    assert attacker.ident == ident, "it knew the session"
    assert shared.remote.server.session.ident == ident
    assert shared.both_engaged
    granted = attacker.refused.count("")
    assert granted == 0 or (what == "looks on" and attacker.refused[-1] != ""), attacker.refused[-5:]


def run(session: VirtualSession, attacker: Attacker, what: str, until: Callable[[], object]) -> None:
    """Attack until something is reached, for a second at most."""
    steps = attack(attacker, what)
    for _ in range(round(1.0 / TICK_S)):
        next(steps)
        session.tick()
        if until():
            return
    raise AssertionError(session.describe())


def test_motion_of_a_copied_key_moves_nothing_and_is_a_latched_fault(working: VirtualSession) -> None:
    server = working.remote.server
    run(working, attacker_of(working, OPERATOR_KEY), "motion", lambda: working.latched[0])
    assert server.session.fault == Fault(FaultCode.KEY_USED_TWICE)
    working.network.visitors.clear()
    working.run(0.3)
    assert (working.now.force_n, working.now.motor_mv, working.now.heater) == (0.0, 0, 0.0)
    working.clear_faults()
    working.run(0.5)
    working.engage()
    working.until(lambda session: session.both_engaged, 5.0)


def test_a_stop_with_a_copied_key_counts_and_the_operator_can_resume(working: VirtualSession) -> None:
    run(working, attacker_of(working, OPERATOR_KEY), "estop", lambda: working.latched[0])
    assert working.remote.server.session.fault == Fault(FaultCode.OPERATOR_STOP)
    working.network.visitors.clear()
    working.run(0.3)
    working.clear_faults()
    working.run(0.5)
    working.engage()
    working.until(lambda session: session.both_engaged, 5.0)


def test_refused_motion_ends_the_session_with_the_reason_at_both_sites(
    working: VirtualSession, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO, "common.link.session_state")
    link: Any = working.operator.client.link
    send, first = link.send_latest, []

    def same_again(stream: str, packet: bytes) -> None:
        first.append(packet)
        send(stream, first[0])

    link.send_latest = same_again
    ident = working.remote.server.session.ident
    waited_s = working.until(lambda session: session.remote.server.session.ident != ident, 2.0)
    assert waited_s > 1.4
    working.until(lambda session: session.operator.client.refusal == REFUSED, 0.02)
    working.run(0.008)
    assert working.operator.client.session.ident != ident
    assert f"disconnected: {REFUSED}" in caplog.text
    assert working.remote.server.session.state is not LinkState.ENGAGED
    assert (working.now.force_n, working.now.motor_mv) == (0.0, 0)
