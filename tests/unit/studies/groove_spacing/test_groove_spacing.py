"""Grooves over a network: at their time they stay as far apart as the hand crossed them."""

from pathlib import Path

import pytest

from studies.groove_spacing.figure import plot
from studies.groove_spacing.run import AS_THEY_COME, AT_THEIR_TIME, run
from tests.unit.studies.written import draw_figure


@pytest.mark.long
def test_at_their_time_grooves_stay_apart_as_they_are_whatever_the_jitter(tmp_path: Path) -> None:
    data = run(quick=True, seed=1, progress=lambda _: None)
    rows = {(row["way"], row["jitter_ms"], row["loss"]): row for row in data["spacing"]}
    for (way, jitter_ms, loss), row in rows.items():
        assert row["felt"] >= row["grooves"] - 2, "what was crossed last is still under way when it ends"
        if way == AT_THEIR_TIME:
            plain = rows[AS_THEY_COME, jitter_ms, loss]
            assert row["spacing_sd_mm"] < 0.5 * plain["spacing_sd_mm"]
            assert row["behind_ms"] < plain["behind_ms"] + 40.0
    draw_figure(plot, data, tmp_path)
