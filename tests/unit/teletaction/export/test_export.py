"""Exported files hold the numbers of the recording under their names, at wall-clock times."""

import base64
import csv
import json
from collections import Counter
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from common.fingers import FINGERS
from common.recording.clock_anchor import ClockAnchor
from common.recording.recorder import Recorder
from common.wire.messages import OBJECT_UNKNOWN_SD_K
from teletaction.export import map_images
from teletaction.export.export import FORMATS, Format, export
from teletaction.export.named_recording import NamedRecording
from teletaction.export.topics import TOPICS
from teletaction.recordings.session_data import SessionData
from tests.commands import command, one_line
from tests.places import GOLDEN
from tests.unit.teletaction.recorded_examination import record_lump

pytestmark = pytest.mark.long

BEGAN = "2026-11-27T10:00:00+00:00"


def began_ns() -> int:
    return round(datetime.fromisoformat(BEGAN).timestamp()) * 10**9


@pytest.fixture(scope="module")
def truth(session: Path) -> SessionData:
    return SessionData.read(session)


@pytest.fixture(scope="module")
def foxglove(session: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[tuple[int, int, Any]]]:
    """Messages of each topic as an MCAP reader sees them: log time, publish time, decoded JSON."""
    out = tmp_path_factory.mktemp("foxglove")
    export(session, "foxglove", out)
    found: dict[str, list[tuple[int, int, Any]]] = {}
    with (out / "session.mcap").open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            fields = json.loads(message.data)
            found.setdefault(channel.topic, []).append((message.log_time, message.publish_time, fields))
    return found


def test_foxglove_has_every_message_and_every_number(foxglove: Any, truth: SessionData) -> None:
    streams = {topic: len(each) for topic, each in foxglove.items() if not topic.startswith(("/log", "/map/"))}
    assert streams == {f"/{stream}": count for stream, count in truth.counts.items()}
    warm = (truth.touch["object_c_sd"] < OBJECT_UNKNOWN_SD_K) & (truth.touch["thermal_status"] > 0.0)
    known = {"object_c": warm, "stiffness_n_m": truth.touch["stiffness_n_m"] > 0.0}
    for name in ("object_c", "contact_force_n", "stiffness_n_m", "probability"):
        expected = np.where(known.get(name, True), truth.touch[name], np.nan)
        for number, finger in enumerate(FINGERS):
            written = [fields[finger].get(name, np.nan) for _, _, fields in foxglove["/remote/touch"]]
            np.testing.assert_array_equal(written, expected[:, number])
    motor = [[fields[finger]["motor_rpm"] for finger in FINGERS] for _, _, fields in foxglove["/operator/rendered"]]
    np.testing.assert_array_equal(motor, truth.rendered["motor_rpm"])


def test_log_times_are_of_the_wall_clock_and_publish_times_monotonic(foxglove: Any, truth: SessionData) -> None:
    times = [(log_ns, publish_ns) for log_ns, publish_ns, _ in foxglove["/operator/rendered"]]
    np.testing.assert_allclose([publish_ns * 1e-9 for _, publish_ns in times], truth.rendered.time_s, atol=1e-9)
    assert len({log_ns - publish_ns for log_ns, publish_ns in times}) == 1
    recorded = datetime.fromtimestamp(times[0][0] * 1e-9).astimezone()
    assert abs((datetime.now().astimezone() - recorded).total_seconds()) < 600.0


def test_what_happened_to_the_session_is_in_the_log(foxglove: Any) -> None:
    entries = [f"{fields['name']}: {fields['message']}" for _, _, fields in foxglove["/log"]]
    for begin in ("remote/session: connected", "operator/session: engaged", "truth_event: index: contact aluminium"):
        assert any(entry.startswith(begin) for entry in entries), entries


def test_the_map_is_an_image_at_the_end(foxglove: Any) -> None:
    maps = {topic: messages for topic, messages in foxglove.items() if topic.startswith("/map/")}
    assert maps.keys() <= {f"/map/{quantity}" for quantity in ("temperature", "roughness", "stiffness", "material")}
    assert maps
    for ((log_ns, _, image),) in maps.values():
        assert base64.b64decode(image["data"]).startswith(b"\x89PNG")
        assert image["timestamp"]["sec"] == log_ns // 10**9


