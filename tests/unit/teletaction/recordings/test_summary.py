"""A summary counts taps, and its time grows in proportion to the length of a session."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from common.exploration.contact_detector import BOUNCE_S
from common.scenes.scene import SceneObject
from common.wire.messages import EventKind, ThermalStatus
from teletaction.recordings.session_data import Series, SessionData
from teletaction.recordings.summary import contact_to_motor_s, contacts, impulses, taps


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


def test_a_touch_that_slides_to_another_material_is_judged_before_it() -> None:
    time_s = np.arange(0.0, 5.0, 0.01)
    under = np.full((len(time_s), 5), -1.0)
    under[(time_s > 1.0) & (time_s < 4.5), 1] = 0.0
    under[(time_s > 3.0) & (time_s < 4.5), 1] = 1.0
    pvc, pine = (
        SceneObject(name=name, material=name, surface="skin", x_m=x_m, length_m=0.1)
        for name, x_m in (("pvc", 0.0), ("pine", 0.1))
    )
    known = {"status": ThermalStatus.IDENTIFIED, "exponential_material": None}
    answers = [{**known, "time_s": 2.5, "best": "pvc"}, {**known, "time_s": 4.0, "best": "pine"}]
    touched = {"object": "pvc", "material": "pvc", "object_c": 23.0}
    session = SessionData(
        **dict.fromkeys(("touch", "rendered", "gate", "fingertips", "skin"), cast(Series, ())),
        contact=Series(time_s, {"object": under}),
        thermal={1: answers},
        truth_events=[{**at(1.0, "contact"), **touched}, {**at(4.5, "release"), **touched}],
        sent_events=[],
        played=[],
        motor_switches=[],
    )
    (contact,) = contacts(session, [pvc, pine])
    assert (contact["true_material"], contact["material"]) == ("pvc", "pvc")
    assert contact["held_s"] == pytest.approx(2.0, abs=0.02)


def test_a_tap_is_displayed_for_one_contact_only() -> None:
    truth = [at(1.0, "contact"), at(1.1, "release"), at(1.15, "contact")]
    played = [{"time_s": 1.2, "kind": EventKind.TAP, "finger": 1}]
    session = cast(SessionData, SimpleNamespace(truth_events=truth, played=played))
    assert taps(session) == {"made": 2, "played": 1}


def test_a_force_that_dips_has_no_latency() -> None:
    again_s = 1.004 + 0.2 * BOUNCE_S
    truth = [at(1.0, "contact"), at(1.004, "release"), at(again_s, "contact")]
    switches = [{"time_s": 1.003, "finger": 1, "motor_mv": 900}]
    session = cast(SessionData, SimpleNamespace(truth_events=truth, motor_switches=switches))
    assert contact_to_motor_s(session) == pytest.approx([0.003])


class CountedList(list[dict[str, Any]]):
    """A list that counts how often it is walked through."""

    walks = 0

    def __iter__(self) -> Iterator[dict[str, Any]]:
        self.walks += 1
        return super().__iter__()


def test_each_list_is_walked_through_a_fixed_number_of_times() -> None:
    thing = {"object": "block", "material": "pvc", "object_c": 23.0}
    truth = [{**at(n + 0.5 * (kind == "groove"), kind), **thing} for n in range(50) for kind in ("contact", "groove")]
    switches = CountedList({"time_s": n + 0.02, "finger": 1, "motor_mv": mv} for n in range(50) for mv in (0, 900))
    sent = CountedList({"ident": n, "finger": 1, "time_ns": round(1e9 * (n + 0.51))} for n in range(50))
    played = CountedList({"time_s": n + 0.52, "kind": EventKind.GROOVE, "ident": n} for n in range(50))
    session = cast(
        SessionData,
        SimpleNamespace(truth_events=truth, motor_switches=switches, sent_events=sent, played=played, contact=()),
    )
    assert contact_to_motor_s(session) == pytest.approx([0.02] * 50)
    assert impulses(session, [])["missed"] == 0
    assert (switches.walks, sent.walks) == (1, 1)


def test_after_a_restart_the_newest_event_of_a_number_was_played() -> None:
    sent = [{"ident": 1, "finger": 1, "time_ns": round(1e9 * time_s)} for time_s in (1.01, 2.01, 9.0)]
    session = SimpleNamespace(
        truth_events=[{**at(2.0, "groove"), "object": "pvc"}],
        sent_events=sent,
        played=[{"time_s": 2.02, "kind": EventKind.GROOVE, "ident": 1}],
        contact=(),
    )
    assert impulses(cast(SessionData, session), [])["missed"] == 0


def test_an_impulse_at_the_border_of_two_objects_is_an_edge_of_the_object_entered() -> None:
    """At 1.2 s finger 1 slides from skin to a lump. The impulse at 1.5 s, far from the border, has no cause."""
    time_s = np.arange(0.0, 2.0, 0.01)
    under = np.full((len(time_s), 5), -1.0)
    under[time_s > 0.5, 1] = 0.0
    under[time_s > 1.2, 1] = 1.0
    when_s = (1.21, 1.5)
    session = SimpleNamespace(
        truth_events=[{**at(0.5, "contact"), "object": "skin", "material": "skin_dermis", "object_c": 33.0}],
        sent_events=[{"ident": n, "finger": 1, "time_ns": round(1e9 * each_s)} for n, each_s in enumerate(when_s)],
        played=[{"time_s": each_s + 0.01, "kind": EventKind.GROOVE, "ident": n} for n, each_s in enumerate(when_s)],
        contact=Series(time_s, {"object": under}),
    )
    found = impulses(cast(SessionData, session), ["skin", "lump"])
    assert found["by_object"] == {"lump": {"crossed": 0, "played": 2, "edges": 1, "missed": 0, "invented": 1}}
