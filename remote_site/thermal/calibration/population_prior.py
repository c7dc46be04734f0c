"""Priors of sensors, contacts and materials before any touch."""

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.touch_model import PLATE_J_M2K

Array = NDArray[np.float64]

SENSOR = 4
"""Number of the sensor's parameters: ln leak, ln half force, early time in EARLY_UNIT_S, ln power of the force."""
COMMON = SENSOR + 2
"""Number of shared parameters before the materials' means: the sensor's, mean ln lag, share of the back."""
FIRST = (np.log(800.0 / PLATE_J_M2K), np.log(0.6), np.log(0.3))
"""Initial values of every touch: ln effusivity, ln conductance, ln lag."""
FIRST_SD = (0.15, 0.2)
"""Initial scatter of the touches: ln effusivity, ln conductance."""
FIRST_LAG_SDS = (0.25, 0.1)
"""Initial scatter of the touches in ln lag; the fit has several optima, and begins with each of these."""
PRIOR_TOUCHES = (1.0, 10.0, 0.1)
"""Weights of the usual scatter beside a population's own, in touches: ln effusivity, ln conductance, ln lag."""
USUAL_SD = (0.05, 0.15, 0.2)
"""Usual scatter of the touches: ln effusivity, ln conductance, ln lag."""
LEAST_LAG_SD = 0.005
"""Minimum scatter of ln lag."""
LEAST_BACK_SD_K = 0.05
"""Minimum standard deviation of the back's temperature, K."""
LEAST_START_SD_K = 0.003
"""Minimum standard deviation of the plate's temperature at contact, K."""
LEAK_LN_SD, FORCE_LN_SD, EARLY_SD, POWER_LN_SD = 0.5, 1.0, 1.0, 0.3
"""Prior standard deviations of the sensor's parameters, in the order of SENSOR."""
EARLY_UNIT_S = 0.02
"""Usual difference between heat and force in the time of contact, s; unit of the early time."""
HALF_FORCE_N = 0.3
"""Prior of the force at which a contact conducts half as well as at large force, N."""
LAG_MEAN_SD, EFFUSIVITY_SD, CONDUCTANCE_SD = 1.0, 3.0, 2.0
"""Prior standard deviations of the populations' means around FIRST, in logarithms."""
MATERIAL_CONDUCTANCE_SD = 0.7
"""Standard deviation of ln conductance between materials with contacts of one kind."""
BACK_SHARE, BACK_SHARE_SD = 0.3, 0.3
"""Prior mean and standard deviation of the back's place at contact between ambient (0) and plate (1)."""
T_FREEDOM, T_SCALE_K = 2.0, 2.0
"""Student's t of unknown object temperatures: degrees of freedom, and width around ambient, K."""


def usual_sensor(leak_per_s: float) -> Array:
    """Return the prior parameters of a sensor (SENSOR,) with this leak, 1/s."""
    return np.array([np.log(max(leak_per_s, 1e-3)), np.log(HALF_FORCE_N), 0.0, 0.0])


def common_prior(sensor: Array, materials: int) -> tuple[Array, Array]:
    """Return prior means and precision of the shared parameters.

    The conductances of all materials are correlated, because they have one kind of contact.
    """
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
