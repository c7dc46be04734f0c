"""Two runs of the studies compared: what is worse, better, gone and new, and what is chance."""

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.compared import Compared, Number
from studies.comparison import Change, compare
from studies.registry import STUDIES, study
from tests.commands import command, one_line
from tests.places import ROOT

RIGHT = Compared("accuracy", "right", "more", ("method", "t_s"), {"shipped": True}, absolute=0.02)
LATE = Compared("latency.ways", "late_us", "less", ("way",), absolute=1.0, relative=0.1)
BORDER = Compared("borders", "share", "same", absolute=0.05)
DATA: dict[str, Any] = {
    "accuracy": [
        {"method": "ours", "t_s": 1.0, "right": 0.9, "shipped": True},
        {"method": "ours", "t_s": 2.0, "right": 0.95, "shipped": True},
        {"method": "theirs", "t_s": 1.0, "right": 0.5, "shipped": False},
    ],
    "latency": {"ways": [{"way": "link", "late_us": 50.0}, {"way": "bare", "late_us": None}]},
    "borders": {"share": 1.0},
    "problems": [],
}


def changed(**rows: Any) -> dict[str, str]:
    """Verdicts, but `same`, of data of which some parts are other ones."""
    found = compare("made-up", DATA, DATA | rows, (RIGHT, LATE, BORDER))
    return {change.number: change.verdict for change in found if change.verdict != "same"}


def ours(*right: float | None) -> list[dict[str, Any]]:
    return [{"method": "ours", "t_s": 1.0 + n, "right": each, "shipped": True} for n, each in enumerate(right)]


@pytest.mark.parametrize(
    ("rows", "verdicts"),
    [
        ({}, {}),  # a run is no worse than itself
        ({"accuracy": ours(0.89, 0.96)}, {}),
        ({"accuracy": ours(0.87, 0.99)}, {"1.0": "worse", "2.0": "better"}),
        ({"accuracy": ours(0.9)}, {"2.0": "gone"}),
        ({"accuracy": ours(0.9, None)}, {"2.0": "gone"}),
        ({"accuracy": ours(0.9, float("nan"))}, {"2.0": "gone"}),
        ({"accuracy": ours(0.9, 0.95, 0.97)}, {"3.0": "new"}),
    ],
)
def test_accuracy_that_falls_is_worse(rows: dict[str, Any], verdicts: dict[str, str]) -> None:
    assert changed(**rows) == {f"accuracy right method=ours, t_s={t_s}": what for t_s, what in verdicts.items()}


@pytest.mark.parametrize("share", [0.35, 0.4, 0.85, 0.9, 0.95, 1.0])
def test_the_largest_allowed_difference_is_allowed(share: float) -> None:
    for old, new in ((share, round(share - 0.05, 2)), (round(share - 0.05, 2), share)):
        (change, _) = compare("made-up", {"borders": {"share": old}}, {"borders": {"share": new}}, [BORDER])
        assert change.verdict == "same"


def test_what_is_better_may_be_less_or_the_same() -> None:
    slower, quicker = ({"ways": [{"way": "link", "late_us": us}, {"way": "bare", "late_us": 9.0}]} for us in (60, 40))
    assert changed(latency=slower) == {"latency.ways late_us way=link": "worse", "latency.ways late_us way=bare": "new"}
    assert changed(latency=quicker)["latency.ways late_us way=link"] == "better"
    assert changed(borders={"share": 0.9}) == {"borders share": "worse"} == changed(borders={"share": 1.1})


def test_rows_of_one_name_are_an_error() -> None:
    with pytest.raises(ValueError, match=r"accuracy right: several rows of one name"):
        Compared("accuracy", "right", "more").numbers(DATA)


def test_a_part_that_is_no_longer_there_is_gone_and_new_problems_are_worse() -> None:
    assert set(changed(latency="not measured").values()) == {"gone"}
    assert changed(problems=["it grew"]) == {"problems": "worse"}


@given(right=st.integers(0, 60), more=st.integers(1, 30))
def test_few_draws_prove_little_and_many_prove_the_same_difference(right: int, more: int) -> None:
    share = Compared("accuracy", "right", "more", counted="touches")

    def proved(draws: int) -> bool:
        old, new = Number((right + more) / 90.0, draws), Number(right / 90.0, draws)
        return share.worse_by(old, new) > share.may_differ(old, new)

    assert not proved(1)
    assert proved(1_000_000)
    known = [proved(90 * 4**n) for n in range(8)]
    assert known == sorted(known), "once it is proved, more of the same prove it too"


numbers = st.floats(-1e6, 1e6)


@given(old=numbers, new=numbers, absolute=st.floats(0.0, 10.0), relative=st.floats(0.0, 1.0))
def test_what_is_worse_one_way_is_better_the_other(old: float, new: float, absolute: float, relative: float) -> None:
    verdicts = {}
    for better in ("less", "more", "same"):
        how = Compared("", "x", better, absolute=absolute, relative=relative)  # type: ignore[arg-type]
        verdicts[better] = next(compare("made-up", {"x": old}, {"x": new}, [how])).verdict
    assert (verdicts["less"] == "same") == (verdicts["more"] == "same") == (verdicts["same"] == "same")
    assert (verdicts["less"] == "worse") == (verdicts["more"] == "better")
    assert verdicts["same"] in {"same", "worse"}


@pytest.mark.parametrize("name", STUDIES)
def test_each_study_declares_what_is_compared(name: str) -> None:
    assert study(name).COMPARED
    assert all(each.absolute >= 0.0 and each.relative >= 0.0 for each in study(name).COMPARED)


