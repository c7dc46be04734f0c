"""Strokes of a slow sensor: periods of grooved boards, and fabrics at a pressure not learned from.

The recordings are by others: 16 capacitive taxels at 35.7 samples/s. The fabrics have flaws as a test, which are
treated as follows:

- Each fabric was mounted once and stroked along one track. The unevenness of this piece along the track, and the place
  of the load on the taxels, identify the piece and not the fabric. Strokes are therefore also judged over the half of
  the track that was not learned from.
- Random splits leave near copies of each stroke to learn from. Their results are shown as a warning.
- One pressure setting in turn is left out. Choices were made with tables of one setting tried on another.

The periods have two more tests: made-up strokes at 2 to 30 mm/s that stick and slip, and changed recordings.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.calibration.spectrum_calibration import LabelledStroke, calibrate_spectra, learned
from remote_site.texture.recorded.spatial_period import spatial_period
from remote_site.texture.recorded.surface_spectrum import MOTIONS, Along, bands, sensor_noise, spectrum, unevenness
from remote_site.traces.trace_files import StrokeTrace, read_stroke
from studies.compared import Compared
from studies.counting import share
from studies.pieces import HERE, Piece, Work, results_of
from studies.recorded_strokes.made_strokes import SPEEDS_MM_S
from studies.recorded_strokes.periods import WITHIN, WRONG, Board, changed_boards, made_periods, pooled
from studies.running import Progress, Unavailable, data_folder
from studies.texture.baselines import band_powers, classifiers, moments

Array = NDArray[np.float64]
Row = dict[str, Any]
Answers = NDArray[np.str_]

SHIPPED = "shipped"
_MADE, _MADE_QUICK = 120, 12
BOARD = re.compile(r"board(\d+)mm_force(\d+)_speed(\d+)mmps")
FABRIC = re.compile(r"(\w+?)_force(\d+)_speed(\d+)mmps_\d+")
_FOLDS = 5
COMPARED = (
    Compared("accuracy", "share", "more", ("split", "group"), {"method": SHIPPED}, counted="strokes"),
    Compared("taxels", "within_1_percent", "more"),
    Compared("made_periods", "wrong", "less", ("signals", "motion")),
    Compared("made_periods", "inside_95_share", "more", ("signals", "motion"), counted="answers"),
)


@dataclass(frozen=True, slots=True)
class Stroke:
    """A recorded stroke: its trace, its speed, m/s, the pressure setting, and its surface."""

    trace: StrokeTrace
    speed_m_s: float
    setting: int
    surface: str

    @property
    def board(self) -> Board:
        """The stroke over a grooved board; its surface is the width of a groove, mm."""
        time_s = self.trace.time_s
        return Board(self.speed_m_s * time_s, self.trace.signals, time_s, 2.0 * float(self.surface))


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Periods of all boards, and fabrics by the shipped method and the classic ones on the same splits.

    Args:
        quick: fewer baselines, no ablations.
        seed: seed of the random forests and random splits.

    Raises:
        Unavailable: there are no such recordings.
        ValueError: a recording cannot be read.
    """
    board_strokes = read_strokes(data_folder("groove_boards"), BOARD)
    fabrics = read_strokes(data_folder("fabric_strokes"), FABRIC)
    pieces: dict[str, list[Piece]] = {
        "boards": [(boards, (board_strokes,))],
        "taxels": [(taxels, (board_strokes,))],
        "changed": [(changed_boards, ([stroke.board for stroke in board_strokes], seed))],
        "made": [(made_periods, (speed, _MADE_QUICK if quick else _MADE, seed)) for speed in SPEEDS_MM_S],
        "methods": [(_fabrics, (fabrics, name, seed)) for name in _methods(quick, seed)],
    }
    found = results_of(pieces, work, progress)
    by_speed = [row for rows in found["made"] for row in rows]
    return {
        "surfaces": sorted({stroke.surface for stroke in fabrics}),
        "boards": found["boards"][0],
        "taxels": found["taxels"][0],
        "changed_boards": found["changed"][0],
        "made_periods": pooled(by_speed),
        "made_by_speed": by_speed,
        "accuracy": [row for rows, _ in found["methods"] for row in rows],
        "errors": [row for _, wrong in found["methods"] for row in wrong],
    }


def _fabrics(fabrics: Sequence[Stroke], name: str, seed: int) -> tuple[list[Row], list[Row]]:
    """Right answers of a method, by split; and errors of the shipped method with a setting left out."""
    method = _methods(False, seed)[name]
    accuracy: list[Row] = []
    confusion: list[Row] = []
    for split, groups in splits(fabrics, seed).items():
        rows, wrong = judged(fabrics, groups, method)
        accuracy += [{"method": name, "split": split, **row} for row in rows]
        if name == SHIPPED and split == "setting left out":
            confusion = wrong
    accuracy += [{"method": name, "split": "one setting learned", **row} for row in _one_setting(fabrics, method)]
    accuracy += [{"method": name, "split": "other half", **row} for row in _other_half(fabrics, method)]
    return accuracy, confusion


