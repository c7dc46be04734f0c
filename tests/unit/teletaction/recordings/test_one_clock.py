"""Recordings of two hosts on one clock: how exact, what it states, and when it refuses."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from common.link.session_state import Happening
from common.recording.reader import RecordingReader
from common.recording.recorder import Recorder
from operator_site.recorded_rows import Clock
from teletaction.export.export import export
from teletaction.export.named_recording import NamedRecording
from teletaction.recordings.incidents import incomplete_recordings
from teletaction.recordings.merge import merge_recordings
from teletaction.recordings.one_clock import ClockLine, TwoClocks
from teletaction.recordings.session_data import SessionData
from teletaction.replay.replay import replay
from teletaction.session.demo_files import PROCESSES, DemoOptions, prepare
from teletaction.testbed.site_clock import SiteClock
from teletaction.testbed.testbed import SessionConfigs
from teletaction.testbed.virtual_recording import PATIENCE_S, recorded_testbed
from tests.commands import command, one_line

pytestmark = pytest.mark.long

HOUR_S = 3600.0
DRIFT = 50e-6
SESSION_S = 6.0


@pytest.fixture(scope="module")
def hosts(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """A session whose remote host booted an hour earlier and whose clock is fast by 50 ppm, over a lossy network."""
    out = tmp_path_factory.mktemp("hosts")
    files = prepare(DemoOptions(seconds=SESSION_S, fingers=2), out)
    clock = SiteClock(HOUR_S, DRIFT)
    with recorded_testbed(SessionConfigs.read(files), remote_clock=clock) as bed:
        bed.until(lambda bed: bed.both_engaged, PATIENCE_S)
        bed.network.impair(delay_s=0.02, jitter_s=0.01)
        bed.run(SESSION_S)
    counts = merge_recordings([out / f"{name}.mcap" for name in PROCESSES], out / "session.mcap")
    return SimpleNamespace(out=out, clock=clock, counts=counts, session=out / "session.mcap")


def times_s(path: Path, stream: str) -> list[tuple[float, float]]:
    """Log time and publish time of each message, s."""
    with path.open("rb") as file:
        found = RecordingReader(path, file).messages([stream])
        return [(message.log_time * 1e-9, message.publish_time * 1e-9) for _, _, message in found]


def test_remote_times_are_true_within_the_stated_uncertainty(hosts: SimpleNamespace) -> None:
    with hosts.session.open("rb") as file:
        stated = RecordingReader(hosts.session, file).metadata["clocks"]
    stated_s = int(stated["uncertainty_p95_ns"]) * 1e-9
    assert stated_s < 0.05
    assert float(stated["drift"]) == pytest.approx(DRIFT, abs=1e-3)
    times = times_s(hosts.session, "remote/sensed")
    true_s = [(own_s - HOUR_S) / (1.0 + DRIFT) for _, own_s in times]
    errors_s = np.abs([log_s - t for (log_s, _), t in zip(times, true_s, strict=True)])
    assert len(times) > 200 * SESSION_S
    assert np.percentile(errors_s, 95) <= stated_s
    assert errors_s.max() < 0.02


def test_the_operators_times_stay_and_all_are_in_order(hosts: SimpleNamespace) -> None:
    assert all(log_s == own_s for log_s, own_s in times_s(hosts.session, "operator/rendered"))
    with hosts.session.open("rb") as file:
        reader = RecordingReader(hosts.session, file)
        assert (reader.end_ns - reader.start_ns) * 1e-9 < SESSION_S + PATIENCE_S
        log_times = [message.log_time for _, _, message in reader.messages()]
    assert log_times == sorted(log_times)
    assert sum(hosts.counts.values()) == len(log_times)


def test_true_contacts_and_identified_ones_meet(hosts: SimpleNamespace) -> None:
    """The simulated devices record the truth on the operator host's clock."""
    data = SessionData.read(hosts.session)
    true_s = min(event["time_s"] for event in data.truth_events if event["kind"] == "contact")
    found_s = data.touch.time_s[np.flatnonzero(data.touch["contact"].any(axis=1))[0]]
    assert abs(found_s - true_s) < 0.03, "without conversion they are an hour apart"


