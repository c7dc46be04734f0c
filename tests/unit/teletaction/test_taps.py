"""A summary counts taps."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from common.exploration.contact_detector import BOUNCE_S
from common.wire.messages import EventKind
from teletaction.recordings.session_data import SessionData
from teletaction.recordings.summary import taps


def at(time_s: float, kind: str, finger: int = 1) -> dict[str, Any]:
    return {"time_s": time_s, "kind": kind, "finger": finger}


@pytest.mark.parametrize(
    ("truth", "made"),
    [
        ([at(1.0, "contact"), at(3.0, "release"), at(3.0 + 0.2 * BOUNCE_S, "contact"), at(5.0, "release")], 1),
        ([at(1.0, "contact"), at(1.1, "release"), at(1.1 + 2.0 * BOUNCE_S, "contact")], 2),
        ([at(1.0, "contact"), at(2.0, "release"), at(2.001, "contact", finger=2)], 2),
    ],
    ids=["a force that dips is no second tap", "a finger that was away taps again", "each finger for itself"],
)
def test_taps_are_counted(truth: list[dict[str, Any]], made: int) -> None:
    played = [{"time_s": 1.01, "kind": EventKind.TAP, "finger": 1}]
    session = cast(SessionData, SimpleNamespace(truth_events=truth, played=played))
    assert taps(session) == {"made": made, "played": 1}
