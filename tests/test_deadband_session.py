"""Both ends of a session with a deadband, over a network in memory that may lose packets, on virtual time."""

import math
from collections.abc import Callable
from typing import cast

import numpy as np
import pytest

from common.limits import GAP_S
from common.link.capabilities import capabilities
from common.link.deadband import HEIGHT_M, ONWARDS_S, PLANE_M, Deadband
from common.link.link import OperatorLink, RemoteLink
from common.timing.timeouts import REFRESH_S
from common.wire.messages import TOUCH_BLOCK, TOUCH_FIELDS, Touch
from common.wire.packets import Floats, LinkState
from operator_site.session.session_client import SessionClient
from remote_site.session.session_server import SessionServer
from teletaction.testbed.network import TO_REMOTE, Network, OperatorEnd, RemoteEnd

TICK_S = 0.002
ABLE = capabilities(("index",), 500.0)
NOTHING = TOUCH_BLOCK.to_bytes(np.zeros((5, len(TOUCH_FIELDS)), np.float32))
STEP_M = np.array([PLANE_M, PLANE_M, HEIGHT_M])
THRESHOLD_M = 0.5e-3
"""What a hand may notice, in any direction."""


def at_rest(_: float) -> tuple[float, float, float]:
    """A hand that stays."""
    return 0.1, 0.02, 0.003


def at_work(t_s: float) -> tuple[float, float, float]:
    """A hand that strokes at 0.1 m/s while its fingers come down and lift."""
    return 0.03 * math.sin(3.3 * t_s), 0.005 * math.sin(1.7 * t_s), 0.003 * math.sin(6.0 * t_s)


class Pair:
    """Two ends that are engaged; the operator's clock is 100 s, the remote one's 7000 s when it begins."""

    def __init__(self, hand: Callable[[float], tuple[float, float, float]], deadband: bool = True) -> None:
        self.network, self.hand = Network(seed=3), hand
        self.client = SessionClient(
            cast(OperatorLink, OperatorEnd(self.network)),
            ABLE,
            0.15,
            want_engaged=True,
            deadband=Deadband(TICK_S) if deadband else None,
        )
        self.server = SessionServer(cast(RemoteLink, RemoteEnd(self.network)), ABLE, 0.15)
        self.time_s, self.sequence, self.sent = 0.0, 0, list[float]()
        self.places: list[tuple[float, Floats]] = []
        self.run(1.0)
        assert self.client.both_engaged
        assert self.server.both_engaged

    def run(self, seconds: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Let time pass; returns how far the remote end is off in each tick, as a share of THRESHOLD_M."""
        off = []
        for _ in range(round(seconds / TICK_S)):
            self.time_s = self.network.now_s = self.time_s + TICK_S
            self.server.step(round((7000.0 + self.time_s) * 1e9), "")
            session = self.server.session
            if session.ident:
                self.sequence += 1
                now_ns = round((7000.0 + self.time_s) * 1e9)
                touch = Touch(session.ident, self.sequence, now_ns, session.state, NOTHING, ("",) * 5, ())
                RemoteEnd(self.network).send_latest("touch", touch.encode())
            operator_ns = round((100.0 + self.time_s) * 1e9)
            self.client.step(operator_ns, "")
            x_m, y_m, z_m = self.hand(self.time_s)
            if self.client.send_motion(operator_ns, x_m, y_m, [z_m] * 5) is not None:
                self.sent.append(self.time_s)
            places = self.server.places(round((7000.0 + self.time_s) * 1e9))
            # What is sent in one tick is there in the next.
            true_m = np.array(self.hand(self.time_s - TICK_S), np.float32)
            off.append(math.inf if places is None else float(np.abs(places - true_m).max()) / THRESHOLD_M)
        return np.array(off)


def test_a_resting_hand_sends_only_refreshes_and_stays_engaged() -> None:
    pair = Pair(at_rest)
    before = len(pair.sent)
    off = pair.run(3.0)
    assert len(pair.sent) - before == pytest.approx(3.0 / REFRESH_S, abs=1)
    assert pair.client.spared + len(pair.sent) == pytest.approx(pair.time_s / TICK_S, abs=100)
    assert off.max() < 0.01
    assert pair.server.both_engaged


def test_a_moving_hand_is_followed_within_the_threshold_by_a_fifth_of_the_packets() -> None:
    pair, dense = Pair(at_work), Pair(at_work, deadband=False)
    before, all_before = len(pair.sent), len(dense.sent)
    off = pair.run(3.0)
    dense.run(3.0)
    assert off.max() * THRESHOLD_M <= STEP_M.max() + 1e-7
    assert len(dense.sent) - all_before == 1500, "every tick without a deadband"
    assert len(pair.sent) - before < 0.2 * 1500


@pytest.mark.parametrize("draw", range(3))
def test_the_error_is_below_the_threshold_one_refresh_after_a_loss_of_a_fifth(draw: int) -> None:
    pair = Pair(at_work)
    for _ in range(10):
        pair.network.impair(TO_REMOTE, "motion", drop=0.2)
        pair.run(0.2 + 0.01 * draw)
        pair.network.heal()
        pair.run(REFRESH_S + TICK_S)
        assert pair.run(0.1).max() < 1.0
    assert pair.server.both_engaged


def test_a_fifth_lost_for_long_is_no_gap() -> None:
    pair = Pair(at_rest)
    pair.network.impair(TO_REMOTE, "motion", drop=0.2)
    for _ in range(20):
        pair.run(1.0)
        gap_ns = pair.server.acceptance.gap_ns(round((7000.0 + pair.time_s) * 1e9))
        assert gap_ns is not None
        assert gap_ns < GAP_S * 1e9
        assert pair.server.both_engaged


def test_a_hand_without_packets_stops_after_two_refreshes() -> None:
    pair = Pair(at_work)
    pair.network.impair(TO_REMOTE, "motion", cut=True)
    pair.run(ONWARDS_S + 2 * TICK_S)
    stands = pair.server.places(round((7000.0 + pair.time_s) * 1e9))
    pair.run(0.05)
    after = pair.server.places(round((7000.0 + pair.time_s) * 1e9))
    assert stands is not None
    assert after is not None
    np.testing.assert_allclose(after, stands, atol=1e-12)


def test_a_release_is_sent_in_the_same_tick_and_again_in_the_next() -> None:
    pair = Pair(at_rest)
    pair.run(3 * TICK_S)
    before_n = len(pair.sent)
    pair.client.session.disengage("let go")
    pair.client.want_engaged = False
    pair.run(2 * TICK_S)
    assert pair.sent[before_n:] == pytest.approx([pair.time_s - TICK_S, pair.time_s])
    pair.run(TICK_S)
    assert pair.server.motion is not None
    assert pair.server.motion.state is LinkState.CONNECTED


def test_each_session_begins_with_a_packet() -> None:
    pair = Pair(at_rest)
    ident = pair.server.session.ident
    pair.network.impair(cut=True)
    pair.run(2.0)
    assert pair.server.places(0) is None or pair.server.session.ident == 0
    pair.network.heal()
    pair.run(2.0)
    assert pair.server.session.ident not in (0, ident)
    assert pair.server.both_engaged
    assert pair.run(0.1).max() < 0.01
