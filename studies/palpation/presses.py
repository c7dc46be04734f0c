"""Judges the stiffness of recorded presses: answers, prediction of deeper samples, and repeated presses."""

from collections.abc import Iterator, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from remote_site.stiffness.recorded.identify_stiffness import identify_presses
from remote_site.traces.press_files import Press
from studies.palpation.recordings import first

Array = NDArray[np.float64]
Row = dict[str, Any]

SAMPLES, LEARNED = 10, 7
"""Number of samples of a complete press, and of those from which the others are predicted."""
REPEAT_MM = 2.06
"""Depth to which repeated presses are compared, mm: 2 mm and the inaccuracy of a step."""
CONTACT_N = 0.08
"""Force of the robot's contact, N, in the classic stiffness with a known contact."""
LAW, LINE, HERTZ = "learned prior", "line", "Hertz"
KNOWN_CONTACT, SLOPE = "known contact", "slope"
_Key = Literal["stiffness_n_m", "stiffness_sd_n_m", "stiffness_repeat_sd_n_m"]


def answered(name: str, presses: Sequence[Press]) -> Iterator[Row]:
    """Yield a row with the counts of the statuses of a set."""
    answers = identify_presses(presses)
    counts = {status: sum(answer["status"] == status for answer in answers) for status in ("known", "uncertain")}
    yield {"set": name, "presses": len(presses), **counts, "failed": len(presses) - sum(counts.values())}


def predicted(name: str, material: str, presses: Sequence[Press]) -> list[Row]:
    """Predict the last samples of each complete press from the first ones; a row for each press and method."""
    answers = identify_presses([first(press, LEARNED) for press in presses])
    rows = []
    for press, answer in zip(presses, answers, strict=True):
        if len(press.depth_mm) != SAMPLES or answer["model"] is None or not np.all(press.force_n[LEARNED:] > 0.0):
            continue
        model, deep_mm, truth_n = answer["model"], press.depth_mm[LEARNED:], press.force_n[LEARNED:]
        law_n = np.interp(deep_mm, model["depth_mm"], model["force_n"])
        sd_n = np.interp(deep_mm, model["depth_mm"], model["force_sd_n"])
        known_mm, known_n = press.depth_mm[:LEARNED], press.force_n[:LEARNED]
        line_n = np.polyval(np.polyfit(known_mm, known_n, 1), deep_mm)
        bent = np.column_stack([np.maximum(known_mm, 0.0) ** 1.5, np.ones(LEARNED)])
        factor, offset = np.linalg.lstsq(bent, known_n, rcond=None)[0]
        methods = {LAW: law_n, LINE: line_n, HERTZ: factor * deep_mm**1.5 + offset}
        for method, force_n in methods.items():
            row = {"set": name, "material": material, "press": press.press, "method": method}
            row |= {"errors": np.abs(force_n / truth_n - 1.0).tolist(), "outside_2_sd": None}
            if method == LAW:
                row["outside_2_sd"] = int(np.sum(np.abs(law_n - truth_n) > 2.0 * sd_n))
            rows.append(row)
    return rows


def repeated(one: Sequence[Press], other: Sequence[Press]) -> list[Row]:
    """Compare two recordings of the same places to the same depth, by this method and two classic ones."""
    recordings = one, [first(press, press.depth_mm <= REPEAT_MM) for press in other]
    pressed = [{press.press: press for press in presses} for presses in recordings]
    answers = [{answer["press"]: answer for answer in identify_presses(presses)} for presses in recordings]
    both = [number for number in pressed[0] if number in pressed[1]]

    def of_law(key: _Key) -> list[Array]:
        return [np.array([found[number][key] or np.nan for number in both]) for found in answers]

    values = {LAW: of_law("stiffness_n_m")} | {
        method: [np.array([_classic(presses[number], method) for number in both]) for presses in pressed]
        for method in (KNOWN_CONTACT, SLOPE)
    }
    rows = []
    for method, (first_n_m, second_n_m) in values.items():
        ln_ratio = np.log(first_n_m / second_n_m)
        outside, outside_repeat = None, None
        if method == LAW:
            first_sd, second_sd = of_law("stiffness_sd_n_m")
            outside = _outside(ln_ratio, first_sd / first_n_m, second_sd / second_n_m)
            first_sd, second_sd = of_law("stiffness_repeat_sd_n_m")
            outside_repeat = _outside(ln_ratio, first_sd / first_n_m, second_sd / second_n_m)
        rows.append(
            {
                "method": method,
                "pairs": len(ln_ratio),
                "cv": float(np.sqrt(0.5 * np.mean(ln_ratio**2))),
                "icc": intraclass_correlation(first_n_m, second_n_m),
                "outside_2_sd": outside,
                "outside_2_repeat_sd": outside_repeat,
            }
        )
    return rows


def _outside(ln_ratio: Array, *ln_sds: Array) -> float:
    """Return the share of pairs that differ by more than two standard deviations of ln stiffness."""
    return float(np.mean(np.abs(ln_ratio) > 2.0 * np.hypot(*ln_sds)))


def intraclass_correlation(one: Array, other: Array) -> float:
    """Return the share of the variance that is between places, of two measurements of each (ICC(1), one-way)."""
    both = np.column_stack([one, other])
    between = 2.0 * np.var(both.mean(axis=1), ddof=1)
    within = float(np.mean(np.var(both, axis=1, ddof=1)))
    return float((between - within) / (between + within))


def _classic(press: Press, method: str) -> float:
    """Return the stiffness, N/m, of a line through a known contact, or of any line."""
    depth_mm = np.maximum(press.depth_mm, 0.0)
    if method == SLOPE:
        return float(1000.0 * np.polyfit(press.depth_mm, press.force_n, 1)[0])
    return float(1000.0 * (depth_mm @ (press.force_n - CONTACT_N)) / (depth_mm @ depth_mm))
