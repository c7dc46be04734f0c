"""Thermal contacts of thermistors with their plates: one that loosens reads a temperature nearer to the room's."""

import numpy as np
from numpy.typing import NDArray

LEAST_CONTACT = 0.4
"""Contact at which a thermistor stops to loosen, as its share of the difference between plate and room."""


class ThermistorContacts:
    """Contacts of n thermistors, whole at first.

    Attributes:
        lost_per_s: contact that each loses per second, (n,); 0 at first, and 0 restores the contact.
    """

    def __init__(self, count: int) -> None:
        self.lost_per_s: NDArray[np.float64] = np.zeros(count)
        self._contact = np.ones(count)

    def read(self, dt_s: float, plate_c: NDArray[np.float64], room_c: float) -> NDArray[np.float64]:
        """Return the temperatures that the thermistors take on plates at `plate_c`, C, `dt_s` after the last call."""
        if not self.lost_per_s.any():
            self._contact.fill(1.0)
            return plate_c
        contact = np.maximum(LEAST_CONTACT, self._contact - dt_s * self.lost_per_s)
        self._contact = np.where(self.lost_per_s > 0.0, contact, 1.0)
        return room_c + self._contact * (plate_c - room_c)
