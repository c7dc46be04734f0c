"""Alarms: one cause is one alarm, the urgent ones stay until a person has seen them (modelled on IEC 60601-1-8).

A high alarm stays until its cause is gone and it was cleared by hand; a medium one 3 s longer than its cause; a low
one as long as its cause.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from operator_site.console.state.frame import Priority

HELD_S = 3.0
"""A medium alarm is shown for so long after its cause is gone."""
LONGEST_QUIET_S = 60.0
MOST_PAST = 200
"""Alarms that are over and still listed."""


class Cause(NamedTuple):
    """Why there is an alarm now.

    Attributes:
        priority: LOW, MEDIUM or HIGH.
        text: where, what, what to do; 60 characters at most.
        after: what it says when only clearing it is left to do; the same without.
        silenceable: whether its sound may be paused.
    """

    priority: Priority
    text: str
    after: str = ""
    silenceable: bool = True


@dataclass(frozen=True, slots=True)
class Alarm:
    """One alarm, now or in the past; times in s.

    Attributes:
        ident: names its cause.
        ended_s: when it was over; None while it is shown.
        cleared_by: who cleared it; None where nobody had to.
        quiet_until_s: its sound is paused until then.
        waits: its cause is gone, and it waits to be cleared.
    """

    ident: str
    cause: Cause
    since_s: float
    gone_s: float | None = None
    ended_s: float | None = None
    cleared_by: str | None = None
    quiet_until_s: float = 0.0

    @property
    def waits(self) -> bool:
        """Whether only clearing it is left to do."""
        return self.gone_s is not None and self.ended_s is None and self.cause.priority is Priority.HIGH

    @property
    def text(self) -> str:
        """What it says now."""
        return self.cause.after if self.waits and self.cause.after else self.cause.text


class Alarms:
    """All of a session. Pure: time is an argument, s."""

    def __init__(self) -> None:
        self._shown: dict[str, Alarm] = {}
        self._past: list[Alarm] = []
        self._changed: list[Alarm] = []

    @property
    def priority(self) -> Priority:
        """Of the most urgent one."""
        return max((alarm.cause.priority for alarm in self._shown.values()), default=Priority.NONE)

    @property
    def listed(self) -> list[Alarm]:
        """Those that are shown, most urgent and newest first, then those that are over, newest first."""
        shown = sorted(self._shown.values(), key=lambda alarm: (-alarm.cause.priority, -alarm.since_s))
        return shown + self._past[::-1]

    def step(self, now_s: float, causes: Mapping[str, Cause]) -> None:
        """Take what is wrong now, by what names each cause."""
        for ident, cause in causes.items():
            self._meet(now_s, ident, cause)
        for ident, alarm in list(self._shown.items()):
            if ident not in causes:
                self._miss(now_s, alarm)

    def clear(self, now_s: float, who: str) -> int:
        """Clear what waits to be cleared; returns how many alarms that were."""
        waiting = [alarm for alarm in self._shown.values() if alarm.waits]
        for alarm in waiting:
            self._end(now_s, alarm, who)
        return len(waiting)

    def quiet(self, now_s: float, ident: str, seconds: float) -> bool:
        """Pause the sound of an alarm; False when there is none of that name, or it may not be paused."""
        alarm = self._shown.get(ident)
        if alarm is None or not alarm.cause.silenceable:
            return False
        until_s = now_s + min(max(0.0, seconds), LONGEST_QUIET_S)
        self._shown[ident] = replace(alarm, quiet_until_s=until_s)
        return True

    def take_changes(self) -> list[Alarm]:
        """Alarms that began, became more urgent or ended since the last call."""
        changed, self._changed = self._changed, []
        return changed

    def _meet(self, now_s: float, ident: str, cause: Cause) -> None:
        alarm = self._shown.get(ident)
        if alarm is None:
            self._shown[ident] = alarm = Alarm(ident, cause, now_s)
            self._changed.append(alarm)
        elif cause.priority > alarm.cause.priority:
            self._shown[ident] = alarm = replace(alarm, cause=cause, gone_s=None, quiet_until_s=0.0)
            self._changed.append(alarm)
        elif alarm.waits:  # it came back: it sounds again
            kept = cause._replace(priority=alarm.cause.priority)
            self._shown[ident] = replace(alarm, cause=kept, gone_s=None, quiet_until_s=0.0)
        else:
            kept = cause._replace(priority=alarm.cause.priority)
            self._shown[ident] = replace(alarm, cause=kept, gone_s=None)

    def _miss(self, now_s: float, alarm: Alarm) -> None:
        """Its cause is gone."""
        if alarm.gone_s is None:
            alarm = replace(alarm, gone_s=now_s)
        self._shown[alarm.ident] = alarm
        priority, gone_s = alarm.cause.priority, alarm.gone_s if alarm.gone_s is not None else now_s
        held = priority is Priority.MEDIUM and 0.0 <= now_s - gone_s < HELD_S
        if priority is not Priority.HIGH and not held:
            self._end(now_s, alarm, None)

    def _end(self, now_s: float, alarm: Alarm, who: str | None) -> None:
        over = replace(alarm, ended_s=now_s, cleared_by=who)
        del self._shown[alarm.ident]
        self._past = [*self._past[-MOST_PAST + 1 :], over]
        self._changed.append(over)
