"""A force that swings by itself is found; hands that tap, press, tremble, stroke and feel a breath are not."""

import itertools
import math
import random
from collections import deque
from collections.abc import Callable, Iterable, Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.faults.texts import fault_text
from common.limits import FORGIVEN_W, PRODUCED_J, SWING_CYCLES, SWING_N, SWING_S, SWING_SLOW_CYCLES, SWING_SLOW_HZ
from common.safety.oscillation_detector import OscillationDetector
from operator_site.safety.passivity_controller import PassivityController

T = 0.002


def found(forces: Iterable[float], fed: Callable[[int], bool] = lambda tick: False) -> tuple[float, str]:
    """Time at which a swinging force is reported, s, and the text; infinite when it is not."""
    watch = OscillationDetector()
    for tick, force_n in enumerate(forces):
        fault = watch.step(T * tick, force_n, fed(tick))
        if fault is not None:
            return T * tick, fault_text(fault)
    return math.inf, ""


def sine(hz: float, swing_n: float, seconds: float = 2.0, mean_n: float = 3.0) -> list[float]:
    return [mean_n + 0.5 * swing_n * math.sin(2.0 * math.pi * hz * T * tick) for tick in range(round(seconds / T))]


Peaks = list[tuple[float, float]]
"""When, s, and how far above what lies between them, N."""


def found_first(
    watch: OscillationDetector, peaks: Peaks, fed: Sequence[bool] = (), base_n: float = 1.0
) -> tuple[int, str] | None:
    """Which peak of a course is found first, and the words; `fed` is of each peak's cycle."""
    watch.step(peaks[0][0] - 0.001, base_n, False)
    for number, (t_s, swing_n) in enumerate(peaks):
        watch.step(t_s, base_n + swing_n, number < len(fed) and fed[number])
        if number:  # a peak is where it was reached
            watch.step(t_s + 0.001, base_n + swing_n, False)
        swings = watch.step(t_s + 0.002, base_n, False)
        if swings is not None:
            return number, fault_text(swings)
    return None


def evenly(period_s: float, cycles: int = SWING_CYCLES, swing_n: float = 2.0) -> Peaks:
    return [(period_s * number, swing_n) for number in range(cycles + 1)]


def after(periods_s: Iterable[float]) -> Peaks:
    return [(t_s, 2.0) for t_s in itertools.accumulate(periods_s, initial=0.0)]


FASTEST_S = SWING_S / SWING_CYCLES
AT_ONCE = SWING_CYCLES, "force swings at 12 Hz by 2.0 N"


def test_cycles_at_the_limit_of_number_and_time_are_found() -> None:
    assert found_first(OscillationDetector(), evenly(FASTEST_S)) == AT_ONCE
    assert found_first(OscillationDetector(), evenly(1.0001 * FASTEST_S, 30)) is None
    small = found_first(OscillationDetector(), evenly(FASTEST_S, swing_n=SWING_N), base_n=0.0)
    assert small == (SWING_CYCLES, "force swings at 12 Hz by 0.4 N")
    assert found_first(OscillationDetector(), evenly(FASTEST_S, 30, SWING_N - 1e-6), base_n=0.0) is None


def test_only_the_last_cycles_count_and_none_from_before_a_restart() -> None:
    assert found_first(OscillationDetector(), after(10 * [0.125] + 10 * [1 / 16])) == (
        14,
        "force swings at 12 Hz by 2.0 N",
    )
    watch = OscillationDetector()
    assert found_first(watch, evenly(FASTEST_S, SWING_CYCLES - 1)) is None
    watch.restart()
    assert found_first(watch, [(0.5 + t_s, swing_n) for t_s, swing_n in evenly(FASTEST_S)]) == AT_ONCE


