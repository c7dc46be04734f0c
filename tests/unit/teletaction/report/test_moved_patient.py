"""A movement of the patient in the report: in words, and hatched on the maps."""

from pathlib import Path

import pytest

from common.recording.recorder import Recorder
from teletaction.report.examination import Examination
from teletaction.report.map_figure import map_figure
from teletaction.report.session_report import report
from tests.unit.operator_site.console.map.shifted_phantom import packets
from tests.unit.teletaction.recorded_examination import begin_of
from tests.unit.teletaction.report_page import Page

pytestmark = pytest.mark.usefixtures("coarse")


@pytest.mark.long
def test_the_report_says_when_and_by_how_much_and_hatches_what_is_older(tmp_path: Path) -> None:
    path, out = tmp_path / "session.mcap", tmp_path / "report.html"
    with Recorder(path, {"operator/touch": {}, "console/session": {}}, {"configuration": ""}) as recorder:
        recorder.write("console/session", 100 * 10**9, begin_of(at_s=100.0))
        for at_ns, packet in packets(0, 0.005):
            recorder.write("operator/touch", at_ns, packet)
    examination = Examination.read(path)
    (movement,) = examination.movements
    assert examination.felt.moved_s == movement.since_s
    figure = map_figure(examination.felt, "stiffness", [])
    assert figure is not None
    assert sum(patch.get_hatch() is not None for patch in figure.axes[0].patches) == len(examination.felt.stale())
    report([path], out)
    words = " ".join(Page(out.read_text("utf-8")).texts)
    assert ": Patient moved by about 5 mm towards the hand. Striped: felt before." in words
