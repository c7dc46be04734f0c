"""Calibrates the thermal look-up table from labelled touches."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from common.runtime.parallel_map import Map, Progress, kept_processes, unseen
from remote_site.thermal.calibration.calibration_touches import (
    KNOWN_OBJECT_SD_K,
    UNKNOWN_OBJECT_SD_K,
    CalibrationReadings,
    CalibrationTouch,
)
from remote_site.thermal.calibration.discrepancy_fit import Labelled, Seen, courses, learn
from remote_site.thermal.calibration.population_fit import Population, fit_populations
from remote_site.thermal.calibration.usable_touch import (
    begins_in_contact,
    check_difference,
    check_gaps,
    contact_length_s,
    lacks_reference,
    touch_of,
    without_reference,
)
from remote_site.thermal.exponential_response import TAU_GRID_S, ExponentialResponse
from remote_site.thermal.material_table import RATE_TIMES_S, MaterialEntry, MaterialTable
from remote_site.thermal.touch_model import PLATE_J_M2K
from remote_site.thermal.touch_start import READING_S, RecordedTouch, reference_touch
from remote_site.traces.trace_files import ThermalTrace, read_labels, read_thermal

Array = NDArray[np.float64]

AIR = "air"
"""Label of a free cool-down, which shows no material but the leak."""
FEWEST = 2
"""Minimum number of touches of a material."""
GOOD = 10
"""Minimum number of touches of a material with a known scatter."""
SHORTEST_S = 0.5
"""Minimum duration of a touch, s."""
LONGEST_S = 6.0
"""Duration after contact from which readings are used, s; later ones show more of what the model leaves out."""
USUAL_LEAK_PER_S = 0.04
"""Leak if no free cool-down was recorded, 1/s."""
LEAST_LEAK_PER_S, LARGEST_LEAK_PER_S = 0.001, 0.5
"""Range of the leak that a free cool-down can show, 1/s."""
LEAST_OFFSET_SD_K = 1.0
"""Minimum standard deviation of object minus ambient temperature in the table, K."""
LARGEST_NOISE_K, LARGEST_LN_SD = 1.0, 100.0
"""Largest noise of a reading, K, and scatter of ln effusivity of a material in a fit; few touches leave metals open."""
MISFIT = 2.0
"""Mean square of the residuals, over the noise's variance, above which the model does not fit the sensor."""
UNLIKE = 3.0
"""Rms residual of a touch over the median of all touches, above which its recording is in doubt."""
ALIKE = 1.5
"""Distance of two materials, in standard deviations of a touch, below which a fifth of their touches is confused."""
SCATTERED_LN_SD = 1.0
"""Scatter of ln effusivity of a material above which one of its labels is in doubt."""


@dataclass(frozen=True, slots=True)
class ThermalFit:
    """A table and the residuals of its touches.

    Attributes:
        table: the table.
        names: material of each touch.
        times_s: (k,) times of the residuals after contact, s.
        residual_k: (touches, k) residuals of the model, K; those of a mean are scaled to one reading.
        seen: evidence of the touches without discrepancy, by time after contact, s.
        shortest: name of the shortest trace.
        in_contact: names of the traces that begin in contact.
        unlike: names of the traces that the model fits much worse than the others.
        no_reference: names of the traces without an unheated sensor, if others have one.
    """

    table: MaterialTable
    names: list[str]
    times_s: Array
    residual_k: Array
    seen: dict[float, list[Seen]] = field(repr=False)
    shortest: str = ""
    in_contact: list[str] = field(default_factory=list)
    unlike: list[str] = field(default_factory=list)
    no_reference: list[str] = field(default_factory=list)

    @property
    def before(self) -> MaterialTable:
        """The table before its discrepancy was learned."""
        return self.table.model_copy(update={"discrepancy": None})

    @property
    def warnings(self) -> list[str]:
        """Limits of the table that a user should know, one line each."""
        found = [
            f"{entry.name}: the model does not fit this sensor on it (misfit {entry.misfit:.1f}, 1 is a perfect fit); "
            f"identification {self._consequence(number)}"
            for number, entry in enumerate(self.table.materials)
            if entry.misfit > MISFIT
        ]
        if self.table.lasts_s < LONGEST_S:
            found.append(
                f"{self.shortest} lasts only {self.table.lasts_s:.2f} s after contact: later readings of all touches "
                f"were not used, and an object is judged for {self.table.lasts_s:.2f} s; {LONGEST_S:g} s are better"
            )
        if self.no_reference:
            dropped = "the unheated sensor of the others was not calibrated; add the column, or leave these touches out"
            found.append(lacks_reference(self.no_reference, len(self.names), dropped))
        found += [begins_in_contact(name) for name in self.in_contact]
        found += [
            f"{name}: the model fits this touch much worse than the others; check its readings, label and object_c, or "
            "leave it out"
            for name in self.unlike
        ]
        found += [
            f"{entry.name}: its touches differ in effusivity by a factor of {np.exp(scatter):.1f}; check their labels, "
            "or touch it more often"
            for entry in self.table.materials
            if (scatter := entry.covariance[0][0] ** 0.5) > SCATTERED_LN_SD
        ]
        found += [
            f"this sensor cannot distinguish {one.name} and {other.name}; give them one label, or both stay ambiguous"
            for one, other in combinations(self.table.materials, 2)
            if _distance(one, other) < ALIKE
        ]
        return found + [
            f"{entry.name}: only {entry.touches} touches; its scatter needs {GOOD} or more"
            for entry in self.table.materials
            if entry.touches < GOOD
        ]

    def _consequence(self, number: int) -> str:
        """Return the consequence of a misfit for the touches of a material."""
        if self.table.discrepancy is not None and self.table.discrepancy.known_objects[number]:
            return "subtracts the error that these touches showed, and its +- covers the rest"
        return "cannot correct the temperature, because these objects' temperatures are not known; its +- is wide"


