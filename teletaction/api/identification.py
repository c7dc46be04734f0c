"""Calibration and identification of touches, strokes and presses in arrays, for Python programs."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from remote_site.stiffness.recorded.identify_stiffness import AT_N, StiffnessAnswer, identify_presses
from remote_site.texture.recorded.identify_texture import SurfaceAnswer, identify_stroke
from remote_site.texture.recorded.spectrum_table import SpectrumTable
from remote_site.texture.surface_table import SurfaceTable
from remote_site.thermal.calibration.temperature_calibration import TemperatureFit, learn_temperature
from remote_site.thermal.calibration.thermal_calibration import ThermalFit, calibrate_traces
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.recorded.identify_thermal import DEFAULT_AT_S, MaterialAnswer, identify_traces
from remote_site.traces.press_files import Press
from remote_site.traces.trace_files import StrokeTrace, ThermalTrace
from remote_site.traces.units import FASTEST_M_S, TEMPERATURE_C, wrong_speeds_m_s
from teletaction.session.demo_files import SURFACES, TABLES


def calibrate_thermal(
    touches: Iterable[tuple[str, ThermalTrace] | tuple[str, ThermalTrace, float | None]], processes: int = 1
) -> ThermalFit:
    """Fit a table of materials to labelled touches of one thermal sensor.

    Args:
        touches: label and trace of each touch and, where it is known, the temperature of the object, C. The label
            `air` is a free cool-down. Ten touches or more of each material show how touches differ.
        processes: number of processes that share the work. With more than one, a script needs
            `if __name__ == "__main__":` around its own work, as for `multiprocessing`.

    Returns:
        A fit with its `table`, the `warnings` about it, and `residual_k`, (touches, k), which the model leaves
        unexplained at `times_s`, (k,), s after contact.

    Raises:
        ValueError: a touch is no label with a trace, the temperature of an object is none, there are fewer than two
            materials or two touches of one, a touch has no contact, is too short or has no temperature difference, or
            a cool-down is none.
    """
    labelled = []
    for number, touch in enumerate(touches):
        if len(touch) not in (2, 3) or not _is_labelled(touch):
            raise ValueError(f"touch {number}: expected (label, trace) or (label, trace, object_c)")
        labelled.append((touch[0], touch[1], _object_c(number, touch[2]) if len(touch) == 3 else None))
    return calibrate_traces(labelled, processes=processes)


def calibrate_temperature(
    table: MaterialTable, touches: Iterable[tuple[str, ThermalTrace, float]], processes: int = 1
) -> TemperatureFit:
    """Learn the errors of object temperatures from touches of references of known temperature.

    Args:
        table: table of a thermal sensor, from `calibrate_thermal`.
        touches: material of the table, trace, and temperature of the reference, C, of each touch. Five touches or more
            of a material are needed, and ten are good. Other materials keep what they have.
        processes: number of processes that share the work, as for `calibrate_thermal`.

    Returns:
        A fit with its `table`, and the `warnings` about it.

    Raises:
        ValueError: a touch is no label with a trace and a temperature, the table is too old, a material is not in it or
            has too few touches, or a touch has no contact, is too short or has no temperature difference.
    """
    labelled = []
    for number, touch in enumerate(touches):
        object_c = _object_c(number, touch[2]) if len(touch) == 3 and _is_labelled(touch) else None
        if object_c is None:
            raise ValueError(f"touch {number}: expected (label, trace, object_c)")
        labelled.append((touch[0], touch[1], object_c))
    return learn_temperature(table, labelled, processes=processes)


def _is_labelled(touch: Sequence[object]) -> bool:
    return isinstance(touch[0], str) and bool(touch[0]) and isinstance(touch[1], ThermalTrace)


def _object_c(number: int, object_c: float | None) -> float | None:
    """Return the temperature of an object, C; raises ValueError where it can be none."""
    low_c, high_c = TEMPERATURE_C
    if object_c is not None and not low_c <= object_c <= high_c:
        raise ValueError(f"touch {number}: object_c must be {low_c:g}..{high_c:g} C, not {object_c:g}")
    return object_c


def identify_thermal(
    traces: ThermalTrace | Sequence[ThermalTrace],
    table: MaterialTable | None = None,
    at_s: Sequence[float] = DEFAULT_AT_S,
) -> list[MaterialAnswer]:
    """Identify the material and the temperature of a touched object (extends Kron & Schmidt 2003, Eq. 11).

    Args:
        traces: a touch, or the touches of several fingers on one object, which are judged together. The clock of each
            trace starts at its own contact.
        table: calibrated materials; by default those of the simulated sensors.
        at_s: times since contact, s. An answer uses no later sample.

    Returns:
        One answer for each time, and the final one.

    Raises:
        ValueError: there is no trace, or a time is not positive.
    """
    listed = [traces] if isinstance(traces, ThermalTrace) else list(traces)
    return identify_traces(table or MaterialTable.load(TABLES / "materials.json"), listed, at_s)


def identify_texture(
    stroke: StrokeTrace,
    table: SurfaceTable | SpectrumTable | None = None,
    speed_m_s: float | None = None,
    speed_sd_m_s: float = 0.0,
) -> list[SurfaceAnswer]:
    """Identify exploration mode, roughness, grooves and surface of a stroke (Kron & Schmidt 2003, Eq. 2).

    Args:
        stroke: the stroke. One without force counts as in contact throughout.
        table: calibrated surfaces; by default those of the simulated sensors. A table of slow strokes is for sensors
            below 1000 samples/s.
        speed_m_s: speed of a stroke without one, m/s.
        speed_sd_m_s: standard deviation of a constant error of the speed, m/s; it widens that of the period.

    Returns:
        One answer for each segment of one mode on one surface.

    Raises:
        TypeError: the table is none of surfaces.
        ValueError: the table is of another kind of stroke or of another sensor, the speed is not positive or looks
            like mm/s, or its standard deviation is negative.
    """
    if table is not None and not isinstance(table, SurfaceTable | SpectrumTable):
        raise TypeError(f"table must be one of surfaces, from load_surfaces, not {type(table).__name__}")
    if speed_m_s is not None:
        if not 0.0 < speed_m_s < math.inf:
            raise ValueError(f"speed_m_s must be above 0, not {speed_m_s}")
        if why := wrong_speeds_m_s(np.array([speed_m_s])):
            raise ValueError(f"speed_m_s: {why}")
    if not 0.0 <= speed_sd_m_s <= FASTEST_M_S:
        raise ValueError(f"speed_sd_m_s must be 0 or more and at most {FASTEST_M_S:g}, not {speed_sd_m_s}")
    return identify_stroke(stroke, table or SurfaceTable.load(SURFACES), speed_m_s, speed_sd_m_s=speed_sd_m_s)


def identify_stiffness(presses: Press | Sequence[Press], at_n: float = AT_N) -> list[StiffnessAnswer]:
    """Identify stiffness, exponent and contact of presses on one object.

    Args:
        presses: the presses. Those of other places are the prior of each, so that one alone is less certain.
        at_n: force at which the stiffness is stated, N.

    Returns:
        One answer for each press, in their order.

    Raises:
        ValueError: the force is not positive.
    """
    return identify_presses([presses] if isinstance(presses, Press) else presses, at_n)
