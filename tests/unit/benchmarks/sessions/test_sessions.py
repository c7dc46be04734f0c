"""Sessions on one machine: loops that do not keep their rates are reported, with the lacking resource."""

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgpack
import pytest

from benchmarks.link.packets import next_motion
from benchmarks.sessions.figure import plot
from benchmarks.sessions.look import Look, look
from benchmarks.sessions.recorded import Recorded
from benchmarks.sessions.run import Stage, does_not_fit, measure, silent, tables
from common.limits import GAP_S
from common.recording.recorder import PACKET_SCHEMA, Recorder
from teletaction.session.demo_files import PROCESSES
from teletaction.session.processes import SessionProcesses
from tests.unit.studies.written import draw_figure, write_tables
from tests.waiting import wait_until

SECONDS = 10.0
RECORDED = Recorded({}, {})


def seen(at_s: float, hz: float, behind: str = "", state: str = "engaged", works: float = 0.3) -> Look:
    """A process whose loop has made this rate of ticks, of 500 a second, since time 0."""
    found = {
        "time_ns": round(at_s * 1e9),
        "loop": {"period_ms": 2.0, "ticks": round(at_s * hz)},
        "behind": behind,
        "behind_s": at_s if behind else 0.0,
        "state": state,
        "sent": {"motion": round(80 * at_s), "touch": round(90 * at_s)},
        "spared": {"motion": round(420 * at_s), "touch": round(410 * at_s)},
        "received": {"motion": round(79 * at_s), "touch": round(88 * at_s)},
        "superseded": {"motion": round(at_s), "touch": round(2 * at_s)},
        "refused": {"motion": {"age": 3}, "touch": {}, "damaged": {}},
    }
    return Look(at_s, found, works * at_s, 0.9 * works * at_s, 0.5 * at_s, 60.0)


def stage(*sessions: dict[str, Any], idle: float = 0.5) -> Stage:
    """Sessions by the differences of their processes from usual ones."""
    sides = [
        [{name: seen(at_s, **{"hz": 500.0, **each.get(name, {})}) for name in PROCESSES} for each in sessions]
        for at_s in (100.0, 100.0 + SECONDS)
    ]
    return Stage(sides[0], sides[1], {"idle": idle, "stolen": 0.0})


def test_sessions_that_fit_have_nothing_to_say() -> None:
    both = stage({}, {})
    loops = both.loops([RECORDED] * 2)
    assert len(loops) == 2 * len(PROCESSES)
    assert loops[0]["rate_hz"] == 500.0
    assert loops[0]["core"] == pytest.approx(0.3)
    counted = both.counted(loops)
    assert (counted["hold_their_rates"], counted["engaged_at_end"], counted["made_least"]) == (2, 2, 1.0)
    assert (counted["cores"], counted["memory_mib"]) == (pytest.approx(2.4), pytest.approx(480.0))
    assert does_not_fit(counted, loops) == silent(loops) == []


def test_a_loop_that_does_not_fit_is_reported_with_the_lacking_resource() -> None:
    remote = {"remote": {"hz": 300.0, "behind": "300 of 500 ticks a second"}}
    for idle, waits, lacking in (
        (0.01, 0.5, "lacks processors: 1% of processor time is idle, "),
        (0.6, 0.5, "lacks a free processor when one is needed: 60% of processor time is idle, "),
        (0.6, 0.05, "lacks time of the loop itself, not processors: "),
    ):
        both = stage({}, remote, idle=idle)
        loops = [row | {"loop_waits": waits} for row in both.loops([RECORDED] * 2)]
        (line,) = does_not_fit(both.counted(loops), loops)
        assert line.startswith(
            "2 sessions: 1 x remote behind, 300 of 500 ticks a second at worst; works 27% of the time"
        )
        assert f"waits for a processor {waits:.0%}" in line
        assert lacking in line
        assert silent(loops) == [], "its status says so"
    assert both.counted(loops)["hold_their_rates"] == 1


def test_a_process_that_is_behind_and_says_nothing_is_a_problem() -> None:
    loops = stage({"operator": {"hz": 400.0}}).loops([RECORDED])
    assert silent(loops) == [
        "1 sessions: operator of session 1 makes 80% of its ticks, and its status does not report it"
    ]


def test_a_session_that_has_fallen_and_one_that_never_came_are_reported() -> None:
    some = stage({}, {"remote": {"state": "fault"}}, {})
    del some.end[2]["operator"]
    loops = some.loops([RECORDED] * 3)
    assert len(loops) == 3 * len(PROCESSES) - 1
    assert does_not_fit(some.counted(loops), loops) == ["3 sessions: 2 no longer engaged"]
    assert len(some.streams([RECORDED] * 3)) == 4


