"""Findings as objects: each change is a record, and the records alone give the state again."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.link.session_state import Refused
from common.recording.clock_anchor import boot_id
from common.wire.roughness_um import RoughnessUm
from operator_site.console.examination.contrast import compared, contrast_of, contrast_text, propose
from operator_site.console.examination.examination import LONGEST_REASON, Examination, Finding
from operator_site.console.examination.journal import Journal
from operator_site.console.examination.resume import unfinished
from operator_site.console.map.tactile_map import ExploredPlace, Measured, TactileMap
from tests.unit.operator_site.console.touch_rows import sample

TISSUE = ExploredPlace(
    0.0, 0.0, Measured(33.0, 0.1, 12, 5.0), Measured(0.0045, 0.0005, 9, 5.0), Measured(600.0, 20.0, 12, 5.0), None
)
NOWHERE = ExploredPlace(0.0, 0.0, None, None, None, None)
MARK = {"finger": "index", "x_mm": 0.0, "y_mm": 0.0}
BODY = {"region": "forearm", "side": "left", "landmark": "wrist crease", "landmark_mm": 20.0}


def felt(here: float = 35.0) -> TactileMap:
    """A warm place at the origin and ten touches around it."""
    made = TactileMap()
    made.take(sample("temperature", 1, 0.0, 0.0, here, 0.01))
    for number in range(10):
        x_m = 0.015 + 1e-4 * number
        made.take(sample("temperature", number + 2, x_m, 0.0, 33.0 + 0.02 * number, 0.01))
    return made


def begun() -> Examination:
    made = Examination()
    made.begin(1.0, "P-0417", body=BODY)
    return made


def replayed(records: list[dict[str, Any]], body: object = BODY) -> Examination:
    """An examination as a later run of the console, playback and report read it."""
    made = Examination()
    made.take("console/session", {"what": "begin", "pseudonym": "P-0417", "at_s": 1.0, "sides": None, "body": body})
    for record in records:
        made.take("console/finding", record)
    return made


def test_edit_withdrawal_and_undo_are_records_of_the_whole_finding() -> None:
    made, tactile_map = begun(), felt()
    records = [made.find(tactile_map, MARK | {"kind": "warm", "body": BODY}, 2.0).record()]
    records.append(made.edit(tactile_map, {"finding": 1, "kind": "cold"}).record())
    records.append(made.note(1, "moves a little").record())
    records.append(made.withdraw(1, " an edge ").record())
    assert [record["change"] for record in records] == ["mark", "edit", "note", "withdraw"]
    assert records[-1]["withdrawn"] == "an edge"
    assert records[-1]["body"] == BODY
    with pytest.raises(Refused, match="was withdrawn"):
        made.note(1, "more")
    for kind, note in (("cold", "moves a little"), ("cold", ""), ("warm", "")):
        records.append(made.undo({}).record())
        assert (records[-1]["kind"], records[-1]["note"], records[-1]["withdrawn"]) == (kind, note, "")
    with pytest.raises(Refused, match="nothing to undo"):
        made.undo({})
    again = replayed(records)
    assert (again.findings, again.undoable, again.body) == (made.findings, made.undoable, made.body)


def test_a_console_that_starts_again_has_every_change_and_can_undo_it(tmp_path: Path) -> None:
    made, tactile_map, journal = begun(), felt(), Journal(tmp_path / "console.mcap", {})
    begin = {"what": "begin", "at_s": 1.0, "pseudonym": "P-0417", "sides": None, "body": BODY}
    journal.write("console/session", 1.0, begin)
    acts = (
        lambda: made.find(tactile_map, MARK, 2.0),
        lambda: made.edit(tactile_map, {"finding": 1, "x_mm": 15.0, "y_mm": 0.0}),
        lambda: made.withdraw(1, "an edge"),
    )
    for number, act in enumerate(acts):
        journal.write("console/finding", 2.0 + number, act().record())
    journal.close()
    again = Examination()
    for stream, record in unfinished(tmp_path / "console.mcap", boot_id()).records:
        again.take(stream, record)
    assert again.findings == made.findings
    assert again.body is not None
    assert again.body.record() == BODY
    assert again.undo({}).withdrawn == ""
    assert again.undo({}).x_m == 0.0


@given(st.lists(st.sampled_from(["find", "edit", "note", "withdraw", "undo"]), max_size=30), st.randoms())
def test_the_records_alone_give_state_and_history_again(acts: list[str], random: Any) -> None:
    made, tactile_map, records = begun(), TactileMap(), []
    for act in acts:
        ident = random.randint(1, 3)
        kind = random.choice(["warm", "stiff", "other"])
        before = dict(made.findings)
        try:
            match act:
                case "find":
                    done = made.find(tactile_map, MARK | {"kind": kind}, 2.0)
                case "edit":
                    done = made.edit(tactile_map, {"finding": ident, "kind": kind, "body": random.choice([None, BODY])})
                case "note":
                    done = made.note(ident, str(random.random()))
                case "withdraw":
                    done = made.withdraw(ident, "why")
                case _:
                    done = made.undo({})
        except Refused:
            continue
        if done is not before.get(done.ident):
            records.append(done.record())
    again = replayed(records)
    assert (again.findings, again.undoable) == (made.findings, made.undoable)


def test_old_records_and_records_with_unknown_fields_still_read() -> None:
    old = {"id": 1, "at_s": 2.0, "kind": "warm", "finger": "index", "x_m": 0.01, "y_m": None, "text": "warm, 36 °C"}
    finding = Finding.of(old | {"compare": "", "note": "a"})
    assert (finding.note, finding.change, finding.withdrawn, finding.body) == ("a", "mark", "", None)
    assert Finding.of(old | {"colour": "red", "body": {"region": "tail"}}) == Finding.of(old)
    again = replayed([old, old | {"note": "written later"}], body=None)
    assert again.findings[1].note == "written later"
    assert not again.undoable, "an old note has no earlier state to return to"
    with pytest.raises(KeyError):
        Finding.of({"at_s": 2.0})


@pytest.mark.parametrize(
    ("details", "why"),
    [
        ({"finding": 9}, "no such finding"),
        ({"finding": 1, "kind": "tumbling"}, "a kind"),
        ({"finding": 1, "x_mm": 1.0}, "are numbers"),
        ({"finding": 1, "x_mm": "1", "y_mm": 2.0}, "are numbers"),
        ({"finding": 1, "body": {"region": "tail"}}, "has a region"),
        ({"finding": 1, "body": BODY | {"side": "up"}}, "has a region"),
        ({"finding": 1, "body": BODY | {"landmark": "x" * 81}}, "80 printable"),
        ({"finding": 1, "body": BODY | {"landmark_mm": -1.0}}, "0 to 1000 mm"),
        ({"finding": 1, "body": BODY | {"landmark_mm": True}}, "0 to 1000 mm"),
    ],
)
def test_an_invalid_edit_is_refused_and_changes_nothing(details: dict[str, Any], why: str) -> None:
    made, tactile_map = begun(), felt()
    before = made.find(tactile_map, MARK, 2.0)
    with pytest.raises(Refused, match=why):
        made.edit(tactile_map, details)
    assert made.findings == {1: before}
    assert not made.undoable


@pytest.mark.parametrize("reason", ["", "  ", None, "x" * (LONGEST_REASON + 1)])
def test_a_withdrawal_needs_a_reason(reason: object) -> None:
    made = begun()
    made.find(felt(), MARK, 2.0)
    with pytest.raises(Refused, match="needs a reason"):
        made.withdraw(1, reason)


def test_nothing_is_edited_withdrawn_or_undone_after_the_end() -> None:
    made, tactile_map = begun(), felt()
    made.find(tactile_map, MARK, 2.0)
    made.note(1, "a")
    made.end(3.0)
    for act in (lambda: made.edit(tactile_map, {"finding": 1}), lambda: made.withdraw(1, "why"), lambda: made.undo({})):
        with pytest.raises(Refused):
            act()


def test_kind_and_confidence_follow_the_contrast() -> None:
    made = begun()
    warm = made.find(felt(), MARK, 2.0)
    assert (warm.kind, warm.confidence) == ("warm", "high")
    assert warm.contrast is not None
    assert warm.contrast["quantity"] == "temperature"
    assert contrast_text(warm.contrast).startswith("+1.9")
    same = made.find(felt(33.1), MARK | {"kind": "warm"}, 2.0)
    assert same.confidence == "low"
    assert same.compare.startswith("no different from its surroundings (")
    nowhere = made.find(TactileMap(), MARK | {"kind": "stiff"}, 2.0)
    assert (nowhere.confidence, nowhere.contrast, nowhere.compare) == ("none", None, "")


@pytest.mark.parametrize(
    ("kind", "stiffness", "sd", "confidence"),
    [
        ("stiff", 612.0, 24.0, "low"),
        ("stiff", 1800.0, 60.0, "high"),
        ("stiff", 900.0, 90.0, "fair"),
        ("stiff", 1800.0, 1200.0, "low"),
        ("soft", 1800.0, 60.0, "low"),
        ("soft", 300.0, 9.0, "high"),
    ],
)
def test_confidence_is_in_the_difference_and_not_in_the_value(
    kind: str, stiffness: float, sd: float, confidence: str
) -> None:
    found = contrast_of(kind, TISSUE._replace(stiffness=Measured(stiffness, sd, 4, 9.0)), TISSUE)
    assert found is not None
    assert found.confidence == confidence
    assert found.clear == (confidence != "low")


def test_a_proposal_says_where_there_is_no_difference() -> None:
    same = TISSUE._replace(stiffness=Measured(612.0, 12.0, 4, 9.0))
    proposed = propose(same, TISSUE, None)
    assert proposed["kind"] is None
    assert proposed["kinds"]["stiff"]["text"] == "no different from its surroundings (1.02 ± 0.04 times)"
    assert proposed["text"].startswith("no different from its surroundings (roughness 1.0 ± 0.2 times, temperature")
    wrong = propose(TISSUE._replace(stiffness=Measured(300.0, 9.0, 4, 9.0)), TISSUE, None)
    assert wrong["kind"] == "soft"
    assert wrong["kinds"]["stiff"]["text"].startswith("not stiffer than its surroundings (0.50 ±")
    unknown = propose(NOWHERE, TISSUE, None)
    assert unknown["kinds"]["warm"]["confidence"] == "none"
    assert "too few touches" in unknown["text"]


def test_a_proposal_has_the_unit_of_the_finding() -> None:
    scale = RoughnessUm(ln_um=4.0, exponent=0.8, ln_sd=0.1, least_v=0.001, most_v=1.0)
    rough = TISSUE._replace(roughness=Measured(0.09, 0.003, 4, 9.0))
    proposed = propose(rough, TISSUE, scale)["kinds"]["rough"]["text"]
    assert proposed == compared("rough", rough, TISSUE, scale)
    assert "µm around it" in proposed


@pytest.mark.parametrize("record", [None, {}, {"quantity": "stiffness"}, {"quantity": 1, "value": "x", "sd": 1.0}])
def test_an_unreadable_contrast_has_no_text(record: Any) -> None:
    assert contrast_text(record) == ""
