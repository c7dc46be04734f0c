"""Turns the answers of the patient's page into the state of a stop switch."""

import json
import math
from dataclasses import dataclass
from typing import Self

from common.buses.serial_messages import SLIDER_FULL, PatientSwitchState
from common.limits import SWITCH_HOLD_S, SWITCH_LOST_S, SWITCH_SILENCE_S
from common.tenderness.presses import WORST_PAIN

MAX_TEXT = 200
"""Largest answer of a page, characters."""


class BadAnswer(ValueError):
    """An answer of a page that cannot be used; the message says why."""


@dataclass(frozen=True, slots=True)
class PageAnswer:
    """Answer of a page to the process's time.

    Attributes:
        at_s: the time that is answered, s of the process's monotonic clock.
        pressed: whether the patient presses stop.
        pain: position of the slider, 0..10.
    """

    at_s: float
    pressed: bool
    pain: int

    @classmethod
    def decode(cls, text: str) -> Self:
        """Check and unpack a JSON object with exactly these fields.

        Raises:
            BadAnswer: too long, no such object, or a value of a wrong type or range.
        """
        try:
            found = json.loads(text) if len(text) <= MAX_TEXT else None
        except (ValueError, RecursionError):
            found = None
        if not isinstance(found, dict) or set(found) != {"at_s", "pressed", "pain"}:
            raise BadAnswer("no object of at_s, pressed and pain")
        at_s, pressed, pain = found["at_s"], found["pressed"], found["pain"]
        if type(at_s) not in (int, float) or not math.isfinite(at_s):
            raise BadAnswer(f"at_s {at_s!r} is no time")
        if type(pressed) is not bool:
            raise BadAnswer(f"pressed {pressed!r} is neither true nor false")
        if type(pain) is not int or not 0 <= pain <= WORST_PAIN:
            raise BadAnswer(f"pain {pain!r} is outside 0..{WORST_PAIN:g}")
        return cls(at_s, pressed, pain)


class TabletSwitch:
    """A stop switch whose contact and slider are on a page. Pure: times are arguments, s of one monotonic clock.

    Attributes:
        slider: whether reports have the position of the pain slider.
        pain: newest position, 0..10.
    """

    def __init__(self, *, slider: bool) -> None:
        """Start silent: no page has answered yet."""
        self.slider, self.pain = slider, 0
        self._answered_s = -math.inf
        self._pressed_s = -math.inf

    def take(self, answer: PageAnswer, now_s: float) -> None:
        """Take an answer of the page in use. A press counts however old it is."""
        if answer.pressed:
            self._pressed_s = now_s
        if self._answered_s <= answer.at_s <= now_s:
            self._answered_s, self.pain = answer.at_s, answer.pain

    def begin(self, now_s: float) -> None:
        """Take the first page: the slider is at 0 again after a silence that is a fault (`SWITCH_LOST_S`)."""
        if now_s - self._answered_s > SWITCH_LOST_S:
            self.pain = 0

    def press(self, now_s: float) -> None:
        """Take a press on a page that is not in use."""
        self._pressed_s = now_s

    def fresh(self, now_s: float) -> bool:
        """Return whether the page has answered a time of the last 0.1 s (`SWITCH_SILENCE_S`)."""
        return now_s - self._answered_s <= SWITCH_SILENCE_S

    def pressed(self, now_s: float) -> bool:
        """Return whether the switch reports a press, for at least 1 s (`SWITCH_HOLD_S`) after the last one."""
        return now_s - self._pressed_s <= SWITCH_HOLD_S

    def report(self, now_s: float) -> PatientSwitchState | None:
        """Return the due report; None, which is silence, where the page is silent and nobody presses."""
        pressed = self.pressed(now_s)
        if not pressed and not self.fresh(now_s):
            return None
        pain = round(SLIDER_FULL * self.pain / WORST_PAIN) if self.slider else None
        return PatientSwitchState(round(now_s * 1e6), not pressed, pain)
