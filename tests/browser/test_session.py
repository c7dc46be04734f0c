"""A whole session in the page: by keyboard alone, by holding and by pressing twice; what is refused is said."""

from collections.abc import Callable
from typing import Any

import pytest

from tests.browser.conftest import Open, wait_for
from tests.browser.stage import Stage

pytestmark = pytest.mark.console

FOCUS = """() => {
  const e = document.activeElement, box = e.getBoundingClientRect(), style = getComputedStyle(e);
  const top = document.elementFromPoint(box.left + box.width / 2, box.top + Math.min(box.height, innerHeight) / 2);
  return { id: e.id, body: e === document.body, seen: top !== null && (e.contains(top) || top.contains(e)),
    ring: parseFloat(style.outlineWidth), style: style.outlineStyle, class: e.className };
}"""

APART_MS = 550
"""Two presses further apart than a double click, ms."""


def tab_to(page: Any, ident: str) -> None:
    """Tab until an element has the focus; on the way every focus is visible and not covered."""
    for _ in range(60):
        page.keyboard.press("Tab")
        focus = page.evaluate(FOCUS)
        if focus["body"]:
            continue
        assert focus["style"] != "none", focus
        assert focus["ring"] >= 3, focus
        assert focus["seen"], focus
        if focus["id"] == ident:
            return
    raise AssertionError(f"{ident} is not reached by Tab")


def hold(page: Any, key: str, stage: Stage, verb: str) -> None:
    """Hold a key until what it does is asked: a busy machine takes longer than the second that the page counts."""
    page.keyboard.down(key)
    wait_for(stage, verb)
    page.keyboard.up(key)


@pytest.mark.parametrize("size", [(1440, 900, 1), (720, 450, 2)])
def test_a_whole_session_by_keyboard_alone(
    stage: Stage, open_page: Open, picture_of: Callable[[Any, str], None], size: tuple[int, int, int]
) -> None:
    page = open_page("connected", size)
    tab_to(page, "stop")
    tab_to(page, "begin-pseudonym")
    page.keyboard.type("P-0417")
    page.keyboard.press("Enter")
    assert wait_for(stage, "begin")[0]["details"]["pseudonym"] == "P-0417"
    page.wait_for_selector("#sheet-session", state="hidden")
    assert page.input_value("#begin-pseudonym") == "", "it is not there for the next person"
    page.wait_for_selector("#act-button:enabled:has-text('Engage')")
    hold(page, "e", stage, "engage")
    page.wait_for_selector("body[data-shown=engaged]")
    page.keyboard.press("2")
    page.keyboard.press("f")
    for key in ("2", "ArrowRight", "ArrowRight", "Shift+ArrowUp"):
        page.keyboard.press(key)
    picture_of(page, f"finding by keyboard {size[0]}")
    page.keyboard.press("Enter")
    finding = wait_for(stage, "finding")[0]["details"]
    assert finding["kind"] == "warm"
    assert finding["finger"] == "index"
    assert (finding["y_mm"], round(finding["y_mm"])) == (-15, finding["y_mm"])
    page.wait_for_selector("#marking", state="hidden")
    assert page.inner_text("#read-out") == "Finding 1 saved: warm, 36.4 ± 0.2 °C."
    page.keyboard.press("n")
    page.keyboard.type("feels like a pea")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    assert wait_for(stage, "note")[0]["details"] == {"finding": 1, "text": "feels like a pea"}
    page.keyboard.press("p")
    wait_for(stage, "disengage")
    page.wait_for_selector("body[data-shown=paused]")
    assert page.inner_text("#state-word") == "PAUSED"
    tab_to(page, "session-button")
    page.keyboard.press("Enter")
    tab_to(page, "end-button")
    page.keyboard.press("Enter")
    page.wait_for_selector("#end-button:has-text('End examination P-0417? 1 finding.')")
    page.keyboard.press("Enter")
    wait_for(stage, "end")
    page.wait_for_selector("#report-link:visible")
    assert page.inner_text("#session-summary") == "Saved: 12 min 41 s, 1 finding, 0 gaps."
    assert page.get_attribute("#report-link", "href") == "/report/P-0417.html"


