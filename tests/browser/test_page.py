"""The page as it is delivered: its weight, its policy, hostile words, contrast, flashing and sound."""

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from common.limits import MOTION_SCALES
from operator_site.console.web.server import PAGE
from remote_site.patient_page.run import PAGE as PATIENT_PAGE
from tests.browser.conftest import Open, wait_for
from tests.browser.stage import Stage
from tests.waiting import wait_until

MOST_BYTES = 240_000
LOADED = ("*.html", "*.css", "*.js", "*.svg")
HOSTILE = "<img src=x onerror='window.struck=1'><script>window.struck=1</script>\u202e&lt;b&gt; \"' ${window.struck=1}"
LONGEST = 10_000
CSP = "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"


def files() -> list[str]:
    return [path.read_text("utf-8") for pattern in LOADED for path in sorted(PAGE.glob(pattern))]


def test_it_weighs_at_most_240_kb_and_names_no_outside_address() -> None:
    assert sum(len(text.encode()) for text in files()) <= MOST_BYTES
    for text in files():
        assert set(re.findall(r"\b(?:https?|wss?)://[\w./-]*", text)) <= {"http://www.w3.org/2000/svg"}


def test_it_offers_the_motion_scales_of_the_limits() -> None:
    assert f"const SCALES = {list(MOTION_SCALES)};" in (PAGE / "clutch.js").read_text("utf-8")


def test_it_writes_text_and_never_markup() -> None:
    for text in files():
        assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\b|new Function", text)


def test_it_reads_no_wall_clock_so_one_that_changes_changes_nothing() -> None:
    for text in files():
        assert not re.search(r"\bDate\b|Temporal", text)


@pytest.mark.parametrize("folder", [PAGE, PATIENT_PAGE])
def test_no_browser_translates_it_because_a_translation_would_change_while_it_is_read(folder: Path) -> None:
    assert '<html lang="en" translate="no">' in (folder / "index.html").read_text("utf-8")


def luminance(colour: str) -> float:
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("theme", [0, 1])
def test_contrast_of_words_and_lines_on_both_grounds(theme: int) -> None:
    blocks = re.findall(r":root[^{]*\{([^}]*)\}", (PAGE / "console.css").read_text("utf-8"))[:2]
    colours = [dict(re.findall(r"--(\w+): (#\w{6})", block)) for block in blocks]
    chosen, fills = colours[theme], colours[0]
    for ground in ("ground", "panel"):
        for ink, least in (("text", 7.0), ("muted", 4.5), ("line", 3.0), ("mark", 3.0)):
            assert contrast(chosen[ink], chosen[ground]) >= least, (ink, ground)
    for fill, ink in (("high", "#FFFFFF"), ("medium", "#000000"), ("low", "#000000"), ("engaged", "#000000")):
        assert contrast(fills[fill], ink) >= 4.5, fill


@pytest.mark.console
def test_hostile_words_stay_words(stage: Stage, open_page: Open) -> None:
    scenario = stage.show("engaged")
    scenario.state["findings"][0] |= {"text": HOSTILE, "note": HOSTILE + "x" * LONGEST}
    scenario.session(pseudonym=HOSTILE[:40], saved={"text": HOSTILE, "report": "javascript:window.struck=1"})
    scenario.state["map"]["materials"] = [HOSTILE] * 6
    scenario.state["checks"][0] |= {"ready": False, "text": HOSTILE, "help": HOSTILE}
    scenario.state["fingers"][1] |= {"candidates": [[HOSTILE, 0.9]], "decision": "IDENTIFIED"}
    scenario.alarm("hostile", "low", HOSTILE)
    page = open_page()
    page.click("#session-button")
    page.click("#alarm-button")
    page.keyboard.press("m")
    page.keyboard.press("n")
    page.wait_for_timeout(600)  # two rounds of everything that is written four times a second
    assert page.evaluate("window.struck") is None
    assert page.inner_text("#alarm-text").startswith("<img src=x")
    assert page.evaluate("document.querySelectorAll('main img, main script').length") == 0
    assert not page.is_visible("#report-link")
    shown = page.text_content("[data-jump='1']")
    assert "<img src=x" in shown
    assert len(shown) < LONGEST, "a long note does not fill the list"


