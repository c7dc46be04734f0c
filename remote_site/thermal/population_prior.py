"""What is usual of sensors, contacts and materials before any touch was seen."""

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.touch_model import PLATE_J_M2K

Array = NDArray[np.float64]

SENSOR = 4
"""Constants of the sensor: ln leak, ln half force, how early heat flows, ln power of the force."""
COMMON = SENSOR + 2
"""Numbers that all touches share, before the materials' means: those, mean ln lag, the back's share."""
FIRST = (np.log(800.0 / PLATE_J_M2K), np.log(0.6), np.log(0.3))
"""Where every touch begins: ln effusivity, ln conductance, ln lag."""
FIRST_SD = (0.15, 0.2, 0.25)
PRIOR_TOUCHES = (1.0, 10.0, 0.1)
"""Weight of the usual scatter beside a population's own, in touches."""
USUAL_SD = (0.05, 0.15, 0.2)
LEAST_LAG_SD = 0.005
LEAST_BACK_SD_K = 0.05
LEAST_START_SD_K = 0.003
LEAK_LN_SD, FORCE_LN_SD, EARLY_SD, POWER_LN_SD = 0.5, 1.0, 1.0, 0.3
EARLY_UNIT_S = 0.02
"""Heat and force agree on the time of contact within about this."""
HALF_FORCE_N = 0.3
LAG_MEAN_SD, EFFUSIVITY_SD, CONDUCTANCE_SD = 1.0, 3.0, 2.0
"""How far from FIRST the populations may lie, in logarithms."""
MATERIAL_CONDUCTANCE_SD = 0.7
"""Materials differ by so much in ln conductance where their contacts are of one kind."""
BACK_SHARE, BACK_SHARE_SD = 0.3, 0.3
"""Where the back is at contact between ambient and plate, before anything was seen."""
T_FREEDOM, T_SCALE_K = 2.0, 8.0
"""Student's t of objects whose temperature nobody stated: freedom, and width around ambient, K."""


def usual_sensor(leak_per_s: float) -> Array:
    """Constants of a sensor (SENSOR,) with this leak, 1/s."""
    return np.array([np.log(max(leak_per_s, 1e-3)), np.log(HALF_FORCE_N), 0.0, 0.0])


def common_prior(sensor: Array, materials: int) -> tuple[Array, Array]:
    """Means and precision of what touches share: the conductances of all materials are of one kind of contact."""
    usual = np.concatenate((sensor, [FIRST[2], BACK_SHARE], np.tile(FIRST[:2], materials)))
    precision = np.diag(
        np.concatenate(
            (
                [LEAK_LN_SD, FORCE_LN_SD, EARLY_SD, POWER_LN_SD, LAG_MEAN_SD, BACK_SHARE_SD],
                np.tile([EFFUSIVITY_SD, 1.0], materials),
            )
        )
        ** -2.0
    )
    kind = np.full((materials, materials), CONDUCTANCE_SD**2) + MATERIAL_CONDUCTANCE_SD**2 * np.eye(materials)
    which = COMMON + 1 + 2 * np.arange(materials)
    precision[np.ix_(which, which)] = np.linalg.inv(kind)
    return usual, precision
