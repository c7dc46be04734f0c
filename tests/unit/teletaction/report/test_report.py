"""A report has every figure and number, also with missing data, and loads nothing from outside."""

import base64
import re
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

from common.fingers import FINGERS
from common.wire.messages import ThermalStatus
from teletaction.recordings.session_data import Series, SessionData
from teletaction.report.examination import Examination
from teletaction.report.report import write_report
from teletaction.report.report_limits import reached
from teletaction.report.report_words import contacts_table, histogram_table, tally_table
from teletaction.report.session_curves import Curve, SessionCurves, held_s, spans
from tests.unit.teletaction.report_page import Page

NAME = 'pvc <b>&"$x$\u6728'
EMPTY = Series(np.array([]), {})
FIGURES = ("Modes over time", "Vibration", "Plate and skin temperature", "Identification converging", "Force")
FIVE = np.ones(5)


pytestmark = pytest.mark.usefixtures("coarse")


def nothing() -> SessionData:
    return SessionData(EMPTY, EMPTY, EMPTY, EMPTY, EMPTY, EMPTY, {}, [], [], [], [])


def session(thing: str = "block") -> SessionData:
    """Four seconds at 50 Hz from 100 s on; engaged at 100.5 s; one touch of all fingers from 101 to 103 s."""
    time_s = 100.0 + np.arange(200) / 50
    touching = ((time_s >= 101.0) & (time_s < 103.0)).astype(float)
    five = touching[:, None] * FIVE
    plates = 30.0 - five

    def answer(at_s: float) -> dict[str, object]:
        during = 101.0 <= at_s < 103.0
        known = ThermalStatus.IDENTIFIED if at_s > 102.0 else ThermalStatus.DECIDING
        return {
            "time_s": at_s,
            "status": int(known if during else ThermalStatus.NO_CONTACT),
            "best": thing if during else None,
            "probability": 0.9 * during,
            "object_c": 22.5 if during else None,
            "object_c_sd": 0.4 if during else None,
            "exponential_object_c": None,
            "exponential_material": None,
            "reason": None,
        }

    def event(kind: str, at_s: float, finger: int) -> dict[str, object]:
        return {"time_s": at_s, "kind": kind, "finger": finger, "object": thing, "material": thing, "object_c": 22.0}

    return SessionData(
        touch=Series(time_s, {"mode": 2 * five, "contact_force_n": five, "sequence": np.arange(200.0)}),
        rendered=Series(
            time_s,
            {
                "engaged": (time_s >= 100.5).astype(float),
                "motor_rpm": 3000 * five,
                "force_n": five,
                "plate_set_c": plates,
                "limits": 32 * five,
                "sequence": np.arange(200.0),
                "written_s": time_s + 0.001,
            },
        ),
        gate=Series(time_s, {"limits": 128 * five}),
        fingertips=Series(time_s, {"motor_rpm": 2900 * five, "plate_c": plates, "felt_c": plates, "force_n": five}),
        contact=Series(time_s, {"mode": 2 * five, "force_n": five, "plate_c": plates}),
        skin=Series(time_s, {"felt_c": plates}),
        thermal={finger: [answer(at_s) for at_s in time_s[::5].tolist()] for finger in range(5)},
        truth_events=[event(*what, f) for what in (("contact", 101.0), ("release", 103.0)) for f in range(5)],
        sent_events=[],
        played=[],
        motor_switches=[{"time_s": 101.005, "finger": f, "motor_mv": 700} for f in range(5)],
    )


def test_the_limits_on_the_page_to_sign_are_of_this_examination() -> None:
    curves = SessionCurves.of(session())
    both = "Limits that acted, each with its longest time on a finger: "
    assert reached(curves).startswith(both)
    assert "(operator site, thumb 2.0 s)" in reached(curves)
    assert "(operator site, thumb 1.0 s)" in reached(curves, 102.0, 110.0)
    assert "(operator site, thumb 1.0 s)" in reached(curves, 90.0, 102.0)
    assert reached(curves, 103.5, None) == "No limit acted."


def test_that_no_limit_acted_is_not_said_of_a_gate_that_is_not_recorded() -> None:
    """The console's report has the patient's gate only where the remote site's recording is on the same machine."""
    here = replace(session(), gate=EMPTY)
    assert reached(SessionCurves.of(here)).endswith("The limits of the patient site are not in this recording.")
    assert reached(SessionCurves.of(here), 103.5, None) == (
        "No limit of the operator site acted. The limits of the patient site are not in this recording."
    )
    assert reached(SessionCurves.of(nothing())) == "The limits of both sites are not in this recording."


