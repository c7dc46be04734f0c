import pickle

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from common.buses.drive_monitor import (
    LONGEST_S,
    MEMORY_S,
    NEAR_N,
    PERSIST_S,
    UNHEARD_S,
    UNREPORTED_FRAMES,
    CommandMonitor,
    Doubt,
    DriveMonitor,
    ForceMonitor,
    ReportMonitor,
)
from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from common.limits import FORCE_RAMP_DOWN_N_S, MODULE_TIMEOUT_S

HEATER = FaultCode.HEATER_UNASKED
TICK_S = 0.002


@given(st.lists(st.integers(-1000, 1000), min_size=1, max_size=200), st.integers(0, 60))
@example([700] * 500, 0)
def test_a_device_that_applies_recent_commands_is_never_a_fault(commands: list[int], late_ticks: int) -> None:
    obeys, off = DriveMonitor(HEATER), DriveMonitor(HEATER)
    for tick, drive in enumerate(commands):
        obeys.commanded(tick * TICK_S, drive)
        off.commanded(tick * TICK_S, drive)
        assert obeys.reported(tick * TICK_S, commands[max(0, tick - late_ticks)] if tick >= late_ticks else 0) is None
        assert off.reported(tick * TICK_S, 0) is None, "no drive is always right"


def test_a_stuck_drive_is_found_soon_and_a_single_wrong_report_is_not() -> None:
    obeys, found_s = DriveMonitor(HEATER), None
    for tick in range(500):
        t_s = tick * TICK_S
        obeys.commanded(t_s, tick % 7)
        applied = 1000 if tick == 100 or t_s >= 0.5 else tick % 7
        if obeys.reported(t_s, applied):
            found_s = found_s or t_s
    assert found_s is not None
    assert 0.5 + PERSIST_S <= found_s <= 0.5 + MEMORY_S + PERSIST_S
    wrong_by_turns = DriveMonitor(HEATER)
    wrong_by_turns.commanded(0.0, 0)
    assert any(wrong_by_turns.reported(tick * TICK_S, 1000 if tick % 2 else 0) for tick in range(500))


def test_a_device_is_deaf_that_reports_no_command_although_commands_are_sent() -> None:
    """Not while none is sent, nor after a standstill of the site, in which the device rightly timed out."""
    commands = CommandMonitor()
    for tick in range(1000):
        commands.reported(tick * TICK_S, received=False)
        assert not commands.deaf
    found_s, begun_s = None, 1000 * TICK_S
    for tick in range(1000, 1500):
        commands.commanded(tick * TICK_S)
        commands.reported(tick * TICK_S, received=False)
        found_s = tick * TICK_S if commands.deaf and found_s is None else found_s
    assert found_s == pytest.approx(begun_s + UNHEARD_S, abs=TICK_S)
    commands.reported(1500 * TICK_S + MODULE_TIMEOUT_S, received=False)
    assert not commands.deaf
    commands.commanded(5.0)
    commands.reported(5.0, received=True)
    assert not commands.deaf


Reports = list[tuple[float, bool]]
"""For each report how long it came after the one before, s, and whether it was wrong."""


@pytest.mark.parametrize(
    ("before", "every_s", "wrong_reports"),
    [
        pytest.param([(0.0, False)], LONGEST_S, 6, id="it may have begun just before the second wrong one"),
        pytest.param([(0.0, False)], 5.0, 6, id="what was not watched does not count"),
        pytest.param([], LONGEST_S, 6, id="from the first report on"),
        pytest.param([(0.0, True)] + 5 * [(LONGEST_S, False)], LONGEST_S, 6, id="the first was wrong, and is over"),
        pytest.param(
            [(0.0, False), (0.002, True), (0.002, True), (0.002, False)], LONGEST_S, 5, id="a doubt that is not over"
        ),
        pytest.param([(0.0, False), (0.002, True), (LONGEST_S, False)], 0.015, 8, id="a doubt that is just over"),
    ],
)
def test_wrong_reports_are_a_fault_at_the_named_time(before: Reports, every_s: float, wrong_reports: int) -> None:
    doubt, t_s, found = Doubt(), 0.0, list[bool]()
    for since_s, wrong in before + wrong_reports * [(every_s, True)]:
        t_s += since_s
        found.append(doubt.step(t_s, wrong))
    assert found == [False] * (len(found) - 1) + [True]


