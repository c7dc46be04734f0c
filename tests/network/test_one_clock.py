"""Two hosts, whose clocks differ by an hour and drift: their recordings are put on one clock, or refused."""

import csv
import json
import re
import time
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import teletaction as tt
from common.recording.reader import RecordingReader
from teletaction.recordings.merge import ORIGIN
from teletaction.recordings.session_data import Series, SessionData
from teletaction.recordings.summary import one_way_s
from tests.commands import command, one_line
from tests.network.two_host_session import FINGERS, LEAD_S, SECONDS, Delays, RemoteClock, TwoHostSession

pytestmark = [pytest.mark.netns, pytest.mark.timeout(180)]

EVEN, UNEVEN = Delays(20.0, 20.0), Delays(5.0, 30.0)
STEP_S = 2.0
PROCESSING_S = 0.015
"""Most time that both sites take for a touch packet at the median, s."""
STEERED_NS = 20_000_000
"""Most that the machine's wall clock may gain or lose against its monotonic clock during the test, ns."""


@dataclass(frozen=True)
class Hosts:
    """A session on two hosts that has ended, and what `summarise` made of it.

    Attributes:
        recordings: folder with the recording of each process.
        clock: the remote host's clock.
        delays: delays of the network.
        wall_ahead_ns: lead of the machine's wall clock over its monotonic clock, ns.
    """

    recordings: Path
    clock: RemoteClock
    delays: Delays
    wall_ahead_ns: int

    @property
    def merged(self) -> Path:
        """The merged recording, with summary and report beside it."""
        return self.recordings / "result" / "session.mcap"

    @property
    def summary(self) -> dict[str, Any]:
        """The summary of the session."""
        return dict(json.loads(self.merged.with_name("summary.json").read_text("utf-8")))

    @property
    def bound_ns(self) -> int:
        """Uncertainty (95 %) of the remote site's times, as the merged recording states it, ns."""
        with self.merged.open("rb") as file:
            return int(RecordingReader(self.merged, file).metadata["clocks"]["uncertainty_p95_ns"])

    def remote_times(self, streams: list[str] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Times of the remote site's messages on the operator's clock, ns: as merged, and true."""
        with self.merged.open("rb") as file:
            found = [
                (message.log_time, self.clock.true_ns(message.publish_time))
                for _, channel, message in RecordingReader(self.merged, file).messages(streams)
                if channel.metadata[ORIGIN] == "remote"
            ]
        merged, true = np.array(found, dtype=np.int64).T
        return merged, true


@pytest.fixture(scope="module", params=[(EVEN, 0.0), (UNEVEN, STEP_S)], ids=["drift", "drift and step of wall clocks"])
def hosts(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Hosts:
    delays, step_s = request.param
    out = tmp_path_factory.mktemp("hosts")
    wall_ahead_ns = time.time_ns() - time.monotonic_ns()
    with ExitStack() as ends:
        session = TwoHostSession(ends, out, delays, step_s)
        session.wait_for_script(SECONDS / 2.0)
        assert session.step_wall_clocks() == [pytest.approx(step_s * 1e9, abs=1e6)] * 2
        session.finish()
    made = command("summarise", "--recordings", out, "--out", out / "result", "--fingers", FINGERS)
    assert made.code == 0, made.err
    return Hosts(out, session.remote_clock, delays, wall_ahead_ns)


def test_remote_times_are_true_within_the_stated_bound_from_begin_to_end(hosts: Hosts) -> None:
    slowest_ns = max(hosts.delays) * 1e6
    assert 0 < hosts.bound_ns < 2.0 * slowest_ns
    merged, true = hosts.remote_times()
    assert true[-1] - true[0] > SECONDS * 1e9
    for errors_ns in np.array_split(np.abs(merged - true), 3):
        assert np.percentile(errors_ns, 95) <= hosts.bound_ns


def test_true_contacts_and_identified_ones_meet(hosts: Hosts) -> None:
    """The simulated devices record the truth on the machine's clock."""
    data = SessionData.read(hosts.merged)
    true_s = min(event["time_s"] for event in data.truth_events if event["kind"] == "contact")
    found_s = data.touch.time_s[np.flatnonzero(data.touch["contact"].any(axis=1))[0]]
    assert abs(found_s - true_s) < hosts.bound_ns * 1e-9 + 0.05
    assert hosts.summary["taps"]["played"] >= 1


def test_the_delay_is_that_of_the_network(hosts: Hosts) -> None:
    data = SessionData.read(hosts.merged)
    _, true = hosts.remote_times(["remote/touch"])
    true_s = np.median(one_way_s(replace(data, touch=Series(true * 1e-9, data.touch.values))))
    network_s = hosts.delays.to_operator_ms * 1e-3
    assert network_s < true_s < network_s + PROCESSING_S
    stated_s = hosts.summary["latency_ms"]["link_one_way"]["p50"] * 1e-3
    assert abs(stated_s - true_s) <= hosts.bound_ns * 1e-9


def test_exported_wall_clock_times_are_true_and_do_not_jump(hosts: Hosts, tmp_path: Path) -> None:
    assert command("export", hosts.merged, "--to", "csv", "--out", tmp_path).code == 0
    for table, allowed_ns in (("operator-rendered", 0), ("remote-sensed", hosts.bound_ns)):
        with (tmp_path / f"{table}.csv").open(encoding="utf-8", newline="") as file:
            times = np.array([(row["wall_ns"], row["monotonic_ns"]) for row in csv.DictReader(file)], dtype=np.int64)
        wall, own = times.T
        true = own if table.startswith("operator") else np.array([hosts.clock.true_ns(each) for each in own.tolist()])
        assert np.ptp(wall - true) <= allowed_ns
        assert np.percentile(np.abs(wall - true - hosts.wall_ahead_ns), 95) <= allowed_ns + STEERED_NS


def test_report_replay_and_python_agree_on_times(hosts: Hosts, tmp_path: Path) -> None:
    merged, _ = hosts.remote_times(["remote/event"])
    assert len(merged) >= 2
    recording = tt.Recording(hosts.merged)
    assert np.ptp(recording["remote/event"].wall_ns - merged) == 0
    assert command("replay", hosts.merged, "--out", tmp_path).code == 0
    result = json.loads((tmp_path / "replay.json").read_text("utf-8"))
    for part in (*result["remote"].values(), *result["operator"].values()):
        assert part["identical"] == part.get("touch_packets", part.get("rendered_rows")) > 100
    with hosts.merged.open("rb") as file:
        start_ns = RecordingReader(hosts.merged, file).start_ns
    lines = map(json.loads, (tmp_path / "identification.jsonl").read_text("utf-8").splitlines())
    replayed_s = [line["time_s"] for line in lines if "event" in line]
    np.testing.assert_allclose(replayed_s, (merged - start_ns) * 1e-9, atol=1e-6)
    recordings = [hosts.recordings / f"{site}.mcap" for site in ("operator", "remote")]
    made = command("report", *recordings, "--out", tmp_path / "report.html")
    assert made.code == 0, made.err
    text = (tmp_path / "report.html").read_text("utf-8")
    row = re.search(r"clock of the remote host[^<]*</td><td>(\S+) ± (\S+)</td>", text)
    assert row is not None
    offset_s, bound_s = map(float, row.groups())
    assert abs(offset_s - LEAD_S) <= bound_s + 0.01
    assert bound_s == pytest.approx(hosts.bound_ns * 1e-9, abs=1e-3)


def test_a_remote_host_that_was_restarted_in_mid_session_is_refused(tmp_path: Path) -> None:
    with ExitStack() as ends:
        session = TwoHostSession(ends, tmp_path, EVEN)
        session.wait_for_script(0.5)
        session.boot_remote(LEAD_S * 2)
        session.wait_for_connection()
        session.end()
    said = one_line(command("summarise", "--recordings", tmp_path, "--out", tmp_path / "result"), 2)
    assert "recorded on 3 hosts, or on one that was restarted" in said
    resumed = [tmp_path / f"{name}.mcap" for name in ("operator", "remote")]
    said = one_line(command("report", *resumed, "--out", tmp_path / "report.html"), 2)
    assert "recorded on two hosts" in said
    assert not (tmp_path / "report.html").exists()
