"""The detector of `operator_site.palpation` for random phantoms: the one of the console and of the command `map`."""

import numpy as np

from operator_site.palpation.lump_probability import lumps_of_presses
from operator_site.palpation.nodule_search import PressNumbers
from studies.nodules.judge import Answer, FoundNodule, places_mm
from studies.nodules.phantoms import Presses
from studies.nodules.press_numbers import press_numbers
from studies.nodules.ranges import CONTACT_N, STEP_S


def detect(presses: Presses) -> Answer:
    """Return the answer about the presses on one phantom."""
    lumps = lumps_of_presses(numbers_of(presses))
    found = [FoundNodule(1e3 * one.x_m, 1e3 * one.y_m, 1e3 * one.diameter_m, one.probability) for one in lumps.nodules]
    return Answer(np.minimum(lumps.probability(1e-3 * places_mm(presses.side_mm)), 1.0), tuple(found))


def numbers_of(presses: Presses) -> PressNumbers:
    """Return the numbers of presses that the search for nodules uses."""
    contact_s = presses.time_s[:, 0] - STEP_S
    return press_numbers(
        1e-3 * np.stack([presses.x_mm, presses.y_mm], axis=1),
        1e-3 * np.median(presses.depth_mm, axis=0),
        presses.force_n,
        CONTACT_N,
        1e-3 * presses.probe_mm,
        presses.time_s[0] - contact_s[0],
        contact_s,
    )