@pytest.mark.console
def test_the_policy_keeps_scripts_and_styles_out_that_are_not_the_pages(stage: Stage, browser: Any) -> None:
    page = browser.new_page()
    answer = page.goto(stage.url)
    assert answer.headers["content-security-policy"] == CSP
    page.evaluate(
        "const s = document.createElement('script'); s.textContent = 'window.struck = 1'; document.body.append(s)"
    )
    assert page.evaluate("window.struck") is None
    page.close()


@pytest.mark.console
def test_alarms_flash_less_than_three_times_a_second_and_not_at_all_where_motion_is_reduced(open_page: Open) -> None:
    flashes = """id => { const { animationDuration, animationName } = getComputedStyle(document.querySelector(id));
      return `${animationDuration} ${animationName}`; }"""
    page = open_page("fault")
    assert page.evaluate(flashes, "#alarm-line") == "0.5s flash"
    assert page.evaluate(flashes, "#alarm-text").endswith("none")
    still = open_page("fault", reduced_motion="reduce")
    assert still.evaluate(flashes, "#alarm-line").endswith("none")
    assert still.evaluate("getComputedStyle(document.querySelector('#alarm-line')).borderTopWidth") == "6px"


@pytest.mark.console
def test_alarm_sounds_have_the_pulses_of_their_priority(open_page: Open) -> None:
    page = open_page("engaged")
    found = page.evaluate(
        """async () => { const { pulses, AGAIN_S } = await import('/page/sound.js');
          return ['high', 'medium', 'low'].map(one => [pulses(one), String(AGAIN_S[one])]); }"""
    )
    (high, high_again), (medium, medium_again), (low, low_again) = found
    assert (len(high), len(medium), len(low)) == (10, 3, 1)
    gaps = [round(later - earlier, 2) for earlier, later in pairwise(high)]
    assert gaps[:4] == gaps[5:]
    assert gaps[4] > gaps[2] > gaps[0]
    assert (high_again, medium_again, low_again) == ("4", "20", "Infinity")