def _distance(one: MaterialEntry, other: MaterialEntry) -> float:
    """Return the distance of two materials by effusivity and conductance, in standard deviations of a touch."""
    covariance = 0.5 * (np.array(one.covariance) + np.array(other.covariance))
    apart = np.array([one.ln_effusivity - other.ln_effusivity, one.ln_conductance - other.ln_conductance])
    return float(np.sqrt(apart @ np.linalg.solve(covariance, apart)))


def calibrate_thermal(
    folder: Path,
    out: Path,
    *,
    sensor_serial: str = "unknown",
    made_on: str = "",
    processes: int = 1,
    progress: Progress = unseen,
) -> ThermalFit:
    """Make a look-up table from FOLDER/labels.csv (`file,material[,object_c]`) and write it to `out`.

    Args:
        folder: holds labels.csv and the traces it names; the label `air` is a free cool-down.
        out: file to write.
        sensor_serial: serial number of the sensor that recorded the traces.
        made_on: ISO date of the calibration.
        processes: number of processes that share the work; the table does not depend on it.
        progress: is called with the completed share of the longest possible fit.

    Raises:
        ValueError: a file cannot be used; the message names file, line and column.
    """
    labelled = [
        (label, read_thermal(path), object_c) for path, label, object_c in read_labels(folder, "material", "object_c")
    ]
    fit = calibrate_traces(labelled, f"{folder / 'labels.csv'}", processes=processes, progress=progress)
    table = fit.table.model_copy(update={"sensor_serial": sensor_serial, "made_on": made_on})
    table.save(out)
    return replace(fit, table=table)


def calibrate_traces(
    labelled: Iterable[tuple[str, ThermalTrace, float | None]],
    where: str = "labels",
    *,
    processes: int = 1,
    progress: Progress = unseen,
) -> ThermalFit:
    """Make a look-up table from labelled touches.

    Args:
        labelled: label, trace, and temperature of the object, C, or None if unknown; the label `air` is a free
            cool-down.
        where: source of the labels, for messages.
        processes: number of processes that share the work; the table does not depend on it.
        progress: is called with the completed share of the longest possible fit.

    Raises:
        ValueError: a trace has no contact or is no cool-down, or as `fit_thermal`.
    """
    leaks: list[float] = []
    touches: dict[str, list[tuple[RecordedTouch, float | None]]] = {}
    for label, trace, object_c in labelled:
        if label.casefold() == AIR:
            leaks.append(_leak_per_s(trace))
            continue
        touches.setdefault(label, []).append((touch_of(trace), object_c))
    leak_per_s = float(np.mean(leaks)) if leaks else USUAL_LEAK_PER_S
    with kept_processes(processes) as mapped:
        return fit_thermal(where, touches, leak_per_s, mapped, progress)


def _leak_per_s(trace: ThermalTrace) -> float:
    """Return the rate of a free cool-down to ambient, 1/s."""
    around = trace.ambient_c if trace.ambient_c is not None else trace.reference_c
    if around is None:
        raise ValueError(f"{trace.name}: column ambient_c is missing: a free cool-down needs it")
    # the heater may hold the plate at first; in the last three quarters it is free
    free = trace.time_s >= trace.time_s[0] + 0.25 * (trace.time_s[-1] - trace.time_s[0])
    above = (trace.sensor_c - around)[free]
    if trace.contact() is not None:
        raise ValueError(
            f"{trace.name}: column force_n: a free cool-down touches nothing, this one does; check its label"
        )
    if not above.min() > 0.5:
        raise ValueError(
            f"{trace.name}: column sensor_c: a free cool-down stays 0.5 K above ambient, this one does not"
        )
    slope = float(np.polyfit(trace.time_s[free], np.log(above), 1)[0])
    if not LEAST_LEAK_PER_S <= -slope <= LARGEST_LEAK_PER_S:
        raise ValueError(
            f"{trace.name}: column sensor_c: a free cool-down loses {100 * LEAST_LEAK_PER_S:g} to "
            f"{100 * LARGEST_LEAK_PER_S:g} % of its height above ambient in a second, this one {-100.0 * slope:.2g} %; "
            "record it with the heater off"
        )
    return -slope


