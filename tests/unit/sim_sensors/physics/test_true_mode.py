from hypothesis import given
from hypothesis import strategies as st

from sim_sensors.physics.true_mode import FREE, QUIESCENT, STROKING, TAPPING, TrueMode

TICK_S = 0.002


def run(path):
    """Modes along (seconds, force, speed) pieces, moving in x."""
    truth, modes, now, x = TrueMode(), [], 0.0, 0.0
    for seconds, force, speed in path:
        for _ in range(round(seconds / TICK_S)):
            now += TICK_S
            x += speed * TICK_S
            modes.append(truth.step(now, force, x, 0.0, speed))
    return modes


def test_touch_rest_stroke_rest_lift():
    modes = run([(0.1, 0.0, 0.0), (0.3, 1.0, 0.0), (0.5, 1.0, 0.05), (0.2, 1.0, 0.0), (0.1, 0.1, 0.0)])
    order = [mode for mode, before in zip(modes, [None, *modes[:-1]], strict=True) if mode != before]
    assert order == [FREE, TAPPING, QUIESCENT, STROKING, QUIESCENT, FREE]
    assert abs(modes.count(TAPPING) * TICK_S - 0.15) < 0.005
    first_stroke = modes.index(STROKING) * TICK_S
    assert abs(first_stroke - (0.4 + 0.002 / 0.05)) < 0.005
    assert abs(modes.count(STROKING) * TICK_S - (0.5 - 0.04 + 0.10)) < 0.008


def test_a_turn_is_no_rest():
    turn = [(0.3, 1.0, 0.0), (0.5, 1.0, 0.05), (0.09, 1.0, 0.0), (0.5, 1.0, 0.05)]
    modes = run(turn)
    assert set(modes[modes.index(STROKING) :]) == {STROKING}


def test_force_between_the_thresholds_keeps_what_was():
    assert set(run([(0.2, 0.2, 0.0)])) == {FREE}
    assert run([(0.1, 0.4, 0.0), (0.2, 0.2, 0.0)])[-1] == QUIESCENT


@given(st.lists(st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 0.2)), max_size=300))
def test_contact_and_mode_never_disagree(samples):
    truth, x = TrueMode(), 0.0
    for number, (force, speed) in enumerate(samples):
        x += speed * TICK_S
        mode = truth.step(number * TICK_S, force, x, 0.0, speed)
        assert (mode == FREE) == (not truth.contact)
        if force >= 0.30:
            assert truth.contact
        if force < 0.15:
            assert not truth.contact
