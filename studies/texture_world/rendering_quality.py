"""Judges rendered against sensed vibration by the bit rate that crosses the link.

The metrics are spectral-temporal similarity (ST-SIM) and the spectral perceptual quality index (SPQI) of the package
`vibromaf`, both 1 for equal signals, and the rms difference of the spectra in bands, dB. Every rendered vibration has
the rms of the sensed one, so that a unit counts for nothing.
"""

import math
from collections.abc import Iterator, Sequence
from importlib import import_module
from importlib.util import find_spec
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import resample_poly

from common.limits import MOTOR_FLOOR_RPM, MOTOR_MAX_RPM
from common.wire.messages import ExplorationMode
from operator_site.vibration.motor_drive import MotorDrive
from operator_site.vibration.vibration import FingerVibration, Surface
from remote_site.texture.calibration.texture_calibration import ROUGH, SMOOTH
from remote_site.texture.motion_spectrum import EDGES_HZ
from remote_site.texture.recorded.stroke_spectrum import stroke_spectrum
from sim_sensors.physics.motor import RPM_PER_RAD_S, VibrationMotors
from studies.counting import grouped
from studies.texture_world.models import RATE_HZ, TextureModel
from studies.texture_world.roughness import RENDERED
from studies.texture_world.strokes import LONGEST_S, Stroke, rendered, stroke_over

Array = NDArray[np.float64]
Row = dict[str, Any]
PACKAGE = "vibromaf"
MISSING = f"{PACKAGE} is not installed: pip install 'teletaction[quality]'"
"""Note of a study without the metrics."""
METRIC_HZ = 8000
"""Sampling rate that the metrics expect, Hz."""
BITS = (1, 2, 3, 4, 6, 8)
"""Numbers of bits of a sample of a quantised waveform."""
RANGE_SDS = 4.0
"""Range of the quantiser, standard deviations of the sensed vibration."""
SPECTRA_HZ = (1.0, 4.0, 16.0)
"""Rates at which a spectrum is sent, Hz."""
LEVEL_BITS = 6
"""Number of bits of the power in a band."""
TOUCH_HZ, CONSTANT_BITS = 500.0, 64
"""Rate of touch packets, Hz, and bits of both constants of Eq. 2 in one finger's row."""
TICK_S = 0.002
ENVELOPE_S = 0.020
"""Time over which the intensity of the sensed vibration is averaged for a motor that follows it, s."""
WAVEFORM, SPECTRUM, CONSTANTS = "waveform", "spectrum", "constants of Eq. 2, motor"
SAME, MOTOR_BEST, ANOTHER = "the texture's own model", "motor that follows the intensity", "another texture"


def installed() -> bool:
    """Return whether the package of the metrics is there."""
    return find_spec(PACKAGE) is not None


def similarities(shown: Array, sensed: Array) -> dict[str, float]:
    """Return ST-SIM and SPQI of a rendered and a sensed vibration, both at RATE_HZ; the package must be installed.

    ST-SIM is a root, which is complex where the signals oppose each other; this counts as 0.
    """
    found = {}
    fine, reference = (resample_poly(each, METRIC_HZ, round(RATE_HZ)) for each in (shown, sensed))
    for name, part in (("st_sim", "stsim"), ("spqi", "spqi")):
        with np.errstate(divide="ignore"):  # a spectrum of the package may have an empty line
            score = getattr(import_module(f"{PACKAGE}.metrics.{part}"), name)(fine, reference)
        found[name] = 0.0 if isinstance(score, complex) else float(score)
    return found


def qualities(models: Sequence[TextureModel], places: Sequence[int], ln_v: Sequence[float], seed: int) -> Iterator[Row]:
    """Yield the quality of each way to render the textures at `places`; nothing without the metrics.

    `ln_v` is ln of the shipped roughness, V, of each of `models`.
    """
    if not installed():
        return
    for place in places:
        stroke = stroke_over(models[place], seed, place, RENDERED)
        part = stroke.steady(LONGEST_S)
        sensed = stroke.acceleration_m_s2[part]
        for way, bits_s, vibration in _ways(models, place, stroke, part, ln_v, seed):
            shown = vibration * (float(sensed.std()) / max(float(vibration.std()), 1e-12))
            yield {
                "material": models[place].material,
                "way": way,
                "bits_s": bits_s,
                **similarities(shown, sensed),
                "off_db": _off_db(shown, sensed),
            }


