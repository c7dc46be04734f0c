"""Three figures of the paper repeated: motor speed (Fig. 4), skin on iron and wood (Fig. 6), identification (Fig. 13).

Kron & Schmidt 2003 print no axis values to compare with. These figures have numbers, from this project's own code on
the simulated devices.
"""

from typing import Any

import numpy as np

from common.scenes.materials import material
from common.wire.messages import ExplorationMode
from sim_sensors.physics.motor import RPM_PER_RAD_S
from sim_sensors.physics.surface import make_profile, relief_of
from studies.compared import Compared
from studies.paper_figures.remote_identification import MATERIAL, OBJECT_C, PAPER_S, identification_rows
from studies.paper_figures.skin_layers import layer_rows, start_rows
from studies.pieces import HERE, Piece, Work, rows_of
from studies.running import Progress, tables_of
from studies.touches.rendered_stroke import VirtualSurface, rendered_stroke
from studies.touches.stroke_path import LENGTH_M

SURFACE = "widely_grooved_pvc"
SHOWN_S = 2.0
BRISK_S = 0.08
"""Time of descent of a finger that taps hard enough to show the decay of Eq. 1, s."""
tables = tables_of("motor", "layers", "starts", "identification")
COMPARED = (
    Compared("layers", "epidermis_c", "same", ("start", "object", "time_s"), absolute=0.02),
    Compared("identification", "object_c", "same", ("time_s",), absolute=0.05),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Compute all three figures; `quick` shortens nothing, since they are quick."""
    pieces: dict[str, list[Piece]] = {
        "motor": [(motor_rows, (seed,))],
        "layers": [(layer_rows, ())],
        "identification": [(identification_rows, (seed,))],
    }
    return {
        "starts": start_rows(),
        "object_c": OBJECT_C,
        "effusivity_j_m2ks05": material(MATERIAL).effusivity,
        "paper_s": PAPER_S,
        **rows_of(pieces, work, progress),
    }


def motor_rows(seed: int) -> list[dict[str, Any]]:
    """Wanted speed and simulated speed of the motor while a grooved surface is tapped and stroked."""
    grooves = make_profile(relief_of(SURFACE), LENGTH_M, np.random.default_rng(seed)).grooves_m
    course = rendered_stroke(VirtualSurface.of(SURFACE, grooves), seed, lower_s=BRISK_S)
    return [
        {
            "time_s": float(time_s),
            "mode": ExplorationMode(int(mode)).name.lower(),
            "wanted_rpm": float(wanted) * RPM_PER_RAD_S,
            "motor_rpm": float(speed) * RPM_PER_RAD_S,
        }
        for time_s, mode, wanted, speed in zip(
            course.time_s, course.mode, course.wanted_rad_s, course.speed_rad_s, strict=True
        )
        if time_s <= SHOWN_S
    ]
