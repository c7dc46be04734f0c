"""Off-line identification: the lines' contract, no look ahead, joint touches, and every kind of bad trace."""

import json
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.recorded.identify_thermal import DEFAULT_AT_S, identify_thermal
from tests.unit.remote_site.made_touches import AMBIENT_C, MadeTouch, made_touches

pytestmark = pytest.mark.long

Line = dict[str, Any]
FIELDS = {
    "t_s",
    "final",
    "status",
    "material",
    "best",
    "probability",
    "candidates",
    "object_c",
    "object_c_sd",
    "effusivity",
    "effusivity_ln_sd",
    "exponential",
    "reason",
}
STATUSES = {"no_contact", "deciding", "identified", "ambiguous", "unknown", "unidentifiable"}


@pytest.fixture
def table(calibrated: tuple[MaterialTable, Path]) -> MaterialTable:
    return calibrated[0]


def stone(seed: int = 5, seconds: float = 2.6) -> MadeTouch:
    return made_touches("stone", 1, seed, seconds)[0]


def identify(
    table: MaterialTable,
    *traces: Path,
    at: tuple[float, ...] = (1.0,),
    touches: Path | None = None,
    unread: str | None = None,
) -> list[Line]:
    """All lines; the first of the unread files is named after them."""
    lines: list[Line] = []
    with nullcontext() if unread is None else pytest.raises(ValueError, match=unread):
        for line in identify_thermal(table, traces, at, touches):
            lines.append(line)  # noqa: PERF402 -- the lines before the error count
    for line in lines:
        assert set(line) == {"trace" if touches is None else "touch"} | FIELDS
        assert line["status"] in STATUSES
        assert (line["material"] is not None) == (line["status"] == "identified")
        assert json.loads(json.dumps(line, allow_nan=False)) == line
    return lines


def said(line: Line) -> Line:
    """All of a line but what it is of."""
    return {name: value for name, value in line.items() if name not in ("trace", "touch")}


def test_one_line_for_each_time_and_a_final_one(table: MaterialTable, tmp_path: Path) -> None:
    trace = stone(seconds=7.1).write(tmp_path / "a.csv")
    lines = identify(table, trace, at=(5.0, 0.5, 2.0))
    assert [line["t_s"] for line in lines] == [0.5, 2.0, 5.0, pytest.approx(7.1, abs=0.02)]
    assert [line["final"] for line in lines] == [False, False, False, True]
    assert {line["trace"] for line in lines} == {str(trace)}
    assert (lines[-1]["status"], lines[-1]["material"]) == ("identified", "stone")
    assert set(lines[-1]["exponential"]) == {"rate_per_s", "object_c", "material"}
    assert lines[0]["exponential"]["rate_per_s"] is None
    assert lines[-1]["exponential"]["material"] in table.names()
    assert lines[-1]["candidates"]["stone"] == lines[-1]["probability"]
    assert [line["t_s"] for line in identify_thermal(table, [trace])][:-1] == list(DEFAULT_AT_S)


@pytest.mark.parametrize("at_s", [0.3, 1.0, 2.0])
def test_no_sample_after_contact_and_t_is_used(table: MaterialTable, tmp_path: Path, at_s: float) -> None:
    whole = stone()
    later = whole.time_s > at_s + 1e-6
    sensor_c = np.where(later, 40.0 + whole.time_s, whole.sensor_c)
    other = replace(whole, sensor_c=sensor_c, force_n=np.where(later, 0.1, whole.force_n))
    lines = [
        said(identify(table, touch.write(tmp_path / "a.csv"), at=(at_s,))[0])
        for touch in (whole, whole.until(at_s), other)
    ]
    assert lines[0]["object_c"] is not None
    assert lines[0] == lines[1] == lines[2]


def test_time_counts_from_contact_on_any_clock(table: MaterialTable, tmp_path: Path) -> None:
    first, again = (identify(table, stone().write(tmp_path / "a.csv", clock_s=clock_s))[0] for clock_s in (0.0, 1000.0))
    assert again["probability"] == pytest.approx(first["probability"], abs=0.002)
    assert again["object_c"] == pytest.approx(first["object_c"], abs=0.02)


def test_a_short_force_is_no_contact(table: MaterialTable, tmp_path: Path) -> None:
    """Contact is 0.30 N held for 50 ms."""
    touch = stone()
    knock = np.where((touch.time_s > -0.3) & (touch.time_s < -0.27), 1.0, touch.force_n)
    a, b = (identify(table, each.write(tmp_path / "a.csv"))[0] for each in (touch, replace(touch, force_n=knock)))
    assert said(a) == said(b)


# --- joint touches ---


def listed(folder: Path, *rows: str) -> Path:
    path = folder / "touches.csv"
    path.write_text("\n".join(("touch,trace", *rows)) + "\n")
    return path