def test_engaging_takes_a_held_press_or_two(stage: Stage, open_page: Open) -> None:
    page = open_page("ready")
    page.click("#act-button")
    page.wait_for_selector("#act-button:has-text('Confirm engage')")
    assert [ask for ask in stage.asks if ask["verb"] == "engage"] == []
    page.wait_for_timeout(APART_MS)
    page.click("#act-button")
    wait_for(stage, "engage")
    stage.show("ready")
    page.wait_for_selector("body[data-shown=connected]")
    box = page.locator("#act-button").bounding_box()
    page.mouse.move(box["x"] + 30, box["y"] + 30)
    page.mouse.down()
    wait_for(stage, "engage", 2)
    page.mouse.up()


def test_releasing_a_held_engage_does_not_pause(stage: Stage, open_page: Open) -> None:
    page = open_page("ready")
    page.hover("#act-button")
    page.mouse.down()
    page.wait_for_selector("#act-button:has-text('Pause')")
    page.mouse.up()
    page.wait_for_timeout(300)  # a request would have come
    assert [ask["verb"] for ask in stage.asks] == ["engage"]
    page.click("#act-button")
    wait_for(stage, "disengage")


def test_a_held_enter_is_one_press(stage: Stage, open_page: Open) -> None:
    page = open_page("ready")
    page.focus("#act-button")
    for _ in range(5):
        page.keyboard.down("Enter")  # from the second on with key repeat
    page.keyboard.up("Enter")
    page.wait_for_selector("#act-button:has-text('Confirm engage')")
    assert stage.asks == []
    page.wait_for_timeout(APART_MS)
    page.keyboard.press("Enter")
    wait_for(stage, "engage")


@pytest.mark.parametrize("way", ["mouse", "touch"])
def test_a_double_click_is_one_press(stage: Stage, open_page: Open, way: str) -> None:
    page = open_page("ready", has_touch=way == "touch")
    if way == "touch":
        page.tap("#act-button")
        page.tap("#act-button")
    else:
        page.dblclick("#act-button")
    page.wait_for_selector("#act-button:has-text('Confirm engage')")
    stage.show("paused")
    page.wait_for_selector("body[data-shown=paused]")
    page.click("#session-button")
    page.dblclick("#end-button")
    page.wait_for_selector("#end-button:has-text('?')")
    page.wait_for_timeout(300)  # a request would have come
    assert stage.asks == []


def test_words_that_are_typed_without_a_text_field_do_not_engage(stage: Stage, open_page: Open) -> None:
    page = open_page("ready")
    page.keyboard.type("feel", delay=100)
    page.keyboard.type("eye", delay=APART_MS)
    page.wait_for_timeout(300)  # a request would have come
    assert [ask for ask in stage.asks if ask["verb"] == "engage"] == []


