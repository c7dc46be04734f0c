"""The examination in the report: findings, maps, untouched places and actions of persons; it runs no script."""

import json
import re
from functools import cache
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from matplotlib.figure import Figure

from common.recording.recorder import Recorder
from operator_site.console.map.finger_samples import Sample
from operator_site.console.map.map_tiles import MapPicture
from operator_site.console.map.tactile_map import TactileMap
from teletaction.report.examination import Examination
from teletaction.report.examination_page import finding_blocks, signed_page
from teletaction.report.examination_record import numbers
from teletaction.report.map_coverage import coverage
from teletaction.report.map_figure import cell_colours, draw_cells, draw_lumps, map_figure, scale_ticks
from teletaction.report.session_curves import SessionCurves
from teletaction.report.session_report import report
from tests.commands import command
from tests.unit.teletaction.recorded_examination import HOSTILE, START_S, begin_of, record, record_lump, touch_of
from tests.unit.teletaction.report.test_report import nothing
from tests.unit.teletaction.report_page import Page

pytestmark = pytest.mark.usefixtures("coarse")


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("examined") / "session.mcap")


@cache
def page_of(path: Path) -> tuple[str, Page]:
    out = path.with_suffix(".html")
    report([path], out)
    html = out.read_text("utf-8")
    return html, Page(html)


def numbers_in(page: Page) -> dict[str, Any]:
    (written,) = [text for text in page.texts if text.startswith('{\n "examination"')]
    numbers: dict[str, Any] = json.loads(written)
    return numbers


@pytest.mark.long
def test_a_recorded_examination_is_read(path: Path) -> None:
    examination = Examination.read(path)
    assert examination.begun["pseudonym"] == "P-0417"
    assert examination.ended_s == START_S + 61.0
    assert [len(examination.findings), len(examination.acts), len(examination.alarms)] == [2, 1, 1]
    assert examination.findings[1]["note"] == HOSTILE
    assert examination.damaged == {"console/finding": 1}
    here = examination.felt.at(0.012, 0.006).temperature
    assert here is not None
    assert here.value == pytest.approx(35.0)


