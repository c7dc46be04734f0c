"""Calibrating the thermal look-up table from labelled touches."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from remote_site.exponential_response import TAU_GRID_S, ExponentialFit
from remote_site.material_table import TIMES_S, MaterialEntry, MaterialTable, drift
from remote_site.thermal_response import AVERAGE, ThermalResponse
from remote_site.thermal_touches import BEFORE, RecordedTouch, find_touch
from remote_site.traces import ThermalTrace, read_labels, read_thermal

Array = NDArray[np.float64]

AIR = "air"
"""Label of a free cool-down: no material, but the leak."""
FEWEST = 2
"""Touches below which a material cannot be calibrated."""
PRIOR_TOUCHES = 4.0
"""Weight of the covariance pooled over materials beside a material's own, in touches."""
ITERATIONS = 4
"""The leak past an object needs the gain that it corrects; it converges within a few rounds."""
LEAST_GAIN = 0.005
LEAST_SCATTER = 0.01
"""Part of a gain that scatters independently from time to time, whatever few touches may say."""
LEAST_OFFSET_SD_K = 1.0
LEAST_DIFFERENCE_K = 1.0
"""A calibration touch with less difference between plate and object calibrates nothing, K."""


@dataclass(frozen=True, slots=True)
class _Course:
    """Figures of one calibration touch."""

    gains: Array
    fits: list[ExponentialFit | None]
    object_c: float
    offset_k: float


def calibrate_thermal(folder: Path, out: Path, *, sensor_serial: str = "unknown", made_on: str = "") -> MaterialTable:
    """Make a look-up table from FOLDER/labels.csv (`file,material[,object_c]`) and write it to `out`.

    Args:
        folder: holds labels.csv and the traces it names; the label `air` is a free cool-down.
        out: file to write.
        sensor_serial: the sensor that recorded them.
        made_on: ISO date.

    Raises:
        ValueError: a file cannot be used; names file, line and column.
    """
    leaks: list[float] = []
    touches: dict[str, list[tuple[RecordedTouch, float | None]]] = {}
    for path, label, object_c in read_labels(folder, "material", "object_c"):
        trace = read_thermal(path)
        if label == AIR:
            leaks.append(_leak_per_s(trace, path))
            continue
        touch = find_touch(trace)
        if touch is None:
            raise ValueError(f"{path}: column force_n: no contact (0.30 N held for 50 ms)")
        touches.setdefault(label, []).append((touch, object_c))
    table = _tabulate(folder, touches, float(np.mean(leaks)) if leaks else 0.0)
    table = table.model_copy(update={"sensor_serial": sensor_serial, "made_on": made_on})
    table.save(out)
    return table


def _leak_per_s(trace: ThermalTrace, path: Path) -> float:
    """Rate of a free cool-down to ambient, 1/s."""
    around = trace.ambient_c if trace.ambient_c is not None else trace.reference_c
    if around is None:
        raise ValueError(f"{path}: column ambient_c is missing: a free cool-down needs it")
    # the plate may be held for a while first; the last three quarters are free
    free = trace.time_s >= trace.time_s[0] + 0.25 * (trace.time_s[-1] - trace.time_s[0])
    above = (trace.sensor_c - around)[free]
    if not above.min() > 0.5:
        raise ValueError(f"{path}: column sensor_c: a free cool-down stays 0.5 K above ambient, this one does not")
    slope = float(np.polyfit(trace.time_s[free], np.log(above), 1)[0])
    return min(max(-slope, 0.0), 0.5)


def _tabulate(
    folder: Path, touches: dict[str, list[tuple[RecordedTouch, float | None]]], leak_per_s: float
) -> MaterialTable:
    """Means and covariances per label."""
    where = folder / "labels.csv"
    if len(touches) < 2:
        raise ValueError(f"{where}: column material: two materials or more are needed, there are {len(touches)}")
    for label, listed in touches.items():
        if len(listed) < FEWEST:
            raise ValueError(f"{where}: column material: {label} has {len(listed)} touch, needs {FEWEST} or more")
    everyone = [touch for listed in touches.values() for touch, _ in listed]
    ambients = [touch.ambient_c for touch in everyone if touch.ambient_c is not None]
    if not ambients and any(object_c is None for listed in touches.values() for _, object_c in listed):
        raise ValueError(f"{where}: column object_c: needed where the traces have no ambient_c")
    objects = [object_c for listed in touches.values() for _, object_c in listed if object_c is not None]
    ambient_c = float(np.mean(ambients or objects))
    length_s = min(float(touch.trace.time_s[-1]) - touch.contact_s for touch in everyone)
    times_s = [t for t in TIMES_S if t <= length_s + 1e-6]
    if not times_s:
        raise ValueError(f"{where}: the shortest touch lasts {length_s:.2f} s, needs {TIMES_S[0]} s or more")
    courses = {
        label: [_course(touch, object_c, ambient_c, leak_per_s, times_s) for touch, object_c in listed]
        for label, listed in touches.items()
    }
    relative = {label: _relative_scatter(own) for label, own in courses.items()}
    pooled = np.mean(list(relative.values()), axis=0)
    return MaterialTable(
        ambient_c=ambient_c,
        leak_per_s=leak_per_s,
        noise_k=_noise_k(everyone),
        times_s=times_s,
        materials=[_entry(label, own, relative[label], pooled) for label, own in courses.items()],
    )