@pytest.mark.usefixtures("coarse")
def test_the_report_states_offset_and_bound(hosts: SimpleNamespace) -> None:
    recordings = [hosts.out / f"{name}.mcap" for name in ("operator", "remote")]
    report = hosts.out / "report.html"
    made = command("report", *recordings, "--out", report)
    assert made.code == 0, made.err
    row = re.search(r"clock of the remote host[^<]*</td><td>(\S+) ± (\S+)</td>", report.read_text("utf-8"))
    assert row is not None
    offset_s, bound_s = map(float, row.groups())
    assert abs(offset_s - HOUR_S) <= bound_s + DRIFT * (SESSION_S + PATIENCE_S)
    assert 0.0 < bound_s < 0.05


def test_events_of_the_remote_site_meet_their_display_and_the_truth(hosts: SimpleNamespace) -> None:
    data = SessionData.read(hosts.session)
    sent_s = {event["ident"]: event["time_ns"] * 1e-9 for event in data.sent_events}
    assert len(data.played) >= 2
    for played in data.played:
        assert 0.0 < played["time_s"] - sent_s[played["ident"]] < 0.3


def test_the_time_at_which_the_remote_recording_stopped_is_converted(hosts: SimpleNamespace) -> None:
    data = SessionData.read(hosts.session)
    start_s = min(entry["time_s"] for entry in data.happenings)
    stopped_ns = hosts.clock.now_ns(start_s + 5.0)
    status = {"recording_failed": "disk full", "recording_lost": 3, "recording_failed_ns": stopped_ns}
    (found,) = incomplete_recordings(data, {"remote": status})
    assert found["time_s"] == pytest.approx(5.0, abs=0.05)


@pytest.mark.exports
def test_rerun_has_both_sites_on_one_monotonic_time_line(hosts: SimpleNamespace, tmp_path: Path) -> None:
    from rerun.chunk import RrdReader

    export(hosts.session, "rerun", tmp_path)
    begins_s = {
        str(chunk.entity_path): min(batch.column(batch.schema.names.index("monotonic")).cast("int64").to_pylist())
        * 1e-9
        for chunk in RrdReader(tmp_path / "session.rrd").stream().to_chunks()
        if "monotonic" in (batch := chunk.to_record_batch()).schema.names
    }
    assert {"/remote/gate/x_m", "/operator/rendered/x_m"} <= begins_s.keys()
    assert max(begins_s.values()) - min(begins_s.values()) < SESSION_S + PATIENCE_S


def test_replay_states_times_on_the_one_clock_and_uses_each_sites_own(hosts: SimpleNamespace, tmp_path: Path) -> None:
    result = replay(hosts.session, tmp_path)
    lines = map(json.loads, (tmp_path / "identification.jsonl").read_text("utf-8").splitlines())
    replayed_s = [line["time_s"] for line in lines if "event" in line]
    with hosts.session.open("rb") as file:
        start_s = RecordingReader(hosts.session, file).start_ns * 1e-9
    recorded_s = [log_s - start_s for log_s, _ in times_s(hosts.session, "remote/event")]
    np.testing.assert_allclose(replayed_s, recorded_s, atol=1e-6)
    for part in (*result["remote"].values(), *result["operator"].values()):
        packets = part.get("touch_packets", part.get("rendered_rows"))
        assert packets > 100
        assert part["identical"] == packets


@pytest.mark.parametrize("names", [("operator-1", "remote"), ("z", "a")])
def test_wall_clock_times_are_those_of_the_operators_host_whatever_the_files_are_called(
    names: tuple[str, str], tmp_path: Path
) -> None:
    """The remote host booted an hour before the operator's, so the anchor of its clock is another one."""
    wall_ns = 1_790_000_000 * 10**9
    files = []
    for name, host, ahead_s in zip(names, ("a", "b"), (0.0, HOUR_S), strict=True):
        now_ns = 10**12 + round(ahead_s * 1e9)
        facts = {"clock_id": host, "monotonic_ns": str(now_ns), "wall_ns": str(wall_ns), "uncertainty_ns": "100"}
        files.append(tmp_path / f"{name}.mcap")
        with Recorder(files[-1], {"operator/clock": {}, "remote/note": {}}, facts) as recorder:
            for time_ns, row in rows(lambda _: HOUR_S) if not ahead_s else []:
                recorder.write("operator/clock", time_ns, row.pack())
            recorder.write("remote/note", now_ns + 10**9, b"\xa2hi")
    merge_recordings(files[::-1], tmp_path / "session.mcap")
    with (tmp_path / "session.mcap").open("rb") as file:
        found = [
            message.wall_ns for message in NamedRecording(tmp_path / "session.mcap", file).messages(["remote/note"])
        ]
    np.testing.assert_allclose(found, wall_ns + 10**9, atol=10_000_000, rtol=0.0)


