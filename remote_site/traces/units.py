"""Recognises columns in a wrong unit by the range of their values, so that nothing is identified from them."""

import numpy as np
from numpy.typing import NDArray

from common.limits import SENSOR_PLATE_C

Array = NDArray[np.float64]
TEMPERATURE_C = (-50.0, 60.0)
"""Range of temperatures that a thermal sensor can measure, C; its plate is cut out far below 60."""
KELVIN = (200.0, 400.0)
"""Range of a median that is taken for kelvin."""
FAHRENHEIT = (60.0, 150.0)
"""Range of a median that is taken for degrees Fahrenheit: 16 to 66 C."""
LONGEST_STEP_S = 0.5
"""Longest median time between two samples, s; a touch or a stroke has at least ten samples."""
LONGEST_S = 1800.0
"""Longest duration of a touch or a stroke, s."""
GAP_S, GAP_STEPS = 0.1, 10.0
"""Longest time without samples in a stroke, s, and as a multiple of the median step; the longer of both holds."""
LARGEST_V = 100.0
"""Largest reading of a pressure sensor, V."""
ROUGHNESS_UM = (0.005, 2000.0)
"""Range of the roughness of a surface, um, from polished glass to coarse grating."""
LARGEST_FORCE_N = 20.0
"""Largest force of a finger in a trace, N; the sites accept half of it."""
SLOWEST_MM_S = 0.5
"""Lowest maximum speed of a stroke, mm/s."""
DEPTH_MM = (0.05, 100.0)
"""Range of the deepest point of the presses of one file, mm."""
FASTEST_M_S = 10.0
"""Largest speed of a stroke, m/s; a hand reaches a tenth of it."""


def wrong_temperature(values: Array) -> str:
    """Return what temperatures look like if they are not in C, and how to convert; empty if they may be."""
    median = float(np.median(values))
    if TEMPERATURE_C[0] <= median <= TEMPERATURE_C[1]:
        return ""
    found = f"a median of {median:g} is no temperature of a sensor in C"
    if KELVIN[0] <= median <= KELVIN[1]:
        return f"{found}: it looks like kelvin; subtract 273.15"
    if FAHRENHEIT[0] < median <= FAHRENHEIT[1]:
        return f"{found}: it looks like Fahrenheit; subtract 32 and divide by 1.8"
    return found


def wrong_reading(values: Array) -> str:
    """Return what is wrong with temperatures, as `wrong_temperature`, or which single one is none; empty if all may be.

    Thermometers report -999 or -127 where they have no reading, and a label may be in another unit than the others.
    """
    if why := wrong_temperature(values):
        return why
    for k in np.flatnonzero((values < TEMPERATURE_C[0]) | (values > TEMPERATURE_C[1])):
        return f"{values[k]:g}, value {k + 1}, is no temperature in C; leave out lines without a reading, or correct it"
    return ""


def wrong_ambient(values: Array) -> str:
    """Return what is wrong with ambient temperatures; empty if all may be. A session refuses the same ones."""
    if why := wrong_reading(values):
        return why
    for value in values[(values <= 0.0) | (values >= SENSOR_PLATE_C)]:
        return f"{value:g} C is no room: the thermometer is shorted or open; leave the column out"
    return ""


def wrong_times(values: Array) -> str:
    """Return what times look like if they are not in s, and how to convert; empty if they may be."""
    step, length = float(np.median(np.diff(values))), float(values[-1] - values[0])
    unit, factor = ("milliseconds", 1000) if step < 500.0 else ("microseconds", 1_000_000)
    if step > LONGEST_STEP_S:
        return f"samples {step:g} s apart are no trace: they look like {unit}; divide by {factor}"
    if length > LONGEST_S:
        return f"a trace of {length:g} s is too long: it looks like {unit}; divide by {factor}, or cut the recording"
    return ""


def wrong_stroke_times(values: Array) -> str:
    """Return what is wrong with the times of a stroke: unit, or samples that are missing; empty if nothing is."""
    if why := wrong_times(values):
        return why
    steps = np.diff(values)
    k = int(steps.argmax())
    if steps[k] <= max(GAP_S, GAP_STEPS * float(np.median(steps))):
        return ""
    return f"no sample for {steps[k]:.3g} s after {values[k]:.12g} s; cut the recording there"


def wrong_pressures(values: Array) -> str:
    """Return what readings look like if they are not in V, and how to convert; empty if they may be."""
    largest = float(np.abs(values).max())
    if largest <= LARGEST_V:
        return ""
    return f"{largest:g} V is no reading of a sensor: it looks like mV; divide by 1000"


def wrong_roughness(values: Array) -> str:
    """Return which roughness cannot be one in um; empty if all may be."""
    for roughness_um in values[(values < ROUGHNESS_UM[0]) | (values > ROUGHNESS_UM[1])]:
        return f"{roughness_um:g} is no roughness in um ({ROUGHNESS_UM[0]:g} to {ROUGHNESS_UM[1]:g})"
    return ""


def wrong_forces(values: Array) -> str:
    """Return what forces look like if they are not in N, and how to convert; empty if they may be."""
    largest = float(np.abs(values).max())
    if largest <= LARGEST_FORCE_N:
        return ""
    return f"{largest:g} N is no force of a finger: it looks like grams; multiply by 0.00981 (mN: by 0.001)"


def wrong_depths(values_mm: Array) -> str:
    """Return what depths look like if they are not in mm, and how to convert; empty if they may be."""
    largest = float(np.abs(values_mm).max())
    if DEPTH_MM[0] <= largest <= DEPTH_MM[1]:
        return ""
    if largest == 0.0:
        return "all depths are 0"
    unit, how = ("m", "multiply") if largest < DEPTH_MM[0] else ("um", "divide")
    return f"at most {largest:g} mm deep is no press: it looks like {unit}; {how} by 1000"


def wrong_speeds(values_mm_s: Array) -> str:
    """Return what speeds look like if they are not in mm/s, and how to convert; empty if they may be.

    A trace whose finger never moves has speeds of 0, which is right in any unit.
    """
    largest = float(np.abs(values_mm_s).max())
    if largest > 1000.0 * FASTEST_M_S:
        return f"{largest:g} mm/s is no stroke: it looks like um/s; divide by 1000"
    if largest == 0.0 or largest >= SLOWEST_MM_S:
        return ""
    return f"at most {largest:g} mm/s is no stroke: it looks like m/s; multiply by 1000"


def wrong_label_speeds(values_mm_s: Array) -> str:
    """Return what is wrong with speeds of whole strokes; empty if all may be."""
    for speed_mm_s in values_mm_s[values_mm_s <= 0.0]:
        return f"must be positive, mm/s, not {speed_mm_s:g}"
    return wrong_speeds(values_mm_s)


def stated_speed_m_s(speed_mm_s: float | None) -> float | None:
    """Return the speed of `--speed`, m/s; None without one.

    Raises:
        ValueError: it is not positive, or looks like another unit.
    """
    if speed_mm_s is None:
        return None
    if not 0.0 < speed_mm_s < 1000.0 * FASTEST_M_S:
        raise ValueError(f"--speed: must be positive, mm/s, not {speed_mm_s}")
    if why := wrong_speeds(np.array([speed_mm_s])):
        raise ValueError(f"--speed: {why}")
    return speed_mm_s / 1000.0


def wrong_speeds_m_s(values: Array) -> str:
    """Return what speeds look like if they are not in m/s, and how to convert; empty if they may be."""
    largest = float(np.abs(values).max())
    if largest <= FASTEST_M_S:
        return ""
    return f"{largest:g} m/s is no stroke: it looks like mm/s; divide by 1000"
