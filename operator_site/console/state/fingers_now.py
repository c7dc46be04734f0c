"""Keeps the newest values of each finger with their age, and hides values that are too old."""

import math
from collections.abc import Sequence
from operator import attrgetter

from common.fingers import FINGER_Y_M, FINGERS
from common.wire.messages import NO_TOUCH, Touch, TouchRow
from common.wire.touch_summary import NOTHING, TouchSummary
from operator_site.safety.limit_flags import Limit

FIELDS = (
    "x_m",
    "y_m",
    "surface_m",
    "force_n",
    "contact_n",
    "motor_hz",
    "plate_c",
    "skin_c",
    "plate_set_c",
    "mode",
    "stiffness_n_m",
    "age_s",
)
"""Values of one finger in a picture, NaN if unknown.

`force_n` acts on the operator's finger, `contact_n` on the remote object.
"""
GONE_S = 1.0
"""Largest age of a shown value, s."""
HELD_S = 3.0
"""Time for which a limit is shown after it acted, s."""
_NAN = math.nan
_SOFTENED = int(Limit.STIFFNESS | Limit.PASSIVITY)
"""Limits that display a surface softer than it is. They act in most touches and need no act, so they are no LIMIT."""
_QUIET = int(Limit.RELEASED | Limit.FORCE_RAMP | Limit.PLATE_RATE | Limit.MOTOR_RANGE) | _SOFTENED
"""Limits that are not shown: they act at each begin and end, or soften a surface."""
_RELEASED = int(Limit.RELEASED)
_LIMITS = {
    int(Limit.FORCE_RANGE): "force",
    int(Limit.PLATE_RANGE): "plate range",
    int(Limit.PLATE_TEMPERATURE): "plate",
    int(Limit.DOSE): "skin dose",
    int(Limit.PLATE_UNKNOWN): "no plate reading",
    int(Limit.DRIVE_RANGE): "drive",
    int(Limit.PLATE_TEST): "plate test",
}
"""Name of each shown limit, by its bit.

Plain integers, because comparing enumeration members takes as long as the rest of a message.
"""
_shown = attrgetter("x_m", "y_m", "surface_z_m", "contact_force_n", "mode", "stiffness_n_m")