def test_a_command_is_in_force_for_the_named_time_after_the_next() -> None:
    obeys = DriveMonitor(HEATER)
    obeys.commanded(-1.0, 300)
    obeys.commanded(0.0, 0)
    assert obeys.reported(MEMORY_S, 300) is None
    words = [obeys.reported(MEMORY_S + LONGEST_S * k, 300) for k in range(1, 7)]
    assert [bool(said) for said in words] == [False] * 5 + [True]


@pytest.mark.parametrize(
    ("code", "value"),
    [(FaultCode.HEATER_UNASKED, 300.0), (FaultCode.DRIVES_UNASKED, None)],
)
def test_a_drive_that_stays_after_its_command_is_long_over_is_found(code: FaultCode, value: float | None) -> None:
    obeys = DriveMonitor(code)
    obeys.commanded(0.0, 300)
    obeys.commanded(1.0, 0)
    words = [obeys.reported(1.0 + tick * TICK_S, 300) for tick in range(200)]
    assert words[0] is None
    assert words[-1] == Fault(code, value=value)


def test_a_silent_module_costs_no_memory_over_any_number_of_commands() -> None:
    obeys = DriveMonitor(HEATER)
    for n in range(10_000):
        obeys.commanded(n * 0.002, n % 1000)
    assert len(pickle.dumps(obeys)) < 2000 + 30 * MEMORY_S / 0.002
    assert obeys.reported(20.0, 999) is None
    assert obeys.reported(20.1, 500) is None
    assert Fault(HEATER, value=500.0) == [obeys.reported(20.1 + tick * TICK_S, 500) for tick in range(100)][-1]


def test_a_standstill_between_two_reads_is_no_fault() -> None:
    """Both reads are of reports that waited; only the first was late, and its command ended long ago."""
    obeys = DriveMonitor(FaultCode.MOTOR_UNASKED)
    obeys.commanded(0.0, 836)
    for tick in range(100):
        obeys.commanded(0.5 + tick * TICK_S, tick)
    assert obeys.reported(0.75, 836) is None
    assert obeys.reported(0.75 + 2.0 * PERSIST_S, 836) is None
    assert obeys.reported(0.752 + 2.0 * PERSIST_S, 99) is None


REPORT_EVERY = 5
"""Ticks between two state frames."""
IN_ONE_READ = 18
"""State frames among the frames that one read takes from a bus."""


class PushingDevice:
    """An exoskeleton's drive: commands arrive late, the force follows within a ramp, and falls after the time-out."""

    def __init__(self, late_ticks: int) -> None:
        self.late_ticks = late_ticks
        self.under_way: list[tuple[int, float]] = []
        self.wanted_n = self.force_n = 0.0
        self.heard_s = -1.0

    def step(self, tick: int) -> float:
        while self.under_way and self.under_way[0][0] <= tick:
            self.wanted_n, self.heard_s = self.under_way.pop(0)[1], tick * TICK_S
        goal_n = self.wanted_n if tick * TICK_S - self.heard_s < MODULE_TIMEOUT_S else 0.0
        most_n = FORCE_RAMP_DOWN_N_S * TICK_S
        self.force_n += max(-most_n, min(most_n, goal_n - self.force_n))
        return round(self.force_n, 2)


Spans = list[tuple[int, int]]
"""When something is held up: first tick, and how many."""


def doubts(asked: list[float], late_ticks: int, held_commands: Spans, held_reports: Spans) -> list[str]:
    """What is found wrong with a device that obeys. Reports that waited come in bursts, as over a line that stood."""

    def held(tick: int, spans: Spans) -> bool:
        return any(begin <= tick < begin + ticks for begin, ticks in spans)

    obey, device, found, waiting = ForceMonitor(), PushingDevice(late_ticks), [], list[float]()
    for tick, force_n in enumerate(asked):
        obey.commanded(tick * TICK_S, [force_n] * 5)
        if not held(tick, held_commands):
            device.under_way.append((tick + late_ticks, force_n))
        applied_n = device.step(tick)
        if tick % REPORT_EVERY == 0:
            waiting.append(applied_n)
        if waiting and not held(tick, held_reports):
            newest_n = waiting[:IN_ONE_READ][-1]
            del waiting[:IN_ONE_READ]
            found += obey.reported(tick * TICK_S, [newest_n] * 5)
    return found