def test_fingers_on_one_object_are_judged_together(table: MaterialTable, tmp_path: Path) -> None:
    starts_c, traces = np.array([29.0, 33.0, 37.0]), [tmp_path / f"f{k}.csv" for k in range(3)]
    touches = made_touches("stone", 3, 8, 2.0, start_c=starts_c, same_piece=True)
    for k, touch in enumerate(touches):
        # each trace's clock starts at its own contact: one was recorded with more before it
        touch.where(touch.time_s >= -0.1 * (k + 2)).write(traces[k])
    lines = identify(table, at=(0.5, 1.0), touches=listed(tmp_path, *(f"one,{trace.name}" for trace in traces)))
    assert [(line["touch"], line["final"]) for line in lines] == [("one", False), ("one", False), ("one", True)]
    assert (lines[1]["best"], lines[1]["probability"] > 0.9) == ("stone", True)
    assert (lines[2]["status"], lines[2]["material"]) == ("identified", "stone")
    alone = identify(table, *traces)
    assert lines[1]["object_c_sd"] < 0.5 * min(line["object_c_sd"] for line in alone if not line["final"])
    assert lines[1]["object_c"] == pytest.approx(touches[0].object_c, abs=0.5)


def test_joint_touches_look_at_no_later_sample_either(table: MaterialTable, tmp_path: Path) -> None:
    touches = made_touches("plastic", 2, 9, 2.0, start_c=np.array([33.0, 37.0]), same_piece=True)
    for k, touch in enumerate(touches):
        touch.write(tmp_path / f"whole{k}.csv")
        touch.until(1.0).write(tmp_path / f"cut{k}.csv")
    rows = [f"{name},{name}{k}.csv" for k in range(2) for name in ("whole", "cut")]
    whole, _, cut, _ = identify(table, touches=listed(tmp_path, *rows))
    assert (whole["touch"], cut["touch"]) == ("whole", "cut")
    assert said(whole) == said(cut)


def test_a_bad_trace_in_a_joint_touch_leaves_the_other_fingers(
    table: MaterialTable, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    for k, touch in enumerate(made_touches("stone", 2, 8, 2.0, start_c=np.array([33.0, 37.0]), same_piece=True)):
        touch.write(tmp_path / f"f{k}.csv")
    touches = listed(tmp_path, "one,f0.csv", "one,gone.csv", "one,f1.csv", "two,gone.csv")
    unread = r"gone.csv: cannot be read: No such file or directory \(2 of 4 files cannot be used\)$"
    lines = identify(table, touches=touches, unread=unread)
    assert [line["touch"] for line in lines] == ["one", "one", "two", "two"]
    assert lines[0]["best"] == "stone"
    assert lines[0]["object_c"] is not None
    assert {line["status"] for line in lines[2:]} == {"unidentifiable"}
    assert "gone.csv" in lines[2]["reason"]
    [warning] = caplog.messages
    assert warning.startswith("touch one is judged without a trace: ")
    assert "gone.csv: cannot be read" in warning


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("touch,trace\n", "no touches are listed"),
        ("touch\none\n", "column trace is missing"),
        ("touch,trace\none,\n", "line 2: column trace: missing value"),
        ("touch,trace\n,a.csv\n", "line 2: column touch: missing value"),
        ("touch,trace\none,a.csv\none,./a.csv\n", "column trace: touch one: .*a.csv: is named twice"),
    ],
)
def test_a_list_of_touches_that_cannot_be_used_is_refused(
    table: MaterialTable, tmp_path: Path, text: str, expected: str
) -> None:
    (tmp_path / "touches.csv").write_text(text)
    with pytest.raises(ValueError, match=expected):
        identify(table, touches=tmp_path / "touches.csv")


@pytest.mark.parametrize("at_s", [0.0, -1.0, float("nan"), float("inf")])
def test_times_have_to_be_positive(table: MaterialTable, at_s: float) -> None:
    with pytest.raises(ValueError, match="at_s: times must be positive"):
        list(identify_thermal(table, [], (at_s,)))


# --- a second, unheated sensor ---


def with_reference(start_c: float, object_c: float, seconds: float = 1.5) -> MadeTouch:
    heated, unheated = made_touches(
        "stone", 2, 11, seconds, start_c=np.array([start_c, AMBIENT_C]), object_c=object_c, same_piece=True
    )
    return replace(heated, reference_c=unheated.sensor_c)


def test_an_unheated_sensor_counts_as_a_second_finger(table: MaterialTable, tmp_path: Path) -> None:
    both = with_reference(33.0, 26.0)
    with_it = identify(table, both.write(tmp_path / "a.csv"))[0]
    alone = identify(table, replace(both, reference_c=None).write(tmp_path / "b.csv"))[0]
    assert with_it["best"] == "stone"
    assert with_it["object_c_sd"] < 0.5 * alone["object_c_sd"]
    assert with_it["object_c"] == pytest.approx(26.0, abs=0.3)


def test_an_unheated_sensor_identifies_where_the_heated_one_cannot(table: MaterialTable, tmp_path: Path) -> None:
    line = identify(table, with_reference(33.0, 33.0, 3.0).write(tmp_path / "a.csv"))[-1]
    assert line["best"] == "stone"
    assert line["reason"] is None
    assert line["object_c"] == pytest.approx(33.0, abs=0.3)