class FingersNow:
    """Newest values of the fingers. Pure: time is an argument, s of the operator site's clock.

    Attributes:
        touch: the newest touch, None before the first.
        summaries, rows: touch summary and touch row of each finger in the newest touch.
        contact_since_s: begin of each finger's contact, s; None without contact.
    """

    def __init__(self) -> None:
        self.touch: Touch | None = None
        self.summaries: tuple[TouchSummary, ...] = (NOTHING,) * len(FINGERS)
        self.contact_since_s: list[float | None] = [None] * len(FINGERS)
        self.rows: Sequence[TouchRow] = (NO_TOUCH,) * len(FINGERS)
        self._touch_s = self._rendered_s = self._skin_s = -math.inf
        self._force_n = self._motor_hz = self._plate_c = self._plate_set_c = self._skin_c = [_NAN] * len(FINGERS)
        self._limited = [0] * len(FINGERS)
        self._acted: list[dict[int, float]] = [{} for _ in FINGERS]
        self._softened_s = [-math.inf] * len(FINGERS)

    def take_touch(self, t_s: float, touch: Touch, rows: Sequence[TouchRow]) -> None:
        """Take an accepted touch with the `rows` of its block."""
        self.touch, self.summaries, self._touch_s, self.rows = touch, touch.summaries, t_s, rows
        for finger, row in enumerate(rows):
            if not row.contact:
                self.contact_since_s[finger] = None
            elif self.contact_since_s[finger] is None:
                self.contact_since_s[finger] = t_s

    def take_rendered(
        self,
        t_s: float,
        force_n: Sequence[float],
        motor_hz: Sequence[float],
        plate_c: Sequence[float],
        plate_set_c: Sequence[float],
        limited: Sequence[int],
    ) -> None:
        """Take the output of one tick to the devices.

        Args:
            t_s: time, s.
            force_n: force on each finger, N.
            motor_hz: motor frequency of each finger, Hz.
            plate_c: temperature of each plate, C; invalid while its limits have PLATE_UNKNOWN.
            plate_set_c: set-point of each plate, C.
            limited: bits of the acting limits of each finger.
        """
        self._rendered_s = t_s
        self._force_n, self._motor_hz, self._plate_c = list(force_n), list(motor_hz), list(plate_c)
        self._plate_set_c, self._limited = list(plate_set_c), list(limited)
        for finger, (bits, touches) in enumerate(zip(limited, self.in_contact(t_s), strict=True)):
            if touches and bits & _SOFTENED and not bits & _RELEASED:
                self._softened_s[finger] = t_s
        for finger, bits in enumerate(self._acting()):
            if bits:
                for limit in _LIMITS:
                    if bits & limit:
                        self._acted[finger][limit] = t_s

    def take_skin(self, t_s: float, skin_c: Sequence[float]) -> None:
        """Take the skin temperature of each finger from the skin model, C."""
        self._skin_s, self._skin_c = t_s, list(skin_c)

    def age_s(self, now_s: float) -> float:
        """Return the age of the older of touch and output, s; infinite until both have arrived."""
        return now_s - min(self._touch_s, self._rendered_s)

    def shown(self, now_s: float) -> list[list[float]]:
        """Return the FIELDS of each finger."""
        touched, rendered = now_s - self._touch_s <= GONE_S, now_s - self._rendered_s <= GONE_S
        skin_c = self._skin_c if now_s - self._skin_s <= GONE_S else [_NAN] * len(FINGERS)
        age_s, plates_c = self.age_s(now_s), self.plates_c(now_s)
        found = []
        for finger, row in enumerate(self.rows):
            x_m, y_m, surface_m, contact_n, mode, stiffness = _shown(row) if touched else [_NAN] * 6
            surfaced = touched and stiffness > 0.0
            found.append(
                [
                    x_m,
                    y_m + FINGER_Y_M[finger],
                    surface_m if surfaced else _NAN,
                    self._force_n[finger] if rendered else _NAN,
                    contact_n,
                    self._motor_hz[finger] if rendered else _NAN,
                    plates_c[finger],
                    skin_c[finger],
                    self._plate_set_c[finger] if rendered else _NAN,
                    mode,
                    stiffness if surfaced else _NAN,
                    age_s if math.isfinite(age_s) else _NAN,
                ]
            )
        return found

    def plates_c(self, now_s: float) -> list[float]:
        """Return each plate's temperature, C; NaN without a fresh reading."""
        if now_s - self._rendered_s > GONE_S:
            return [_NAN] * len(FINGERS)
        return [
            _NAN if bits & Limit.PLATE_UNKNOWN else plate_c
            for plate_c, bits in zip(self._plate_c, self._limited, strict=True)
        ]

    def in_contact(self, now_s: float) -> list[bool]:
        """Return whether each finger is in contact, by a touch no older than GONE_S."""
        fresh = now_s - self._touch_s <= GONE_S
        return [fresh and since_s is not None for since_s in self.contact_since_s]

    def acting(self) -> list[bool]:
        """Return whether a shown limit acts on each finger now."""
        return [bits != 0 for bits in self._acting()]

    def _acting(self) -> list[int]:
        """Return the bits of the shown limits: none for a released finger."""
        return [0 if bits & _RELEASED else bits & ~_QUIET for bits in self._limited]

    def softened(self, finger: int, now_s: float) -> bool:
        """Return whether a surface was displayed softer than it is at a finger in the last HELD_S."""
        return 0.0 <= now_s - self._softened_s[finger] <= HELD_S

    def holds(self, finger: int, limit: Limit) -> bool:
        """Return whether a limit acted on a finger in the newest output."""
        return bool(self._limited[finger] & limit)

    def limits(self, finger: int, now_s: float) -> list[str]:
        """Return the names of the limits that acted on a finger in the last HELD_S."""
        return [_LIMITS[limit] for limit, at_s in self._acted[finger].items() if 0.0 <= now_s - at_s <= HELD_S]
