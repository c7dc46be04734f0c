"""The soak finds a session that does not work as before, and reads the files of its processes."""

import json
import os
from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.faults import fault as faults
from common.faults.texts import fault_text
from common.limits import CONTACT_FORCE_N
from common.recording.recorder import Recorder
from robustness import soak
from robustness.fault_table import Fault, Outcome
from robustness.soak_growth import GROWTH_MIB_H, MORE_FILES, Life, lives
from robustness.soak_judge import LIMITS, Episode, account, over_limits
from robustness.soak_plan import FAULTS, PAUSE_S, Turn, may_contain, turns
from robustness.soak_records import LOST_AT_MOST_S, read_records
from robustness.soak_watch import Sample, read_samples, watching
from teletaction.session.demo_files import PROCESSES
from tests.waiting import wait_until

SUITS = 5


def named(key: str) -> Fault:
    (found,) = (fault for fault in FAULTS if fault.key == key)
    return found


def test_a_soak_does_not_write_over_another(tmp_path: Path) -> None:
    (tmp_path / "session").mkdir()
    with pytest.raises(FileExistsError):
        soak.run(out=tmp_path)
    with pytest.raises(SystemExit) as ended:
        soak.main(["--out", str(tmp_path)])
    assert ended.value.code == 2


@given(st.integers(0, 2**32))
def test_the_same_seed_draws_the_same_faults_and_never_two_that_cannot_meet(seed: int) -> None:
    drawn = list(islice(turns(seed), 60))
    assert drawn == list(islice(turns(seed), 60))
    for turn in drawn:
        assert PAUSE_S[0] <= turn.pause_s <= PAUSE_S[1]
        assert turn.second is None or may_contain(turn.first, turn.second)


def test_a_long_soak_meets_every_fault_and_a_short_one_every_kind() -> None:
    drawn = list(islice(turns(0), 200))
    assert {turn.first for turn in drawn} == set(FAULTS)
    assert any(turn.second for turn in drawn)
    for seed in range(20):
        first = [turn.first for turn in islice(turns(seed), SUITS)]
        assert any(fault.where == "network" for fault in first)
        assert any(fault.begin == "kill" for fault in first)
        assert any(fault.expected is Outcome.LATCHED for fault in first)


def test_a_dead_process_gets_no_command_and_a_fault_is_repaired_once() -> None:
    kill = named("sim-remote-kill")
    assert not any(may_contain(kill, fault) for fault in FAULTS if fault.where == "sim-remote")
    assert not any(may_contain(fault, kill) for fault in FAULTS if fault.where == "sim-remote")
    assert may_contain(named("remote-kill"), named("sim-remote-unplug-can"))
    opened, shorted = named("sim-remote-thermistor-index-open"), named("sim-remote-thermistor-index-short")
    assert opened.mend == shorted.mend
    assert not may_contain(opened, shorted)


def life(rss_mib: Any, open_files: Any = 20.0, seconds: int = 600) -> Life:
    time_s = np.arange(float(seconds))
    return Life("remote", 1, time_s, rss_mib + 0.0 * time_s, open_files + 0.0 * time_s, 0.0 * time_s + 5.0)


@pytest.mark.parametrize("warm_mib", [0.0, 50.0])
def test_a_warmed_up_process_may_grow_up_to_its_limit_an_hour(warm_mib: float) -> None:
    time_s = np.arange(3600.0)
    warm = 100.0 + warm_mib * np.minimum(1.0, time_s / 60.0)
    allowed = life(warm + 0.9 * GROWTH_MIB_H * time_s / 3600.0, seconds=3600).growth()
    assert allowed["wrong"] == []
    assert allowed["rss_mib_h"] == pytest.approx(0.9 * GROWTH_MIB_H, abs=0.1)
    (wrong,) = life(warm + 1.5 * GROWTH_MIB_H * time_s / 3600.0, seconds=3600).growth()["wrong"]
    assert wrong.startswith("remote: grew by ")


