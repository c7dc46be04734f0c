"""When a contact has become another one: a finger that is back after a bounce, or presses otherwise for good."""

import math

from common.exploration.contact_detector import CONTACT_OFF_N
from remote_site.thermal.touch_model import SensorConstants

RESTS_S = 0.4
"""A finger has come to rest so long after contact, s."""
PRESSURE_S = 0.1
"""Smoothing of the force, s."""
PRESSURE_STEP = 0.1
"""Change of the contact's conductance, in its logarithm, that counts as another pressure."""
LEAST_SHARE = 0.02
"""Of the full conductance; a lighter contact counts as this one."""
REMADE = 0.25
"""A contact that a finger made anew where it had been differs from the last one by so much in ln conductance: it is
another draw, and two draws differ by more than one does from the mean."""
UNSTEADY = 0.3
"""A contact that a changed force made anew differs from the law by this part of the change."""
NEARLY_S = 1e-3
"""A reading so much before a time counts as one at that time: clocks are rounded, s."""


class ContactChange:
    """Follows the force on one touch; step it with each reading."""

    def __init__(self, sensor: SensorConstants) -> None:
        """Begin at contact."""
        self._sensor = sensor
        self._begin(0.0)

    def _begin(self, force_n: float) -> None:
        self._force_n, self._since_s = force_n, 0.0
        self._away = False
        self._ln_share: float | None = None
        """Of the pressure that is relied on."""

    def step(self, dt_s: float, force_n: float) -> float:
        """Variance of ln conductance by which the contact may just have become another, beyond the law of force.

        Args:
            dt_s: since the last reading, s.
            force_n: mean force since then, N.
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
