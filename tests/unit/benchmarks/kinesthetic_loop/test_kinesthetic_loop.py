"""The study of the kinesthetic loop, briefly on the virtual bus: it runs, and its step costs some bare springs only."""

from pathlib import Path

import pytest

from benchmarks.kinesthetic_loop.figure import plot
from benchmarks.kinesthetic_loop.run import measure, tables
from benchmarks.kinesthetic_loop.step import STIFFNESS_N_M, bare_springs
from common.buses.can_frames import FrameSender, database
from common.fingers import FINGERS
from tests.unit.studies.written import draw_figure

MOST_SPRINGS = 10.0
"""Contacts that count energy and the limits of their forces cost 4 to 6 times the bare springs."""


def test_five_bare_springs_push_as_hard_as_their_depth() -> None:
    heights = dict(zip(FINGERS, (1.0, 0.0, -0.5, -2.0, -10.24), strict=True))
    pushed = bare_springs(bytes(FrameSender("FingerHeights").encode(heights).data))
    forces = database().get_message_by_name("FingerForces").decode(pushed)
    wanted = [min(10.0, max(0.0, -1e-3 * STIFFNESS_N_M * height)) for height in heights.values()]
    assert [forces[finger] for finger in FINGERS] == pytest.approx(wanted, abs=0.006)
    assert forces["enabled"] == 1.0


@pytest.mark.long
@pytest.mark.real_time
def test_it_runs_at_1_khz_and_a_step_costs_some_bare_springs_only(tmp_path: Path) -> None:
    data = measure(0.4, 2, ("virtual",))
    bare_us, step_us = (row["step_us"] for row in data["loops"] if row["rate_hz"] == 1000.0)
    assert step_us < MOST_SPRINGS * bare_us
    bare, virtual, site = data["loops"]
    assert (bare["bus"], virtual["bus"], virtual["rate_hz"], site["rate_hz"]) == ("bare loop", "virtual", 1000.0, 500.0)
    assert virtual["ticks"] == 800
    assert virtual["unsent"] == 0
    assert not [problem for problem in data["problems"] if "their limits cost" not in problem]
    for answers in data["answers"]:
        assert 0.0 < answers["p50_ms"] < answers["max_ms"]
    assert set(tables(data)) == {"loops", "answers", "parts"}
    draw_figure(plot, data, tmp_path)