@pytest.mark.console
def test_a_paused_sound_comes_back_on_a_page_that_draws_nothing(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.evaluate("""() => { window.played = 0;
      const made = AudioContext.prototype.createOscillator;
      AudioContext.prototype.createOscillator = function () { window.played += 1; return made.call(this); }; }""")
    page.keyboard.press("1")  # sound needs an act of the user
    page.evaluate("""() => { window.requestAnimationFrame = () => 0;
      Object.defineProperty(document, 'hidden', { get: () => true }); }""")
    stage.scenario.alarm("link", "medium", "Link slow: 200 ± 8 ms. Move slowly.", quiet_until_s=stage.now_s + 2.0)
    page.wait_for_selector("#alarm[data-priority=medium]")
    page.wait_for_timeout(600)  # twice what sounds alarms
    assert page.evaluate("window.played") == 0
    wait_until(lambda: page.evaluate("window.played") == 3, "the sound stays off", 10.0)


@pytest.mark.console
def test_one_announcement_at_most_every_two_seconds_and_none_for_a_number_that_counts(
    stage: Stage, open_page: Open
) -> None:
    page = open_page("engaged")
    page.evaluate("""() => { window.said = []; const polite = document.getElementById('polite');
          new MutationObserver(all => all.forEach(() => window.said.push(polite.textContent)))
            .observe(polite, { childList: true, characterData: true, subtree: true }); }""")
    for number in range(20):
        stage.scenario.state["alarms"] = []
        stage.scenario.alarm("link", "medium", f"Link slow: {200 + number} ± 8 ms. Move slowly.")
        page.wait_for_timeout(100)  # as fast as states are sent
    page.wait_for_timeout(2500)  # past the next announcement
    assert page.evaluate("window.said.length") == 1


@pytest.mark.console
def test_the_users_theme_outlasts_a_change_of_the_systems(open_page: Open) -> None:
    page = open_page("engaged", theme="dark")
    page.keyboard.press("l")
    page.wait_for_selector("html[data-theme=light]")
    for system in ("light", "dark"):
        page.emulate_media(color_scheme=system)
    assert page.get_attribute("html", "data-theme") == "light"


MUTE = """Object.defineProperty(AudioContext.prototype, 'state',
  { get: () => window.allowed ? 'running' : 'suspended' });"""
"""A browser that waits for an act of the user, as after a reload."""


@pytest.mark.console
def test_a_page_that_may_not_sound_yet_says_what_to_do(open_page: Open) -> None:
    page = open_page("paused", script=MUTE)
    page.keyboard.press("a")
    page.wait_for_selector("#alarm-list li:has-text('No alarm sound in this page. Click into it once.')")
    page.evaluate("window.allowed = true")
    page.wait_for_selector("#alarm-list li:has-text('No alarm sound')", state="detached")
    assert open_page("connected", script=MUTE).locator("#alarm-text:has-text('sound')").count() == 0, (
        "it is asked first"
    )


@pytest.mark.console
def test_the_sounds_button_does_not_read_as_a_sound_that_is_off(stage: Stage, open_page: Open) -> None:
    page = open_page("unknown")
    page.wait_for_selector("#quiet-button:has-text('Pause sound 60 s (Q)')")
    page.keyboard.press("q")
    page.wait_for_selector("#quiet-button:has-text('Sound paused 60 s')")
    assert [ask["details"]["alarm"] for ask in wait_for(stage, "quiet")] == ["plate-index"]


@pytest.mark.console
def test_an_observer_pauses_the_sound_of_its_own_page_only(stage: Stage, open_page: Open) -> None:
    stage.show("observer").alarm("link", "medium", "Link slow: 200 ± 8 ms. Move slowly.")
    page = open_page()
    page.wait_for_selector("#quiet-button:visible")
    page.keyboard.press("q")
    page.wait_for_selector("#quiet-button:has-text('Sound paused')")
    assert [ask["verb"] for ask in stage.asks if ask["verb"] != "place"] == []


@pytest.mark.console
def test_a_list_of_alarms_that_only_grow_older_is_not_written_again(stage: Stage, open_page: Open) -> None:
    page = open_page("fault")
    page.keyboard.press("a")
    page.wait_for_selector("#alarm-list li")
    page.evaluate("document.querySelector('#alarm-list li').id = 'read'")
    for alarm in stage.scenario.state["alarms"]:
        alarm["age_s"] += 1.0
    page.wait_for_timeout(500)  # a few states
    assert page.locator("#read").count() == 1


@pytest.mark.console
def test_with_the_systems_colours_the_mark_and_a_held_press_are_seen(open_page: Open) -> None:
    page = open_page("ready", forced_colors="active")
    fills = "({ backgroundColor, backgroundImage }) => [backgroundColor, backgroundImage]"
    ground, _ = page.evaluate(f"({fills})(getComputedStyle(document.body))")
    mark, _ = page.evaluate(f"({fills})(getComputedStyle(document.querySelector('#mark-step')))")
    assert mark != ground
    page.hover("#act-button")
    page.mouse.down()
    _, held = page.evaluate(f"({fills})(getComputedStyle(document.querySelector('#act-button')))")
    page.mouse.up()
    assert "gradient" in held


@pytest.mark.console
def test_a_contrast_names_its_quantity(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.wait_for_selector("#against:has-text('−0.9 ± 0.3 K, 1.8 ± 0.1 times as stiff')")
    del stage.scenario.state["fingers"][1]["against"]["temperature"]
    page.wait_for_function("() => document.getElementById('against').textContent === '1.8 ± 0.1 times as stiff'")


@pytest.mark.console
def test_the_name_of_the_tab_is_its_state(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.wait_for_function("() => document.title === 'ENGAGED · teletaction'")
    stage.show("playback")
    page.wait_for_function("() => document.title === 'PLAYBACK · teletaction'")


@pytest.mark.console
@pytest.mark.parametrize("scenario", ["observer", "playback"])
def test_without_buttons_an_upright_page_keeps_no_room_for_them(open_page: Open, scenario: str) -> None:
    page = open_page(scenario, (768, 1024, 1))
    box = page.locator("main").bounding_box()
    assert box["y"] + box["height"] >= 0.9 * 1024
