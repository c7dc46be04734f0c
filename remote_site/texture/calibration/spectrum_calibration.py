"""Calibrates the table of surfaces from slow labelled strokes, and tests it on strokes that were left out."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.recorded.spectrum_table import SpectrumModel, SpectrumTable
from remote_site.texture.recorded.stroke_playback import FAST_HZ
from remote_site.texture.recorded.surface_spectrum import Along, Unevenness, bands, sensor_noise, spectrum, unevenness
from remote_site.traces.trace_files import StrokeTrace, TraceFile, read_labels, read_stroke
from remote_site.traces.units import stated_speed_m_s

Array = NDArray[np.float64]

SHRINKAGE = 0.1
"""Fraction of the covariance between bands that is discarded, because few strokes cannot show it."""
LEAST_SD = 0.1
"""Minimum standard deviation of ln power."""
SAME_LOAD = 0.05
"""Largest relative difference between neighbours, sorted by load, that belong to one pressure setting."""


@dataclass(frozen=True, slots=True)
class LabelledStroke:
    """A stroke, its surface, and its speed, m/s, if the recording has none."""

    trace: StrokeTrace
    surface: str
    speed_m_s: float | None


@dataclass(frozen=True, slots=True)
class SpectrumFit:
    """A calibration.

    Attributes:
        table: calibrated table.
        left_out: label and answer (the nearest surface) of each stroke, by a table made without all strokes of its
            load. For a surface with one load only, the table is made without that stroke. A surface's only stroke is
            not tested.
        by_load: whether any surface was stroked with several loads.
        without_speed: names of the strokes of unknown speed; a single one leaves out the speeds of all.
    """

    table: SpectrumTable
    left_out: list[tuple[str, str]]
    by_load: bool
    without_speed: list[str]


def of_slow_strokes(folder: Path, signal: str | None) -> bool:
    """Return whether the first stroke of FOLDER/labels.csv is too slow for the online identification.

    Raises:
        ValueError: a file cannot be used; the message names file, line and column.
    """
    return read_stroke(read_labels(folder, "surface")[0][0], signal).rate_hz < FAST_HZ


def read_labelled(folder: Path, signal: str | None, speed_mm_s: float | None) -> list[LabelledStroke]:
    """Read the strokes that FOLDER/labels.csv names (`file,surface` and, where it is known, `speed_mm_s`).

    Args:
        folder: holds labels.csv and the strokes.
        signal: name of a column. `best` and `mean` both read all signals, because a mean loses what passes the
            signals one after the other.
        speed_mm_s: speed of strokes without one in labels.csv or in the recording, mm/s.

    Raises:
        ValueError: a file cannot be used, or there is a column `roughness_um`; the message names file, line and column.
            Or the speed cannot be one.
    """
    if "roughness_um" in TraceFile(folder / "labels.csv").names:
        raise ValueError(
            f"{folder / 'labels.csv'}: column roughness_um: strokes below {FAST_HZ:.0f} samples/s show no roughness; "
            "remove the column"
        )
    strokes, stated_m_s = [], stated_speed_m_s(speed_mm_s)
    for path, surface, own in read_labels(folder, "surface", "speed_mm_s"):
        trace = read_stroke(path, "best" if signal == "mean" else signal)
        if trace.rate_hz >= FAST_HZ:
            raise ValueError(f"{path}: {trace.rate_hz:.0f} samples/s among strokes below {FAST_HZ:.0f}")
        strokes.append(LabelledStroke(trace, surface, stated_m_s if own is None else own / 1000.0))
    return strokes


def calibrate_spectra(
    strokes: Sequence[LabelledStroke], *, sensor_serial: str = "unknown", made_on: str = ""
) -> SpectrumFit:
    """Learn surfaces from labelled slow strokes.

    One model measures the path in metres, if all speeds are known. Another needs no speed and measures it in seconds
    or in parts of a stroke, whichever identifies left-out strokes better.

    Raises:
        ValueError: strokes are flat, too short or too coarse, or have different numbers of signals.
    """
    signals = {stroke.trace.signals.shape[1] for stroke in strokes}
    if len(signals) != 1:
        raise ValueError(f"strokes have {', '.join(map(str, sorted(signals)))} signals; all must have the same columns")
    for stroke in strokes:
        if unevenness(stroke.trace, "s") is None:
            raise ValueError(f"{stroke.trace.name}: no signal in it moves, or it has too few samples")
    with_speed = _tried(strokes, "m")
    without = [tried for along in ("stroke", "s") if (tried := _tried(strokes, along)) is not None]
    found = [tried for tried in (with_speed, max(without, key=lambda tried: tried.surety, default=None)) if tried]
    table = SpectrumTable(
        surfaces=list(dict.fromkeys(stroke.surface for stroke in strokes)),
        signals=signals.pop(),
        models=[tried.model for tried in found],
        sensor_serial=sensor_serial,
        made_on=made_on,
    )
    without_speed = [one.trace.name for one in strokes if one.trace.speed_m_s is None and one.speed_m_s is None]
    return SpectrumFit(table, found[0].left_out, found[0].by_load, without_speed)


@dataclass(frozen=True, slots=True)
class _Tried:
    model: SpectrumModel
    left_out: list[tuple[str, str]]
    by_load: bool
    surety: float


def _tried(strokes: Sequence[LabelledStroke], along: Along) -> _Tried | None:
    """Return a model along one measure of the path, with its result on left-out strokes; None if a stroke lacks it."""
    seen = [unevenness(stroke.trace, along, stroke.speed_m_s) for stroke in strokes]
    whole = [one for one in seen if one is not None]
    if len(whole) < len(strokes):
        return None
    try:
        edges = bands(whole)
    except ValueError as error:
        pairs = list(zip(whole, strokes, strict=True))
        _, shortest = min(pairs, key=lambda pair: pair[0].length)
        _, coarsest = max(pairs, key=lambda pair: pair[0].step)
        raise ValueError(
            f"{shortest.trace.name} is the shortest and {coarsest.trace.name} the coarsest stroke: {error}"
        ) from None
    noise = sensor_noise(whole, strokes[0].trace.signals.shape[1])
    spectra = [spectrum(one, edges, noise) for one in whole]
    labels = np.array([stroke.surface for stroke in strokes])
    loads = _loads(whole)
    left_out, distances, sureties = [], [], []
    by_load = False
    models: dict[bytes, SpectrumModel] = {}
    for k, label in enumerate(labels):
        others = np.flatnonzero(loads != loads[k])
        if label in labels[others]:
            by_load = True
        else:
            others = np.flatnonzero(np.arange(len(labels)) != k)
        if label not in labels[others]:
            continue
        if others.tobytes() not in models:
            rest = [spectra[other] for other in others]
            models[others.tobytes()] = learned(rest, labels[others], along, edges, noise)
        found = models[others.tobytes()].distances(spectra[k])
        if found is not None:
            known = list(dict.fromkeys(labels[others]))
            left_out.append((str(label), str(known[int(np.argmin(found[0]))])))
            own = found[0][known.index(label)]
            distances.append(own / found[1])
            sureties.append(-0.5 * own - np.logaddexp.reduce(-0.5 * found[0]))
    model = learned(spectra, labels, along, edges, noise)
    misfit = max(1.0, float(np.mean(distances))) if distances else 1.0
    surety = float(np.mean(sureties)) if sureties else -np.inf
    return _Tried(model.model_copy(update={"misfit": misfit}), left_out, by_load, surety)


def _loads(strokes: Sequence[Unevenness]) -> NDArray[np.intp]:
    """Return the number of each stroke's pressure setting, from its load."""
    load = np.log([stroke.loads.mean() for stroke in strokes])
    order = np.argsort(load)
    numbers = np.empty(len(strokes), dtype=np.intp)
    numbers[order] = np.concatenate(([0], np.cumsum(np.diff(load[order]) > SAME_LOAD)))
    return numbers


