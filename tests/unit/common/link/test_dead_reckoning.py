"""Places between two packets follow the hand, are bounded, and stay within the threshold of the sender."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.link.deadband import HEIGHT_M, ONWARDS_S, PLANE_M, TOGETHER_S, Deadband, DeadReckoning, motion_perceptible
from common.timing.timeouts import REFRESH_S
from common.wire.messages import MotionRow

TICK_S = 0.002
HALF_RANGE_M = np.array([0.66, 0.66, 0.0103])


def after(*packets: tuple[float, float]) -> DeadReckoning:
    """A prediction that has taken packets: time and x of all fingers."""
    prediction = DeadReckoning()
    for t_s, x_m in packets:
        prediction.take(t_s, [MotionRow(x_m, 0.0, 0.0)] * 5)
    return prediction


def x_at(prediction: DeadReckoning, t_s: float) -> float:
    """The predicted x."""
    places = prediction.at(t_s)
    assert places is not None
    return places[0].x_m


def test_motion_continues_at_its_last_speed_and_stops_after_two_refreshes() -> None:
    prediction = after((1.0, 0.1), (1.012, 0.1012))
    assert x_at(prediction, 1.012) == pytest.approx(0.1012)
    assert x_at(prediction, 1.020) == pytest.approx(0.1020, abs=1e-7)
    assert x_at(prediction, 1.012 + ONWARDS_S) == x_at(prediction, 2.0) == pytest.approx(0.1012 + 0.1 * ONWARDS_S)
    assert x_at(prediction, 1.0) == pytest.approx(0.1012), "never back beyond the last packet"


def test_there_is_a_speed_only_between_packets_that_belong_together() -> None:
    assert DeadReckoning().at(1.0) is None, "before the first packet nothing is known"
    assert x_at(after((1.0, 0.1)), 1.01) == pytest.approx(0.1)
    assert x_at(after((1.0, 0.1), (1.002, 0.1002)), 1.01) == pytest.approx(0.1002)
    assert x_at(after((1.0, 0.1), (1.012, 0.1012), (1.014, 0.1014)), 1.02) == pytest.approx(0.1020, abs=1e-7)
    assert x_at(after((1.0, 0.1), (1.0 + TOGETHER_S + 0.01, 0.2)), 1.1) == pytest.approx(0.2), "across a pause"
    assert x_at(after((9.0, 0.1), (9.012, 0.2), (1.0, 0.3)), 1.01) == pytest.approx(0.3), "the clock was set back"


Walk = st.lists(
    st.tuples(*[st.floats(-1.0, 1.0)] * 15, st.sampled_from((0.0, 1e-4, 1e-3, 1.0))), min_size=2, max_size=60
)


@given(Walk, st.sampled_from((0.001, TICK_S, 0.010)))
def test_the_receivers_error_without_loss_stays_below_the_threshold(
    walk: list[tuple[float, ...]], tick_s: float
) -> None:
    """Whatever the hand does, jumps through its whole range included; times are those of a session of weeks."""
    deadband, sender, receiver = Deadband(tick_s), DeadReckoning(), DeadReckoning()
    place, sent_s = np.zeros((5, 3)), 0.0
    for tick, (*steps, size) in enumerate(walk):
        t_s = 1e6 + tick_s * tick
        place = np.clip(place + size * np.reshape(steps, (5, 3)) * HALF_RANGE_M, -HALF_RANGE_M, HALF_RANGE_M)
        true = [MotionRow(*row) for row in place.astype(np.float32).tolist()]
        expected = sender.at(t_s)
        if deadband.step(t_s, expected is None or motion_perceptible(expected, true)):
            sender.take(t_s, true)
            receiver.take(t_s, true)
            sent_s = t_s
        there = receiver.at(t_s)
        assert there is not None
        assert (np.abs(np.subtract(there, true)) <= np.array([PLANE_M, PLANE_M, HEIGHT_M]) + 1e-7).all()
        assert t_s - sent_s <= REFRESH_S + 0.25 * tick_s
