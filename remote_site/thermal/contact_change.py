"""Detects when a contact has become another one, after a bounce or a lasting change of pressure."""

import math

from common.exploration.contact_detector import CONTACT_OFF_N
from remote_site.thermal.touch_model import SensorConstants

RESTS_S = 0.4
"""Time after contact when a finger has come to rest, s."""
PRESSURE_S = 0.1
"""Time constant of the smoothing of the force, s."""
PRESSURE_STEP = 0.1
"""Minimum change of the contact's ln conductance that counts as another pressure."""
LEAST_SHARE = 0.02
"""Minimum share of the full conductance, 0..1; a lighter contact counts as this one."""
REMADE = 0.25
"""Standard deviation of the change of ln conductance when a finger touches again at the same place.

Each contact is a random draw, and two draws differ more from each other than one from the mean.
"""
UNSTEADY = 0.3
"""Standard deviation of a contact after a change of force, as a fraction of the change of ln conductance by the law."""
NEARLY_S = 1e-3
"""Maximum time by which a reading may precede its nominal time, s, because clocks are rounded."""


class ContactChange:
    """Monitors the force of one touch; step it with each reading."""

    def __init__(self, sensor: SensorConstants) -> None:
        self._sensor = sensor
        self._begin(0.0)

    def _begin(self, force_n: float) -> None:
        self._force_n, self._since_s = force_n, 0.0
        self._away = False
        self._ln_share: float | None = None
        """ln of the share of the full conductance at the last steady pressure; None before it."""

    def step(self, dt_s: float, force_n: float) -> float:
        """Return the variance of ln conductance that a change of contact just added beyond the law of force.

        `force_n` is the mean in the `dt_s` since the last reading, s.
        """
        if force_n < CONTACT_OFF_N:
            self._away = True
            return 0.0
        if self._away:
            self._begin(force_n)
            return REMADE**2
        self._since_s += dt_s
        self._force_n += (force_n - self._force_n) * min(dt_s / PRESSURE_S, 1.0)
        if self._since_s < RESTS_S - NEARLY_S:
            return 0.0
        ln_share = math.log(max(float(self._sensor.force_share(self._force_n)), LEAST_SHARE))
        change = ln_share - (ln_share if self._ln_share is None else self._ln_share)
        if self._ln_share is None or abs(change) > PRESSURE_STEP:
            self._ln_share = ln_share
            return (UNSTEADY * change) ** 2
        return 0.0