def _ways(
    models: Sequence[TextureModel], place: int, stroke: Stroke, part: slice, ln_v: Sequence[float], seed: int
) -> Iterator[tuple[str, float | None, Array]]:
    """Yield each way, its bit rate, bit/s, or None where none crosses a link, and its vibration."""
    sensed, chance = stroke.acceleration_m_s2[part], np.random.default_rng([seed, place, RENDERED + 1])
    for bits in BITS:
        yield WAVEFORM, bits * RATE_HZ, quantised(sensed, bits)
    for rate_hz in SPECTRA_HZ:
        yield SPECTRUM, rate_hz * LEVEL_BITS * (len(EDGES_HZ) - 1), resounded(sensed, rate_hz, chance)
    moved = stroke.speed_mm_s[part], stroke.force_n[part]
    yield CONSTANTS, TOUCH_HZ * CONSTANT_BITS, by_constants(*moved, ln_v[place])
    yield SAME, None, rendered(models[place], *moved, chance)
    yield ANOTHER, None, rendered(models[(place + len(models) // 2) % len(models)], *moved, chance)
    yield MOTOR_BEST, None, following(sensed)


def quantised(signal: Array, bits: int) -> Array:
    """Return the signal in 2^bits even steps over RANGE_SDS."""
    step = 2.0 * RANGE_SDS * float(signal.std()) / 2**bits
    most = step * (2 ** (bits - 1) - 0.5)
    return np.asarray(np.clip((np.floor(signal / step) + 0.5) * step, -most, most))


def resounded(signal: Array, rate_hz: float, chance: np.random.Generator) -> Array:
    """Return noise that has the power of the signal in each band, renewed at a rate, Hz."""
    length = round(2.0 * RATE_HZ / rate_hz)
    window = np.sqrt(np.hanning(length + 1)[:-1])
    padded = np.pad(signal, length)
    out = np.zeros(len(padded))
    frequency_hz = np.fft.rfftfreq(length, 1.0 / RATE_HZ)
    edges_hz = [0.0, *EDGES_HZ[1:-1], 0.5 * RATE_HZ + 1.0]
    for first in range(0, len(padded) - length + 1, length // 2):
        power = np.abs(np.fft.rfft(window * padded[first : first + length])) ** 2 / np.mean(window**2)
        noise = np.fft.rfft(chance.standard_normal(length))
        gain = np.zeros(len(power))
        for low_hz, high_hz in pairwise(edges_hz):
            inside = (frequency_hz >= low_hz) & (frequency_hz < high_hz)
            gain[inside] = math.sqrt(float(power[inside].mean()) / length) if inside.any() else 0.0
        out[first : first + length] += window * np.fft.irfft(gain * noise, length)
    return out[length : length + len(signal)]


def by_constants(speed_mm_s: Array, force_n: Array, ln_roughness_v: float) -> Array:
    """Return the motor's vibration with the constants that a calibration gives a surface of this roughness."""
    share = float(np.clip((ln_roughness_v - SMOOTH[0]) / (ROUGH[0] - SMOOTH[0]), 0.0, 1.0))
    k_v, k_f = (low * (high / low) ** share for low, high in zip(SMOOTH[1:], ROUGH[1:], strict=True))
    finger, surface, every = FingerVibration(), Surface(k_stroke_v=k_v, k_stroke_f=k_f), round(TICK_S * RATE_HZ)
    wanted = [
        finger.step(TICK_S * tick, ExplorationMode.STROKING, 1e-3 * speed, force, surface=surface)
        for tick, (speed, force) in enumerate(zip(speed_mm_s[::every], force_n[::every], strict=True))
    ]
    return turned(np.array(wanted))


def following(sensed: Array) -> Array:
    """Return the vibration of a motor whose intensity is to follow that of the sensed vibration.

    The sensed vibration of 98 % of the time fits into the range of the motor. No other drive of this motor comes nearer
    in intensity, since its frequency follows from it.
    """
    width = round(ENVELOPE_S * RATE_HZ)
    rms = np.sqrt(np.convolve(sensed**2, np.full(width, 1.0 / width), "same"))
    speed = MOTOR_MAX_RPM * np.sqrt(rms / np.quantile(rms, 0.98))
    wanted = np.clip(speed, MOTOR_FLOOR_RPM, MOTOR_MAX_RPM)
    return turned(wanted[:: round(TICK_S * RATE_HZ)])


def turned(wanted_rpm: Array) -> Array:
    """Return the vibration of the simulated motor at wanted speeds, one each TICK_S: one axis of its acceleration."""
    motor, drive = VibrationMotors(1), MotorDrive()
    every = round(TICK_S * RATE_HZ)
    speed_rad_s = []
    for tick, rpm in enumerate(wanted_rpm.tolist()):
        drive.step(TICK_S * tick, rpm)
        for _ in range(every):
            motor.step(1.0 / RATE_HZ, np.array([_volts(drive)]))
            speed_rad_s.append(float(motor.rpm[0]) / RPM_PER_RAD_S)
    speed = np.array(speed_rad_s)
    return np.asarray(speed**2 * np.sin(np.cumsum(speed) / RATE_HZ))


def _volts(drive: MotorDrive) -> float:
    """Return the voltage of a drive's present command within its pulse, V."""
    pulse_mv, pulse_us, _ = drive.pulse
    return 1e-3 * (pulse_mv if pulse_us > 0 else drive.hold_mv)


def _off_db(shown: Array, sensed: Array) -> float:
    """Return the rms difference of the powers in bands, dB."""
    spectra = [stroke_spectrum(each, RATE_HZ, 0.1, 1.0) for each in (shown, sensed)]
    powers = [each.ln_power for each in spectra if each is not None]
    return float(np.sqrt(np.mean(np.square(np.subtract(*powers))))) * 10.0 / math.log(10.0)


def quality_rows(rows: Sequence[Row]) -> list[Row]:
    """Return the mean of each way over the textures, and the quantiles of 10 and 90 %."""
    found = []
    for (way, bits_s), mine in grouped(rows, "way", "bits_s").items():
        line: Row = {"way": way, "bits_s": bits_s, "textures": len(mine)}
        for name in ("st_sim", "spqi", "off_db"):
            values = np.array([row[name] for row in mine])
            line |= {name: float(values.mean())}
            line |= {f"{name}_{part}": float(np.quantile(values, 0.01 * part)) for part in (10, 90)}
        found.append(line)
    return found