@pytest.mark.long
def test_what_the_hand_feels_before_the_begin_and_after_the_end_is_not_of_the_examination(tmp_path: Path) -> None:
    """One recording of the operator site holds several examinations, and each has a file of the console's."""
    with Recorder(tmp_path / "session.mcap", {"console/session": {}, "operator/touch": {}}, {}) as recorder:
        for number in range(60):
            if number == 20:
                recorder.write("console/session", at_ns(1.95), begin_of(START_S + 1.95))
            if number == 40:
                ended = {"what": "end", "at_s": START_S + 3.95}
                recorder.write("console/session", at_ns(3.95), msgpack.packb(ended))
            recorder.write("operator/touch", at_ns(0.1 * number), stiff_touch(number, 0.02 * (number // 20)))
    felt = Examination.read(tmp_path / "session.mcap").felt
    assert [felt.at(x_m, 0.0).stiffness is not None for x_m in (0.0, 0.02, 0.04)] == [False, True, False]


def test_the_study_number_of_the_next_examination_is_not_in_the_report() -> None:
    """The journal has its request to begin in the file of this examination, and its answer in the next one's."""
    examination = Examination()
    asked = {"at_s": START_S, "who": "OR-1 1", "verb": "begin", "details": {"pseudonym": "P-0419"}, "ok": None}
    next_one = asked | {"at_s": START_S + 9.0, "details": {"pseudonym": "P-0420"}}
    examination.take("console/act", START_S, msgpack.packb(asked))
    examination.take("console/session", START_S, begin_of(START_S))
    examination.take("console/act", START_S, msgpack.packb(asked | {"ok": True}))
    examination.take("console/session", START_S + 8.0, msgpack.packb({"what": "end", "at_s": START_S + 8.0}))
    examination.take("console/act", START_S + 9.0, msgpack.packb(next_one))
    assert [(act["details"]["pseudonym"], act["ok"]) for act in examination.acts.values()] == [("P-0419", True)]
    examination.take("console/act", START_S + 9.0, msgpack.packb(next_one | {"ok": False}))
    assert len(examination.acts) == 2


def test_packets_are_counted_anew_after_a_restart_of_the_remote_site() -> None:
    """Its numbers begin again: of 1..4 and of 1..5, the second 3 and 4 are missing."""
    examination = Examination(sequences=[1, 2, 3, 4, 1, 2, 5])
    link = numbers(examination, nothing(), {})["link"]
    assert (link["touch_packets"], link["superseded_or_lost"], link["longest_gap_packets"]) == (7, 2, 2)


def at_ns(after_s: float) -> int:
    return round(1e9 * (START_S + after_s))


def stiff_touch(number: int, x_m: float) -> bytes:
    """A touch of the index finger at `x_m` (m); it lifts at every fourth one."""
    return touch_of(number, at_ns(0.1 * number), x_m, 0.0, contact=number % 4 > 0, warm=False).encode()


@pytest.mark.long
@pytest.mark.parametrize(("late_s", "said"), [(0.5, ""), (95.0, "begins 1 min 35 s after the examination")])
def test_what_a_restarted_operator_site_has_recorded_elsewhere_is_missed(late_s: float, said: str) -> None:
    """The earlier part is in a file that the restart has set aside, which the console's report does not read."""
    examination = Examination()
    examination.take("console/session", START_S, begin_of(START_S))
    examination.take("operator/figures", START_S + late_s, msgpack.packb({}))
    examination.take("operator/touch", START_S + late_s, stiff_touch(1, 0.0))
    signed = str(signed_page(examination, SessionCurves.of(nothing()), None))
    assert ("What was felt before is not in this report." in signed) is bool(said)
    assert said in signed


@pytest.mark.long
@pytest.mark.parametrize(("scale", "shown"), [({"ln_um": 5.0, "exponent": 1.0, "ln_sd": 0.1}, "µm"), (None, "of 10")])
def test_a_roughness_has_the_unit_that_the_finding_has(scale: object, shown: str) -> None:
    examination = Examination()
    examination.take("operator/figures", START_S, msgpack.packb({"roughness_um": scale}))
    examination.take("console/session", START_S, begin_of(START_S))
    examination.felt.restore(Sample("roughness", (1, 1, 1), 1, 1, 0.0, 0.0, START_S, 0.05, 0.01))
    examination.findings[1] = {"id": 1, "at_s": START_S, "kind": "rough", "x_m": 0.0, "y_m": 0.0, "text": "rough"}
    blocks = finding_blocks(examination, SessionCurves.of(nothing()))
    found = re.search(r"roughness ([\d.]+) ± [\d.]+ ([^(]+) \(1 touch\)", str(blocks))
    assert found is not None
    assert found[2] == shown


@pytest.mark.long
def test_the_report_names_the_person_and_the_findings(path: Path) -> None:
    html, page = page_of(path)
    assert "@page { size: A4 portrait" in html
    for words in (
        "Examination P-0417",
        "23 November 2026, 14:07 UTC+01:00",
        "1 min 1 s",
        "OR-1",
        "warm, 35.0 ± 0.2 °C",
        "+2.0 ± 0.3 K against 33.0 ± 0.2 °C around it (8 touches)",
        "a moment, no place",
        "roughness not felt anywhere",
        "temperature on 94\xa0%, roughness nowhere",
        "The limits of both sites are not in this recording.",
        "Signature",
        "Top edge: head. Right edge: left.",
        "refused",
        "TT0001",
        "teletaction replay session.mcap",
        "Messages that could not be read: 1.",
    ):
        assert words in page.text, words


def test_an_attached_table_that_is_nested_too_deeply_has_its_hash_alone(tmp_path: Path) -> None:
    with Recorder(tmp_path / "operator.mcap", {"operator/touch": {}}, {}, {"materials.json": 100_000 * b"["}):
        pass
    (table,) = Examination.read(tmp_path / "operator.mcap").tables
    assert (table["name"], table["kind"], len(table["hash"])) == ("materials.json", None, 64)


def test_a_material_has_the_name_that_the_console_shows(path: Path) -> None:
    html, _ = page_of(path)
    assert "material &lt;i&gt;skin dermis&lt;/i&gt; (100 % of the touches)" in html


def test_hostile_text_stays_text_and_the_page_loads_and_runs_nothing(path: Path) -> None:
    html, page = page_of(path)
    assert "default-src &#39;none&#39;" in html
    assert {picture[:10] for picture in page.pictures} == {"data:image"}
    assert "<script" not in html
    assert not {"script", "iframe", "link", "object", "i"} & page.tags
    assert not {name for name in page.attributes if name.startswith("on")}
    assert "<img src=x" not in html
    assert page.text.count("<script>alert(1)</script>") >= 4
    assert "(all of it below)" in page.text
    assert "x" * 10_000 in page.text


@pytest.mark.long
def test_withdrawn_findings_are_struck_out_with_their_reason_and_lumps_are_outlined(tmp_path: Path) -> None:
    html, page = page_of(record_lump(tmp_path / "session.mcap"))
    assert html.count('<del class="withdrawn">') == 6
    for words in (
        "3, and 1 withdrawn",
        "Withdrawn: pressed twice, no difference",
        "left forearm, 80 mm from wrist crease",
        "Dashed outlines: lumps",
    ):
        assert words in page.text, words
    assert "Finding 4" not in page.text


def test_a_lump_is_drawn_at_its_place_and_never_called_certain() -> None:
    lump = {"outline_mm": [[1.0, 2.0], [5.0, 2.0], [3.0, 6.0]], "x_mm": 3.0, "y_mm": 3.5}
    axes = Figure().subplots()
    draw_lumps(axes, [lump | {"probability": 0.874}, lump | {"probability": 0.9999}])
    assert [text.get_text() for text in axes.texts] == ["lump 87 %", "lump > 99 %"]
    assert axes.patches[0].get_path().vertices[:3].tolist() == lump["outline_mm"]


def test_every_number_is_in_the_json(path: Path) -> None:
    numbers = numbers_in(page_of(path)[1])
    (warm, moment) = numbers["findings"]
    assert warm["felt_by_the_end"]["temperature"]["value"] == pytest.approx(35.0)
    assert warm["confidence"] == "high"
    assert moment["felt_by_the_end"] is None
    assert numbers["coverage"]["roughness"] is None
    assert numbers["coverage"]["temperature"]["felt_m2"] > 3e-4
    assert numbers["link"]["superseded_or_lost"] == 0
    assert numbers["configurations"]["session"]


@pytest.mark.long
def test_a_report_without_a_console_says_so_and_keeps_the_rest(tmp_path: Path) -> None:
    _, page = page_of(record(tmp_path / "plain.mcap", console=False))
    assert "No console took part" in page.text
    assert "33.0" not in page.text.split("Every number")[0]
    for title in ("Maps", "Limits", "Modes over time", "Link quality", "Audit trail"):
        assert title in page.text, title
    assert "summary.json" not in page.text.split("Every number")[0]
    assert "true" not in page.text.split("Every number")[0]
    for title in ("Contacts", "Latency", "Modes identified", "Loops, CPU and memory"):
        assert title not in page.text.split("Every number")[0], title
    assert numbers_in(page)["findings"] == []


def test_an_empty_recording_has_a_report(tmp_path: Path) -> None:
    empty = tmp_path / "empty.mcap"
    Recorder(empty, {"operator/touch": {}}, {}).close()
    _, page = page_of(empty)
    assert "Nothing was felt." in page.text


@pytest.mark.long
def test_the_command(path: Path, tmp_path: Path) -> None:
    out, beside = tmp_path / "out.html", tmp_path / "session.mcap"
    beside.write_bytes(path.read_bytes())
    (tmp_path / "summary.json").write_text('{"scene": "phantom", "seed": 3}')
    assert command("report", beside, "--out", out).code == 0
    assert "Examination P-0417: phantom, seed 3" in out.read_text("utf-8")
    (tmp_path / "summary.json").write_text("[1]")
    with pytest.raises(ValueError, match="not a summary of a session"):
        report([beside], out)
    (tmp_path / "summary.json").unlink()
    beside.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(ValueError, match="teletaction recover"):
        report([beside], out)


def lines(apart_cells: int) -> MapPicture:
    """Lines of five cells' width."""
    value = np.full((60, 60), np.nan)
    for first in range(5, 55, apart_cells):
        value[first : first + 5, 5:55] = 33.0
    return MapPicture(0.0, 0.0, value, np.full(value.shape, 3, dtype=np.uint8), np.zeros(value.shape, dtype=np.bool_))


def test_lines_too_far_apart_are_reported() -> None:
    close, far = coverage(lines(5)), coverage(lines(9))
    assert not close.gaps
    assert close.share == pytest.approx(1.0)
    assert far.gaps
    assert far.lines_m == pytest.approx(0.006 + 0.003, abs=1.1e-3)
    assert far.share == pytest.approx(5 / 9, abs=0.06)


def test_untouched_places_have_no_colour_and_scales_have_plain_numbers() -> None:
    shown = lines(9)
    colour = cell_colours("temperature", shown, (30.0, 36.0))
    np.testing.assert_array_equal(colour[..., 3] > 0.0, ~np.isnan(shown.value))
    assert scale_ticks("temperature", (30.0, 36.0)) == [30.0, 31.0, 32.0, 33.0, 34.0, 35.0, 36.0]
    assert scale_ticks("stiffness", (200.0, 5000.0)) == [200.0, 500.0, 1000.0, 2000.0, 5000.0]


def test_names_of_materials_fit_beside_the_map() -> None:
    surface = TactileMap()
    for touch, name in enumerate(["carbon_steel", "stainless_steel_polished"], 1):
        surface.take(Sample("material", (1, touch, 0), touch, 1, 0.02 * touch, 0.0, 0.0, 0.99, 0.01, name))
    figure = map_figure(surface, "material", [])
    assert figure is not None
    figure.draw_without_rendering()
    assert figure.axes[0].get_legend().get_window_extent().x1 <= figure.bbox.x1


@pytest.mark.parametrize("steep", [True, False])
def test_steep_ground_is_hatched(steep: bool) -> None:
    shown = lines(8)
    shown.steep[20:30, 20:30] = steep
    axes = Figure().subplots()
    draw_cells(axes, "temperature", shown, (30.0, 36.0))
    hatched = [drawn for drawn in axes.collections if getattr(drawn, "hatches", None)]
    assert bool(hatched) is steep


@pytest.mark.parametrize(
    ("configuration", "consent"),
    [
        ("rate_hz = 250.0\n", ""),
        ("[consent]\ntouch = true\npain = true\n", "touch, pain"),
        ("[consent]\ntouch = true\npain = false\n", "touch"),
        ("[consent]\ntouch = false\npain = false\n", "nothing"),
        ("consent = 3\n", ""),
        ("no TOML", ""),
    ],
)
def test_the_report_says_what_the_patient_agreed_to_have_recorded(configuration: str, consent: str) -> None:
    examination = Examination(facts={"console": {}, "remote": {"configuration": configuration}})
    assert examination.consent() == consent


def test_answers_that_differ_are_given_one_by_one() -> None:
    answers = {"remote": "touch = true\npain = true\n", "console": "touch = true\npicture = true\n"}
    facts = {origin: {"configuration": f"[consent]\n{answer}"} for origin, answer in answers.items()}
    assert Examination(facts=facts).consent() == "remote: touch, pain; console: touch, picture"
    assert (
        Examination(facts={"operator": facts["console"], **facts, "remote": facts["console"]}).consent()
        == "touch, picture"
    )