@pytest.mark.parametrize(
    ("periods", "expected", "hz"),
    [
        pytest.param([1, 2, 1, 2, 1, 2], 6, 21, id="twice as long, or half, is the same swinging"),
        pytest.param([1, 1, 1, 2.0625, 2, 2, 2, 2, 2], 9, 16, id="longer is another one"),
        pytest.param([2, 2, 2, 0.9375, 1, 1, 1, 1, 1], 9, 32, id="shorter is another one"),
    ],
)
def test_cycles_belong_together_when_they_last_about_as_long(periods: list[float], expected: int, hz: int) -> None:
    words = f"force swings at {hz} Hz by 2.0 N"
    assert found_first(OscillationDetector(), after(period / 32 for period in periods)) == (expected, words)


@pytest.mark.parametrize(("low_n", "expected"), [(2.0, True), (1.9375, False)])
def test_cycles_belong_together_while_they_do_not_die_down(low_n: float, expected: bool) -> None:
    peaks = [(t_s, low_n if number % 2 else 4.0) for number, (t_s, _) in enumerate(evenly(1 / 16, 30))]
    assert found_first(OscillationDetector(), peaks) == ((6, "force swings at 16 Hz by 4.0 N") if expected else None)


SLOWEST = [(0.0, 2.0), (1.0 / SWING_SLOW_HZ, 2.0), (2.0 / SWING_SLOW_HZ, 2.0), (0.999, 2.0)]


@pytest.mark.parametrize(
    ("peaks", "fed", "expected"),
    [
        pytest.param(SLOWEST, [True] * 4, (3, "force swings at 3 Hz by 2.0 N"), id="as slow as it may be"),
        pytest.param([(1.001 * t_s, n) for t_s, n in SLOWEST], [True] * 4, None, id="too slow"),
        pytest.param(evenly(0.25), [False, True, True, True], (3, "force swings at 4 Hz by 2.0 N"), id="three fed"),
        pytest.param(evenly(0.25), [True, True, True, False, True, True], None, id="two at a time"),
        pytest.param(after([0.125, 0.125, 0.3, 0.3]), [True] * 5, None, id="two of another swinging"),
        pytest.param([(0.0, 2.0)] * 20, [True] * 20, None, id="a clock that stands still"),
    ],
)
def test_slow_cycles_are_found_when_enough_in_a_row_are_fed(
    peaks: Peaks, fed: list[bool], expected: tuple[int, str] | None
) -> None:
    assert found_first(OscillationDetector(), peaks, fed) == expected


@pytest.mark.parametrize("hz", [12.5, 23.0, 60.0, 125.0])
def test_a_swing_faster_than_a_hand_is_reported_within_half_a_second(hz: float) -> None:
    took_s, fault = found(sine(hz, 1.2))
    assert took_s <= SWING_S + 1.5 / hz
    assert fault.startswith("force swings at ")
    assert float(fault.split()[3]) == pytest.approx(hz, rel=0.05, abs=0.5)
    assert float(fault.split()[6]) == pytest.approx(1.2, abs=0.35 if hz > 60.0 else 0.1)


