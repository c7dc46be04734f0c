"""Replay: its output, its input, and its reports of a different or incomplete recording."""

import csv
import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgpack
import pytest
from mcap.writer import CompressionType, Writer

from common.recording.recorder import Recorder
from teletaction.recordings.merge import merge_recordings
from teletaction.recordings.recorded_session import RecordedSession
from teletaction.recordings.recover import recover
from teletaction.replay.replay import open_operator, open_remote, replay
from teletaction.replay.replay_comparison import Comparison
from teletaction.replay.replay_each import replay_each
from tests.commands import command, one_line
from tests.places import GOLDEN

pytestmark = pytest.mark.long

STREAMS = ("remote/sensed", "remote/touch", "operator/touch", "operator/input", "operator/rendered")
Change = Callable[[str, int, bytes], Iterator[bytes]]
Own = tuple[Path, dict[str, Any]]


def altered(
    out: Path,
    change: Change,
    streams: tuple[str, ...] = STREAMS,
    attached: bool = True,
    metadata: bool = True,
    single: bool = False,
    configured: str = "",
    source: Path = GOLDEN,
) -> Path:
    """The golden recording with messages changed; `single` as one site records, before merging.

    Lines in `configured` come before those of each site's configuration.
    """
    with source.open("rb") as file, out.open("wb") as out_file:
        session = RecordedSession(source, file)
        writer = Writer(out_file, compression=CompressionType.NONE, chunk_size=100_000)
        writer.start()
        site = streams[0].split("/")[0]
        for entry, facts in session.reader.metadata.items():
            if metadata and (not single or entry.startswith(site)):
                name = entry.removeprefix(f"{site}/") if single else entry
                writer.add_metadata(name, {**facts, "configuration": configured + facts["configuration"]})
        for table in session.reader.attachments.values():
            if attached:
                name = table.name.removeprefix(f"{site}/") if single else table.name
                writer.add_attachment(0, 0, name, table.media_type, table.data)
        channels: dict[str, int] = {}
        counts: dict[str, int] = {}
        for stream, origin, time_ns, payload in session.messages(streams):
            if stream not in channels:
                origin_of = {} if single else {"recording": origin}
                channels[stream] = writer.register_channel(stream, "msgpack", 0, origin_of)
            for changed in change(stream, counts.get(stream, 0), payload):
                writer.add_message(channels[stream], time_ns, changed, time_ns)
            counts[stream] = counts.get(stream, 0) + 1
        writer.finish()  # type: ignore[no-untyped-call]
    return out


def as_it_is(_stream: str, _number: int, payload: bytes) -> Iterator[bytes]:
    yield payload


@pytest.fixture(scope="module")
def golden(tmp_path_factory: pytest.TempPathFactory) -> Own:
    out = tmp_path_factory.mktemp("golden")
    return out, replay(GOLDEN, out)


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Own:
    """What this machine computes, and its replay: another kind of processor rounds the golden outputs otherwise."""
    out = tmp_path_factory.mktemp("own")
    path = altered(out / "own.mcap", replayed_outputs())
    return path, replay(path, out)


