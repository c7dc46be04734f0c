"""Keeps the alarms of a session, one for each cause (modelled on IEC 60601-1-8).

A latching alarm stays until its cause is gone and a person has acknowledged it. A medium one outlasts its cause by
HELD_S. All others end with their cause.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from operator_site.console.state.frame import Priority

HELD_S = 3.0
"""Time for which a medium alarm is shown after its cause is gone, s."""
LONGEST_QUIET_S = 60.0
"""Longest pause of an alarm's sound, s."""
MOST_PAST = 200
"""Maximum number of ended alarms in the list."""


class Cause(NamedTuple):
    """The cause of an alarm.

    Attributes:
        priority: LOW, MEDIUM or HIGH.
        text: place, problem and remedy; see `texts`.
        after: text once the cause is gone and the alarm waits for a person; empty keeps `text`.
        silenceable: whether the sound may be paused.
        latches: whether a person must acknowledge it after its cause is gone.
    """

    priority: Priority
    text: str
    after: str = ""
    silenceable: bool = True
    latches: bool = False


@dataclass(frozen=True, slots=True)
class Alarm:
    """One present or past alarm; times in s.

    Attributes:
        ident: identifier of its cause.
        since_s: when it began.
        gone_s: when its cause was gone; None while the cause persists.
        ended_s: when it ended; None while it is shown.
        cleared_by: person who acknowledged it; None if it ended by itself.
        quiet_until_s: end of the pause of its sound.
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
        """Whether its cause is gone and a person has yet to acknowledge it."""
        return self.gone_s is not None and self.ended_s is None and self.cause.latches

    @property
    def text(self) -> str:
        """The text to show now."""
        return self.cause.after if self.waits and self.cause.after else self.cause.text


class Alarms:
    """All alarms of a session. Pure: time is an argument, s."""

    def __init__(self) -> None:
        self._shown: dict[str, Alarm] = {}
        self._past: list[Alarm] = []
        self._changed: list[Alarm] = []

    @property
    def priority(self) -> Priority:
        """Priority of the most urgent alarm."""
        return max((alarm.cause.priority for alarm in self._shown.values()), default=Priority.NONE)

    @property
    def listed(self) -> list[Alarm]:
        """The shown alarms, most urgent and newest first, then the ended ones, newest first."""
        shown = sorted(self._shown.values(), key=lambda alarm: (-alarm.cause.priority, -alarm.since_s))
        return shown + self._past[::-1]

    def step(self, now_s: float, causes: Mapping[str, Cause], *, complete: bool = True) -> None:
        """Update the alarms from the present causes, keyed by their identifiers.

        `complete` is False if other causes are unknown: then no alarm ends.
        """
        for ident, cause in causes.items():
            self._meet(now_s, ident, cause)
        if not complete:
            return
        for ident, alarm in list(self._shown.items()):
            if ident not in causes:
                self._miss(now_s, alarm)

    def clear(self, now_s: float, who: str, only: Collection[str] | None = None) -> int:
        """Acknowledge all waiting alarms, or those of them in `only`; return their number."""
        waiting = [alarm for alarm in self._shown.values() if alarm.waits and (only is None or alarm.ident in only)]
        for alarm in waiting:
            self._end(now_s, alarm, who)
        return len(waiting)

    def quiet(self, now_s: float, ident: str, seconds: float) -> bool:
        """Pause the sound of an alarm for up to LONGEST_QUIET_S.

        Return False if no such alarm is shown or its sound may not be paused.
        """
        alarm = self._shown.get(ident)
        if alarm is None or not alarm.cause.silenceable:
            return False
        until_s = now_s + min(max(0.0, seconds), LONGEST_QUIET_S)
        self._shown[ident] = replace(alarm, quiet_until_s=until_s)
        return True

    def take_changes(self) -> list[Alarm]:
        """Return the alarms that began, became more urgent or ended since the last call."""
        changed, self._changed = self._changed, []
        return changed

    def _meet(self, now_s: float, ident: str, cause: Cause) -> None:
        alarm = self._shown.get(ident)
        if alarm is None:
            self._shown[ident] = alarm = Alarm(ident, cause, now_s)
            self._changed.append(alarm)
        elif cause.priority > alarm.cause.priority:
            latches = cause.latches or alarm.cause.latches
            cause = cause._replace(latches=latches)
            self._shown[ident] = alarm = replace(alarm, cause=cause, gone_s=None, quiet_until_s=0.0)
            self._changed.append(alarm)
        else:
            kept = cause
            if alarm.cause.latches:
                after = cause.after or alarm.cause.after
                kept = cause._replace(priority=alarm.cause.priority, after=after, latches=True)
            quiet_until_s = 0.0 if alarm.waits else alarm.quiet_until_s  # a cause that returned sounds again
            self._shown[ident] = replace(alarm, cause=kept, gone_s=None, quiet_until_s=quiet_until_s)

    def _miss(self, now_s: float, alarm: Alarm) -> None:
        """Update an alarm whose cause is gone."""
        gone_s = now_s if alarm.gone_s is None else alarm.gone_s
        self._shown[alarm.ident] = alarm = replace(alarm, gone_s=gone_s)
        priority = alarm.cause.priority
        held = priority is Priority.MEDIUM and 0.0 <= now_s - gone_s < HELD_S
        if not alarm.waits and not held:
            self._end(now_s, alarm, None)

    def _end(self, now_s: float, alarm: Alarm, who: str | None) -> None:
        over = replace(alarm, ended_s=now_s, cleared_by=who)
        del self._shown[alarm.ident]
        self._past = [*self._past[-MOST_PAST + 1 :], over]
        self._changed.append(over)