def learned(
    spectra: Sequence[Array], labels: NDArray[np.str_], along: Along, edges: Array, noise: Array
) -> SpectrumModel:
    """Return a model of labelled spectra.

    Args:
        spectra: ln power of each stroke, pieces x bands; at least one stroke.
        labels: labels of the strokes.
        along: measure of the path.
        edges: edges of the bands, 1 over the unit of the path.
        noise: standard deviation of each signal's noise, whose power was subtracted.
    """
    names = list(dict.fromkeys(labels))
    strokes = np.array([pieces.mean(axis=0) for pieces in spectra])
    means = np.array([strokes[labels == name].mean(axis=0) for name in names])
    scatter = strokes - means[[names.index(name) for name in labels]]
    places = np.concatenate([pieces - pieces.mean(axis=0) for pieces in spectra])
    return SpectrumModel(
        along=along,
        edges=edges.tolist(),
        noise=noise.tolist(),
        means=means.tolist(),
        between_strokes=(_covariance(scatter, len(names)) + LEAST_SD**2 * np.eye(len(edges) - 1)).tolist(),
        between_places=_covariance(places, len(spectra)).tolist(),
    )


def _covariance(deviations: Array, means_taken: int) -> Array:
    whole = deviations.T @ deviations / max(len(deviations) - means_taken, 1)
    return np.asarray((1.0 - SHRINKAGE) * whole + SHRINKAGE * np.diag(np.diag(whole)))
