"""How rows of places and lines are laid out in time."""

import numpy as np
import pytest
from pydantic import ValidationError

from common.fingers import FINGERS
from common.scenes.scene import Scene
from sim_sensors.operator_hand.hand_plan import HOVER_M, TRAVEL_M_S, HandPlan, Segment

TISSUE = {"name": "tissue", "material": "skin_dermis", "surface": "skin", "x_m": -0.05, "length_m": 0.05}
SPOT = {"name": "spot", "material": "skin_dermis", "surface": "skin", "x_m": 0.0, "length_m": 0.05}
PRESSES = {"act": "presses", "x_m": [-0.02, 0.01], "y_m": [0.0, 0.005], "hold_s": 1.0, "wait_s": 0.5}
STROKES = {"act": "strokes", "x_m": [-0.03, 0.03], "y_m": [0.0, 0.005], "speed_mm_s": 40}


def plan(*script: dict[str, object]) -> HandPlan:
    scene = Scene.model_validate({"name": "test", "objects": [TISSUE, SPOT], "script": script})
    return HandPlan(scene, np.ones(len(FINGERS), dtype=bool), np.random.default_rng(0))


def acts(made: HandPlan, act: str) -> list[Segment]:
    return [segment for segment in made.segments if segment.act == act]


def test_presses_rest_at_every_place_in_order_and_name_what_lies_there() -> None:
    made = plan(PRESSES)
    holds = acts(made, "hold")
    places = [(-0.02, 0.0), (0.01, 0.0), (-0.02, 0.005), (0.01, 0.005)]
    assert [(hold.to_x_m, hold.to_y_m) for hold in holds] == places
    assert [hold.object for hold in holds] == ["tissue", "spot"] * 2
    assert all(hold.duration_s == 1.0 and (hold.from_z_m < -0.003).all() for hold in holds)
    waits = acts(made, "wait")
    assert len(waits) == 4
    assert all((wait.from_z_m == HOVER_M).all() for wait in waits)


def test_deeper_presses_are_as_fast_as_others() -> None:
    usual, deep = plan(PRESSES), plan({**PRESSES, "depth_m": 0.009})
    assert all((hold.from_z_m < -0.008).all() for hold in acts(deep, "hold"))
    lowered = [[s.duration_s for s in acts(made, "touch")] for made in (usual, deep)]
    assert lowered[1] == pytest.approx([1.5 * seconds for seconds in lowered[0]], rel=1e-9)


def test_only_the_named_fingers_press() -> None:
    (first, *_) = acts(plan({**PRESSES, "fingers": ["index", "ring"]}), "hold")
    assert [finger for finger, z_m in zip(FINGERS, first.from_z_m, strict=True) if z_m < 0.0] == ["index", "ring"]


def test_strokes_go_there_and_back_in_contact_and_lift_between_lines() -> None:
    made = plan(STROKES)
    ways = [(s.from_x_m, s.to_x_m, s.to_y_m) for s in acts(made, "stroke")]
    assert ways == [(-0.03, 0.03, 0.0), (0.03, -0.03, 0.0), (-0.03, 0.03, 0.005), (0.03, -0.03, 0.005)]
    assert all((s.from_z_m < 0.0).all() for s in acts(made, "stroke"))
    assert all((s.from_z_m == HOVER_M).all() for s in acts(made, "move"))
    assert [s.speed_m_s for s in acts(made, "stroke")] == pytest.approx([0.04] * 4, rel=0.11)


@pytest.mark.parametrize("x_m", [0.0001, 0.001, 0.02, 0.06])
def test_a_slanting_way_is_no_faster_than_the_hand_travels(x_m: float) -> None:
    made = plan({**PRESSES, "x_m": [0.0, x_m], "y_m": [0.0, 0.1]})
    (move,) = (move for move in acts(made, "move") if move.to_y_m != move.from_y_m)
    time_s = np.linspace(move.start_s, move.start_s + move.duration_s, 1000)
    places = np.array([(made.at(t_s).x_m, made.at(t_s).y_m) for t_s in time_s])
    speed_m_s = np.hypot(*np.diff(places, axis=0).T) / np.diff(time_s)
    assert speed_m_s.max() == pytest.approx(TRAVEL_M_S, rel=1e-6)
    assert (places[0], places[-1]) == (pytest.approx([x_m, 0.0], abs=1e-5), pytest.approx([0.0, 0.1], abs=1e-5))


def test_the_hand_begins_where_the_script_begins() -> None:
    for made, x_m in ((plan(PRESSES, STROKES), -0.02), (plan(STROKES, PRESSES), -0.03)):
        assert (made.at(0.0).x_m, made.at(0.0).y_m) == (x_m, 0.0)


@pytest.mark.parametrize(
    "wrong", [{"x_m": []}, {"y_m": [0.7]}, {"fingers": ["toe"]}, {"fingers": []}, {"hold_s": 0.0}, {"depth_m": 0.02}]
)
def test_what_the_hand_cannot_do_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        plan({**PRESSES, **wrong})