TOUCHES = (("thermal-identification", "accuracy"), ("second-world", "accuracy"), ("other-objects", "shares"))
TOUCHED = {"touches": 96, "object_stated": 1.0, "named": 0.5, "object_errors": 96, "object_within_sd": 0.95}
SHOWN = {"architecture": "local model", "link": "steady"}
WITHHELD = [
    *((name, table, TOUCHED, TOUCHED | {"object_stated": 0.5}) for name, table in TOUCHES),
    *((name, table, TOUCHED, TOUCHED | {"named": 0.0}) for name, table in TOUCHES),
    *((name, table, TOUCHED, TOUCHED | {"object_within_sd": 0.7}) for name, table in TOUCHES[1:]),
    ("recorded-touches", "names", {"touches": 162, "named_6_s": 0.5}, {"touches": 162, "named_6_s": 0.0}),
    ("recorded-touches", "names", {"touches": 162, "wrong": 0.0}, {"touches": 162, "wrong": 0.5}),
    ("texture-world", "strangers", {"own": 2400, "own_unknown_share": 0.5}, {"own": 2400, "own_unknown_share": 1.0}),
    ("texture", "changes", {"told_but_not_there": 0}, {"told_but_not_there": 4}),
    ("teleoperation-stability", "matrix", *(SHOWN | {"felt_n_m": felt_n_m} for felt_n_m in (500.0, 480.0))),
    ("rates", "rates", {"named_rightly": 60}, {"named_rightly": 50}),
    ("rates", "rates", {"named_wrongly": 0}, {"named_wrongly": 1}),
    ("rates", "rates", {"grooves_wrong": 0}, {"grooves_wrong": 5}),
    ("exploration-modes", "levels", *({"method": "mode machine", "invented_taps": taps} for taps in (0, 100))),
    ("tactile-map", "", {"false_outlines": 0}, {"false_outlines": 5}),
]
"""Study, table, and a row of two runs: the second one withholds its answers, or invents some."""


@pytest.mark.parametrize(("name", "table", "old", "new"), WITHHELD)
def test_a_run_that_withholds_or_invents_answers_is_worse(
    name: str, table: str, old: dict[str, Any], new: dict[str, Any]
) -> None:
    before, after = ({table: [row]} if table else row for row in (old, new))
    assert [change.verdict for change in compare(name, before, after, study(name).COMPARED)].count("worse") == 1


@pytest.mark.parametrize(("name", "table"), TOUCHES[1:])
def test_the_few_errors_of_many_touches_prove_little(name: str, table: str) -> None:
    runs = [{table: [TOUCHED | {"object_errors": 8, "object_within_sd": share}]} for share in (0.95, 0.7)]
    assert {change.verdict for change in compare(name, *runs, study(name).COMPARED)} == {"same"}


QUICK = sorted((ROOT / "docs" / "results" / "quick").glob("*.json"))


@pytest.mark.parametrize("file", QUICK, ids=lambda file: file.stem)
def test_the_stored_quick_run_has_each_number_that_is_compared(file: Path) -> None:
    """A number that the stored run lacks is new in every run, and never worse."""
    data = json.loads(file.read_text("utf-8"))
    for each in study(file.stem).COMPARED:
        found = [number for number in each.numbers(data).values() if number.value is not None]
        assert found, each
        assert all(number.count for number in found) or each.counted is None, each


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    """Two runs of two studies, of which one holds another, too."""
    spacing = [{"way": "w", "jitter_ms": 1.0, "loss": 0.0, "spacing_sd_mm": 0.1, "behind_ms": 100.0, "felt": 9}]
    for name in ("old", "new"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "groove-spacing.json").write_text(json.dumps({"quick": True, "spacing": spacing}))
        (tmp_path / name / "soak.json").write_text(json.dumps({"quick": True, "again_s": {"max": 3.0}}))
    (tmp_path / "old" / "texture.json").write_text("{}")
    return tmp_path / "old", tmp_path / "new"


def test_the_command_prints_what_differs_and_fails_where_it_is_worse(folders: tuple[Path, Path]) -> None:
    old, new = folders
    code, out, err = command("study", "--compare", old, new).said
    assert (code, out) == (0, "verdict,study,number,old,new,may_differ\n")
    assert "in one folder only: texture" in err
    assert "6 numbers: 0 worse, 0 gone, 0 better, 0 new, 6 same" in err
    file = folders[1] / "groove-spacing.json"
    file.write_text(file.read_text().replace('"behind_ms": 100.0', '"behind_ms": 120.0'))
    worse = command("study", "--compare", old, new)
    line = 'worse,groove-spacing,"spacing behind_ms way=w, jitter_ms=1.0, loss=0.0",100.0,120.0,7.0'
    assert (worse.code, worse.out.splitlines()[1:]) == (1, [line])
    better = command("study", "--compare", new, old)
    assert better.code == 0, "what was worse before is better now"
    assert better.out.splitlines()[1].startswith("better,")
    assert command("study", "soak", "--compare", old, new).code == 0, "only what was asked for"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[]", "no data of a study"),
        ("{", "no JSON"),
        ('{"quick": false}', "quick run"),
    ],
)
def test_files_that_cannot_be_compared_are_one_line_and_exit_2(
    folders: tuple[Path, Path], text: str, words: str
) -> None:
    (folders[1] / "soak.json").write_text(text)
    line = one_line(command("study", "--compare", *folders), 2)
    assert words in line
    assert str(folders[1] / "soak.json") in line
    line = one_line(command("study", "--compare", folders[0], folders[0] / "none"), 2)
    assert f"no study in common; there is no folder {folders[0] / 'none'}" in line


def test_a_change_has_all_its_numbers() -> None:
    (change, *_) = compare("made-up", DATA, DATA | {"borders": {"share": 0.9}}, [BORDER])
    assert change == Change("made-up", "borders share", 1.0, 0.9, 0.05, "worse")