def fit_thermal(
    where: str,
    touches: dict[str, list[tuple[RecordedTouch, float | None]]],
    leak_per_s: float,
    mapped: Map = map,
    progress: Progress = unseen,
) -> ThermalFit:
    """Fit the table to labelled touches.

    Args:
        where: source of the labels, for messages.
        touches: touches of each material, each with the temperature of its object, C, or None if unknown.
        leak_per_s: rate of a free cool-down, 1/s.
        mapped: the function `map`, or a parallel one, that computes courses of touches.
        progress: is called with the completed share of the longest possible fit.

    Raises:
        ValueError: too few materials or touches, a touch too short, one without temperature difference, or touches that
            no material fits.
    """
    if len(touches) < 2:
        raise ValueError(f"{where}: column material: two materials or more are needed, there are {len(touches)}")
    for label, listed in touches.items():
        if len(listed) < FEWEST:
            raise ValueError(f"{where}: column material: {label} has {len(listed)} touch, needs {FEWEST} or more")
    everyone = [touch for listed in touches.values() for touch, _ in listed]
    shortest = min(everyone, key=contact_length_s)
    name, length_s = shortest.trace.name, contact_length_s(shortest)
    if length_s < SHORTEST_S:
        raise ValueError(f"{where}: {name} lasts {length_s:.2f} s after contact, needs {SHORTEST_S} s or more")
    for touch in everyone:
        check_gaps(touch, min(length_s, LONGEST_S))
    in_contact = [touch.trace.name for touch in everyone if touch.first == 0]
    if bare := without_reference(everyone):
        fit, _ = _fit(where, touches, leak_per_s, length_s, None, mapped, progress)
        no_reference = bare if len(bare) < len(everyone) else []
        return replace(fit, shortest=name, in_contact=in_contact, no_reference=no_reference)
    beside = {
        label: [(reference_touch(touch), object_c) for touch, object_c in listed] for label, listed in touches.items()
    }
    reference, other = _fit(where, beside, USUAL_LEAK_PER_S, length_s, None, mapped, lambda share: progress(share / 2))
    # a sensor that starts at ambient gives the best temperature of the object
    fit, _ = _fit(where, touches, leak_per_s, length_s, other, mapped, lambda share: progress((1 + share) / 2))
    return replace(
        fit, table=fit.table.model_copy(update={"reference": reference.table}), shortest=name, in_contact=in_contact
    )