def contact(**changed: object) -> dict[str, object]:
    return {
        "finger": "index",
        "object": "block",
        "true_material": "pvc",
        "material": "pvc",
        "status": "identified",
        "probability": 0.99,
        "seconds": 2.1,
        "true_object_c": 23.0,
        "object_c": 23.2,
        "paper_material": "pine",
    } | changed


def summary(**changed: object) -> dict[str, object]:
    return {
        "duration_s": 4.0,
        "scene": "materials",
        "seed": 3,
        "fingers": 5,
        "contacts": [contact()],
        "modes": {"agreement": 0.97, "confusion": {"tapping": {"tapping": 3, "stroking": 1}}},
        "impulses": {"crossed": 120, "played": 119, "missed": 1, "invented": 0},
        "taps": {"made": 12, "played": 11},
        "latency_ms": {"contact_to_motor": {"p50": 4.25, "p99": 7.0, "max": 8.0}, "bare_curve_ping": {"p50": 0.5}},
        "force_n": {"max": 1.75},
        "loop": {"remote": {"period_ms": 2.0, "late_p50_us": 35.5, "cpu": 0.319}},
        "rss_mib": {"remote": 125.6},
        "packets": {"touch": {"sent": 200, "received": 198, "superseded": 2, "refused": 0}},
        "faults": [],
    } | changed


def report(tmp_path: Path, data: SessionData, figures: dict[str, object]) -> tuple[str, Page]:
    out = tmp_path / "report.html"
    write_report(data, figures, out)
    html = out.read_text("utf-8")
    return html, Page(html)


@pytest.mark.long
def test_a_report_holds_all_figures_and_numbers_and_needs_nothing_from_outside(tmp_path: Path) -> None:
    html, page = report(tmp_path, session(), summary())
    assert len(page.pictures) == len(FIGURES) + 1
    for picture in page.pictures:
        assert base64.b64decode(picture.removeprefix("data:image/png;base64,")).startswith(b"\x89PNG")
    assert not {"script", "link", "iframe"} & page.tags
    sources = re.findall(r"(?:src|href|url)\s*[=(]\s*[\"']?([^\"'\s]{5})", html)
    assert sources == ["data:"] * (len(FIGURES) + 1)
    assert len(html) < 3_000_000
    assert "Targets" not in html
    for words in (
        *FIGURES,
        "materials, seed 3",
        "✓\xa0right",
        "✗\xa0wrong",
        "97.0 %",
        "4.25",
        "125.6",
        "0.319",
        "12 made, 11 played",
        "119",
        "198",
        "plate rate",
        "heater contact",
        "bare CURVE ping of the same size, there and back",
    ):
        assert words in page.text, words
    one, _ = report(tmp_path, session(), summary(fingers=1))
    assert "index (s)" in one
    assert "thumb (s)" not in one
    assert len(one) < len(html)


def test_targets_of_a_scene_and_a_missed_rate_are_reported(tmp_path: Path) -> None:
    target = {"target": "nodule", "quantity": "stiffness", "place_error_mm": 0.62, "value": 1790.0, "sd": 31.0}
    loop = {"remote": {"behind_s": 12.2}, "operator": {"behind_s": 0.0}}
    figures = summary(targets=[target | {"true_value": 1800.0, "error": -10.0}], loop=loop)
    html, page = report(tmp_path, nothing(), figures)
    assert "<h2>Targets</h2>" in html
    assert "1790 ± 30 N/m" in html
    assert "−10 ± 30 N/m" in html
    assert page.text.index("too slow for 5 fingers: the rate was not held for 12 s") < page.text.index("duration")


@pytest.mark.long
def test_names_are_escaped_everywhere(tmp_path: Path) -> None:
    figures = summary(
        fingers=1,
        scene=NAME,
        contacts=[contact(object=NAME, true_material=NAME, best=NAME, reason=NAME)],
        faults=[{"site": "remote", "fault": NAME}],
        modes={"confusion": {NAME: {NAME: 1}}},
        impulses={"crossed": 1, "by_object": {NAME: {"crossed": 1}}},
        packets={NAME: {"sent": 1}},
        loop={NAME: {"behind_s": 3.0}},
        rss_mib={NAME: 1.0},
    )
    html, page = report(tmp_path, session(NAME), figures)
    assert NAME not in html
    assert page.text.count(NAME) >= 8


@pytest.mark.long
@pytest.mark.parametrize(
    "figures", [{}, summary(contacts=[], modes={"agreement": None, "confusion": {}}, loop={}, packets={})]
)
def test_an_empty_session_is_reported_as_empty(tmp_path: Path, figures: dict[str, object]) -> None:
    _, page = report(tmp_path, nothing(), figures)
    assert not page.pictures
    for title in FIGURES:
        assert f"{title} none" in page.text


