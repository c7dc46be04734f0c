"""Display at the operator's finger in arrays, for Python programs."""

import numpy as np
from numpy.typing import NDArray

from operator_site.offline_rendering import PLATE_COLUMN, THERMAL_COLUMNS, VIBRATION_COLUMNS
from operator_site.offline_rendering import render_thermal as thermal_rows
from remote_site.texture.surface_table import SurfaceTable
from remote_site.traces.trace_files import StrokeTrace
from teletaction.replay.render_vibration import render_stroke
from teletaction.session.demo_files import SURFACES

Columns = dict[str, NDArray[np.float64]]


def render_thermal(
    material: str,
    object_c: float,
    air_c: float = 23.0,
    seconds: float = 10.0,
    *,
    model: str | None = None,
    plate: bool = False,
) -> Columns:
    """Compute the skin of a fingertip that touches an object, every 10 ms; the contact begins at 1.0 s.

    The skin model has layers with perfusion, and an object of second order (after Kron & Schmidt 2003; `docs/errata.md`
    has the corrected equations).

    Args:
        material: name of a material, such as `pvc` or `aluminium`.
        object_c: temperature of the object, -50..150 C.
        air_c: temperature of the air, -50..150 C.
        seconds: duration, above 0 and at most 3600 s.
        model: cells of epidermis, dermis, subcutis and object, such as `4+1+1+6`; by default the smallest model within
            the tolerance.
        plate: whether to add the plate's set-point within the limits of the comfort profile.

    Returns:
        Arrays (n,) by name: `time_s`; `skin1_c`, `skin2_c`, `skin3_c`, mean temperatures of the layers, C; `surface_c`,
        C; `flux_w_m2` into the finger, W/m2; and `plate_c`, C, if `plate`.

    Raises:
        ValueError: the material or the model is unknown, or a number is out of range.
    """
    rows = np.array(list(thermal_rows(material, object_c, air_c, seconds, model=model, plate=plate)))
    names = (*THERMAL_COLUMNS, PLATE_COLUMN) if plate else THERMAL_COLUMNS
    return dict(zip(names, rows.T, strict=True))


def render_vibration(stroke: StrokeTrace, table: SurfaceTable | None = None) -> Columns:
    """Compute the motor speed that displays a stroke, every 5 ms (Kron & Schmidt 2003, Eq. 1 and 2).

    Args:
        stroke: the stroke; below 1000 samples/s it has no single grooves. One without force counts as in contact, one
            without speed as a stroke at nominal speed.
        table: calibrated surfaces; by default those of the simulated sensors.

    Returns:
        Arrays (n,) by name: `time_s`; `mode`, 0 free, 1 tapping, 2 quiescent, 3 stroking; `motor_rpm`, 0..10000 rpm.
    """
    rows = np.array(list(render_stroke(stroke, table or SurfaceTable.load(SURFACES))))
    return dict(zip(VIBRATION_COLUMNS, rows.T, strict=True))