def tables(data: Mapping[str, Any]) -> dict[str, list[Row]]:
    """Parts of the result that are tables, by name."""
    return {
        "boards": data["boards"],
        "changed-boards": data["changed_boards"],
        "made-by-speed": data["made_by_speed"],
        "fabrics": data["accuracy"],
        "fabric-errors": data["errors"],
    }


def read_strokes(folder: Path, name: re.Pattern[str]) -> list[Stroke]:
    """All strokes of a folder; their names give surface (or groove width, mm), setting and speed (mm/s).

    Raises:
        Unavailable: there are none.
    """
    named = [(path, match) for path in sorted(folder.glob("*.csv")) if (match := name.fullmatch(path.stem))]
    if not named:
        raise Unavailable(f"there are no recordings in {folder}")
    return [Stroke(read_stroke(path, "best"), float(m[3]) / 1000.0, int(m[2]), m[1]) for path, m in named]


def boards(strokes: Sequence[Stroke]) -> list[Row]:
    """Period of each stroke from the best taxel and from the mean of all, beside the truth."""
    rows = []
    for stroke in strokes:
        path_m, signals, _, true_mm = stroke.board
        for signal, values in (("best", signals), ("mean", signals.mean(axis=1, keepdims=True))):
            found = spatial_period(path_m, values, signals)
            row: Row = {"stroke": Path(stroke.trace.name).name, "signal": signal, "true_mm": true_mm}
            row |= dict.fromkeys(("period_mm", "period_sd_mm", "error_percent", "error_sds", "taxel"))
            if found is not None:
                period_mm, sd_mm = 1e3 * found[0].period_m, 1e3 * found[0].period_sd_m
                row |= {"period_mm": period_mm, "period_sd_mm": sd_mm, "error_sds": (period_mm - true_mm) / sd_mm}
                row |= {"error_percent": 100.0 * (period_mm / true_mm - 1.0)}
                row |= {"taxel": stroke.trace.signal_names[found[1]] if signal == "best" else None}
            rows.append(row)
    return rows


def taxels(strokes: Sequence[Stroke]) -> dict[str, float]:
    """Each taxel of each board by itself: counts of those that show its period, and calibration of the deviation."""
    nothing, other, errors, sds = 0, 0, [], []
    for stroke in strokes:
        path_m, signals, _, _ = stroke.board
        true_m = 2e-3 * float(stroke.surface)
        for column in signals.T:
            found = spatial_period(path_m, column[:, None])
            if found is None:
                nothing += 1
            elif (error := abs(found[0].period_m / true_m - 1.0)) > WRONG:
                other += 1
            else:
                errors.append(error)
                sds.append(abs(found[0].period_m - true_m) / found[0].period_sd_m)
    return {
        "none": nothing,
        "another_line": other,
        "the_board": len(errors),
        "within_1_percent": sum(error < WITHIN for error in errors),
        "within_1_sd_share": float(np.mean(np.array(sds) < 1.0)),
        "within_2_sd_share": float(np.mean(np.array(sds) < 2.0)),
    }


Method = Callable[[Sequence[Stroke], Sequence[Stroke]], Answers]
"""Learns from strokes and names the surfaces of others."""


def shipped(learn: Sequence[Stroke], judge: Sequence[Stroke]) -> Answers:
    """Learn and name surfaces as `calibrate texture` and `identify texture` do."""
    table = calibrate_spectra([LabelledStroke(s.trace, s.surface, s.speed_m_s) for s in learn]).table
    found = [table.recognise(stroke.trace, stroke.speed_m_s) for stroke in judge]
    return np.array(["" if one is None else one.surface for one in found])


def varied(
    along: Along = "m", motions: int = MOTIONS, noise_off: bool = True, over_load: bool = True, taxel: int | None = None
) -> Method:
    """The shipped method with a part left out; it always answers the nearest surface."""

    def method(learn: Sequence[Stroke], judge: Sequence[Stroke]) -> Answers:
        def seen(strokes: Sequence[Stroke]) -> list[Any]:
            chosen = slice(None) if taxel is None else slice(taxel, taxel + 1)
            names = strokes[0].trace.signal_names[chosen]
            traces = [replace(s.trace, signals=s.trace.signals[:, chosen], signal_names=names) for s in strokes]
            return [unevenness(t, along, s.speed_m_s, motions) for t, s in zip(traces, strokes, strict=True)]

        first = seen(learn)
        labels = np.array([stroke.surface for stroke in learn])
        edges = bands(first)
        noise = sensor_noise(first, 16 if taxel is None else 1) * noise_off

        def spectra(strokes: Sequence[Any]) -> list[Array]:
            return [spectrum(s, edges, noise) + (0.0 if over_load else 2.0 * np.log(s.loads.mean())) for s in strokes]

        model = learned(spectra(first), labels, along, edges, noise)
        names = list(dict.fromkeys(labels))
        found = [model.distances(pieces) for pieces in spectra(seen(judge))]
        return np.array(["" if one is None else names[int(np.argmin(one[0]))] for one in found])

    return method