@pytest.mark.parametrize("hz", [3.2, 6.0, 11.0])
def test_a_slow_swing_is_reported_where_the_energy_limit_acts_in_every_cycle(hz: float) -> None:
    force = sine(hz, 1.2, 4.0)
    each, second = (lambda tick: math.sin(2.0 * math.pi * hz * T * tick) > 0.9), round(2.0 / hz / T)
    assert found(force, each)[0] <= (SWING_SLOW_CYCLES + 2.5) / hz
    assert found(force, lambda tick: each(tick) and tick % second < second // 2)[0] == math.inf  # in every other one
    assert found(force)[0] == math.inf


def test_swings_below_the_limits_of_rate_and_size_are_not_reported() -> None:
    assert found(sine(0.9 * SWING_SLOW_HZ, 5.0, 6.0), lambda tick: True)[0] == math.inf
    assert found(sine(23.0, 0.95 * SWING_N), lambda tick: True)[0] == math.inf


def test_ringing_after_an_impact_is_not_reported() -> None:
    """Taps of a stiff remote finger on a hard object, each with its bounces."""

    def tap(since_s: float) -> float:
        rings = 3.0 * math.exp(-since_s / 0.02) * math.sin(2.0 * math.pi * 45.0 * since_s)
        return max(0.0, (2.0 + rings) if since_s < 0.06 else 0.0)

    assert found(tap(math.fmod(T * tick, 0.125)) for tick in range(3000))[0] == math.inf


def test_a_clock_set_back_only_delays_the_report() -> None:
    watch, fault = OscillationDetector(), []
    for tick, force_n in enumerate(sine(25.0, 2.0, 4.0)):
        fault.append(watch.step(T * tick - (500.0 if tick >= 100 else 0.0), force_n, False))
    assert fault[99] is None
    assert next(tick for tick, words in enumerate(fault) if words) <= 100 + (SWING_S + 0.1) / T


taps = st.lists(
    st.tuples(st.floats(0.03, 0.12), st.floats(0.0, 0.3), st.floats(0.2, 5.0), st.floats(1.0, 4.0)),
    min_size=8,
    max_size=30,
)


@given(taps, st.booleans())
def test_no_tapping_hand_is_reported(course: list[tuple[float, float, float, float]], noisy: bool) -> None:
    """Up to eight taps a second, each from 0 N to 5 N and back and free in between, quick or slow, even or not."""
    forces: list[float] = []
    for contact_s, rest_s, peak_n, shape in course:
        period_s = max(0.125, contact_s + rest_s)
        for tick in range(round(period_s / T)):
            part = T * tick / contact_s
            forces.append(peak_n * math.sin(math.pi * part) ** shape if part < 1.0 else 0.0)
    noise = random.Random(1)
    if noisy:
        forces = [max(0.0, force_n + 0.01 * noise.gauss(0.0, 1.0)) for force_n in forces]
    assert found(forces) == (math.inf, "")


hands = st.tuples(
    st.floats(0.5, 4.0), st.floats(2e-5, 1e-4), st.floats(8.0, 12.0), st.floats(0.1, 0.4), st.floats(0, 2)
)


@given(hands)
def test_no_tremor_stroke_or_breath_is_reported(hand: tuple[float, float, float, float, float]) -> None:
    """A hand pressed on the stiffest wall (1000 N/m), trembling, over grooves of 0.08 mm, on what breathes by 4 mm."""
    pressed_n, tremor_m, tremor_hz, breath_hz, phase = hand
    forces = []
    for tick in range(1500):
        t_s = T * tick
        shaken_m = tremor_m * math.sin(2.0 * math.pi * tremor_hz * t_s + phase)
        groove_m = 0.08e-3 * max(0.0, math.sin(2.0 * math.pi * 25.0 * t_s))
        breath_m = 0.002 * math.sin(2.0 * math.pi * breath_hz * t_s)
        forces.append(max(0.0, pressed_n + 1000.0 * (shaken_m - groove_m) + 400.0 * breath_m))
    assert found(forces) == (math.inf, "")


SECONDS = 3.0


def coupled(
    wall_n_m: float,
    period_s: float,
    round_trip_s: float,
    hand: tuple[float, float, float],
    *,
    stiffest_n_m: float,
    held_back: bool,
) -> tuple[float, float, float]:
    """A finger presses a device with 0.09 kg and 0.5 Ns/m on a wall whose force comes late, and is not made passive.

    Returns:
        time at which the swinging is reported, s; true energy output, J; how far the force swings in the end, N.
    """
    kg, ns_m, n_m = hand
    port, watch = PassivityController(stiffest_n_m, 0.005, damping_n_s_m=0.5), OscillationDetector()
    late = deque([0.0] * (round(round_trip_s / period_s) + 1), maxlen=round(round_trip_s / period_s) + 1)
    place_m, speed, given_j, most_j, step_s, reported_s = -0.005, 0.0, 0.0, 0.0, 1e-4, math.inf
    forces = []
    for tick in range(round(SECONDS / period_s)):
        t_s = period_s * tick
        measured_m = round(place_m / 1e-5) * 1e-5
        port.observe(t_s, -measured_m)
        late.append(min(10.0, max(0.0, wall_n_m * measured_m)))
        force_n, payable_n = late[0], port.limit_n()
        fed = force_n > payable_n
        if held_back:
            force_n = min(force_n, payable_n)
        port.command(t_s, force_n)
        if watch.step(t_s, force_n, fed) is not None:
            reported_s = min(reported_s, t_s)
        forces.append(force_n)
        meant_m = -0.005 + (0.005 + 2.0 / wall_n_m + 2.0 / n_m) * min(1.0, t_s / 0.6)
        for _ in range(round(period_s / step_s)):
            speed += step_s / (kg + 0.09) * (n_m * (meant_m - place_m) - (ns_m + 0.5) * speed - force_n)
            place_m += step_s * speed
            given_j -= step_s * speed * (force_n + 0.5 * speed)
            most_j = max(most_j, given_j - 0.5 * 0.09 * speed * speed)
    last = forces[-round(1.0 / period_s) :]
    return reported_s, most_j, max(last) - min(last)


LIGHT, FIRM, ARM = (0.006, 2.0, 200.0), (0.010, 3.0, 800.0), (1.4, 7.5, 400.0)
UNSTABLE = [
    pytest.param(5000.0, 0.005, 0.0, LIGHT, 200.0, id="too stiff for its period, light"),
    pytest.param(5000.0, 0.005, 0.0, FIRM, 200.0, id="too stiff for its period, firm"),
    pytest.param(5000.0, 0.005, 0.0, ARM, 200.0, id="too stiff for its period, arm"),
    pytest.param(1000.0, 0.001, 0.02, LIGHT, 1000.0, id="direct force, 20 ms, light"),
    pytest.param(1000.0, 0.001, 0.02, FIRM, 1000.0, id="direct force, 20 ms, firm"),
    pytest.param(1000.0, 0.001, 0.1, LIGHT, 1000.0, id="direct force, 100 ms, light"),
    pytest.param(1000.0, 0.001, 0.1, FIRM, 1000.0, id="direct force, 100 ms, firm"),
]


@pytest.mark.parametrize(("wall", "period_s", "round_trip_s", "hand", "stiffest"), UNSTABLE)
def test_unstable_loops_are_reported_and_keep_the_energy_limit_when_guarded(
    wall: float, period_s: float, round_trip_s: float, hand: tuple[float, float, float], stiffest: float
) -> None:
    reported_s, out_j, swing_n = coupled(wall, period_s, round_trip_s, hand, stiffest_n_m=stiffest, held_back=False)
    assert reported_s < 1.2
    assert out_j > 0.02
    assert swing_n > 4.0
    reported_s, out_j, swing_n = coupled(wall, period_s, round_trip_s, hand, stiffest_n_m=stiffest, held_back=True)
    assert out_j <= 1.1 * PRODUCED_J + FORGIVEN_W * SECONDS
    assert swing_n < 0.1


@pytest.mark.parametrize("round_trip_s", [0.2, 0.4])
@pytest.mark.parametrize("hand", [LIGHT, FIRM, ARM])
def test_a_loop_as_slow_as_a_hand_is_limited(round_trip_s: float, hand: tuple[float, float, float]) -> None:
    assert coupled(1000.0, 0.001, round_trip_s, hand, stiffest_n_m=1000.0, held_back=False)[1] > 0.04
    _, out_j, swing_n = coupled(1000.0, 0.001, round_trip_s, hand, stiffest_n_m=1000.0, held_back=True)
    assert out_j <= 1.1 * PRODUCED_J + FORGIVEN_W * SECONDS
    assert swing_n < 0.1


def test_the_numbers_leave_room_for_a_hand() -> None:
    assert SWING_CYCLES / SWING_S >= 1.5 * 8.0