@pytest.mark.long
@pytest.mark.parametrize(
    "streams", [("touch",), ("rendered",), ("gate", "contact", "skin"), ("fingertips", "thermal")], ids=" and ".join
)
def test_streams_may_be_missing(tmp_path: Path, streams: tuple[str, ...]) -> None:
    parts = {name: getattr(session(), name) for name in SessionData.__slots__}
    data = SessionData(**(parts | {name: {} if name == "thermal" else EMPTY for name in streams}))
    _, page = report(tmp_path, data, summary(fingers=1))
    assert len(page.pictures) == len(FIGURES) + 1 - ("thermal" in streams)


def test_a_site_with_some_modules_is_reported_by_its_own_fingers(tmp_path: Path) -> None:
    site = Examination(figures={"devices": {"little tacttip": {}, "thumb tacttip": {}, "exoskeleton": {}}})
    write_report(session(), {}, tmp_path / "report.html", site)
    text = Page((tmp_path / "report.html").read_text("utf-8")).text
    assert [finger for finger in FINGERS if f"{finger} (s)" in text] == ["thumb", "little"]


@pytest.mark.long
def test_it_leaves_no_settings_of_figures_behind(tmp_path: Path) -> None:
    before = dict(mpl.rcParams)
    report(tmp_path, session(), {})
    assert dict(mpl.rcParams) == before


def test_the_clock_starts_when_the_sites_engage_and_a_touch_that_never_ends_lasts_until_the_end() -> None:
    curves = SessionCurves.of(session())
    assert curves.zero_s == pytest.approx(100.5)
    assert [(t.start_s, t.end_s) for t in curves.touches] == [(0.5, 2.5)] * 5
    (shared,) = curves.shared_touches(range(5))
    assert len(shared.touches) == 5
    assert all(0 < a["time_s"] < 2 for a in curves.answers(shared.touches[0]))
    data = session()
    del data.truth_events[5:]
    assert [touch.end_s for touch in SessionCurves.of(data).touches] == pytest.approx([103.98 - 100.5] * 5)


def test_thinning_keeps_peaks_and_gaps() -> None:
    value = np.zeros(100_000)
    value[54_321], value[98_765] = 7.0, -3.0
    value[:5000] = np.nan
    thin = Curve(np.arange(100_000.0), value).thinned(500)
    assert len(thin.time_s) == len(thin.value) == 1000
    assert np.nanmax(thin.value) == 7.0
    assert np.nanmin(thin.value) == -3.0
    assert np.isnan(thin.value[:40]).all()
    assert (np.diff(thin.time_s) >= 0).all()


def test_a_mode_has_spans_and_a_pause_in_the_recording_does_not_count_as_held() -> None:
    curve = Curve(np.arange(6.0), np.array([0, 0, 2, 2, np.nan, 3]))
    assert spans(curve) == [(0.0, 2.0, 0), (2.0, 4.0, 2), (5.0, 5.0, 3)]
    assert held_s(np.array([0.0, 0.1, 0.2, 60.0])).sum() == pytest.approx(0.7)


def test_right_wrong_and_silence_are_words() -> None:
    rows = [contact(), contact(material="wood"), contact(material=None, status="ambiguous", paper_material=None)]
    tables = [re.sub("class=.[a-z-]+", "", str(contacts_table([row]))) for row in rows]
    answers = [re.findall("right|wrong|no answer", table) for table in tables]
    assert answers == [["right", "wrong"], ["wrong", "wrong"], ["no answer", "no answer"]]
    tally = str(tally_table(rows))
    assert "<td>pvc</td><td>3</td><td>1</td><td>1</td><td>1</td><td>0</td><td>2</td><td>1</td>" in tally


def test_a_temperature_has_its_uncertainty() -> None:
    texts = [str(contacts_table([contact(object_c=31.2, object_c_sd=sd_k)])) for sd_k in (0.2, 2.1)]
    assert [re.findall("31.20\xa0[^<]*", text) for text in texts] == [
        ["31.20\xa0±\xa00.20"],
        ["31.20\xa0±\xa02.10, uncertain"],
    ]


def test_every_delay_is_counted_once() -> None:
    html = str(histogram_table([-0.001, 0.0, 0.0019, 0.002, 0.5], (0, 2, 10), "delay"))
    assert re.findall(r"<tr><td>([^<]+)</td><td>(\d+)</td>", html) == [
        ("below 0", "1"),
        ("0 to 2", "2"),
        ("2 to 10", "1"),
        ("10 and more", "1"),
    ]