def test_the_map_shows_no_withdrawn_finding(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    drawn = []
    monkeypatch.setattr(map_images, "map_figure", lambda felt, quantity, findings: drawn.append(findings))
    recording = record_lump(tmp_path / "session.mcap")
    with recording.open("rb") as file:
        assert not list(map_images.map_images(NamedRecording(recording, file)))
    assert [[finding["id"] for finding in findings] for findings in drawn] == [[1, 2, 3]] * 4


def test_csv_has_a_row_for_each_message_and_an_empty_cell_for_what_is_not_known(
    session: Path, truth: SessionData, tmp_path: Path
) -> None:
    rows = export(session, "csv", tmp_path)
    assert rows == {stream.replace("/", "-"): count for stream, count in truth.counts.items()}
    with (tmp_path / "operator-rendered.csv").open(encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    np.testing.assert_array_equal([float(row["index.force_n"]) for row in table], truth.rendered["force_n"][:, 1])
    assert {row["thumb.plate_c"] for row in table} == {""}
    assert Counter(int(row["wall_ns"]) - int(row["monotonic_ns"]) for row in table).total() == len(table)


def test_a_recording_without_an_anchor_needs_its_begin(tmp_path: Path) -> None:
    said = one_line(command("export", GOLDEN, "--to", "csv", "--out", tmp_path / "out"), 2)
    assert "--began" in said
    assert not (tmp_path / "out").exists()
    exported = command("export", GOLDEN, "--to", "foxglove", "--out", tmp_path / "out", "--began", BEGAN)
    assert exported.code == 0, exported.err
    with (tmp_path / "out" / "session.mcap").open("rb") as file:
        first = min(message.log_time for _, _, message in make_reader(file).iter_messages())
    assert first == began_ns()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--to", "xml"], "choose one of csv, parquet, foxglove, fhir, dicom-sr, rerun"),
        (["--to", "csv", "--began", "yesterday"], "--began"),
    ],
)
def test_wrong_options_are_one_line(arguments: list[str], said: str, tmp_path: Path) -> None:
    assert said in one_line(command("export", GOLDEN, "--out", tmp_path / "out", *arguments), 2)


def test_the_recording_is_never_replaced(tmp_path: Path) -> None:
    recording = tmp_path / "session.mcap"
    recording.write_bytes(GOLDEN.read_bytes())
    said = one_line(command("export", recording, "--to", "foxglove", "--out", tmp_path, "--began", BEGAN), 2)
    assert "name another one" in said
    assert recording.read_bytes() == GOLDEN.read_bytes()


def test_a_missing_package_names_its_extra(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(FORMATS, "parquet", Format("", "a_module_that_is_not_there", "write", "parquet"))
    with pytest.raises(ValueError, match=r"pip install 'teletaction\[parquet\]'"):
        export(GOLDEN, "parquet", tmp_path)


@pytest.mark.parametrize("to", ["csv", "foxglove"])
def test_an_export_that_fails_leaves_the_files_of_the_one_before(to: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    export(_notes(tmp_path / "whole.mcap", b"\xa2hi"), to, out)
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    with pytest.raises(ValueError, match="remote/note"):
        export(_notes(tmp_path / "damaged.mcap", b"\xa2hi", b"\xc1"), to, out)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def _notes(path: Path, *payloads: bytes) -> Path:
    with Recorder(path, {"remote/note": {"type": "string"}}, {}) as recorder:
        for payload in payloads:
            recorder.write("remote/note", ClockAnchor.now().monotonic_ns, payload)
    return path


def test_a_recorder_anchors_its_recording(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    with Recorder(path, {"remote/note": {"type": "string"}}, {"key": "curve:abc"}) as recorder:
        recorder.write("remote/note", ClockAnchor.now().monotonic_ns, b"\xa2hi")
    with path.open("rb") as file:
        recording = NamedRecording(path, file)
        (message,) = recording.messages()
        assert abs(message.wall_ns * 1e-9 - datetime.now().timestamp()) < 60.0
        assert message.fields == {"text": "hi"}


def test_the_layout_shows_values_that_the_export_has(session: Path, tmp_path: Path) -> None:
    export(session, "foxglove", tmp_path)
    panels = json.loads((tmp_path / "layout.json").read_text("utf-8"))["configById"]
    paths = [path["value"] for panel in panels.values() for path in panel.get("paths", ())]
    assert len(paths) > 20
    for path in paths:
        topic, *names = path.removeprefix("/").split(".")
        part = TOPICS[topic].schema
        for name in names:
            part = part["properties"][name]
        assert part["type"] in ("number", "string"), path
