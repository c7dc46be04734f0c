"""Recordings of version 0.1.0: what opens them, and what the errors say.

`session-0.1.0.mcap` is a part of a demo of that version: 2 s around a contact, one finger, both sites at 100 Hz.
"""

from contextlib import closing
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

import teletaction as tt
from common.recording.recorder import PACKET_SCHEMA, Recorder
from operator_site.console.model import Console
from operator_site.console.playback.playback import Playback, Recording
from teletaction.export.export import FORMATS
from tests.commands import command, one_line
from tests.places import GOLDEN
from tests.unit.teletaction.held_recordings import held

OLD = GOLDEN.with_name("session-0.1.0.mcap")
BEGAN = "2026-11-27T10:00:00+00:00"
formats = pytest.mark.parametrize(
    "to",
    [pytest.param(name, marks=[pytest.mark.exports] if kind.extra else []) for name, kind in FORMATS.items()],
)


@pytest.mark.long
@formats
def test_it_is_exported_with_the_time_of_its_first_message(to: str, tmp_path: Path) -> None:
    made = command("export", OLD, "--to", to, "--out", tmp_path / "out", "--began", BEGAN)
    assert made.code == 0, made.err
    assert any((tmp_path / "out").iterdir())


@formats
def test_without_that_time_the_error_names_the_option(to: str, tmp_path: Path) -> None:
    said = one_line(command("export", OLD, "--to", to, "--out", tmp_path / "out"), 2)
    assert "version 0.1.0; give the time of its first message: --began 2026" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("year", ["0001", "1960", "9999"])
def test_a_year_of_another_century_is_refused(year: str, tmp_path: Path) -> None:
    began = f"{year}-11-27T10:00:00+00:00"
    said = one_line(command("export", OLD, "--to", "foxglove", "--out", tmp_path / "out", "--began", began), 2)
    assert said == f"teletaction: began {began}: its year is none of a recording (2000 to 2200)"
    assert not (tmp_path / "out").exists()


def test_it_opens_in_python(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="--began"):
        tt.Recording(OLD)
    recording = tt.Recording(OLD, datetime.fromisoformat(BEGAN))
    assert recording.began == datetime.fromisoformat(BEGAN)
    assert len(recording.touch) > 100
    assert np.nanmax(recording.touch["index"].array("contact_force_n")) > 0.3
    assert len(recording.rendered) > 100


@pytest.mark.long
@pytest.mark.usefixtures("coarse")
def test_report_replay_and_console_need_no_wall_clock(tmp_path: Path) -> None:
    for name in ("report", "replay"):
        made = command(name, OLD, "--out", tmp_path / name)
        assert made.code == 0, made.err
    with closing(Recording(OLD)) as recording:
        played = Playback(recording, lambda: Console(live=False))
        played.seek(played.length_s, 0.0)


@pytest.mark.parametrize("name", ["report", "replay", "export"])
def test_packets_of_an_earlier_schema_are_no_damage(name: str, tmp_path: Path) -> None:
    """Earlier states of version 0.1.0 recorded packets of schema version 6, whose second byte is 6."""
    packets = [(time_ns, data) for stream, time_ns, data in held(GOLDEN) if stream == "remote/touch"][:3]
    path = tmp_path / "old.mcap"
    with Recorder(path, {"remote/touch": PACKET_SCHEMA, "remote/sensed": {}}, {"version": "0.1.0"}) as recorder:
        for time_ns, packet in packets:
            recorder.write("remote/touch", time_ns, packet[:1] + b"\x06" + packet[2:])
            recorder.write("remote/sensed", time_ns, b"\x90")
    more = ["--to", "csv"] if name == "export" else []
    said = one_line(command(name, path, "--out", tmp_path / name, *more), 2)
    assert (
        "old.mcap: recorded by version 0.1.0: schema version 6, this side speaks 7; open it with that version" in said
    )