def test_a_replay_writes_commands_of_devices_and_its_comparison(golden: Own) -> None:
    out, result = golden
    assert json.loads((out / "replay.json").read_text("utf-8")) == result
    remote, operator = result["remote"]["remote"], result["operator"]["operator"]
    assert remote["ticks"] > 2000 > remote["touch_packets"] > 80
    assert operator["ticks"] > 2000 > operator["rendered_rows"] > 80
    assert operator["missing_touch_packets"] == 0
    with (out / "rendering.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == operator["ticks"]
    assert list(rows[0])[:5] == [
        "time_s",
        "index_force_n",
        "index_motor_rpm",
        "index_plate_set_c",
        "index_peltier_drive",
    ]
    assert list(rows[0])[-1] == "fault"
    assert max(float(row["index_force_n"]) for row in rows) > 0.5
    assert {float(row["thumb_force_n"]) for row in rows if "thumb_force_n" in row} == set()


@pytest.mark.parametrize(("site", "streams"), [("remote", STREAMS[:2]), ("operator", STREAMS[2:])])
def test_one_sites_recording_replays_the_half_that_is_there(
    own: Own, tmp_path: Path, site: str, streams: tuple[str, ...]
) -> None:
    path = altered(tmp_path / f"{site}.mcap", as_it_is, streams, single=True, source=own[0])
    result = replay(path, tmp_path / "out")
    other = "operator" if site == "remote" else "remote"
    assert result[other] == {}
    assert result[site][site] == own[1][site][site]


def replayed_outputs() -> Change:
    """Puts what this machine computes in the place of what was recorded."""
    file = GOLDEN.open("rb")
    session = RecordedSession(GOLDEN, file)
    remote, operator = open_remote(session, "remote"), open_operator(session, "operator")
    file.close()

    def change(stream: str, _number: int, payload: bytes) -> Iterator[bytes]:
        match stream:
            case "remote/sensed":
                remote.sensed(0.0, payload)
            case "operator/touch":
                operator.touch(payload)
            case "operator/input":
                operator.input(payload)
            case "remote/touch":
                payload = remote.touch(0.0, payload)
            case "operator/rendered":
                payload = operator.rendered(0.0, payload)
        yield payload

    return change


def test_the_first_difference_names_tick_field_and_both_values_and_missing_touch_is_counted(tmp_path: Path) -> None:
    computed = replayed_outputs()

    def change(stream: str, number: int, payload: bytes) -> Iterator[bytes]:
        if stream == "operator/touch" and number in (100, 200):
            return
        (payload,) = computed(stream, number, payload)
        if stream == "operator/rendered":
            row = msgpack.unpackb(payload)
            row[-1] += 1.0  # wall time is no difference
            row[4][2] += 0.5 * (number == 40)
            payload = msgpack.packb(row)
        yield payload

    part = replay(altered(tmp_path / "a.mcap", change), tmp_path / "out")["operator"]["operator"]
    assert part["missing_touch_packets"] == 2
    assert part["identical"] == part["rendered_rows"] - 1
    difference = part["first_difference"]
    assert difference["field"] == "middle.plate_set_c"
    assert difference["recorded"] == pytest.approx(difference["replayed"] + 0.5)
    assert 40 * 25 - 25 <= difference["tick"] <= 40 * 25 + 25


def test_a_restarted_site_begins_from_its_initial_state(golden: Own, tmp_path: Path) -> None:
    """Two recordings of one site in one session: the second knows nothing of the first."""
    first = altered(tmp_path / "remote-1.mcap", as_it_is, STREAMS[:2], single=True)
    shutil.copy(first, tmp_path / "remote.mcap")
    merge_recordings([first, tmp_path / "remote.mcap"], tmp_path / "session.mcap")
    result = replay(tmp_path / "session.mcap", tmp_path / "out")
    expected = golden[1]["remote"]["remote"]
    assert result["remote"] == {"remote-1": expected, "remote": expected}


def test_a_cut_recording_is_replayed_after_it_was_recovered(own: Own, tmp_path: Path) -> None:
    whole = own[0].read_bytes()
    for share in (0.3, 0.8):
        cut = tmp_path / f"cut-{share}.mcap"
        cut.write_bytes(whole[: int(len(whole) * share)])
        with pytest.raises(ValueError, match=rf"cut, without its end; `teletaction recover .*{cut.name}` makes"):
            replay(cut, tmp_path / "out")
        recovered = recover(cut)
        assert recovered is not None
        part = replay(recovered.out, tmp_path / "out")["remote"]["remote"]
        assert part["identical"] == part["touch_packets"] > 10


def test_a_replay_on_the_same_machine_is_identical_to_the_last_bit_and_says_so(own: Own, tmp_path: Path) -> None:
    """Whatever processor runs this: what it records, it replays."""
    path, result = own
    for part, what in (
        (result["remote"]["remote"], "touch_packets"),
        (result["operator"]["operator"], "rendered_rows"),
    ):
        assert part["identical"] == part[what] > 80
        assert part["first_difference"] is None
    outcome = command("replay", path, "--out", tmp_path / "out")
    assert (outcome.code, outcome.out) == (0, "")
    remote, operator, *_ = outcome.err.splitlines()
    assert remote.startswith("remote: ")
    assert remote.endswith("touch packets are identical")
    assert "all of" in operator


def test_touches_changed_by_late_ticks_are_listed(golden: Own, tmp_path: Path) -> None:
    """By its configuration this site made a tick each millisecond: all that it recorded are late."""
    path = altered(tmp_path / "late.mcap", as_it_is, STREAMS[:2], configured="rate_hz = 1000.0\n")
    outcome = command("replay", path, "--out", tmp_path / "late")
    assert outcome.code == 0
    remote = json.loads((tmp_path / "late" / "replay.json").read_text("utf-8"))["remote"]["remote"]
    assert remote["postponed"] > 10 * golden[1]["remote"]["remote"]["postponed"]
    changed = remote["changed_by_waiting"]
    named = {line["name"] for line in lines(golden[0]) if line.get("event") == "material"}
    assert {line["full_material"] for line in changed} == named
    assert all(line["material"] in ("", line["full_material"]) for line in changed)
    assert all(line["named_s"] != line["full_named_s"] for line in changed)
    for line in changed:
        where = f"the {line['finger']}'s touch at {line['began_s']:.1f} s"
        assert f"without late ticks, {where} would be named" in outcome.err


def lines(out: Path) -> list[dict[str, Any]]:
    """What a replay wrote of identification."""
    return [json.loads(line) for line in (out / "identification.jsonl").read_text("utf-8").splitlines()]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"streams": ("remote/touch",)}, "nothing to replay: has neither remote/sensed nor operator/input"),
        ({"attached": False}, "the table materials.json is not attached"),
        ({"metadata": False, "streams": STREAMS[2:]}, "its metadata operator/session has no configuration"),
        ({"metadata": False, "streams": STREAMS[:2]}, "the attached materials.json is not the table that its metadata"),
        ({"configured": "rate_hz = 0\n"}, "its configuration cannot be used: rate_hz: Input should be greater than 0"),
        ({"change": lambda *_: iter([b"\x03"]), "streams": STREAMS[:1]}, "not a record of sensed values"),
        ({"change": lambda *_: iter([b"\x03"]), "streams": STREAMS[3:4]}, "not a record of rendering input"),
        ({"change": lambda *_: iter([b"\x03"]), "streams": STREAMS[2:4]}, "operator/touch at"),
    ],
)
def test_a_recording_that_lacks_something_is_refused_in_one_line(
    tmp_path: Path, options: dict[str, Any], words: str
) -> None:
    path = altered(tmp_path / "a.mcap", **{"change": as_it_is, **options})
    line = one_line(command("replay", path, "--out", tmp_path / "out"), 2)
    assert words in line
    assert line.count(f"{path}: ") == 1, "no message is called damaged, which names the file again"


