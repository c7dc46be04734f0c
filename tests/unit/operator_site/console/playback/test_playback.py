"""A recording played: every message once and in order at any speed, and any moment entered as if it had been played."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import msgpack
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.faults.fault import Fault, FaultCode
from common.link.session_state import Happening
from common.recording.recorder import Recorder
from operator_site.console.playback import playback
from operator_site.console.playback.playback import _FEW, PREVIEW_S, Playback, Recording

START_NS = 7_000_000_000
SECONDS, HZ = 60, 20


class Counting:
    """A console that remembers what it was given."""

    given = 0
    """To all of them, by this test's hand and not from a checkpoint."""

    def __init__(self) -> None:
        self.taken: list[tuple[str, int, bytes]] = []

    def take(self, stream: str, time_ns: int, payload: bytes) -> None:
        self.taken.append((stream, time_ns, payload))
        Counting.given += 1


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """60 s of touches and renderings that only count, a fault, an alarm and a finding that got a note later."""
    out = tmp_path_factory.mktemp("recorded") / "session.mcap"
    ticking = ("operator/touch", "operator/rendered", "remote/touch")
    streams = (*ticking, "operator/session", "console/alarm", "console/finding")
    with Recorder(out, {stream: {} for stream in streams}, {}) as recorder:
        for tick in range(SECONDS * HZ + 1):
            time_ns = START_NS + tick * 1_000_000_000 // HZ
            for stream in ticking:
                recorder.write(stream, time_ns, msgpack.packb(tick))
            if tick == 200:
                recorder.write(
                    "operator/session", time_ns, msgpack.packb(["fault", 1, "", Fault(FaultCode.OPERATOR_STOP)])
                )
            if tick == 260:
                recorder.write("operator/session", time_ns, msgpack.packb(["scale", 1, "1:2", None]))
            if tick in {300, 320}:
                alarm = {"id": "plate-index", "since_s": 22.0, "text": "Index: plate 42.3 °C"}
                recorder.write("console/alarm", time_ns, msgpack.packb(alarm))
            if tick in {500, 600}:
                finding = {"id": 1, "at_s": 30.0, "text": "warm, 36.4 ± 0.2 °C", "note": "x" * (tick - 500)}
                recorder.write("console/finding", time_ns, msgpack.packb(finding))
    return out


@pytest.fixture
def recording(path: Path) -> Iterator[Recording]:
    opened = Recording(path)
    yield opened
    opened.close()


def taken(made: Playback) -> list[tuple[str, int, bytes]]:
    return made.console.taken


@pytest.mark.long
def test_it_plays_everything_once_in_order_at_its_speed(recording: Recording) -> None:
    made = Playback(recording, Counting)
    made.play(100.0, 4.0)
    for tick in range(1, 31):
        made.step(100.0 + 0.1 * tick)
        assert made.at_s == pytest.approx(0.4 * tick)
        assert max(time_ns for _, time_ns, _ in taken(made)) <= made.now_ns
    made.step(100.0 + 60.0 / 4.0)
    assert not made.playing
    assert made.at_s == pytest.approx(60.0)
    streams = [stream for stream, _, _ in taken(made)]
    assert streams.count("operator/touch") == streams.count("operator/rendered") == SECONDS * HZ + 1
    assert "remote/touch" not in streams
    times = [time_ns for _, time_ns, _ in taken(made)]
    assert times == sorted(times)


def test_paused_time_stands_still(recording: Recording) -> None:
    made = Playback(recording, Counting)
    made.step(5.0)
    assert made.at_s == 0.0
    made.play(5.0)
    made.pause(7.0)
    made.step(50.0)
    assert made.at_s == pytest.approx(2.0)
    made.play(50.0, 0.5)
    made.step(54.0)
    assert made.at_s == pytest.approx(4.0)
    seen = list(taken(made))
    made.step(45.0)
    assert taken(made) == seen, "a wall clock that is set back takes nothing back"


@pytest.mark.long
@settings(deadline=None, max_examples=30)
@given(st.lists(st.floats(-1.0, 61.0), min_size=1, max_size=6))
def test_a_moment_that_was_jumped_to_is_as_if_played(path: Path, moments: list[float]) -> None:
    recording = Recording(path)
    jumping, playing = Playback(recording, Counting), Playback(recording, Counting)
    for moment in moments:
        jumping.seek(moment, 0.0)
    playing.play(0.0)
    playing.step(jumping.at_s)
    assert jumping.now_ns == playing.now_ns
    assert taken(jumping) == taken(playing)
    recording.close()


@pytest.mark.long
def test_playing_continues_from_the_target_of_a_jump(recording: Recording) -> None:
    made = Playback(recording, Counting)
    made.play(0.0)
    made.seek(30.0, 1.0)
    made.step(2.0)
    assert made.at_s == pytest.approx(31.0)
    assert made.jumps == 1
    assert len([1 for stream, _, _ in taken(made) if stream == "operator/touch"]) == 31 * HZ + 1
    made.seek(60.0, 3.0)
    made.play(3.0)
    assert made.playing
    assert made.at_s == 0.0, "from the end it begins at the start"


