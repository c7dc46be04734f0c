"""Both sites with their deadbands: little is sent, and the remote hand follows as it does without."""

import numpy as np
import pytest

from common.config.site_models import RemoteConfig
from common.fingers import FINGERS
from common.timing.timeouts import REFRESH_S, SECOND_REFRESH_S
from teletaction.testbed.network import TO_OPERATOR, TO_REMOTE
from tests.virtual.session import TICK_S, VirtualSession

INDEX = FINGERS.index("index")
REMOTE_TICK_S = 1.0 / RemoteConfig.model_fields["rate_hz"].default
LAG_S = 0.036
"""Of the telemanipulator behind the hand, with one tick on the way each."""
WAYS = (("motion", TO_REMOTE), ("touch", TO_OPERATOR))


def sent(session: VirtualSession) -> tuple[int, int]:
    """Motions and touches so far."""
    return session.operator.motions_sent, session.remote.touches_sent


def test_a_remote_site_that_gets_each_motion_twice_refreshes_touch_half_as_often(session: VirtualSession) -> None:
    session.operator.client.want_engaged = False
    session.network.impair(stream="motion", duplicate=1.0)
    session.run(1.0)
    _, before = sent(session)
    session.run(3.0)
    assert sent(session)[1] - before == pytest.approx(3.0 / SECOND_REFRESH_S, rel=0.05)
    session.network.heal()
    session.run(1.2)
    _, before = sent(session)
    session.run(1.0)
    assert sent(session)[1] - before == pytest.approx(1.0 / REFRESH_S, rel=0.05)


@pytest.mark.long
def test_a_hand_that_waits_sends_only_refreshes_and_every_tick_is_counted(session: VirtualSession) -> None:
    session.operator.client.want_engaged = False
    session.run(1.0)
    before, arrived = sent(session), [session.network.ways[way].arrived for way in WAYS]
    session.run(3.0)
    for stream, was in enumerate(before):
        assert sent(session)[stream] - was == pytest.approx(3.0 / REFRESH_S, rel=0.05)
    for way, was in zip(WAYS, arrived, strict=True):
        assert session.network.ways[way].arrived - was == pytest.approx(3.0 / REFRESH_S, rel=0.05)
    for figures, stream, tick_s in (
        (session.operator.figures(), "motion", TICK_S),
        (session.remote.figures(), "touch", REMOTE_TICK_S),
    ):
        counts = [figures[count][stream] for count in ("sent", "spared")]  # type: ignore[index]
        assert sum(counts) == pytest.approx(4.0 / tick_s, abs=0.2 / tick_s), "less the ticks before there was a session"


@pytest.mark.long
def test_a_stroke_is_followed_smoothly_by_a_fifth_of_the_packets(session: VirtualSession) -> None:
    session.work()
    before = sent(session)
    truth, hand_x, set_points = list[float](), list[float](), list[float]()
    for _ in range(round(3.0 / TICK_S)):
        session.tick()
        truth.append(session.now.x_m)
        hand_x.append(session.sim_operator.hand.x_m)
        set_points.append(session.remote.gate._plane.x_m)
    for stream, was in enumerate(before):
        assert sent(session)[stream] - was < 0.2 * len(truth)
    lag = round(LAG_S / TICK_S)
    assert np.abs(np.array(truth[lag:]) - hand_x[:-lag]).max() < 1e-3
    every = round(REMOTE_TICK_S / TICK_S)
    moved, followed = np.array(hand_x[::every]), np.array(set_points[::every])
    assert np.abs(np.diff(followed)).max() < 2.0 * np.abs(np.diff(moved)).max() + 2e-5, (
        "no jumps that the hand did not make"
    )
    assert session.both_engaged


@pytest.mark.long
def test_contact_is_sent_in_the_tick_that_detects_it_and_again_in_the_next(session: VirtualSession) -> None:
    def in_contact() -> bool:
        touch = session.remote.perception.touches.get(INDEX)
        return touch is not None and touch.contact

    def touches_sent_n() -> int:
        return session.remote.touches_sent

    session.until(lambda s: s.both_engaged and not in_contact(), 20.0)
    before = touches_sent_n()
    while not in_contact():
        before = touches_sent_n()
        session.tick()
        assert session.time_s < 20.0
    assert touches_sent_n() == before + 1
    session.run(REMOTE_TICK_S)
    assert touches_sent_n() == before + 2