def _course(
    touch: RecordedTouch, object_c: float | None, ambient_c: float, leak_per_s: float, times_s: Sequence[float]
) -> _Course:
    """Gains and fits of one touch; an unstated object temperature is the ambient one."""
    around_c = ambient_c if touch.ambient_c is None else touch.ambient_c
    object_c = around_c if object_c is None else object_c
    difference_k = touch.start_c - object_c
    name = touch.trace.name
    if abs(difference_k) < LEAST_DIFFERENCE_K:
        raise ValueError(f"{name}: plate {touch.start_c:.2f} C and object {object_c:.2f} C are too close to calibrate")
    response = ThermalResponse(0.0, touch.start_c, times_s)
    fits: list[ExponentialFit | None] = []
    for since_s, sensor_c, _ in touch.readings():
        try:
            if response.step(since_s, sensor_c):
                fits.append(response.fit())
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
    drops_k, offset_k = np.array(response.drops_k), object_c - around_c
    gains = drops_k / difference_k
    for _ in range(ITERATIONS):
        gains = (drops_k - offset_k * drift(gains, times_s, leak_per_s)) / difference_k
    return _Course(gains, fits, object_c, offset_k)


def _noise_k(touches: list[RecordedTouch]) -> float:
    """White noise of one averaged drop, from differences of readings before contact, K."""
    before = [touch.trace.sensor_c[: touch.first] for touch in touches if touch.first >= BEFORE]
    steps = np.concatenate([np.diff(readings) for readings in before]) if before else np.zeros(0)
    single_k = float(np.sqrt(np.mean(steps**2) / 2.0)) if len(steps) else 0.015
    return max(single_k * float(np.sqrt(1.0 / AVERAGE + 1.0 / BEFORE)), 0.004)


def _relative_scatter(courses: list[_Course]) -> Array:
    """Covariance of g over touches, as parts of its mean."""
    gains = np.array([course.gains for course in courses])
    mean = _safe(gains.mean(axis=0))
    return np.cov((gains / mean).T).reshape(len(mean), len(mean))


def _safe(mean: Array) -> Array:
    """A mean gain kept away from zero, which slow sensors show at the first times."""
    return np.where(np.abs(mean) < LEAST_GAIN, LEAST_GAIN, mean)


def _entry(label: str, courses: list[_Course], relative: Array, pooled: Array) -> MaterialEntry:
    """One material's row of the table."""
    n = len(courses)
    gains = np.array([course.gains for course in courses])
    mean = gains.mean(axis=0)
    # shrunk to the pooled covariance, widened by the uncertainty of the mean, and never singular
    covariance = ((n - 1) * relative + PRIOR_TOUCHES * pooled) / (n - 1 + PRIOR_TOUCHES) * (1.0 + 1.0 / n)
    covariance = (covariance + LEAST_SCATTER**2 * np.eye(len(mean))) * np.outer(_safe(mean), _safe(mean))
    offsets = np.array([course.offset_k for course in courses])
    rates: list[tuple[float, float, float]] = []
    for k in range(len(mean)):
        fits = [(course.fits[k], course.object_c) for course in courses]
        known = [(np.log(fit.rate_per_s), fit.object_c - object_c) for fit, object_c in fits if fit is not None]
        values = np.array(known) if known else np.array([[-np.log(TAU_GRID_S[-1]), 0.0]])
        rates.append((float(np.median(values[:, 0])), float(values[:, 0].std()), float(np.median(values[:, 1]))))
    return MaterialEntry(
        name=label,
        touches=n,
        gain_mean=mean.tolist(),
        gain_covariance=((covariance + covariance.T) / 2.0).tolist(),
        ln_rate=[rate for rate, _, _ in rates],
        ln_rate_sd=[sd for _, sd, _ in rates],
        object_bias_k=[bias for _, _, bias in rates],
        offset_k=float(offsets.mean()),
        offset_sd_k=max(float(offsets.std(ddof=1)), LEAST_OFFSET_SD_K),
    )
