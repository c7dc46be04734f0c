"""Priority, latching, one cause one alarm, and that what is over is over."""

from hypothesis import given
from hypothesis import strategies as st

from operator_site.console.alarms.alarms import HELD_S, LONGEST_QUIET_S, Alarms, Cause
from operator_site.console.state.frame import Priority

HIGH = Cause(Priority.HIGH, "LINK LOST.", "Link is back.", latches=True)
MEDIUM = Cause(Priority.MEDIUM, "Link slow.")
LOW = Cause(Priority.LOW, "Disk 91 % full.")


def test_a_latching_alarm_stays_until_its_cause_is_gone_and_it_was_acknowledged() -> None:
    alarms = Alarms()
    alarms.step(1.0, {"link": HIGH})
    assert alarms.clear(1.5, "console 1") == 0, "its cause is still there"
    assert alarms.priority is Priority.HIGH
    alarms.step(100.0, {})
    (alarm,) = alarms.listed
    assert alarm.waits
    assert alarm.text == "Link is back."
    assert alarms.clear(101.0, "console 1") == 1
    (over,) = alarms.listed
    assert (over.ended_s, over.cleared_by, over.since_s) == (101.0, "console 1", 1.0)
    assert alarms.priority is Priority.NONE


def test_an_alarm_that_does_not_latch_ends_with_its_cause() -> None:
    alarms = Alarms()
    alarms.step(0.0, {"feed": Cause(Priority.HIGH, "No data.")})
    alarms.step(1.0, {})
    assert alarms.priority is Priority.NONE
    assert [(alarm.ended_s, alarm.cleared_by) for alarm in alarms.listed] == [(1.0, None)]


def test_an_alarm_that_latches_later_keeps_the_text_of_what_happened() -> None:
    alarms = Alarms()
    alarms.step(0.0, {"link": HIGH._replace(latches=False)})
    alarms.step(1.0, {"link": HIGH})
    alarms.step(1.5, {"link": LOW})
    alarms.step(2.0, {})
    (alarm,) = alarms.listed
    assert alarm.waits
    assert (alarm.text, alarm.cause.priority) == ("Link is back.", Priority.HIGH)


def test_no_alarm_ends_while_its_cause_is_unknown() -> None:
    alarms = Alarms()
    alarms.step(0.0, {"fault": HIGH})
    alarms.step(1.0, {"feed": LOW}, complete=False)
    assert [(alarm.ident, alarm.waits) for alarm in alarms.listed] == [("fault", False), ("feed", False)]


def test_a_medium_alarm_stays_three_seconds_longer_and_a_low_one_no_longer() -> None:
    alarms = Alarms()
    alarms.step(0.0, {"link": MEDIUM, "disk": LOW})
    alarms.step(1.0, {})
    assert alarms.priority is Priority.MEDIUM
    assert [alarm.ident for alarm in alarms.listed if alarm.ended_s is None] == ["link"]
    alarms.step(1.0 + HELD_S - 0.01, {})
    assert alarms.priority is Priority.MEDIUM
    alarms.step(1.0 + HELD_S, {})
    assert alarms.priority is Priority.NONE
    assert all(alarm.cleared_by is None for alarm in alarms.listed)


def test_of_one_cause_the_higher_priority_is_shown_and_stays() -> None:
    alarms = Alarms()
    alarms.step(0.0, {"link": MEDIUM})
    alarms.quiet(0.1, "link", 60.0)
    alarms.step(1.0, {"link": HIGH})
    (alarm,) = alarms.listed
    assert (alarm.cause.priority, alarm.since_s, alarm.quiet_until_s) == (Priority.HIGH, 0.0, 0.0)
    alarms.step(2.0, {"link": MEDIUM})
    assert alarms.priority is Priority.HIGH, "it latches at its highest"


def test_the_most_urgent_and_newest_comes_first_and_the_past_last() -> None:
    alarms = Alarms()
    alarms.step(0.0, {"a": LOW})
    alarms.step(1.0, {"a": LOW, "b": HIGH})
    alarms.step(2.0, {"a": LOW, "b": HIGH, "c": HIGH, "d": MEDIUM})
    alarms.step(3.0, {"b": HIGH, "c": HIGH, "d": MEDIUM})
    assert [alarm.ident for alarm in alarms.listed] == ["c", "b", "d", "a"]


def test_a_pause_of_the_sound_has_its_longest_and_ends_when_the_alarm_comes_back() -> None:
    alarms = Alarms()
    alarms.step(0.0, {"link": HIGH, "stop": HIGH._replace(silenceable=False)})
    assert alarms.quiet(1.0, "link", 1e6)
    assert not alarms.quiet(1.0, "stop", 60.0)
    assert not alarms.quiet(1.0, "nothing", 60.0)
    by_name = {alarm.ident: alarm for alarm in alarms.listed}
    assert by_name["link"].quiet_until_s == 1.0 + LONGEST_QUIET_S
    alarms.step(2.0, {"stop": HIGH})
    alarms.step(3.0, {"link": HIGH, "stop": HIGH})
    assert {alarm.ident: alarm.quiet_until_s for alarm in alarms.listed}["link"] == 0.0


def test_beginning_rising_and_ending_are_recorded_once() -> None:
    alarms = Alarms()
    for at_s, causes in ((0.0, {"x": LOW}), (1.0, {"x": LOW}), (2.0, {"x": HIGH}), (3.0, {"x": HIGH}), (4.0, {})):
        alarms.step(at_s, causes)
    alarms.clear(5.0, "me")
    assert [(alarm.cause.priority, alarm.ended_s) for alarm in alarms.take_changes()] == [
        (Priority.LOW, None),
        (Priority.HIGH, None),
        (Priority.HIGH, 5.0),
    ]
    assert alarms.take_changes() == []


causes = st.dictionaries(st.sampled_from("abc"), st.sampled_from([HIGH, MEDIUM, LOW]))


@given(st.lists(st.tuples(st.floats(0.0, 10.0), causes | st.none()), max_size=30))
def test_what_is_wrong_is_always_shown_with_at_least_its_priority(
    course: list[tuple[float, dict[str, Cause] | None]],
) -> None:
    alarms, now_s, wrong = Alarms(), 0.0, {}
    for dt_s, step in course:
        now_s += dt_s
        if step is None:
            alarms.clear(now_s, "me")
        else:
            wrong = step
        alarms.step(now_s, wrong)
        shown = {alarm.ident: alarm for alarm in alarms.listed if alarm.ended_s is None}
        assert set(wrong) <= set(shown)
        assert all(shown[ident].cause.priority >= cause.priority for ident, cause in wrong.items())
        assert all(alarm.ident in wrong or alarm.gone_s is not None for alarm in shown.values())


def test_the_list_of_the_past_is_bounded() -> None:
    alarms = Alarms()
    for n in range(500):
        alarms.step(2.0 * n, {f"{n}": LOW})
    assert len(alarms.listed) <= 201
