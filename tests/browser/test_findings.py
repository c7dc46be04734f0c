"""Findings as objects: list, jump, edit, withdrawal and undo by mouse, touch and keyboard, and the body diagram."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.browser.conftest import Open, wait_for
from tests.browser.stage import Stage
from tests.browser.test_every_state import axe_findings

pytestmark = pytest.mark.console

LOOK = Path(__file__).with_name("look.js").read_text("utf-8")
WAYS = ("mouse", "touch", "keyboard")
SIZES = {"1440 x 900": (1440, 900, 1), "1024 x 768": (1024, 768, 1), "800 x 1280": (800, 1280, 1)}


def press(page: Any, selector: str, way: str) -> None:
    """Use a control in one of WAYS."""
    if way == "mouse":
        page.click(selector)
    elif way == "touch":
        page.tap(selector)
    else:
        page.focus(selector)
        page.keyboard.press("Enter")


def kinds_pressed(page: Any) -> list[str]:
    pressed = "buttons => buttons.map(button => button.textContent)"
    found: list[str] = page.eval_on_selector_all("#kinds [aria-pressed=true]", pressed)
    return found


def test_the_list_is_in_view_and_shows_kind_value_contrast_and_place(open_page: Open) -> None:
    page = open_page("engaged")
    shown = page.inner_text("#found-list")
    for part in ("1: warm, 36.4 ± 0.2 °C", "+3.4 ± 0.3 K", "x 40 y -20 mm", "10 ± 1 times"):
        assert part in shown
    assert page.inner_text("#found-title") == "2 findings"
    numbers = page.eval_on_selector_all("[data-jump]", "found => found.map(each => each.dataset.jump)")
    assert numbers == ["2", "1"], "the newest first"


@pytest.mark.parametrize(
    ("name", "text"),
    [("engaged", "No findings yet. F marks one."), ("observer", "No findings yet."), ("playback", "No findings yet.")],
)
def test_only_who_may_mark_a_finding_reads_the_key_for_it(stage: Stage, open_page: Open, name: str, text: str) -> None:
    page = open_page(name)
    stage.scenario.state["findings"].clear()
    page.wait_for_selector("#found-none:visible")
    assert page.inner_text("#found-none") == text


@pytest.mark.parametrize("way", WAYS)
def test_a_jump_puts_the_middle_of_the_map_on_the_finding(stage: Stage, open_page: Open, way: str) -> None:
    page = open_page("engaged", has_touch=way == "touch")
    press(page, "[data-jump='2']", way)
    page.wait_for_function("() => document.getElementById('read-out').textContent.startsWith('x -30 y 20 mm')")
    assert {"x_mm": -30, "y_mm": 20} in [ask["details"] for ask in wait_for(stage, "place")]


@pytest.mark.parametrize("way", WAYS)
def test_a_finding_is_edited_withdrawn_and_brought_back(stage: Stage, open_page: Open, way: str) -> None:
    page = open_page("engaged", has_touch=way == "touch")
    press(page, "[data-edit='1']", way)
    page.wait_for_selector("#marking:not([hidden])")
    assert kinds_pressed(page) == ["warm 2"]
    press(page, "#kinds button:nth-child(4)", way)
    page.wait_for_selector("#marking-contrast:has-text('no different from its surroundings')")
    press(page, "#finding-save", way)
    (edited,) = wait_for(stage, "edit")
    assert edited["details"] == {"finding": 1, "kind": "stiff", "x_mm": 40, "y_mm": -20}
    page.wait_for_selector("#marking", state="hidden")
    press(page, "[data-edit='1']", way)
    press(page, "#finding-withdraw", way)
    page.keyboard.type("an edge of the table")
    press(page, "#withdrawing .first", way)
    (withdrawn,) = wait_for(stage, "withdraw")
    assert withdrawn["details"] == {"finding": 1, "reason": "an edge of the table"}
    page.wait_for_selector("[data-jump='1'] s")
    assert "withdrawn: an edge of the table" in page.inner_text("[data-jump='1']")
    assert page.inner_text("#found-title") == "1 finding"
    press(page, "[data-undo='1']", way)
    (undone,) = wait_for(stage, "undo")
    assert undone["details"] == {"finding": 1, "changes": 1}
    page.wait_for_selector("[data-edit='1']")
    page.wait_for_selector("[data-undo]", state="detached")


def test_a_withdrawal_needs_a_reason(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.click("[data-edit='2']")
    page.click("#finding-withdraw")
    page.click("#withdrawing .first")
    assert page.inner_text("#withdraw-said") == "Give a reason."
    page.click("#withdraw-cancel")
    assert page.evaluate("document.activeElement.dataset.jump") == "2"
    assert not [ask for ask in stage.asks if ask["verb"] == "withdraw"]


@pytest.mark.parametrize("way", WAYS)
def test_the_kind_is_proposed_and_no_contrast_is_said_before_saving(stage: Stage, open_page: Open, way: str) -> None:
    page = open_page("engaged", has_touch=way == "touch")
    press(page, "#finding-button", way)
    page.wait_for_selector("#marking-contrast:has-text('Proposed warm: +3.4 ± 0.3 K against')")
    assert kinds_pressed(page) == ["warm 2"]
    assert "Confidence: high." in page.inner_text("#marking-contrast")
    press(page, "#kinds button:nth-child(4)", way)
    said = page.inner_text("#marking-contrast")
    assert said == "Stiff: no different from its surroundings (1.02 ± 0.04 times). Confidence: low."
    assert not [ask for ask in stage.asks if ask["verb"] == "finding"]
    press(page, "#finding-save", way)
    (saved,) = wait_for(stage, "finding")
    assert saved["details"]["kind"] == "stiff"


def test_a_place_that_moved_has_no_proposal_of_the_old_place(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.click("#finding-button")
    page.wait_for_selector("#marking-contrast:has-text('Proposed warm')")
    asked = len(wait_for(stage, "propose"))
    stage.answers["propose"] = lambda _: {"ok": None}
    page.keyboard.press("ArrowRight")
    assert kinds_pressed(page) == []
    assert page.inner_text("#marking-contrast") == ""
    wait_for(stage, "propose", asked + 2)
    del stage.answers["propose"]
    page.wait_for_selector("#marking-contrast:has-text('Proposed warm')")


@pytest.mark.parametrize("way", WAYS)
def test_a_place_on_the_body_goes_with_a_finding(stage: Stage, open_page: Open, way: str) -> None:
    page = open_page("engaged", has_touch=way == "touch")
    press(page, "#finding-button", way)
    press(page, "#finding-body", way)
    press(page, "#body-views [data-value=front]", way)
    if way == "keyboard":
        press(page, "#body-regions [data-value=forearm]", way)
        press(page, "#body-sides [data-value=left]", way)
    else:
        press(page, "#body-picture [data-r=forearm][data-s=left]", way)
    assert page.inner_text("#body-said") == "Left forearm"
    page.fill("#body-landmark", "wrist crease")
    page.fill("#body-mm", "20")
    page.focus("#body-use")
    assert page.inner_text("#body-said") == "Left forearm, 20 mm from wrist crease"
    press(page, "#body-use", way)
    assert page.inner_text("#marking-title").endswith("left forearm, 20 mm from wrist crease")
    press(page, "#finding-save", way)
    (saved,) = wait_for(stage, "finding")
    mark = {"region": "forearm", "side": "left", "landmark": "wrist crease", "landmark_mm": 20}
    assert saved["details"]["body"] == mark


@pytest.mark.parametrize(("typed", "mm"), [("12,5", 12.5), ("12.5", 12.5), (" 20 ", 20), ("", None)])
def test_a_distance_from_a_landmark_may_have_a_comma(
    stage: Stage, open_page: Open, typed: str, mm: float | None
) -> None:
    page = open_page("engaged")
    page.click("#finding-button")
    page.click("#finding-body")
    page.click("#body-regions [data-value=abdomen]")
    page.fill("#body-landmark", "navel")
    page.focus("#body-mm")
    page.keyboard.type(typed)
    page.click("#body-use")
    page.click("#finding-save")
    (saved,) = wait_for(stage, "finding")
    assert saved["details"]["body"]["landmark_mm"] == mm


@pytest.mark.parametrize("typed", ["1.2.5", "two", "1e3", "-4", "1001"])
def test_a_distance_that_is_no_number_keeps_the_diagram_open(open_page: Open, typed: str) -> None:
    page = open_page("engaged")
    page.click("#finding-button")
    page.click("#finding-body")
    page.click("#body-regions [data-value=abdomen]")
    page.focus("#body-mm")
    page.keyboard.type(typed)
    page.click("#body-use")
    assert page.inner_text("#body-said") == "The distance is a number from 0 to 1000 mm."
    assert page.evaluate("document.activeElement.id") == "body-mm"


@pytest.mark.parametrize("key", ["ArrowRight", "2", "Backspace", "Enter"])
def test_keys_in_the_diagram_change_no_finding_below_it(stage: Stage, open_page: Open, key: str) -> None:
    page = open_page("engaged")
    page.click("#finding-button")
    page.click("#finding-body")
    before = page.inner_text("#marking-title"), kinds_pressed(page)
    page.focus("#body-close")
    page.keyboard.press(key)
    assert (page.inner_text("#marking-title"), kinds_pressed(page)) == before
    assert page.is_visible("#marking")
    assert not [ask for ask in stage.asks if ask["verb"] == "finding"]


def test_an_examination_begins_at_a_place_on_the_body(stage: Stage, open_page: Open) -> None:
    page = open_page("connected")
    page.fill("#begin-pseudonym", "P-0417")
    page.click("#begin-body")
    page.click("#body-views [data-value=hand]")
    page.click("#body-picture [data-r=palm][data-s=right]")
    page.fill("#body-landmark", "base of the thumb")
    page.click("#body-use")
    assert page.inner_text("#begin-body") == "Right palm, at base of the thumb"
    page.click("#begin-form .first")
    (begun,) = wait_for(stage, "begin")
    mark = {"region": "palm", "side": "right", "landmark": "base of the thumb", "landmark_mm": None}
    assert begun["details"]["body"] == mark


@pytest.mark.parametrize("theme", ["dark", "light"])
@pytest.mark.parametrize("size", SIZES)
def test_trays_and_diagram_fit_and_are_accessible(
    open_page: Open, picture_of: Callable[[Any, str], None], size: str, theme: str
) -> None:
    page = open_page("engaged", SIZES[size], theme)
    wrong: dict[str, list[str]] = {}

    def look(name: str) -> None:
        page.wait_for_timeout(300)  # a round of the numbers
        if found := page.evaluate(LOOK) + axe_findings(page):
            wrong[name] = found
        picture_of(page, f"{name} {size} {theme}")

    look("findings")
    page.click("[data-edit='1']")
    look("editing")
    page.click("#finding-body")
    for view in ("head", "front", "back", "hand"):
        page.click(f"#body-views [data-value={view}]")
        page.click("#body-regions button:last-child")
        look(f"body {view}")
    page.click("#body-close")
    page.click("#finding-withdraw")
    look("withdrawing")
    page.fill("#withdraw-reason", "an edge of the table")
    page.click("#withdrawing .first")
    look("withdrawn")
    assert wrong == {}


def test_the_text_of_a_note_stays_with_its_finding_until_it_is_saved(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.click("#note-button")
    page.select_option("#note-finding", "1")
    page.fill("#note-text", "a pea")
    page.click("#note-close")
    page.click("#note-button")
    page.select_option("#note-finding", "2")
    assert page.input_value("#note-text") != "a pea"
    page.select_option("#note-finding", "1")
    assert page.input_value("#note-text") == "a pea"
    page.click("#noting [type=submit]")
    assert wait_for(stage, "note")[0]["details"] == {"finding": 1, "text": "a pea"}


@pytest.mark.parametrize(
    ("opened", "tray"),
    [("#note-button", "#noting"), ("#finding-button", "#marking"), ("[data-edit='1']", "#marking")],
)
def test_a_note_or_a_mark_of_one_examination_does_not_reach_the_next(
    stage: Stage, open_page: Open, opened: str, tray: str
) -> None:
    page = open_page("engaged")
    page.click(opened)
    page.wait_for_timeout(300)  # a round of the numbers
    assert page.is_visible(tray)
    stage.scenario.session(pseudonym="P-0418")
    page.wait_for_selector("#pseudonym:has-text('P-0418')")
    page.wait_for_timeout(300)
    assert not page.is_visible(tray)


def test_a_note_can_be_saved_after_the_end(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.click("#note-button")
    page.select_option("#note-finding", "1")
    page.fill("#note-text", "a pea")
    stage.scenario.session(pseudonym=None)
    page.wait_for_selector("#pseudonym:not(:has-text('P-0417'))", state="attached")
    page.wait_for_timeout(300)  # a round of the numbers
    page.click("#noting [type=submit]")
    assert wait_for(stage, "note")[0]["details"] == {"finding": 1, "text": "a pea"}


def test_tab_goes_from_the_text_of_a_note_to_its_button_and_not_to_stop(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.keyboard.press("n")
    page.keyboard.type("a pea")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    assert wait_for(stage, "note")[0]["details"]["text"].endswith("a pea")
    assert {ask["verb"] for ask in stage.asks} <= {"note", "place"}


@pytest.mark.parametrize(("verb", "opened"), [("finding", "#finding-button"), ("edit", "[data-edit='1']")])
def test_a_late_answer_leaves_the_tray_of_a_newer_finding_open(
    stage: Stage, open_page: Open, verb: str, opened: str
) -> None:
    page = open_page("engaged")
    stage.answers[verb] = lambda _: {"ok": None}
    page.click(opened)
    page.click("#kinds button:nth-child(4)")
    page.click("#finding-save")
    (slow,) = wait_for(stage, verb)
    page.click("#finding-discard")
    page.click("[data-edit='2']")
    page.click("#kinds button:nth-child(5)")
    newer = page.inner_text("#marking-title"), kinds_pressed(page)
    stage.answer_late(slow, {"id": 3})
    del stage.answers[verb]
    page.click("#finding-save")  # the answers come in order
    edited = wait_for(stage, "edit", 2 if verb == "edit" else 1)[-1]
    assert (edited["details"]["finding"], edited["details"]["kind"]) == (2, newer[1][0].split()[0])
    page.wait_for_selector("#marking", state="hidden")


def test_a_late_answer_keeps_a_newer_note_and_what_was_typed_since(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    stage.answers["note"] = lambda _: {"ok": None}
    page.click("#note-button")
    page.select_option("#note-finding", "1")
    page.fill("#note-text", "a pea")
    page.click("#noting [type=submit]")
    (first,) = wait_for(stage, "note")
    page.select_option("#note-finding", "2")
    page.fill("#note-text", "an edge")
    stage.answer_late(first, {})
    page.wait_for_selector("#note-said:text-is('')", state="attached")
    assert page.is_visible("#noting")
    assert page.input_value("#note-text") == "an edge"
    page.click("#noting [type=submit]")
    _, second = wait_for(stage, "note", 2)
    page.fill("#note-text", "an edge of the table")
    stage.answer_late(second, {})
    page.wait_for_selector("#note-said:text-is('')", state="attached")
    assert page.is_visible("#noting")
    assert page.input_value("#note-text") == "an edge of the table"


def test_a_late_answer_keeps_the_reason_of_another_withdrawal(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    stage.answers["withdraw"] = lambda _: {"ok": None}
    page.click("[data-edit='1']")
    page.click("#finding-withdraw")
    page.fill("#withdraw-reason", "a pea")
    page.click("#withdrawing .first")
    (slow,) = wait_for(stage, "withdraw")
    page.click("#withdraw-cancel")
    page.click("[data-edit='2']")
    page.click("#finding-withdraw")
    page.fill("#withdraw-reason", "an edge")
    stage.answer_late(slow, {})
    del stage.answers["withdraw"]
    page.click("#withdrawing .first", timeout=3000)
    assert wait_for(stage, "withdraw", 2)[-1]["details"] == {"finding": 2, "reason": "an edge"}


def test_a_place_on_the_body_goes_with_no_other_finding(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.keyboard.press("f")
    page.click("#finding-body")
    page.click("#body-regions button")
    stage.scenario.state["session"]["pseudonym"] = "P-0418"
    page.wait_for_selector("#marking", state="hidden")
    page.click("#finding-button")
    page.click("#body-use")
    page.click("#finding-save")
    assert "body" not in wait_for(stage, "finding")[0]["details"]


def test_a_note_opens_without_the_answer_to_the_note_before(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.keyboard.press("n")
    page.fill("#note-text", "feels like a pea")
    page.click("#noting .first")
    page.wait_for_selector("#noting", state="hidden")
    page.keyboard.press("n")
    assert page.input_value("#note-text") == "feels like a pea"
    assert page.inner_text("#note-said") == ""


def test_two_clicks_on_undo_are_one_undo(stage: Stage, open_page: Open) -> None:
    stage.answers["undo"] = lambda _: {"ok": None}
    stage.show("engaged").state["undo"] = 1
    page = open_page()
    page.dblclick("[data-undo='1']")
    page.keyboard.press("p")
    wait_for(stage, "disengage")
    assert [ask["verb"] for ask in stage.asks].count("undo") == 1


def test_an_undo_is_repeated_as_it_was_after_a_lost_answer(stage: Stage, open_page: Open) -> None:
    state = stage.show("engaged").state
    state["undo"], state["changes"] = 1, 2
    stage.answers["undo"] = lambda _: {"ok": None}
    page = open_page()

    def undo(times: int, text: str) -> dict[str, object]:
        page.click("[data-undo='1']")
        asked = wait_for(stage, "undo", times)
        page.wait_for_selector(f"#polite:has-text('{text}')", state="attached")
        details: dict[str, object] = asked[-1]["details"]
        return details

    assert undo(1, "No answer from the console.") == {"finding": 1, "changes": 2}
    stage.answers["undo"] = lambda _: {"text": "Undo saved."}
    state["changes"] = 1
    page.wait_for_timeout(500)
    assert undo(2, "Undo saved.") == {"finding": 1, "changes": 2}, "it may have been done"
    stage.answers["undo"] = lambda _: {"text": "Undo saved again."}
    assert undo(3, "Undo saved again.") == {"finding": 1, "changes": 1}


def test_two_clicks_on_begin_are_one_examination(stage: Stage, open_page: Open) -> None:
    stage.answers["begin"] = lambda _: {"ok": None}
    page = open_page("connected")
    page.fill("#begin-pseudonym", "P-0417")
    page.dblclick("#begin-form .first")
    page.click("#sound-refused")
    wait_for(stage, "sound")
    assert [ask["verb"] for ask in stage.asks].count("begin") == 1


def test_without_an_examination_no_finding_is_begun(stage: Stage, open_page: Open) -> None:
    page = open_page("connected")
    page.click("#sheet-session .close")
    assert page.is_disabled("#finding-button")
    page.keyboard.press("f")
    page.wait_for_selector("#read-out:has-text('No examination is open.')")
    assert page.is_hidden("#marking")