def test_a_wrong_file_or_a_repeated_name_is_refused_in_one_line(tmp_path: Path) -> None:
    other, empty = tmp_path / "a.csv", tmp_path / "b.mcap"
    other.write_text("time_s,force_n\n")
    Recorder(empty, {"a": {"type": "integer"}}, {}).close()
    for paths, words in (
        ((other,), "not an MCAP file"),
        ((empty,), "nothing to replay"),
        ((empty, tmp_path / "again" / "b.mcap"), "two recordings named b"),
    ):
        assert words in one_line(command("replay", *paths, "--out", tmp_path / "out"), 2)
    assert not (tmp_path / "out").exists()


def test_values_are_compared_by_their_bits() -> None:
    comparison = Comparison(msgpack.unpackb)
    comparison.add(3, 0.5, msgpack.packb({"a": 1.0, "b": 0.0}), msgpack.packb({"a": 1.0, "b": -0.0}))
    comparison.add(4, 0.6, msgpack.packb({"a": float("nan")}), msgpack.packb({"a": float("nan")}))
    comparison.add(5, 0.7, msgpack.packb({"a": 1.0}), msgpack.packb({"a": float("inf")}))
    assert (comparison.compared, comparison.identical) == (3, 1)
    first = {"tick": 3, "time_s": 0.5, "field": "b", "recorded": 0.0, "replayed": -0.0}
    assert comparison.first_difference == first


def test_several_recordings_are_replayed_side_by_side_with_the_same_results(own: Own, tmp_path: Path) -> None:
    whole, paths = own[0].read_bytes(), [tmp_path / "first.mcap", tmp_path / "second.mcap"]
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    assert recover(tmp_path / "cut.mcap", paths[0]) is not None
    shutil.copy(*paths)
    replay(paths[0], tmp_path / "alone")
    for processes in (1, 2):
        out = tmp_path / f"by {processes}"
        shares: list[float] = []
        found = list(replay_each(paths, out, processes, shares.append))
        assert [path for path, _ in found] == paths
        assert shares == [0.5, 1.0]
        for name in ("identification.jsonl", "rendering.csv", "replay.json"):
            assert (out / "first" / name).read_bytes() == (tmp_path / "alone" / name).read_bytes()
        assert json.loads((out / "second" / "replay.json").read_text("utf-8")) == found[1][1]
    outcome = command("replay", tmp_path / "gone.mcap", paths[1], "--out", tmp_path / "rest", "--processes", 1)
    assert outcome.code == 2
    *others, last = outcome.err.splitlines()
    assert others
    assert all(line.startswith(f"{paths[1]}: ") for line in others)
    assert last == f"teletaction: {tmp_path / 'gone.mcap'}: No such file or directory"
    assert (tmp_path / "rest" / "second" / "replay.json").exists()
