"""A short recorded session gives its recorded results, so that every change of behaviour is found.

After a change that is meant: `make golden`, and look at what changes in identification.jsonl.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from common.wire.messages import TOUCH_BLOCK, TOUCH_COLUMN, Touch
from teletaction.recordings.recorded_session import RecordedSession
from teletaction.replay.replay import open_operator, open_remote, replay
from teletaction.replay.replay_sites import rendered_fields, touch_fields
from tests.places import GOLDEN

STREAMS = ("remote/sensed", "remote/touch", "operator/touch", "operator/input", "operator/rendered")


def agree(replayed: Any, recorded: Any) -> bool:
    """Equal, but for floats: another processor rounds differently."""
    if isinstance(recorded, float):
        return bool(replayed == pytest.approx(recorded, rel=1e-6, abs=1e-9, nan_ok=True))
    if isinstance(recorded, list):
        return len(replayed) == len(recorded) and all(map(agree, replayed, recorded))
    return bool(replayed == recorded)


def differences(replayed: Any, recorded: Any) -> dict[str, tuple[Any, Any]]:
    assert replayed.keys() == recorded.keys()
    return {name: (replayed[name], was) for name, was in recorded.items() if not agree(replayed[name], was)}


def test_both_sites_compute_the_recorded_values() -> None:
    counts = dict.fromkeys(STREAMS, 0)
    with GOLDEN.open("rb") as file:
        session = RecordedSession(GOLDEN, file)
        remote, operator = open_remote(session, "remote"), open_operator(session, "operator")
        for stream, _, time_ns, payload in session.messages(STREAMS):
            counts[stream] += 1
            match stream:
                case "remote/sensed":
                    remote.sensed(0.0, payload)
                case "remote/touch":
                    found = differences(touch_fields(remote.touch(0.0, payload)), touch_fields(payload))
                    assert found == {}, f"touch packet at {time_ns} ns"
                case "operator/touch":
                    operator.touch(payload)
                case "operator/input":
                    operator.input(payload)
                case "operator/rendered":
                    found = differences(rendered_fields(operator.rendered(0.0, payload)), rendered_fields(payload))
                    assert found == {}, f"rendered row at {time_ns} ns"
    assert counts["remote/sensed"] > 2000
    assert counts["operator/input"] > 2000
    assert min(counts.values()) > 80


def test_events_and_material_answers_equal_the_recorded_ones(tmp_path: Path) -> None:
    replay(GOLDEN, tmp_path)
    replayed, recorded = (
        [json.loads(line) for line in (folder / "identification.jsonl").read_text("utf-8").splitlines()]
        for folder in (tmp_path, GOLDEN.parent)
    )
    assert len(replayed) == len(recorded)
    for number, (now, was) in enumerate(zip(replayed, recorded, strict=True), 1):
        assert differences(now, was) == {}, f"line {number}"
    events = {line.get("event") for line in recorded}
    assert {"tap", "groove", "material"} <= events, "the recording shows what it is for"
    assert {"deciding", "identified"} <= {line.get("status") for line in recorded}


def test_the_recording_is_small_and_names_no_machine() -> None:
    assert GOLDEN.stat().st_size <= 600_000
    with GOLDEN.open("rb") as file:
        session = RecordedSession(GOLDEN, file)
        for origin in ("remote", "operator"):
            assert session.configuration(origin).keys() <= {"fingers", "link", "rendering"}
        assert session.configuration("operator")["link"].keys() == {"gap_s"}


def test_a_change_of_behaviour_would_be_found() -> None:
    with GOLDEN.open("rb") as file:
        packet = next(p for _, _, _, p in RecordedSession(GOLDEN, file).messages(("remote/touch",)))
    touch = Touch.decode(packet)
    block = touch.block.copy()
    block[1, TOUCH_COLUMN["stiffness_n_m"]] += 0.01
    changed = touch._replace(floats=TOUCH_BLOCK.to_bytes(block)).encode()
    assert list(differences(touch_fields(changed), touch_fields(packet))) == ["index.stiffness_n_m"]
