"""What counts as a tap in a summary."""

from types import SimpleNamespace
from typing import Any, cast

from common.contact import BOUNCE_S
from common.messages import EventKind
from teletaction.session_data import SessionData
from teletaction.summary import taps


def at(time_s: float, kind: str, finger: int = 1) -> dict[str, Any]:
    return {"time_s": time_s, "kind": kind, "finger": finger}


def session(truth: list[dict[str, Any]], felt_s: list[float]) -> SessionData:
    played = [{"time_s": time_s, "kind": EventKind.TAP, "finger": 1} for time_s in felt_s]
    return cast(SessionData, SimpleNamespace(truth_events=truth, played=played))


def test_a_force_that_dips_for_a_moment_is_no_second_tap() -> None:
    dip = [at(1.0, "contact"), at(3.0, "release"), at(3.0 + 0.2 * BOUNCE_S, "contact"), at(5.0, "release")]
    assert taps(session(dip, [1.01])) == {"made": 1, "played": 1}


def test_a_finger_that_was_away_taps_again() -> None:
    twice = [at(1.0, "contact"), at(1.1, "release"), at(1.1 + 2.0 * BOUNCE_S, "contact")]
    assert taps(session(twice, [1.01])) == {"made": 2, "played": 1}


def test_fingers_tap_each_for_itself() -> None:
    both = [at(1.0, "contact"), at(2.0, "release"), at(2.001, "contact", finger=2)]
    assert taps(session(both, [1.01])) == {"made": 2, "played": 1}