def classic(features: Callable[[StrokeTrace], Array], classifier: str, seed: int) -> Method:
    """Features and a classifier without knowledge of pressure, speed or space."""

    def method(learn: Sequence[Stroke], judge: Sequence[Stroke]) -> Answers:
        fitted = classifiers(seed)[classifier]
        fitted.fit(np.array([features(s.trace) for s in learn]), np.array([s.surface for s in learn]))
        return np.asarray(fitted.predict(np.array([features(s.trace) for s in judge])))

    return method


def _methods(quick: bool, seed: int) -> dict[str, Method]:
    features: dict[str, Callable[[StrokeTrace], Array]] = {
        "band powers": lambda trace: band_powers(trace.signals, trace.rate_hz),
        "moments": lambda trace: moments(trace.signals),
        "band powers of the mean": lambda trace: band_powers(trace.signals.mean(axis=1), trace.rate_hz),
        "moments of the mean": lambda trace: moments(trace.signals.mean(axis=1)),
    }
    found: dict[str, Method] = {SHIPPED: shipped}
    for name, feature in list(features.items())[: 2 if quick else None]:
        for classifier in classifiers(seed):
            found[f"{name}, {classifier}"] = classic(feature, classifier, seed)
    if not quick:
        found |= {
            "motions of the sensor left in": varied(motions=0),
            "only heaving taken away": varied(motions=1),
            "noise of the sensor left in": varied(noise_off=False),
            "not over the load": varied(over_load=False),
            "along time": varied(along="s"),
            "along the stroke, speed unknown": varied(along="stroke"),
            "one taxel": varied(taxel=9),
        }
    return found


def splits(strokes: Sequence[Stroke], seed: int) -> dict[str, NDArray[np.intp]]:
    """Group number of each stroke, by split; strokes of one group are left out together."""
    settings = np.array([stroke.setting for stroke in strokes])
    folds = np.random.default_rng(seed).permutation(len(strokes)) % _FOLDS
    return {"setting left out": settings, "at random": folds}


def judged(strokes: Sequence[Stroke], groups: NDArray[np.intp], method: Method) -> tuple[list[Row], list[Row]]:
    """Judge the strokes of each group by what was learned from the others; returns counts and wrong answers."""
    rows, wrong = [], []
    for group in np.unique(groups):
        learn = [s for s, own in zip(strokes, groups, strict=True) if own != group]
        judge = [s for s, own in zip(strokes, groups, strict=True) if own == group]
        said = method(learn, judge)
        rows.append({"group": int(group), **_counted(judge, said)})
        wrong += [
            {"stroke": Path(s.trace.name).name, "surface": s.surface, "said": str(name)}
            for s, name in zip(judge, said, strict=True)
            if name != s.surface
        ]
    return rows, wrong


def _one_setting(strokes: Sequence[Stroke], method: Method) -> Iterator[Row]:
    """Learn at one setting, and judge all strokes of the others that have the same surfaces."""
    for setting in sorted({stroke.setting for stroke in strokes}):
        learn = [stroke for stroke in strokes if stroke.setting == setting]
        known = {stroke.surface for stroke in learn}
        judge = [stroke for stroke in strokes if stroke.setting != setting and stroke.surface in known]
        yield {"group": setting, **_counted(judge, method(learn, judge))}


def _other_half(strokes: Sequence[Stroke], method: Method) -> Iterator[Row]:
    """Leave each setting out, learn over one half of the track and judge over the other, both ways together."""
    for setting in sorted({stroke.setting for stroke in strokes}):
        judged: list[Stroke] = []
        said: list[str] = []
        for first in (True, False):
            learn = [_half(stroke, first) for stroke in strokes if stroke.setting != setting]
            judge = [_half(stroke, not first) for stroke in strokes if stroke.setting == setting]
            judged += judge
            said += list(method(learn, judge))
        yield {"group": setting, **_counted(judged, said)}


def _half(stroke: Stroke, first: bool) -> Stroke:
    middle = len(stroke.trace.time_s) // 2
    part = slice(None, middle) if first else slice(middle, None)
    trace = replace(stroke.trace, time_s=stroke.trace.time_s[part], signals=stroke.trace.signals[part])
    return replace(stroke, trace=trace)


def _counted(strokes: Sequence[Stroke], said: Sequence[str] | Answers) -> Row:
    right = sum(stroke.surface == name for stroke, name in zip(strokes, said, strict=True))
    return {"right": right, "strokes": len(strokes), **share(right, len(strokes))}