def test_a_file_left_open_by_every_fault_is_found_and_a_temporary_one_is_not() -> None:
    time_s = np.arange(600.0)
    (wrong,) = life(100.0, 20.0 + time_s // 30.0).growth()["wrong"]
    assert "files open at its end" in wrong
    coming_and_going = 20.0 + 3.0 * MORE_FILES * (time_s % 50.0 < 10.0)
    assert life(100.0, coming_and_going).growth()["wrong"] == []
    devices_dead_at_first = 20.0 - 9.0 * ((time_s > 200.0) & (time_s < 220.0))
    assert life(100.0, devices_dead_at_first).growth()["wrong"] == []


def test_a_restarted_process_is_judged_separately() -> None:
    samples = [Sample(float(n), "remote", 1 if n < 20 else 2, 100.0 + n, 20, 5, {}) for n in range(40)]
    assert [(each.pid, len(each.time_s)) for each in lives(samples)] == [(1, 20), (2, 20)]
    assert [each.growth()["rss_mib_h"] for each in lives(samples)] == [None, None]


HOT = faults.Fault(faults.FaultCode.PLATE_TOO_HOT, "index", value=43.0, limit=42.0)
CALM: dict[str, Any] = {
    "fault": None,
    "missing": "",
    "limited": {"middle": ["heater_contact"]},
    "texture_faults": {},
    "devices": {
        "middle texture_sensor": {"times_lost": 1, "damaged": 0, "missed": 7},
        "exoskeleton": {"times_lost": 0, "refused": {"HandPose": 1}},
    },
    "overruns": 3,
    "delay_ms": 0.0,
    "faults": {"cut": 1},
}


def seen(process: str, *, pid: int = 1, **status: object) -> dict[str, list[Sample]]:
    """A process before (at 0 s) and while (at 15 s) something is done to it, from 10 to 20 s."""
    before = Sample(0.0, process, 1, 100.0, 20, 5, CALM)
    return {process: [before, Sample(15.0, process, pid, 100.0, 20, 5, {**CALM, **status})]}


def wrong(samples: Mapping[str, list[Sample]], *keys: str, latched: str = "", recorded: str = "") -> list[str]:
    first, *second = (named(key) for key in keys)
    episode = Episode(Turn(first, second[0] if second else None, 2.0), 10.0, 12.0, next_s=20.0)
    episode.latched = [("remote", latched)] if latched else []
    account(episode, samples, [(11.0, recorded)] if recorded else [])
    return episode.wrong


def lost(**counts: int) -> dict[str, dict[str, int]]:
    return {"middle texture_sensor": {**CALM["devices"]["middle texture_sensor"], **counts}}


@pytest.mark.parametrize(
    ("key", "traced"),
    [
        ("sim-remote-unplug-middle-texture", seen("remote", devices=lost(times_lost=2))),
        ("sim-remote-unplug-middle-texture", seen("remote", missing="middle texture_sensor: gone")),
        ("sim-remote-babble-middle-texture", seen("remote", devices=lost(damaged=900))),
        ("sim-remote-unplug-can", seen("remote", missing="telemanipulator: gone")),
        ("sim-operator-silence-can", seen("operator", missing="exoskeleton: silent")),
        ("sim-operator-damage-can-crc-0.01", seen("operator", devices={"exoskeleton": {"refused": {"HandPose": 2}}})),
        ("sim-operator-unplug-middle-tacttip", seen("operator", limited={"middle": ["plate_unknown"]})),
        ("sim-remote-piezo-middle-saturated", seen("remote", texture_faults={"middle": "saturated"})),
        ("remote-kill", seen("remote", pid=2)),
        ("remote-stop-3-s", seen("remote", overruns=4)),
        ("sim-operator-slow", seen("sim-operator", overruns=70)),
        ("network-delay-100-20", seen("network", delay_ms=100.0)),
        ("network-cut", seen("network", faults={"cut": 2})),
        ("network-stall-3", seen("network", faults={"cut": 1, "stall": 1})),
    ],
)
def test_a_fault_is_reported_by_the_processes_that_must_know_it_and_no_other(
    key: str, traced: dict[str, list[Sample]]
) -> None:
    assert wrong(traced, key) == []
    (process,) = traced
    assert wrong(seen(process), key) == [f"{named(key).name}: left no trace"]
    assert wrong({}, key) == [f"{named(key).name}: left no trace"]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.key)
def test_a_calm_session_shows_no_trace_of_any_fault(fault: Fault) -> None:
    calm = {process: each for name in (*PROCESSES, "network") for process, each in seen(name).items()}
    unseen = fault.begin == "burn" or fault.begin.startswith("water") or fault.begin.endswith("frozen")
    assert unseen or f"{fault.name}: left no trace" in wrong(calm, fault.key)


def test_a_stopped_site_need_not_report_a_fault() -> None:
    stopped = seen("remote", overruns=4)
    assert wrong(stopped, "remote-stop-3-s", "sim-remote-silence-middle-texture") == []
    assert wrong(stopped, "sim-remote-silence-middle-texture") != []


def test_a_fault_too_slow_to_be_seen_need_not_be_reported() -> None:
    for key in ("sim-operator-water-middle", "sim-remote-thermistor-index-frozen"):
        assert wrong(seen("operator"), key) == []


