"""The simulated patient moves under the hand: the console notices it, and marks what was felt before."""

from pathlib import Path

import pytest

from operator_site.console import texts
from tests.virtual.test_tender_place import Examined

BEFORE_S, AFTER_S = 36.0, 32.0
"""One pass of the scene's presses, and most of another."""

pytestmark = pytest.mark.long


def test_a_movement_is_noticed_by_the_presses_of_the_next_pass(tmp_path: Path) -> None:
    session = Examined(tmp_path)
    session.run_coarsely(BEFORE_S)
    assert session.console.shift.movement is None
    assert session.console.tactile_map.stale() == []
    began_s = session.operator_host.now_ns() * 1e-9
    session.break_device("remote: shift 0 0 -5")
    while session.console.shift.movement is None and session.time_s < BEFORE_S + AFTER_S:
        session.run_coarsely(1.0)
    movement = session.console.shift.movement
    session.close()
    assert movement is not None
    assert movement.since_s >= began_s
    assert movement.contacts <= 4
    assert movement.by_m == pytest.approx(-0.005, abs=0.0015)
    assert "away from the hand" in texts.moved(movement.by_m)
    assert session.console.tactile_map.stale()