def test_pausing_is_one_press_and_a_fault_is_cleared_by_holding(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.click("#act-button")
    wait_for(stage, "disengage")
    stage.show("fault")
    page.wait_for_selector("body[data-shown=fault]")
    page.keyboard.press("c")
    page.wait_for_selector("#act-button:has-text('Confirm clear')")
    hold(page, "c", stage, "clear_fault")
    page.wait_for_selector("body[data-shown=connected]")


def test_a_refusal_is_shown_and_spoken(stage: Stage, open_page: Open) -> None:
    stage.answers["engage"] = lambda _: {"ok": False, "text": "Cannot engage: Ring module absent."}
    page = open_page("ready")
    page.evaluate(
        "window.spoken = [];"
        "const polite = document.querySelector('#polite');"
        "new MutationObserver(() => window.spoken.push(polite.innerText)).observe(polite, {childList: true});"
    )
    hold(page, "e", stage, "engage")
    page.wait_for_selector("#read-out:has-text('Cannot engage: Ring module absent.')")
    # On a busy machine the page may be late, and says then that it is not live.
    assert "Cannot engage: Ring module absent." in page.evaluate("window.spoken")
    page.wait_for_selector("body[data-shown=connected]")


def test_a_name_is_no_study_number(open_page: Open) -> None:
    page = open_page("connected")
    page.fill("#begin-pseudonym", "Anna Muster")
    page.click("#begin-form .first")
    page.wait_for_selector("#begin-said:has-text('Use a study number, not a name.')")
    assert page.evaluate("document.activeElement.id") == "begin-pseudonym"


@pytest.mark.parametrize("way", ["mouse", "touch", "key"])
def test_the_patient_confirms_what_is_recorded(stage: Stage, open_page: Open, way: str) -> None:
    stage.show("connected").state["session"]["consented"] = ["touch", "picture"]
    page = open_page(has_touch=True)
    box = page.get_by_label("The patient agrees to have recorded: touch, pictures.")
    box.wait_for()
    {"mouse": box.click, "touch": box.tap, "key": lambda: box.press("Space")}[way]()
    page.fill("#begin-pseudonym", "P-0417")
    page.keyboard.press("Enter")
    (begun,) = wait_for(stage, "begin")
    assert begun["details"]["consent"] is True


def test_what_is_missing_is_listed_with_the_command_to_run(open_page: Open) -> None:
    page = open_page("disconnected")
    page.wait_for_selector("#checks li")
    texts = [" ".join(text.split()) for text in page.locator("#checks li").all_inner_texts()]
    assert "✗ Ring Ring module absent. Check its cable, then: teletaction doctor --config operator.toml" in texts
    assert "✗ Calibration Not calibrated. Materials stay UNKNOWN. teletaction calibrate --config remote.toml" in texts
    assert len(texts) == 4
    assert page.inner_text("#chart-meaning") == "Accuracy of these answers: not known."


def test_a_finding_is_discarded_by_backspace_and_kept_open_when_it_is_not_taken(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.keyboard.press("f")
    page.keyboard.press("Backspace")
    page.wait_for_selector("#marking", state="hidden")
    stage.answers["finding"] = lambda _: {"ok": False, "text": "Not taken."}
    page.keyboard.press("f")
    page.keyboard.press("1")
    page.keyboard.press("Enter")
    wait_for(stage, "finding")
    page.wait_for_selector("#read-out:has-text('Not taken.')")
    assert page.is_visible("#marking")


def test_letter_keys_can_be_moved_to_alt(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.keyboard.press("?")
    page.click("#letters-button")
    page.click("#sheet-help .close")
    page.keyboard.press("p")
    page.keyboard.press("Alt+r")
    page.wait_for_selector("[data-quantity=roughness][aria-pressed=true]")
    assert [ask for ask in stage.asks if ask["verb"] == "disengage"] == []
    page.keyboard.press("Alt+p")
    wait_for(stage, "disengage")
    hint = "getComputedStyle(document.querySelector('{}'), '::before').content"
    assert page.evaluate(hint.format("#act-button kbd")) == '"Alt "', "its key is shown as it works"
    assert page.evaluate(hint.format("#finding-save kbd")) == "none"


def test_an_observer_acts_in_no_way(stage: Stage, open_page: Open) -> None:
    page = open_page("observer")
    assert page.inner_text("#looking-on") == "OBSERVER. Control is at OR-2."
    for key in ("e", "p", "c", "f", "n", "Space", "Escape"):
        # A held key takes a second.
        page.keyboard.press(key, delay=1200 if key in "ec" else 0)
    page.mouse.move(700, 400)
    page.wait_for_timeout(600)  # two rounds of the read-out under the cursor
    assert {ask["verb"] for ask in stage.asks} == {"place"}
    assert not page.is_visible("#marking")


def test_control_is_taken_over_only_while_nothing_is_driven(stage: Stage, open_page: Open) -> None:
    page = open_page("elsewhere")
    while not any(ask["verb"] == "take_control" for ask in stage.asks):
        # A page that is late at this moment asks for nothing, and shows that; a person presses again.
        page.click("#act-button:has-text('Take control')")
        page.wait_for_timeout(500)
    page.wait_for_selector("#act-button:enabled:has-text('Engage')")


@pytest.mark.parametrize(
    ("state", "offered", "is_offered"), [("engaged", "Pause", False), ("fault", "Take control", True)]
)
def test_a_page_without_control_offers_nothing_that_is_refused(
    stage: Stage, open_page: Open, state: str, offered: str, is_offered: bool
) -> None:
    stage.show(state).shows(you={"role": "act", "in_control": False, "control": "OR-2"})
    page = open_page()
    page.wait_for_selector(f"#act-button:has-text('{offered}')")
    assert "Control is at OR-2." in page.inner_text("#act-button")
    assert page.is_enabled("#act-button") == is_offered
    for button in ("#finding-button", "#note-button", "#clutch-button"):
        assert page.is_disabled(button), button
    assert page.locator("[data-edit]").count() == 0
    for key in "pfn":
        page.keyboard.press(key)
    page.wait_for_timeout(300)  # a request would have come
    assert [ask["verb"] for ask in stage.asks if ask["verb"] != "place"] == []
    page.keyboard.press("Space") if state == "engaged" else page.click("#stop")
    wait_for(stage, "estop")


def test_a_recording_is_played_and_sought(stage: Stage, open_page: Open) -> None:
    page = open_page("playback")
    page.keyboard.press("Space")
    wait_for(stage, "pause")
    page.wait_for_selector("#play-button:has-text('Play')")
    page.keyboard.press("Space")
    assert wait_for(stage, "play")[0]["details"] == {"speed": 1}
    stage.scenario.state["session"]["playback"]["at_s"] = 200.0
    page.wait_for_selector("#played:has-text('00:03:20 of 00:12:41')")
    for key in ("ArrowRight", "Shift+ArrowRight", "]", "[", "Home", "End"):
        page.keyboard.press(key)
    places = [ask["details"]["at_s"] for ask in wait_for(stage, "seek", 6)]
    assert places == pytest.approx([201, 211, 311, 120, 0, 761.2])
    assert page.locator("#ticks > span").count() == 4


PAST = "Link was lost: session ended. Acknowledge (K)."


def paused_after_alarm(stage: Stage, why: str = "") -> None:
    """Paused, with one alarm that is over and not acknowledged."""
    scenario = stage.show("paused").session(why=why)
    scenario.state["alarms"].clear()
    scenario.alarm("link", "high", PAST, what="LINK LOST.", active=False, waits=True, ended_s=712.0)


def test_a_past_alarm_hides_no_pause_and_takes_no_button(stage: Stage, open_page: Open) -> None:
    paused_after_alarm(stage, "Console was hidden for 3 s")
    page = open_page()
    page.wait_for_selector("#alarm-text:has-text('PAUSED. Console was hidden for 3 s.')")
    assert page.inner_text("#alarm-button") == "+1 (A)"
    assert "Resume" in page.inner_text("#act-button")
    page.click("#alarm-button")
    line = page.inner_text("#alarm-list li:has-text('LINK LOST.')")
    assert "14:06:01" in line
    assert "lasted 12.0 s" in line
    assert "over, not acknowledged" in line


@pytest.mark.parametrize("way", ["key", "mouse"])
def test_a_past_alarm_is_acknowledged_in_the_alarm_line(stage: Stage, open_page: Open, way: str) -> None:
    paused_after_alarm(stage)
    page = open_page()
    page.wait_for_selector(f"#alarm-text:has-text('{PAST}')")
    if way == "key":
        page.keyboard.press("k")
    else:
        page.click("#acknowledge-button")
    wait_for(stage, "acknowledge")
    page.wait_for_selector("#acknowledge-button", state="hidden")
    page.wait_for_selector("#alarm-text:has-text('No alarms')")


def test_a_past_alarm_is_acknowledged_by_touch(stage: Stage, open_page: Open) -> None:
    paused_after_alarm(stage)
    page = open_page(has_touch=True)
    page.tap("#acknowledge-button")
    wait_for(stage, "acknowledge")


def test_nothing_is_acknowledged_by_an_observer_or_without_data(stage: Stage, open_page: Open) -> None:
    stage.show("observer").alarm("link", "high", PAST, active=False, waits=True, ended_s=712.0)
    page = open_page()
    page.wait_for_selector(f"#alarm-text:has-text('{PAST}')")
    assert page.is_hidden("#acknowledge-button")
    paused_after_alarm(stage)
    page.wait_for_selector("#acknowledge-button")
    stage.cut()
    page.wait_for_selector("#acknowledge-button", state="hidden")


def test_why_a_session_paused_is_said_beside_lesser_alarms(stage: Stage, open_page: Open) -> None:
    stage.show("paused").session(why="Console was hidden for 3 s")
    page = open_page()
    page.wait_for_selector("#alarm-text:has-text('PAUSED. Console was hidden for 3 s.')")


def test_an_opened_sheet_takes_the_focus_in_an_examination_too(open_page: Open) -> None:
    page = open_page("paused")
    for button in ("#session-button", "#alarm-button", "#help-button"):
        page.focus(button)
        page.keyboard.press("Enter")
        assert page.evaluate("document.activeElement.closest('.sheet') !== null"), button
        assert page.evaluate("document.activeElement.id") != "end-button", "a further Enter ends nothing"


def test_the_focus_is_where_the_next_examination_begins_after_the_end(open_page: Open) -> None:
    page = open_page("paused")
    page.click("#session-button")
    page.focus("#end-button")
    page.keyboard.press("Enter")
    page.wait_for_selector("#end-button:has-text('?')")
    page.keyboard.press("Enter")
    page.wait_for_selector("#session-summary:has-text('Saved')")
    assert page.evaluate("document.activeElement.id") == "begin-pseudonym"