def _fit(
    where: str,
    touches: dict[str, list[tuple[RecordedTouch, float | None]]],
    leak_per_s: float,
    length_s: float,
    other: Population | None,
    mapped: Map,
    progress: Progress,
) -> tuple[ThermalFit, Population]:
    """Fit one sensor; `other` is the fit of another sensor beside it, which touched the same objects."""
    everyone = [touch for listed in touches.values() for touch, _ in listed]
    ambients = [touch.ambient_c for touch in everyone if touch.ambient_c is not None]
    if not ambients and any(object_c is None for listed in touches.values() for _, object_c in listed):
        raise ValueError(f"{where}: column object_c: needed where the traces have no ambient_c")
    objects = [object_c for listed in touches.values() for _, object_c in listed if object_c is not None]
    ambient_c = float(np.mean(ambients or objects))
    readings = round(min(length_s, LONGEST_S) / READING_S)
    each = [
        _calibration_touch(number, touch, object_c, ambient_c, readings)
        for number, listed in enumerate(touches.values())
        for touch, object_c in listed
    ]
    stated = np.array([touch.object_sd_k == KNOWN_OBJECT_SD_K for touch in each])
    if other is not None:
        each = [
            touch
            if known
            else replace(touch, object_c=touch.ambient_c + float(object_k), object_sd_k=float(object_sd_k))
            for touch, known, object_k, object_sd_k in zip(each, stated, other.object_k, other.object_sd_k, strict=True)
        ]
    means = CalibrationReadings.of(each)
    population = fit_populations(means, len(touches), leak_per_s, mapped, progress)
    scatter = np.sqrt(np.einsum("mii->mi", population.covariance)).max()
    if not (population.noise_k < LARGEST_NOISE_K and scatter < LARGEST_LN_SD):
        raise ValueError(
            f"{where}: no possible material fits these touches; check the labels, object_c, and that each trace is of "
            "this sensor and begins before contact"
        )
    times_s = [t for t in RATE_TIMES_S if t <= length_s + 1e-6]
    material = np.array([touch.material for touch in each])
    offsets = np.array([touch.object_c - touch.ambient_c for touch in each])
    offsets = np.where(stated, offsets, population.object_k)
    table = MaterialTable(
        ambient_c=ambient_c,
        plate_j_m2k=PLATE_J_M2K,
        leak_per_s=population.sensor.leak_per_s,
        half_force_n=population.sensor.half_force_n,
        force_power=population.sensor.force_power,
        early_s=population.sensor.early_s,
        back_share=population.back_share,
        back_sd_k=population.back_sd_k,
        start_sd_k=population.start_sd_k,
        ln_lag=population.ln_lag,
        ln_lag_sd=population.ln_lag_sd,
        noise_k=population.noise_k,
        lasts_s=READING_S * readings,
        times_s=times_s,
        materials=[
            _entry(label, number, listed, population, offsets[material == number], times_s)
            for number, (label, listed) in enumerate(touches.items())
        ],
    )
    labelled = [
        Labelled(touch, number, object_c)
        for number, listed in enumerate(touches.values())
        for touch, object_c in listed
    ]
    seen = courses(table, labelled, mapped)
    table = table.model_copy(update={"discrepancy": learn(table, seen)})
    names = list(touches)
    residual_k = population.residual_k * np.sqrt(means.count)
    rms_k = np.sqrt(np.mean(residual_k**2, axis=1))
    unlike = [one.touch.trace.name for one, k in zip(labelled, rms_k, strict=True) if k > UNLIKE * np.median(rms_k)]
    labels = [names[touch.material] for touch in each]
    return ThermalFit(table, labels, means.times_s, residual_k, seen, unlike=unlike), population


def _calibration_touch(
    material: int, touch: RecordedTouch, object_c: float | None, ambient_c: float, readings: int
) -> CalibrationTouch:
    """Resample a touch to 100 Hz."""
    around_c = ambient_c if touch.ambient_c is None else touch.ambient_c
    trace = touch.trace
    if object_c is not None:
        check_difference(touch, object_c)
    time_s = touch.contact_s + READING_S * np.arange(1, readings + 1)
    return CalibrationTouch(
        material,
        np.interp(time_s, trace.time_s, trace.sensor_c),
        np.interp(time_s, trace.time_s, trace.force_n),
        touch.start_c,
        touch.slope_k_s,
        around_c,
        around_c if object_c is None else object_c,
        UNKNOWN_OBJECT_SD_K if object_c is None else KNOWN_OBJECT_SD_K,
    )


def _entry(
    label: str,
    number: int,
    listed: list[tuple[RecordedTouch, float | None]],
    population: Population,
    offsets_k: Array,
    times_s: list[float],
) -> MaterialEntry:
    """Return one material's row of the table."""
    rates = np.array([_ln_rates(touch, times_s) for touch, _ in listed])
    known = np.isfinite(rates)
    ln_rate, ln_rate_sd = [], []
    for k in range(len(times_s)):
        values = rates[known[:, k], k]
        ln_rate.append(float(np.median(values)) if len(values) else -float(np.log(TAU_GRID_S[-1])))
        ln_rate_sd.append(float(values.std()) if len(values) else 0.0)
    slab_s = float(population.slab_s[number])
    return MaterialEntry(
        name=label,
        touches=len(listed),
        ln_effusivity=float(population.mean[number, 0]),
        ln_conductance=float(population.mean[number, 1]),
        covariance=population.covariance[number].tolist(),
        slab_s=slab_s if np.isfinite(slab_s) else None,
        offset_k=float(offsets_k.mean()),
        offset_sd_k=max(float(offsets_k.std(ddof=1)), LEAST_OFFSET_SD_K),
        ln_rate=ln_rate,
        ln_rate_sd=ln_rate_sd,
        misfit=float(population.misfit[number]),
    )


def _ln_rates(touch: RecordedTouch, times_s: list[float]) -> list[float]:
    """Return ln(rate of Eq. 11 in 1/s) of the readings up to each time; NaN without a fit."""
    response = ExponentialResponse(touch.start_c)
    rates: list[float] = []
    for since_s, sensor_c, _ in touch.readings():
        while len(rates) < len(times_s) and since_s > times_s[len(rates)] + 1e-9:
            fit = response.fit()
            rates.append(np.nan if fit is None else float(np.log(fit.rate_per_s)))
        response.add(since_s, sensor_c)
    while len(rates) < len(times_s):
        fit = response.fit()
        rates.append(np.nan if fit is None else float(np.log(fit.rate_per_s)))
    return rates
