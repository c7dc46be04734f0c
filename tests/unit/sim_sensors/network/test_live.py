"""The timetable of a network on a clock, and the commands that interfere with it."""

from pathlib import Path

import pytest

from common.wire.streams import Direction
from sim_sensors.network.fault import WAYS, Way
from sim_sensors.network.file import load_network
from sim_sensors.network.live import LiveNetwork

TABLE = """
[[phase]]
from_s = 0
delay_ms = 10
loss = 0.25

[[phase]]
from_s = 5
delay_ms = 20

[[fault]]
at_s = 3
kind = "cut"

[[fault]]
at_s = 1
kind = "partition"
seconds = 2

[[fault]]
at_s = 4
kind = "stall"
seconds = 1
direction = "to_remote"
"""
START_S = 1000.0
TO_REMOTE, TO_OPERATOR = WAYS


@pytest.fixture
def live(tmp_path: Path) -> LiveNetwork:
    (tmp_path / "table.toml").write_text(TABLE, "utf-8")
    return LiveNetwork(load_network(str(tmp_path / "table.toml")))


def delay_s(live: LiveNetwork, now_s: float) -> float:
    return live.conditions(now_s).delay_s


def test_faults_begin_in_order_at_their_own_times_however_late_somebody_looks(live: LiveNetwork) -> None:
    assert live.begin_faults(START_S) == []
    assert (live.time_s(START_S), delay_s(live, START_S)) == (0.0, 0.010), "before the start it stays as at time 0"
    live.obey("start", START_S)
    assert live.begin_faults(START_S + 0.999) == []
    begun = live.begin_faults(START_S + 3.5)
    assert [(begin_s - START_S, fault.kind) for begin_s, fault in begun] == [(1.0, "partition"), (3.0, "cut")]
    partitions = live.paths[TO_OPERATOR].partitions
    assert partitions.end_s(START_S + 0.99) is None
    assert partitions.end_s(START_S + 1.0) == START_S + 3.0
    assert partitions.end_s(START_S + 3.0) is None
    assert live.begin_faults(START_S + 3.6) == []
    assert delay_s(live, START_S + 5.0) == 0.020


@pytest.mark.parametrize(
    ("direction", "ways"), [("", WAYS), (" to_remote", (Direction.TO_REMOTE,)), (" to_operator", (TO_OPERATOR,))]
)
def test_a_stall_may_concern_one_direction_alone(live: LiveNetwork, direction: str, ways: tuple[Way, ...]) -> None:
    live.obey(f"stall 3{direction}", START_S)
    live.begin_faults(START_S)
    for way in WAYS:
        assert live.paths[way].stalls.end_s(START_S + 2.9) == (START_S + 3.0 if way in ways else None)


def test_no_new_connection_while_one_direction_is_cut_off(live: LiveNetwork) -> None:
    assert not live.partitioned(START_S)
    live.obey("partition 10 to_operator", START_S)
    live.begin_faults(START_S)
    assert live.partitioned(START_S + 9.9)
    assert not live.partitioned(START_S + 10.0)


def test_a_delay_replaces_that_of_the_table_until_it_is_cleared(live: LiveNetwork) -> None:
    live.obey("start", START_S)
    live.obey("delay 400 20", START_S)
    now = live.conditions(START_S + 6.0)
    assert (now.delay_s, now.jitter_s, now.loss) == (0.4, 0.02, 0.25)
    live.obey("delay 5", START_S + 6.0)
    assert live.conditions(START_S + 6.0).jitter_s == 0.0
    live.obey("clear", START_S + 6.0)
    assert delay_s(live, START_S + 6.0) == 0.020


def test_clear_ends_what_lasts(live: LiveNetwork) -> None:
    live.obey("partition 10", START_S)
    live.obey("stall 10", START_S)
    live.begin_faults(START_S)
    live.obey("clear", START_S + 4.0)
    for path in live.paths.values():
        for outages in (path.partitions, path.stalls):
            assert outages.end_s(START_S + 3.9) == START_S + 4.0
            assert outages.end_s(START_S + 4.0) is None


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        ("", "expected partition, stall"),
        ("explode", "expected partition, stall"),
        ("partition", "needs its length"),
        ("partition soon", "'soon' is no number"),
        ("partition -1", "seconds: "),
        ("partition nan", "seconds: "),
        ("partition 1e9", "seconds: "),
        ("partition 1 upwards", "direction: "),
        ("partition 1 both 2", "expected partition, stall"),
        ("cut 3", "a cut ends both"),
        ("delay", "expected partition, stall"),
        ("delay 10 20", "jitter of at most the delay"),
        ("delay nan", "from 0 to"),
        ("delay x", "'x' is no number"),
        ("delay 1 2 3", "expected partition, stall"),
    ],
)
def test_a_command_that_is_none_is_refused_and_changes_nothing(live: LiveNetwork, command: str, expected: str) -> None:
    with pytest.raises(ValueError, match=expected) as refused:
        live.obey(command, START_S)
    assert "\n" not in str(refused.value)
    assert live.begin_faults(START_S) == []
    assert delay_s(live, START_S) == 0.010
