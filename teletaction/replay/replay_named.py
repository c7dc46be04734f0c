"""Compares the material named in each touch with the one named when no solution waits for a late tick."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from common.fingers import FINGERS
from common.wire.messages import Event, EventKind


@dataclass(slots=True)
class NamedTouch:
    """One touch of one finger.

    Attributes:
        began_s: time of the detected contact, s.
        material: material named last; empty if none was.
        named_s: time at which it was named, s.
    """

    began_s: float
    material: str = ""
    named_s: float | None = None


@dataclass(slots=True)
class NamedTouches:
    """The touches of a site's fingers.

    Contact detection does not use the thermal sensor, so both replays have the same touches.
    """

    touches: dict[int, list[NamedTouch]] = field(default_factory=lambda: defaultdict(list))
    """Touches by the finger's number."""

    def take(self, time_s: float, events: Iterable[Event]) -> None:
        """Take the events of one tick at `time_s` (s)."""
        for event in events:
            touches = self.touches[event.finger]
            if event.kind is EventKind.TAP:
                touches.append(NamedTouch(time_s))
            elif event.kind is EventKind.MATERIAL and touches:
                touches[-1].material, touches[-1].named_s = event.name, time_s

    def changed(self, whole: "NamedTouches") -> list[dict[str, object]]:
        """Return the touches whose material or naming time differs in `whole`, in order of time."""
        found: list[tuple[float, dict[str, object]]] = []
        for finger, touches in self.touches.items():
            for touch, full in zip(touches, whole.touches[finger], strict=False):
                if touch != full:
                    line = {
                        "finger": FINGERS[finger],
                        "began_s": touch.began_s,
                        "material": touch.material,
                        "named_s": touch.named_s,
                        "full_material": full.material,
                        "full_named_s": full.named_s,
                    }
                    found.append((touch.began_s, line))
        return [line for _, line in sorted(found, key=lambda pair: pair[0])]


def in_words(changed: Mapping[str, Any]) -> str:
    """Describe one entry of `NamedTouches.changed`; the sentence begins with "without late ticks"."""
    where = f"the {changed['finger']}'s touch at {changed['began_s']:.1f} s"
    full = _named(changed["full_material"], changed["full_named_s"])
    return f"{where} would be {full}; it was {_named(changed['material'], changed['named_s'])}"


def _named(material: str, named_s: float | None) -> str:
    return "without a name" if named_s is None else f"named {material} at {named_s:.2f} s"
