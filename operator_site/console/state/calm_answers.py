"""Holds the last sure answer of each finger for a moment, so that the largest text of the page can be read."""

from typing import Any

HOLD_S = 2.0
"""Time for which a sure answer stays after the finger left or became unsure, s."""


class CalmAnswers:
    """Sure answers of the fingers. Pure: time is an argument, s."""

    def __init__(self) -> None:
        """Begin without an answer."""
        self._sure: dict[int, tuple[float, dict[str, Any]]] = {}

    def step(self, now_s: float, finger: int, answer: dict[str, Any]) -> dict[str, Any]:
        """Take the present state of a finger; return it, or the last sure one of at most HOLD_S before.

        A new contact and another sure answer end the hold. A held state has its age in `held_s`, s, and no contact; a
        present one has None. Limits, mark and age are always the present ones.

        Args:
            now_s: time, s; a jump back ends the hold.
            finger: number of the finger.
            answer: state of the finger for a page, with `decision`, `contact_s`, `limits`, `softened` and `age_s`.
        """
        if answer["decision"] == "IDENTIFIED":
            self._sure[finger] = now_s, answer
            return answer | {"held_s": None}
        sure_s, sure = self._sure.get(finger, (float("-inf"), answer))
        held_s, contact_s = now_s - sure_s, answer["contact_s"]
        again = contact_s is not None and contact_s < held_s
        if again or not 0.0 <= held_s < HOLD_S:
            return answer | {"held_s": None}
        present = {name: answer[name] for name in ("limits", "softened", "age_s", "in_use")}
        return sure | present | {"held_s": round(held_s, 2), "contact_s": None}
