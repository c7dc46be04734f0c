"""The paper's two experiments repeated with a simulated fingertip and an observer model without fitted parameters.

These are Table 2 (objects distinguished by temperature) and Table 1 (surfaces matched by texture) of Kron & Schmidt
2003. Felt quantities come from the simulators' own finger and motor, never from the models that the operator site
renders with. Predictions stand beside the paper's shares and their exact 95 % intervals, whatever the result.
"""

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

from common.config.site_models import RenderingConfig
from common.limits import PLATE_COOLING_K_S, PLATE_HEATING_K_S
from sim_sensors.physics.finger_plate import DEEP_C, ROOM_C
from studies.compared import Compared
from studies.observer.texture_comparison import OWN_STIFFNESS, Strokes, confusion_rows, matching_rows, strokes
from studies.observer.thermal_comparison import (
    OBJECT_C,
    USUAL_S,
    Courses,
    ablation_rows,
    answer_rows,
    course_pieces,
    course_rows,
    courses,
)
from studies.pieces import HERE, Piece, Work, results_of
from studies.running import Progress, tables_of
from studies.touches.teleoperation import DELAY_S, SCENE

TOUCHES, TOUCHES_QUICK = 6, 2
STROKES, STROKES_QUICK = 4, 1
DRAWS, DRAWS_QUICK = 20_000, 2_000
FASTER = "4 times faster"
ASSUMED = (
    f"Objects are at {OBJECT_C:g} C, the simulated room at {ROOM_C:g} C, deep tissue at {DEEP_C:g} C; rendering takes "
    f"air of {RenderingConfig().air_c:g} C and deep tissue of {RenderingConfig().deep_c:g} C, its defaults.",
    "Wood is pine. The first row of Table 2, whose label is lost in print, is aluminium against wood.",
    "Each object is touched once, by one finger; what counts is the change of felt temperature after the dwell.",
    f"Remote objects are the blocks of the scene {SCENE!r}, identified with its calibrated table; touch packets take "
    f"{1e3 * DELAY_S:g} ms.",
    "Surfaces are stroked at 50 mm/s with 1 N; a groove is felt as one where the motor's acceleration rises by 32 %.",
    "3 % of all answers are lapses, spread evenly; nothing else is free, and nothing was fitted.",
    "The strength of a vibration is compared within the six real surfaces and within the six displayed ones only: "
    "fluctuation of the force on a stiff tip and acceleration of a motor have no common unit.",
    "All surfaces are displayed equally stiff, as in the paper, but for the prediction about foam.",
)
"""Assumptions where the paper leaves something open, or a simulation has to choose."""
tables = tables_of("answers", "courses", "ablations", "matching", "confusion", "predictions")
COMPARED = (
    Compared("answers", "predicted_percent", "same", ("side", "pair", "dwell_s", "first_is_felt"), absolute=5.0),
    Compared("matching", "predicted_percent", "same", ("side", "features", "surface"), absolute=8.0),
    Compared("predictions", "holds", "more", ("prediction",)),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Repeat both experiments."""
    pieces: dict[str, list[Piece]] = {
        "strokes": [(strokes, (seed + number,)) for number in range(STROKES_QUICK if quick else STROKES)],
        "touches": course_pieces(TOUCHES_QUICK if quick else TOUCHES, seed),
        "ablations": [(ablation_rows, ())],
    }
    found = results_of(pieces, work, progress)
    sides, (ablations,) = courses(chain(*found["touches"])), found["ablations"]
    return findings(sides, found["strokes"], ablations, seed, DRAWS_QUICK if quick else DRAWS)


def findings(
    sides: Mapping[str, Courses], stroked: Sequence[Strokes], ablations: list[dict[str, Any]], seed: int, draws: int
) -> dict[str, Any]:
    """Results computed from touches and strokes."""
    data: dict[str, Any] = {
        "assumed": list(ASSUMED),
        "answers": answer_rows(sides),
        "courses": course_rows(sides),
        "ablations": ablations,
        "matching": matching_rows(stroked, seed, draws),
        "confusion": confusion_rows(stroked[0], seed, draws),
    }
    return data | {"predictions": predictions(data)}


def predictions(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Predictions that were made beforehand, and the results."""
    (faster,) = (row for row in data["ablations"] if row["value"] == FASTER and row["pair"] == "a-p")
    soft = {row["surface"]: row for row in data["matching"] if row["features"] == OWN_STIFFNESS}
    real = [
        row["inside"]
        for row in data["answers"]
        if row["side"] == "real" and row["dwell_s"] == USUAL_S and row["pair"] != "a-c"
    ]
    rate = f"an ideal plate of {4 * PLATE_COOLING_K_S:g} K/s cooling and {4 * PLATE_HEATING_K_S:g} K/s heating"
    said = [
        (f"on {rate} aluminium is felt colder than PVC, percent", 93.0, faster["colder_percent"]),
        *(
            (f"with foam's own stiffness {surface} is matched, percent", 85.0, soft[surface]["predicted_percent"])
            for surface in ("foam", "plain_pvc")
        ),
        (f"of {len(real)} real shares of Table 2, within the paper's interval", float(len(real)), float(sum(real))),
    ]
    return [
        {"prediction": what, "at_least": least, "found": found, "holds": found >= least} for what, least, found in said
    ]
