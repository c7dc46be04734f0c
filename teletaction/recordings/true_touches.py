"""Pairs the contacts of the simulated world with their releases."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

SHORTEST_TOUCH_S = 1.0
"""Shortest touch that is judged by its material, s. A shorter one counts as a tap."""


@dataclass(frozen=True, slots=True)
class Touch:
    """A true contact of one finger with an object; times in s."""

    finger: int
    thing: str
    material: str
    object_c: float
    start_s: float
    end_s: float


def true_touches(events: Iterable[Mapping[str, Any]], end_s: float, zero_s: float = 0.0) -> list[Touch]:
    """Return the true touches in order of time. A contact without release ends with the recording.

    Args:
        events: truth events, in order of time.
        end_s: end of the recording, s, on the clock that starts at `zero_s`.
        zero_s: time subtracted from the events' times, s.
    """
    found: list[Touch] = []
    open_touches: dict[int, tuple[Mapping[str, Any], float]] = {}

    def close(finger: int, at_s: float) -> None:
        if finger in open_touches:
            event, start_s = open_touches.pop(finger)
            found.append(
                Touch(finger, str(event["object"]), str(event["material"]), float(event["object_c"]), start_s, at_s)
            )

    for event in events:
        at_s = event["time_s"] - zero_s
        if event["kind"] in ("contact", "release"):
            close(event["finger"], at_s)
        if event["kind"] == "contact":
            open_touches[event["finger"]] = (event, at_s)
    for finger in list(open_touches):
        close(finger, max(end_s, open_touches[finger][1]))
    return sorted(found, key=lambda touch: (touch.start_s, touch.finger))