def test_an_unheated_sensor_gives_the_ambient_temperature(table: MaterialTable, tmp_path: Path) -> None:
    both = with_reference(33.0, 24.0)
    given, missing = (identify(table, both.write(tmp_path / "a.csv", ambient=ambient))[0] for ambient in (True, False))
    assert missing["object_c"] == pytest.approx(given["object_c"], abs=0.05)


# --- bad traces ---


Spoil = Callable[[MadeTouch, Path], Path]


def spoiled(change: Callable[[MadeTouch], MadeTouch]) -> Spoil:
    return lambda touch, path: change(touch).write(path)


def not_a_number(touch: MadeTouch, path: Path) -> Path:
    """In line 80."""
    rows = touch.write(path).read_text().splitlines()
    rows[79] = ",".join((rows[79].split(",")[0], "nan", *rows[79].split(",")[2:]))
    path.write_text("\n".join(rows) + "\n")
    return path


BAD: dict[str, tuple[Spoil, str | None, str | None]] = {
    "gap": (
        spoiled(lambda t: t.where((t.time_s < 0.15) | (t.time_s > 0.6))),
        "unidentifiable",
        "readings-missing",
    ),
    "no number": (not_a_number, "unidentifiable", "line 80: column sensor_c"),
    "no contact": (spoiled(lambda t: replace(t, force_n=0.1 + 0 * t.force_n)), "no_contact", None),
    "flat line": (
        spoiled(lambda t: replace(t, sensor_c=33.0 + 0 * t.sensor_c)),
        "unidentifiable",
        "reading-stuck",
    ),
    "saturated": (
        spoiled(lambda t: replace(t, sensor_c=np.minimum(t.sensor_c, 24.0))),
        "unidentifiable",
        "reading-stuck",
    ),
    "missing file": (lambda _, path: path.with_name("none.csv"), "unidentifiable", "none.csv: cannot be read"),
    "a folder": (lambda _, path: path.parent, "unidentifiable", "cannot be read"),
    "contact lost": (
        spoiled(lambda t: replace(t, force_n=np.where(t.time_s > 0.15, 0.0, t.force_n))),
        "unidentifiable",
        "contact-lost",
    ),
    "in contact from the first sample": (spoiled(lambda t: t.where(t.time_s >= 0.0)), None, None),
    "ends at contact": (spoiled(lambda t: t.until(0.06)), "deciding", None),
}

UNREAD = ("missing file", "a folder")


@pytest.mark.parametrize("kind", BAD)
def test_a_bad_trace_is_answered_with_its_reason_and_the_others_continue(
    table: MaterialTable, tmp_path: Path, kind: str
) -> None:
    spoil, status, reason = BAD[kind]
    good = stone(seconds=1.2)
    before, after = good.write(tmp_path / "before.csv"), good.write(tmp_path / "after.csv")
    bad = spoil(good, tmp_path / "bad.csv")
    unread = rf"{bad}: cannot be read: .* \(1 of 3 files cannot be used\)$" if kind in UNREAD else None
    lines = identify(table, before, bad, after, unread=unread)
    assert [line["trace"] for line in lines] == [str(path) for path in (before, before, bad, bad, after, after)]
    of_bad = lines[2:4]
    assert [line["final"] for line in of_bad] == [False, True]
    if status is not None:
        assert {line["status"] for line in of_bad} == {status}
    for line in of_bad:
        assert line["material"] is None
        assert line["reason"] is None if reason is None else reason in line["reason"]
    assert said(lines[0]) == said(lines[4])
    assert lines[4]["best"] == "stone"


def test_a_trace_that_begins_in_contact_is_answered_with_a_warning(
    table: MaterialTable, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A second after contact the plate has lost most of its heat, and another object fits as well."""
    touch = stone(seconds=7.0)
    whole, late = touch.write(tmp_path / "whole.csv"), touch.where(touch.time_s >= 1.0).write(tmp_path / "late.csv")
    identify(table, whole)
    assert caplog.messages == []
    assert len(identify(table, late)) == 2
    [warning] = caplog.messages
    assert warning.startswith(f"{late}: begins in contact")


def test_a_slow_trace_is_answered_with_a_warning(
    table: MaterialTable, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """With 20 samples/s and a table of 100, errors after 1 s are three times as large, and their ± is not."""
    touch = stone()
    for step, name in ((2, "half.csv"), (5, "slow.csv")):
        kept = np.arange(len(touch.time_s)) % step == 0
        identify(table, touch.where(kept).write(tmp_path / name))
    [warning] = caplog.messages
    assert warning.startswith(f"{tmp_path / 'slow.csv'}: 20 samples/s, so that the time of contact is not exact")


def test_a_bad_trace_after_a_name_keeps_it(table: MaterialTable, tmp_path: Path) -> None:
    touch = stone(seconds=7.0)
    stuck = replace(touch, sensor_c=np.where(touch.time_s > 5.0, 25.0, touch.sensor_c))
    kept, final = identify(table, stuck.write(tmp_path / "a.csv"), at=(5.0,))
    assert kept["material"] == "stone"
    assert final["material"] in ("stone", None)