def rows(offset: Callable[[float], float], bound_s: float = 0.002, count: int = 200) -> list[tuple[int, Clock]]:
    times_s = np.arange(count) * 0.05
    return [(10**12 + round(t * 1e9), Clock(round(offset(t) * 1e9), round(bound_s * 1e9), 10**6)) for t in times_s]


def test_a_line_is_converted_back_exactly() -> None:
    line = ClockLine.fit(rows(lambda t_s: HOUR_S + DRIFT * t_s))
    for t_s in (0.0, 3.7, 9.9):
        remote_ns = 10**12 + round((t_s + HOUR_S + DRIFT * t_s) * 1e9)
        assert abs(line.operator_time_ns(remote_ns) - 10**12 - round(t_s * 1e9)) < 2_000


@pytest.mark.parametrize("jump_s", [0.1, -5.0])
def test_a_clock_that_is_stepped_or_stands_still_is_refused(jump_s: float) -> None:
    with pytest.raises(TwoClocks, match="stepped or stood still"):
        ClockLine.fit(rows(lambda t_s: 1.0 if t_s < 5.0 else 1.0 + jump_s))


def test_without_a_measured_offset_nothing_is_merged() -> None:
    with pytest.raises(TwoClocks, match="no offset"):
        ClockLine.fit([(1, Clock(0, None, 0))])


def recorded(path: Path, site: str, clock_id: str | None, offset_s: float | None = None, session: int = 7) -> Path:
    facts = {} if clock_id is None else {"clock_id": clock_id}
    schemas = {"operator/clock": Clock.schema(), f"{site}/session": Happening.schema()}
    with Recorder(path, schemas, facts) as recorder:
        for time_ns, row in rows(lambda _: offset_s or 0.0) if offset_s is not None else []:
            recorder.write("operator/clock", time_ns, row.pack())
        recorder.write(f"{site}/session", 10**12, Happening("connected", session, "", None).pack())
    return path


def test_two_hosts_without_the_operators_recording_are_refused(tmp_path: Path) -> None:
    remote, other = recorded(tmp_path / "remote.mcap", "remote", "a"), recorded(tmp_path / "x.mcap", "remote", "b")
    said = one_line(command("report", remote, other, "--out", tmp_path / "report.html"), 2)
    assert "recorded on 2 hosts, or on one that was restarted" in said
    assert not (tmp_path / "report.html").exists()


def test_recordings_of_another_session_are_refused(tmp_path: Path) -> None:
    third = [recorded(tmp_path / f"{name}.mcap", "remote", name, 0.0) for name in ("a", "b", "c")]
    with pytest.raises(TwoClocks, match="3 hosts"):
        merge_recordings(third, tmp_path / "session.mcap")
    assert not (tmp_path / "session.mcap").exists()


@pytest.mark.parametrize(("session", "refused"), [(7, False), (8, True)])
def test_a_recording_of_another_session_on_the_remote_host_is_refused(
    session: int, refused: bool, tmp_path: Path
) -> None:
    files = [
        recorded(tmp_path / "remote.mcap", "remote", "a", session=session),
        recorded(tmp_path / "operator.mcap", "operator", "b", 60.0),
    ]
    if refused:
        with pytest.raises(TwoClocks, match="different sessions"):
            merge_recordings(files, tmp_path / "session.mcap")
    else:
        assert merge_recordings(files, tmp_path / "session.mcap")["remote/session"] == 1


def test_what_is_older_than_the_operators_host_is_left_out(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    files = [
        recorded(tmp_path / "remote.mcap", "remote", "a"),
        recorded(tmp_path / "operator.mcap", "operator", "b", 3660.0),
    ]
    counts = merge_recordings(files, tmp_path / "session.mcap")
    assert counts == {"operator/session": 1, "operator/clock": 200}
    assert "remote: 1 messages are older" in caplog.text


@pytest.mark.parametrize(("offset_s", "refused"), [(3660.0, True), (0.0, False)])
def test_older_recordings_are_merged_only_if_their_clocks_agree(
    offset_s: float, refused: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("common.recording.recorder.ClockAnchor.metadata", lambda _: {})
    files = [
        recorded(tmp_path / "remote.mcap", "remote", None),
        recorded(tmp_path / "o.mcap", "operator", None, offset_s),
    ]
    if refused:
        with pytest.raises(TwoClocks, match=r"clocks differ by \+3660\.000 s"):
            merge_recordings(files, tmp_path / "session.mcap")
    else:
        assert merge_recordings(files, tmp_path / "session.mcap")["operator/clock"] == 200