def test_packets_are_counted_at_both_ends() -> None:
    motion, _ = stage({}).streams([RECORDED])
    rates = {name: motion[f"{name}_hz"] for name in ("sent", "spared", "received", "superseded", "refused")}
    assert rates == {"sent": 80.0, "spared": 420.0, "received": 79.0, "superseded": 1.0, "refused": 0.0}
    assert motion["age_p50_ms"] is None
    assert motion["longest_gap_ms"] == SECONDS * 1e3, "none came at all"
    assert motion["gap_share"] == pytest.approx(1.0 - GAP_S / SECONDS)


def test_age_and_lateness_are_read_from_the_recordings(tmp_path: Path) -> None:
    """Packets 3 ms old every 10 ms; a loop of which every tenth tick comes 1 ms late."""
    schemas: dict[str, dict[str, object]] = {"remote/gate": {"type": "array"}, "remote/motion": PACKET_SCHEMA}
    with Recorder(tmp_path / "remote.mcap", schemas, {}) as recorder:
        for tick in range(1000):
            time_ns = 10**9 + tick * 2_000_000 + (1_000_000 if tick % 10 == 9 else 0)
            recorder.write("remote/gate", time_ns, msgpack.packb([]))
            if tick % 5 == 0:
                recorder.write("remote/motion", time_ns, next_motion(tick, time_ns - 3_000_000))
    read = Recorded.read(tmp_path)
    assert read.lateness("remote", 1.0, 3.0, 0.002) == {"off_p50_us": 0.0, "off_p99_us": pytest.approx(1000.0)}
    assert read.lateness("operator", 1.0, 3.0, 0.002) == {"off_p50_us": None, "off_p99_us": None}
    found = read.arrivals("motion", 1.5, 2.5)
    assert found == {"age_p50_ms": 3.0, "age_p99_ms": 3.0, "longest_gap_ms": 10.0, "gap_share": 0.0}
    assert read.arrivals("motion", 2.0, 4.0)["gap_share"] == pytest.approx(0.45, abs=0.01)
    assert Recorded.read(tmp_path / "never began").times_s == {}


@pytest.mark.long
def test_a_process_that_records_is_looked_at_with_the_one_that_writes(tmp_path: Path) -> None:
    (tmp_path / "operator.json").write_text('{"behind": ""}', "utf-8")
    this: Any = SimpleNamespace(pid=os.getpid())
    pair = SessionProcesses(tmp_path, {"operator": this})
    alone = look(pair)["operator"]
    with Recorder(tmp_path / "operator.mcap", {"motion": PACKET_SCHEMA}, {}) as recorder:
        recorder.write("motion", 0, b"")
        wait_until(lambda: recorder.written)
        assert look(pair)["operator"].memory_mib > alone.memory_mib + 5.0, "an interpreter's"


@pytest.mark.long
def test_the_figure_shows_sessions_that_fit_and_those_that_do_not(tmp_path: Path) -> None:
    stages = [stage({}), stage({}, {"remote": {"hz": 200.0, "behind": "x"}}, idle=0.0)]
    loops = [row for each in stages for row in each.loops([RECORDED] * 2)]
    for row in loops:
        row |= {"off_p50_us": 20.0, "off_p99_us": 900.0}
    data = {
        "processors": 2,
        "loops": loops,
        "counts": [each.counted(loops) for each in stages],
        "streams": [row for each in stages for row in each.streams([RECORDED] * 2)],
    }
    draw_figure(plot, data, tmp_path, 20_000)


@pytest.mark.costs
def test_a_real_session_is_measured_and_ended(tmp_path: Path) -> None:
    data = measure((1,), seconds=3.0, seed=0, progress=lambda _: None)
    write_tables(tables(data), tmp_path)
    assert [row["process"] for row in data["loops"]] == list(PROCESSES)
    assert all(row["rate_hz"] > 0.0 and row["core"] > 0.0 and row["memory_mib"] > 10.0 for row in data["loops"])
    assert [row["stream"] for row in data["streams"]] == ["motion", "touch"]
    made_hz = {row["process"]: row["rate_hz"] for row in data["loops"]}
    for row, sender in zip(data["streams"], ("operator", "remote"), strict=True):
        assert row["sent_hz"] + row["spared_hz"] > 0.5 * made_hz[sender]
        assert 0.0 < row["age_p50_ms"] < 150.0
    assert data["counts"][0]["engaged_at_end"] == 1
    assert [len(rows) for rows in tables(data).values()] == [1, 4, 2]
