"""A sure answer stays for two seconds, but never under another contact."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from operator_site.console.state.calm_answers import HOLD_S, CalmAnswers

INDEX = 1


def answer(decision: str, contact_s: float | None = None, **more: Any) -> dict[str, Any]:
    usual = {"decision": decision, "line": "", "limits": [], "softened": False, "age_s": 0.0, "in_use": True}
    return usual | {"contact_s": contact_s} | more


SURE = answer("IDENTIFIED", 3.0, line="PVC 91 %")


def test_it_stays_when_the_finger_leaves_and_says_how_old_it_is() -> None:
    calm = CalmAnswers()
    assert calm.step(10.0, INDEX, SURE)["held_s"] is None
    held = calm.step(10.5, INDEX, answer("NO CONTACT", limits=["force_range"]))
    assert (held["decision"], held["line"], held["held_s"], held["contact_s"]) == ("IDENTIFIED", "PVC 91 %", 0.5, None)
    assert held["limits"] == ["force_range"], "a limit is the present one"
    assert calm.step(10.0 + HOLD_S, INDEX, answer("NO CONTACT"))["decision"] == "NO CONTACT"


def test_it_stays_while_the_same_touch_becomes_unsure() -> None:
    calm = CalmAnswers()
    calm.step(10.0, INDEX, SURE)
    assert calm.step(10.5, INDEX, answer("DECIDING", 3.5))["line"] == "PVC 91 %"


@pytest.mark.parametrize(("now_s", "contact_s"), [(10.5, 0.1), (9.0, 2.0)])
def test_another_contact_and_a_jump_back_end_it(now_s: float, contact_s: float) -> None:
    calm = CalmAnswers()
    calm.step(10.0, INDEX, SURE)
    assert calm.step(now_s, INDEX, answer("DECIDING", contact_s))["decision"] == "DECIDING"


def test_each_finger_has_its_own() -> None:
    calm = CalmAnswers()
    calm.step(10.0, INDEX, SURE)
    assert calm.step(10.1, INDEX + 1, answer("DECIDING", 1.0))["decision"] == "DECIDING"


STEPS = st.lists(st.tuples(st.floats(0.01, 3.0), st.booleans(), st.booleans()), max_size=40)


@given(STEPS)
def test_it_is_never_older_than_two_seconds_and_never_of_another_contact(steps: list[tuple[float, bool, bool]]) -> None:
    calm, now_s, began_s, sure_s, sure_of = CalmAnswers(), 100.0, 100.0, None, 0.0
    for wait_s, again, sure in steps:
        now_s += wait_s
        began_s = now_s - 1e-3 if again else began_s
        word = "IDENTIFIED" if sure else "DECIDING"
        shown = calm.step(now_s, INDEX, answer(word, now_s - began_s, line=f"of {began_s}"))
        if sure:
            sure_s, sure_of = now_s, began_s
        if shown["held_s"] is not None:
            assert sure_s is not None
            assert now_s - sure_s < HOLD_S
            assert sure_of == began_s
            assert shown["line"] == f"of {began_s}"