@pytest.mark.long
def test_what_is_prepared_costs_a_jump_no_more_than_one_checkpoint(recording: Recording) -> None:
    made, ahead = Playback(recording, Counting), Playback(recording, Counting)
    steps = 0
    while ahead.prepare():
        steps += 1
        assert ahead.ready(steps * playback.CHECKPOINT_S)
    assert steps == SECONDS // playback.CHECKPOINT_S
    assert made.ready(0.99 * playback.CHECKPOINT_S)
    assert not made.ready(1.01 * playback.CHECKPOINT_S)
    made.checkpoints += ahead.checkpoints
    assert made.ready(1000.0), "that is the end"
    given = Counting.given
    made.seek(59.9, 0.0)
    assert 0 < Counting.given - given <= 2 * (playback.CHECKPOINT_S * HZ + 1)
    assert len(taken(made)) > 0.9 * 2 * SECONDS * HZ


def test_marks_are_where_things_were(recording: Recording) -> None:
    marks = recording.marks()
    assert [mark[1:] for mark in marks] == [
        ("fault", "emergency stop by the operator"),
        ("mode", "fault"),
        ("clutch", "scale 1:2"),
        ("alarm", "Index: plate 42.3 °C"),
        ("finding", "1: warm, 36.4 ± 0.2 °C"),
    ]
    assert [mark.at_s for mark in marks] == pytest.approx([10.0, 10.0, 13.0, 15.0, 23.0])
    assert recording.title() == "session.mcap"


def test_each_examination_of_a_recording_keeps_its_marks(tmp_path: Path) -> None:
    with Recorder(tmp_path / "session.mcap", {"console/session": {}, "console/finding": {}}, {}) as recorder:
        for at_s, study_number in ((1.0, "P-0417"), (5.0, "P-0418")):
            begun = {"what": "begin", "at_s": at_s, "pseudonym": study_number}
            recorder.write("console/session", round(1e9 * at_s), msgpack.packb(begun))
            for note in ("", "noted"):
                found = {"id": 1, "at_s": at_s + 1.0, "text": f"of {study_number}", "note": note}
                recorder.write("console/finding", round(1e9 * (at_s + 1.0)), msgpack.packb(found))
    with closing(Recording(tmp_path / "session.mcap")) as recording:
        marks = [(mark.at_s, mark.text) for mark in recording.marks()]
    assert marks == [(1.0, "1: of P-0417"), (5.0, "1: of P-0418")]


def test_a_stop_is_no_mode_after_it_was_cleared(tmp_path: Path) -> None:
    whats = ("connected", "fault", "estop", "cleared", "estop", "engaged")
    with Recorder(tmp_path / "session.mcap", {"operator/session": {}}, {}) as recorder:
        for at_s, what in enumerate(whats):
            fault = Fault(FaultCode.OPERATOR_STOP) if what == "fault" else None
            recorder.write("operator/session", at_s * 1_000_000_000, Happening(what, 7, "", fault).pack())
    with closing(Recording(tmp_path / "session.mcap")) as recording:
        modes = [(mark.at_s, mark.text) for mark in recording.marks() if mark.kind == "mode"]
    assert modes == [(0.0, "connected"), (1.0, "fault"), (2.0, "stopped"), (3.0, "paused"), (5.0, "engaged")]


@pytest.mark.long
@pytest.mark.parametrize("at_s", [0.0, 0.5, 21.3, 59.99, 60.0])
def test_a_preview_has_the_last_messages_and_is_completed_in_parts(recording: Recording, at_s: float) -> None:
    whole, made = Playback(recording, Counting), Playback(recording, Counting)
    whole.seek(at_s, 0.0)
    made.preview(at_s, 0.0)
    assert made.partial
    assert made.at_s == pytest.approx(at_s)
    last = [message for message in taken(whole) if message[1] >= made.now_ns - PREVIEW_S * 1e9]
    assert [message for message in taken(made) if message[0] not in _FEW] == [
        message for message in last if message[0] not in _FEW
    ]
    assert {message[0] for message in taken(whole)} & {*_FEW} == {message[0] for message in taken(made)} & {*_FEW}
    made.checkpoints = whole.checkpoints
    jumps = made.jumps
    for _ in range(1 + len(taken(whole))):
        if made.partial:
            before = Counting.given
            made.complete(7)
            assert Counting.given - before <= 7
    assert not made.partial
    assert made.jumps == jumps + 1
    assert taken(made) == taken(whole)
    made.play(0.0)
    whole.play(0.0)
    made.step(3.0)
    whole.step(3.0)
    assert taken(made) == taken(whole), "it plays on from there"


@pytest.mark.parametrize(("speed", "played"), [(0.4, 0.5), (8.1, 8.0), (-1.0, 0.5)])
def test_a_speed_out_of_range_becomes_the_nearest_end(recording: Recording, speed: float, played: float) -> None:
    made = Playback(recording, Counting)
    made.play(0.0, speed)
    assert made.speed == played


def test_what_is_no_recording_is_refused(path: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(ValueError, match="teletaction recover"):
        Recording(cut)
    text = tmp_path / "text.mcap"
    text.write_text("hello")
    with pytest.raises(ValueError, match="not an MCAP file"):
        Recording(text)
    other = tmp_path / "other.mcap"
    with Recorder(other, {"remote/touch": {}}, {}) as recorder:
        recorder.write("remote/touch", 1, b"")
    with pytest.raises(ValueError, match="none of the streams"):
        Recording(other)