spans = st.lists(st.tuples(st.integers(0, 400), st.integers(1, 300)), max_size=2)


@given(
    st.lists(st.tuples(st.floats(0.0, 10.0), st.integers(1, 60)), min_size=1, max_size=12),
    st.integers(0, 15),
    spans,
    spans,
)
def test_an_exoskeleton_that_obeys_is_never_a_fault(
    steps: list[tuple[float, int]], late_ticks: int, held_commands: Spans, held_reports: Spans
) -> None:
    """Whatever is asked for, with a late line, commands that are lost for a while, and reports that come in a burst."""
    asked = [force_n for force_n, ticks in steps for _ in range(ticks)]
    assert doubts(asked, late_ticks, held_commands, held_reports) == []


CHANGE = 100
"""Tick at which the wanted force changes."""


@pytest.mark.parametrize("after_n", [0.0, 2.0, 10.0])
@pytest.mark.parametrize("before_n", [10.0, 3.0])
@pytest.mark.parametrize("late_ticks", [0, 15])
@pytest.mark.parametrize("lost_ticks", [0, 40, 70, 200])
@pytest.mark.parametrize("stood_ticks", [0, 100, 500])
def test_lost_commands_or_late_reports_of_a_change_are_no_fault(
    before_n: float, after_n: float, late_ticks: int, lost_ticks: int, stood_ticks: int
) -> None:
    asked = [before_n] * CHANGE + [after_n] * 800
    assert doubts(asked, late_ticks, [(CHANGE, lost_ticks)], [(CHANGE - 20, stood_ticks)]) == []


def test_a_force_without_a_command_is_found_soon_and_named_by_its_finger() -> None:
    obey, found_s = ForceMonitor(), None
    for tick in range(500):
        t_s = tick * TICK_S
        obey.commanded(t_s, [0.0, 0.0, 1.0, 0.0, 0.0])
        if tick % REPORT_EVERY == 0:
            found = obey.reported(t_s, [0.0, 0.0, 1.05, 10.2 if t_s >= 0.5 else 0.0, 0.0])
            if found and found_s is None:
                found_s = t_s
                assert found == [Fault(FaultCode.FORCE_UNASKED, "ring", value=10.2, limit=0.0)]
    assert found_s is not None
    assert 0.5 + PERSIST_S <= found_s <= 0.5 + PERSIST_S + 2 * REPORT_EVERY * TICK_S


def test_a_report_that_lacks_a_finger_is_refused() -> None:
    with pytest.raises(ValueError, match="shorter"):
        ForceMonitor().reported(0.0, [0.0] * 4)


def test_a_force_too_small_is_found_but_none_at_all_is_right() -> None:
    found: dict[float, list[Fault]] = {}
    for applied_n in (0.0, 3.0, 4.9):
        obey = ForceMonitor()
        for tick in range(0, 500, REPORT_EVERY):
            obey.commanded(tick * TICK_S, [5.0] * 5)
            found[applied_n] = obey.reported(tick * TICK_S, [applied_n] * 5)
    assert (found[0.0], found[4.9]) == ([], [])
    assert found[3.0][0] == Fault(FaultCode.FORCE_UNASKED, "thumb", value=3.0, limit=5.0)


@pytest.mark.parametrize("asked", [False, True])
def test_a_tiny_force_without_a_command_is_right(asked: bool) -> None:
    for applied_n in (NEAR_N, NEAR_N + 0.01):
        obey, found = ForceMonitor(), list[Fault]()
        for tick in range(100):
            if asked:
                obey.commanded(tick * TICK_S, [0.0] * 5)
            found = obey.reported(tick * TICK_S, [applied_n] * 5)
        wrong = [Fault(FaultCode.FORCE_UNASKED, finger, value=0.11, limit=0.0) for finger in FINGERS]
        assert found == (wrong if applied_n > NEAR_N else [])


def test_a_node_that_hides_its_outputs_is_found_by_its_frames_even_late_ones() -> None:
    comes = ReportMonitor()
    comes.step(1000, 7)
    comes.step(1000 + UNREPORTED_FRAMES, 7)
    assert comes.fault is None
    comes.step(1001 + UNREPORTED_FRAMES, 7)
    assert comes.fault == Fault(FaultCode.STATE_NOT_REPORTED)
    comes.step(1300 + UNREPORTED_FRAMES, 8)
    assert comes.fault is None