def test_a_latched_reason_is_in_the_recording_only_where_a_fault_latches() -> None:
    samples = seen("remote", fault="it does not obey")
    key = "sim-remote-disobey"
    assert wrong(samples, key, latched="it does not obey", recorded="it does not obey") == []
    assert wrong(seen("remote"), key, latched="it does not obey", recorded="it does not obey") == [], "cleared at once"
    (unsaid,) = wrong(samples, key, latched="it does not obey", recorded="another one")
    assert "its recording does not show it" in unsaid
    assert wrong(samples, key) == ["not latched"]
    (unwanted,) = wrong(
        seen("remote", devices=lost(damaged=9)), "sim-remote-babble-middle-texture", latched="hot", recorded="hot"
    )
    assert unwanted == "latched unexpectedly: hot"


def test_a_broken_limit_is_named_with_the_fault_that_broke_it() -> None:
    held = {name: (limit, 15.0) for name, limit in LIMITS.values()}
    episode = Episode(Turn(named("network-cut"), None, 2.0), 10.0, 12.0, next_s=20.0)
    assert over_limits(held, [episode]) == []
    name = "force on the patient, N"
    held[name] = (CONTACT_FORCE_N + 0.1, 15.0)
    assert over_limits(held, [episode]) == [f"{name}: 5.10, limit 5, during ['TCP connections reset']"]
    del held[name]
    assert over_limits(held, [episode]) == [f"{name}: nothing was recorded"]


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    """One second of all recordings of a session, and one more of a remote site that was killed."""
    for process in (*PROCESSES, "remote-1"):
        streams = ["truth_fingertips", "truth_contact", "remote/session"]
        with Recorder(tmp_path / f"{process}.mcap", {name: {} for name in streams}, {}) as recorder:
            for n in range(101):
                forces = {name: [0.01 * n, 0.0] for name in ("force_n", "motor_rpm", "plate_c")}
                for stream in ("truth_fingertips", "truth_contact"):
                    recorder.write(stream, n * 10_000_000, msgpack.packb(forces))
            if process == "remote":
                recorder.write("remote/session", 500_000_000, msgpack.packb(["fault", 1, "", HOT]))
    return tmp_path


def test_recordings_are_read_to_their_ends_with_extremes_and_faults(recorded: Path) -> None:
    ends_s = {process: [1.0] for process in PROCESSES}
    ends_s["remote"] = [1.0 + 0.9 * LOST_AT_MOST_S, 1.0]
    records = read_records(recorded, ends_s)
    assert records.wrong == []
    assert records.faults == [(0.5, fault_text(HOT))]
    assert {value for value, _ in records.extremes.values()} == {1.0}
    assert set(records.messages.values()) == {202, 203}
    assert read_records(recorded, {**ends_s, "operator": []}).wrong == ["operator: 1 recordings of 0 lives"]


def test_a_recording_that_ends_too_early_or_is_damaged_is_named(recorded: Path) -> None:
    path = recorded / "operator.mcap"
    content = bytearray(path.read_bytes())
    content[len(content) // 4] ^= 1
    path.write_bytes(content)
    ends_s = {process: [1.0] for process in PROCESSES} | {"remote": [1.0, 1.0]}
    (damaged, _) = read_records(recorded, ends_s).wrong
    assert damaged == "operator.mcap: 1 damaged parts"
    ends_s["sim-remote"] = [1.0 + 1.1 * LOST_AT_MOST_S]
    path.unlink()
    assert "operator: 0 recordings of 1 lives" in read_records(recorded, ends_s).wrong
    assert any(each.startswith("sim-remote.mcap: ends 0.55 s before") for each in read_records(recorded, ends_s).wrong)


def test_the_watch_reports_resources_and_status_of_a_process(tmp_path: Path) -> None:
    """Of this very process, as if it were a remote site."""
    status = {"pid": os.getpid(), "state": "engaged", "fault": None, "loop": {"overruns": 2}, "devices": {}}
    (tmp_path / "remote.json").write_text(json.dumps(status), "utf-8")
    (tmp_path / "operator.json").write_text(json.dumps({**status, "pid": 2**30}), "utf-8")
    log = tmp_path / "samples.jsonl"
    with watching(tmp_path, log):
        wait_until(lambda: read_samples(log), "no sample is written", 30.0)
    first = read_samples(log)[0]
    assert (first.process, first.pid) == ("remote", os.getpid())
    assert first.rss_mib > 10.0
    assert first.open_files >= 3
    assert first.threads >= 1
    assert first.status == {"state": "engaged", "fault": None, "devices": {}, "overruns": 2}
