"""Networks are read from files, and a bad file is refused in one line that says where."""

import os
import re
from pathlib import Path

import pytest

from sim_sensors.network.file import load_network, network_names

PHASE = "[[phase]]\nfrom_s = 0\ndelay_ms = 10\n"


def write(folder: Path, text: str, name: str = "line.toml") -> str:
    (folder / name).write_text(text, "utf-8")
    return str(folder / name)


@pytest.mark.parametrize(
    ("name", "delay_ms", "jitter_ms", "loss"),
    [("lan", 0.3, 0.1, 0.0), ("city", 10, 2, 0.0), ("mobile", 40, 15, 0.01), ("satellite", 280, 0, 0.0)],
)
def test_steady_networks_are_shipped_by_name(name: str, delay_ms: float, jitter_ms: float, loss: float) -> None:
    network = load_network(name)
    for time_s in (0.0, 1000.0):
        now = network.conditions(time_s)
        assert (now.delay_s, now.jitter_s, now.loss) == pytest.approx((delay_ms / 1e3, jitter_ms / 1e3, loss))
    assert network.faults == ()


def test_a_bad_evening_has_everything() -> None:
    network = load_network("bad_evening")
    assert len({network.conditions(time_s).delay_s for time_s in range(20)}) >= 4
    kinds = [fault.kind for fault in network.faults]
    assert {"stall", "cut", "partition"} <= set(kinds)
    assert [fault.seconds for fault in network.faults if fault.kind == "partition"] == [2.0]
    times_s = [fault.at_s for fault in network.faults]
    assert times_s == sorted(times_s)


def test_phases_follow_each_other_and_the_last_stays(tmp_path: Path) -> None:
    later = "[[phase]]\nfrom_s = 5\ndelay_ms = 20\nloss = 0.5\nrate_kbit_s = 100\n"
    at = load_network(write(tmp_path, PHASE + later)).conditions
    assert [at(t).delay_s for t in (0.0, 4.999, 5.0, 1e9)] == [0.010, 0.010, 0.020, 0.020]
    assert at(5.0).loss == 0.5
    assert at(5.0).rate_bit_s == 1e5


def test_recorded_round_trips_are_halved_joined_and_repeated(tmp_path: Path) -> None:
    recording = write(tmp_path, "send_time_s,rtt_ms,place\n10.0,20,a\n10.5,40,b\n12.0,20,c\n", "drive.csv")
    by_toml = write(tmp_path, 'round_trips = "drive.csv"\n[[fault]]\nat_s = 1\nkind = "cut"\n')
    for path, faults in ((recording, 0), (by_toml, 1)):
        network = load_network(path)
        delays_s = [network.conditions(t).delay_s for t in (0.0, 0.25, 0.5, 2.0, 2.5, 200.5)]
        assert delays_s == pytest.approx([0.010, 0.015, 0.020, 0.010, 0.020, 0.020])
        assert len(network.faults) == faults


BAD_TABLES = [
    ("", ":1", "[[phase]] entries or round_trips"),
    ('round_trips = "x.csv"\n' + PHASE, ":1", "one of the two"),
    ("[[phase]]\nfrom_s = 1\n", ":1", "first phase"),
    (PHASE + "[[phase]]\nfrom_s = 0\n", ":1", "increase"),
    (PHASE + "jitter_ms = 11\n", ":1", "phase.0: jitter_ms is more than delay_ms"),
    (PHASE + "loss = 1.5\n", ":4", "phase.0.loss"),
    (PHASE + "[[phase]]\nfrom_s = 3\ndelay_ms = nan\n", ":6", "phase.1.delay_ms"),
    (PHASE + "[[phase]]\n\nfrom_s = 3\nlosses = 0.1\n", ":7", "phase.1.losses"),
    (PHASE + "rate_kbit_s = 0\n", ":4", "rate_kbit_s"),
    (PHASE + '[[fault]]\nat_s = 1\nkind = "cut"\n[[fault]]\nat_s = 1\nkind = "hiccup"\n', ":9", "fault.1.kind"),
    (PHASE + '[[fault]]\nat_s = 1\nkind = "stall"\n', ":4", "fault.0: a stall needs its length in seconds"),
    (PHASE + '[[fault]]\nat_s = 1\nkind = "cut"\nseconds = 1\n', ":4", "fault.0: a cut ends both"),
    (PHASE + '[[fault]]\nat_s = 1\nkind = "stall"\nseconds = -1\n', ":7", "fault.0.seconds"),
    (PHASE + '[[fault]]\nkind = "cut"\n', ":4", "fault.0.at_s"),
]
BAD_ROUND_TRIPS = [
    ("", ":1", "no column send_time_s"),
    ("send_time_s,ping\n0,1\n", ":1", "no column rtt_ms"),
    ("send_time_s,rtt_ms\n0,1\n1,soon\n", ":3", "rtt_ms: 'soon' is no number"),
    ("send_time_s,rtt_ms\n0,1\n1\n", ":3", "rtt_ms"),
    ("send_time_s,rtt_ms\nnan,1\n", ":2", "send_time_s"),
    ("send_time_s,rtt_ms\n0,1\n1,2\n1,3\n", ":4", "1 does not follow 1"),
    ("send_time_s,rtt_ms\n0,1\n1,-2\n", ":3", "rtt_ms: must be from 0"),
    ("send_time_s,rtt_ms\n0,1\n", "", "two rows"),
]


@pytest.mark.parametrize(
    ("name", "text", "line", "expected"),
    [("line.toml", *bad) for bad in BAD_TABLES] + [("drive.csv", *bad) for bad in BAD_ROUND_TRIPS],
)
def test_a_bad_file_is_refused_in_one_line_with_its_place(
    tmp_path: Path, name: str, text: str, line: str, expected: str
) -> None:
    path = write(tmp_path, text, name)
    with pytest.raises(ValueError, match=re.escape(name)) as refused:
        load_network(path)
    message = str(refused.value)
    assert message.startswith(f"{path}{line}: ")
    assert expected in message
    assert "\n" not in message


def test_round_trips_of_a_spreadsheet_may_begin_with_a_byte_order_mark(tmp_path: Path) -> None:
    path = write(tmp_path, "\ufeffsend_time_s,rtt_ms\n0,20\n1,20\n", "drive.csv")
    assert load_network(path).conditions(0.5).delay_s == 0.010


def test_an_unknown_network_is_answered_with_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="unknown network 'moon'; known: bad_evening, city, lan, mobile, satellite"):
        load_network("moon")
    with pytest.raises(ValueError, match=r"absent\.toml: No such file"):
        load_network(str(tmp_path / "absent.toml"))
    with pytest.raises(ValueError, match=r"absent\.csv: cannot read round trips"):
        load_network(str(tmp_path / "absent.csv"))
    with pytest.raises(ValueError, match=r"absent\.csv: cannot read round trips"):
        load_network(write(tmp_path, 'round_trips = "absent.csv"\n'))
    assert "moon" not in network_names()


def test_round_trips_recorded_on_the_road_are_read() -> None:
    data = os.environ.get("TELETACTION_DATA")
    if data is None:
        pytest.skip("TELETACTION_DATA does not name the folder of recordings")
    recordings = sorted((Path(data) / "network_rtt").glob("*.csv"))
    assert recordings, f"no recordings in {data}/network_rtt"
    for recording in recordings:
        conditions = load_network(str(recording)).conditions
        delays_s = [conditions(0.05 * n).delay_s for n in range(1200)]
        assert 0.005 < min(delays_s) < max(delays_s) < 5.0
