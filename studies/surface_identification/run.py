"""Surface identification from one press: stiffness, time until it is known, and moving, sloping and changing surfaces.

The physics is that of `pressed_surface`. Forces have 0.01 N of noise and 12 bits, or the CAN frames' wider steps.
"""

import math
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remote_site.stiffness.surface_estimate import SurfaceEstimate
from studies.compared import Compared
from studies.pieces import HERE, Piece, Work, one_thread, part_of, rows_of
from studies.running import Progress, tables_of
from studies.surface_identification.pressed_surface import STEPS, TICK_S, Floats, Touches, sense
from studies.surface_identification.scenes import (
    HAND_STEP_M,
    STROKE_FROM_S,
    Identified,
    identify,
    pressed,
    pressed_again,
    rested,
    stroked,
)

STIFFNESSES_N_M = (100.0, 200.0, 500.0, 1000.0, 2000.0, 3000.0)
PRESSES, QUICK_PRESSES = 100, 8
FORCES_N = ((2.0, 3.0), (3.0, 4.0), (4.0, 5.0))
WITHIN = 0.15
DAMPINGS_S_M = (0.0, 0.5, 3.0)
"""Hunt-Crossley damping constants of the pressed objects, s/m; the simulated objects elsewhere have 1.5."""
RESTED_N_M = (50.0, 150.0, 500.0, 1000.0, 3000.0)
MOVES = {"2 mm, 0.25 Hz": (1e-3, 0.25), "12 mm/s, 0.5 Hz": (12e-3 / math.pi, 0.5)}
"""Amplitude, m, and frequency, Hz, of each motion of a surface."""
MOVED_N_M, MOVED_N = (150.0, 500.0, 1000.0, 3000.0), 4.0
SETTLED_S = 1.5
AGAIN_N_M, AGAIN_STEP_S = (150.0, 500.0, 1000.0, 3000.0), 1.0
AGAIN, QUICK_AGAIN = (120, 12.0), (20, 6.0)
"""Number and duration, s, of the contacts that are pressed again and again."""
TISSUE_N_M, NODULE_N_M, NODULE_FROM_M, NODULE_TO_M = 150.0, 600.0, 0.03, 0.05
EDGES_M = (0.0, 2e-3, 5e-3)
SLOPE = 0.1
MOST_LAG_TICKS = 100
tables = tables_of(
    "presses", "known", "dampings", "jitter", "moving", "again", "again_by_time", "nodule", "slope", "cost"
)
COMPARED = (
    Compared("known", "seconds_p50", "less", ("steps", "stiffness_n_m"), absolute=0.01, relative=0.3),
    Compared("known", "ever_told_wrong", "less", ("steps", "stiffness_n_m"), absolute=1.0),
    Compared("known", "harder_n", "less", ("steps", "stiffness_n_m"), absolute=0.02),
    Compared("dampings", "error_p50", "less", ("damping_s_m",), absolute=0.005, relative=0.5),
    Compared("jitter", "told_mm", "less", ("stiffness_n_m",), relative=0.3),
    Compared("moving", "lag_ms", "less", ("moves", "stiffness_n_m"), absolute=4.0),
    Compared("again", "known_and_wrong", "less", ("breathes", "stiffness_n_m"), absolute=0.02),
    Compared("again", "known", "more", ("breathes", "stiffness_n_m"), absolute=0.1),
    Compared("cost", "times_a_bare_call", "less", ("while",), relative=0.5),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Press, rest, breathe and stroke; return all rows, and two courses for the figure.

    The cost is measured in this process after all other work.
    """
    count, again = (QUICK_PRESSES, QUICK_AGAIN) if quick else (PRESSES, AGAIN)
    pieces: dict[str, list[Piece]] = {
        "pressed": [(_pressed, (stiffness_n_m, count, seed)) for stiffness_n_m in STIFFNESSES_N_M],
        "dampings": [(_damping, (damping_s_m, count, seed)) for damping_s_m in DAMPINGS_S_M],
        "jitter": [(_jitter, (seed,))],
        "moving": [(_moving, (name, seed)) for name in MOVES],
        "again": [(_again, (k, breathes, *again, seed)) for breathes in (False, True) for k in AGAIN_N_M],
        "nodule": [(_nodule, (edge_m, seed)) for edge_m in EDGES_M],
        "slope": [(_slope, (seed,))],
    }
    found = rows_of(pieces, work, part_of(progress, 0.0, 0.95))
    with one_thread():
        cost = _cost(_chance(seed, "cost"))
    breaths, lumps = ([course for _, course in found[name]] for name in ("moving", "nodule"))
    return {
        "presses": [row for presses, _ in found["pressed"] for row in presses],
        "known": [row for _, known in found["pressed"] for row in known],
        "dampings": found["dampings"],
        "jitter": found["jitter"],
        "moving": [row for rows, _ in found["moving"] for row in rows],
        "again": [row for row, _ in found["again"]],
        "again_by_time": [row for _, rows in found["again"] for row in rows],
        "nodule": [row for rows, _ in found["nodule"] for row in rows],
        "slope": found["slope"],
        "cost": cost,
        "courses": {"breath": breaths[0], "nodule": lumps[1]},
    }


def _chance(seed: int, *what: str | float) -> np.random.Generator:
    """Return the random generator of a piece, which is the same in every process."""
    return np.random.default_rng([seed, *repr(what).encode()])


def _pressed(
    stiffness_n_m: float, count: int, seed: int
) -> Iterator[tuple[list[dict[str, Any]], list[dict[str, Any]]]]:
    """Press objects of one stiffness; yield rows of errors and of the time until it is known, for each force step."""
    rng = _chance(seed, "pressed", stiffness_n_m)
    touches, force_n = pressed(np.full(count, stiffness_n_m), rng)
    for steps in STEPS:
        judged = [_judge(touches, finger, each) for finger, each in enumerate(_identified(touches, rng, steps))]
        kind = {"steps": steps, "stiffness_n_m": stiffness_n_m}
        yield [kind | row for row in _by_force(judged, force_n)], [kind | _known(judged)]


def _identified(touches: Touches, rng: np.random.Generator, steps: str = "12 bits") -> list[Identified]:
    force_n, z_m = sense(touches, rng, STEPS[steps])
    x_m = np.round(touches.x_m / HAND_STEP_M) * HAND_STEP_M
    return [identify(*columns) for columns in zip(force_n.T, z_m.T, x_m.T, strict=True)]


def _judge(touches: Touches, finger: int, identified: Identified) -> dict[str, Any]:
    """Judge one press: error at the end, correctness and time of the known stiffness, and excess force until then."""
    force_n, z_m = touches.force_n[:, finger], touches.z_m[:, finger]
    error = identified.stiffness_n_m / touches.stiffness_n_m[:, finger] - 1.0
    first = int(np.flatnonzero(force_n > 0.0)[0])
    last = int(np.flatnonzero(force_n > 1.0)[-1])
    until = int(np.argmax(identified.known)) if identified.known.any() else len(force_n)
    shown_n = identified.stiffness_n_m * np.maximum(0.0, identified.surface_m - z_m)
    return {
        "known": bool(identified.known[last]),
        "error": float(abs(error[last])),
        "known_at_peak": bool(identified.known[int(np.argmax(force_n))]),
        "known_ticks": int(identified.known.sum()),
        "right_ticks": int((np.abs(error[identified.known]) <= WITHIN).sum()),
        "seconds": TICK_S * (until - first) if identified.known.any() else None,
        "force_when_known_n": float(force_n[until]) if identified.known.any() else None,
        "harder_n": float((shown_n - force_n)[:until].max()),
    }


def _by_force(judged: list[dict[str, Any]], force_n: Floats) -> Iterator[dict[str, Any]]:
    """Yield the errors at the end of the presses with a known stiffness, by their largest force."""
    for low, high in FORCES_N:
        mine = [each for each, newton in zip(judged, force_n.tolist(), strict=True) if low <= newton < high]
        errors = [each["error"] for each in mine if each["known"]]
        if errors:
            yield {"from_n": low, "to_n": high, "count": len(mine), "known": len(errors)} | _quantiles("error", errors)


def _known(judged: list[dict[str, Any]]) -> dict[str, Any]:
    seconds = [each["seconds"] for each in judged if each["seconds"] is not None]
    return {
        "count": len(judged),
        "unknown_at_peak": sum(not each["known_at_peak"] for each in judged),
        "unknown_at_end": sum(not each["known"] for each in judged),
        "ever_told_wrong": sum(each["right_ticks"] < each["known_ticks"] for each in judged),
        "share_right_when_known": sum(e["right_ticks"] for e in judged) / max(1, sum(e["known_ticks"] for e in judged)),
        "harder_n": max(each["harder_n"] for each in judged),
        "median_force_n": float(np.median([e["force_when_known_n"] for e in judged if e["seconds"] is not None])),
    } | _quantiles("seconds", seconds)


def _quantiles(name: str, values: list[float]) -> dict[str, float]:
    p50, p95, most = np.quantile(values, (0.5, 0.95, 1.0)).tolist()
    return {f"{name}_p50": p50, f"{name}_p95": p95, f"{name}_most": most}


def _damping(damping_s_m: float, count: int, seed: int) -> Iterator[dict[str, Any]]:
    """Press objects of all stiffnesses with another damping."""
    rng = _chance(seed, "damping", damping_s_m)
    touches, force_n = pressed(np.repeat(STIFFNESSES_N_M, max(2, count // 5)), rng, damping_s_m)
    identified = _identified(touches, rng)
    judged = [_judge(touches, finger, each) for finger, each in enumerate(identified)]
    constants = [
        each.damping_n_s_m[last] / touches.force_n[last, finger]
        for finger, each in enumerate(identified)
        if each.damping_n_s_m[last := int(np.flatnonzero(touches.force_n[:, finger] > 1.0)[-1])] > 0.0
    ]
    yield (
        {
            "damping_s_m": damping_s_m,
            "count": len(force_n),
            "unknown_at_end": sum(not each["known"] for each in judged),
            "ever_told_wrong": sum(each["right_ticks"] < each["known_ticks"] for each in judged),
            "damping_told": len(constants),
            "told_p50_s_m": float(np.median(constants)) if constants else None,
        }
        | _quantiles("error", [each["error"] for each in judged if each["known"]])
    )


def _jitter(seed: int) -> Iterator[dict[str, Any]]:
    """Yield the standard deviation of the surface under a finger that rests with 1 N, identified and raw (z + F/k)."""
    rng, stiffness_n_m = _chance(seed, "jitter"), np.array(RESTED_N_M)
    touches = rested(stiffness_n_m, 1.0, 6.0)
    late = touches.time_s > SETTLED_S
    force_n, z_m = sense(touches, rng, STEPS["12 bits"])
    raw_m = (z_m + force_n / stiffness_n_m)[late].std(axis=0)
    for finger, wall_n_m in enumerate(RESTED_N_M):
        identified_m = identify(force_n[:, finger], z_m[:, finger], touches.x_m[:, finger]).surface_m[late]
        yield {
            "stiffness_n_m": wall_n_m,
            "raw_mm": 1e3 * float(raw_m[finger]),
            "told_mm": 1e3 * float(identified_m.std()),
            "told_in_10_ms_mm": 1e3 * float((identified_m[5:] - identified_m[:-5]).std()),
        }


def _moving(name: str, seed: int) -> Iterator[tuple[list[dict[str, Any]], dict[str, list[float]]]]:
    """Move surfaces below a resting finger; yield the delay of their identification, and the course at 500 N/m."""
    amplitude_m, frequency_hz = MOVES[name]
    touches = rested(np.array(MOVED_N_M), MOVED_N, 8.0, amplitude_m=amplitude_m, frequency_hz=frequency_hz)
    late = touches.time_s > SETTLED_S
    rows: list[dict[str, Any]] = []
    course: dict[str, list[float]] = {}
    for finger, identified in enumerate(_identified(touches, _chance(seed, "moving", name))):
        true_m = touches.surface_m[:, finger]
        shown_n = identified.stiffness_n_m * np.maximum(0.0, identified.surface_m - touches.z_m[:, finger])
        rows.append(
            {
                "moves": name,
                "stiffness_n_m": MOVED_N_M[finger],
                "lag_ms": 1e3 * TICK_S * _lag_ticks(identified.surface_m, true_m, late),
                "offset_mm": 1e3 * float((identified.surface_m - true_m)[late].mean()),
                "off_beside_mm": 1e3 * float((identified.surface_m - true_m)[late].std()),
                "force_off_rms_n": float(np.sqrt(((shown_n - touches.force_n[:, finger])[late] ** 2).mean())),
                "stiffness_error": float(np.median(identified.stiffness_n_m[late]) / MOVED_N_M[finger] - 1.0),
                "share_known": float(identified.known[late].mean()),
            }
        )
        if MOVED_N_M[finger] == 500.0:
            course = _course(touches.time_s, true_mm=1e3 * true_m, told_mm=1e3 * identified.surface_m)
    yield rows, course


def _again(
    stiffness_n_m: float, breathes: bool, contacts: int, seconds: float, seed: int
) -> Iterator[tuple[dict[str, Any], list[dict[str, Any]]]]:
    """Press again and again; yield the shares of time, in all and by time, that the stiffness is known, and wrong."""
    rng = _chance(seed, "again", stiffness_n_m, breathes)
    touches = pressed_again(np.full(contacts, stiffness_n_m), rng, seconds, breathes=breathes)
    all_identified = _identified(touches, rng)
    known = np.array([identified.known for identified in all_identified]).T
    error = np.array([identified.stiffness_n_m for identified in all_identified]).T / stiffness_n_m - 1.0
    pressed_at = touches.force_n > 0.1
    late = pressed_at & (touches.time_s > SETTLED_S)[:, None]
    kind = {"breathes": breathes, "stiffness_n_m": stiffness_n_m, "contacts": contacts}
    shares = {"known": known, "known_and_wrong": known & (np.abs(error) > WITHIN), "too_hard": error > WITHIN}
    rows = []
    for from_s in np.arange(0.0, seconds, AGAIN_STEP_S).tolist():
        here = pressed_at & ((touches.time_s >= from_s) & (touches.time_s < from_s + AGAIN_STEP_S))[:, None]
        at = {"from_s": from_s, "to_s": from_s + AGAIN_STEP_S}
        rows.append(kind | at | {name: _share(share, here) for name, share in shares.items()})
    yield kind | {name: _share(share, late) for name, share in shares.items()}, rows


def _share(true: NDArray[np.bool_], of: NDArray[np.bool_]) -> float | None:
    """Return the share of samples that are true; None without samples."""
    return float(true[of].mean()) if of.any() else None


def _lag_ticks(identified_m: Floats, true_m: Floats, late: Any) -> int:
    """Return the delay in ticks that explains the identified height best, apart from a constant offset."""
    ticks = np.flatnonzero(late)
    return min(range(MOST_LAG_TICKS), key=lambda lag: float((identified_m[ticks] - true_m[ticks - lag]).std()))


def _nodule(edge_m: float, seed: int) -> Iterator[tuple[list[dict[str, Any]], dict[str, list[float]]]]:
    """Stroke from tissue over a nodule with a soft or hard edge; yield the rows and one course."""
    width_m = max(edge_m, 1e-6)

    def stiffness_n_m(x_m: Floats) -> Floats:
        upon = np.clip((x_m - NODULE_FROM_M) / width_m, 0.0, 1.0) - np.clip((x_m - NODULE_TO_M) / width_m, 0.0, 1.0)
        return TISSUE_N_M + (NODULE_N_M - TISSUE_N_M) * upon

    touches = stroked(stiffness_n_m, np.array([TISSUE_N_M] * 4), 1.0, STROKE_FROM_S + 2.4)
    x_m, stroking = touches.x_m[:, 0], touches.time_s > STROKE_FROM_S
    all_identified = _identified(touches, _chance(seed, "nodule", edge_m))
    rows: list[dict[str, Any]] = []
    for identified in all_identified:
        ratio = identified.stiffness_n_m / touches.stiffness_n_m[:, 0]
        rows.append(
            {
                "edge_mm": 1e3 * edge_m,
                "onto_ms": _settles_ms(ratio, x_m, NODULE_FROM_M + edge_m, NODULE_TO_M),
                "off_ms": _settles_ms(ratio, x_m, NODULE_TO_M + edge_m, math.inf),
                "nodule_error": float(ratio[x_m < NODULE_TO_M][-1] - 1.0),
                "after_error": float(ratio[-1] - 1.0),
                "surface_off_most_mm": 1e3 * float(np.abs(identified.surface_m[stroking]).max()),
            }
        )
    identified_n_m = all_identified[0].stiffness_n_m[stroking]
    yield rows, _course(1e3 * x_m[stroking], true_n_m=touches.stiffness_n_m[stroking, 0], told_n_m=identified_n_m)


def _settles_ms(ratio: Floats, x_m: Floats, from_m: float, to_m: float) -> float | None:
    """Return the time from full contact with a part until the stiffness stays within 15 %, ms; None if it does not."""
    here = np.abs(ratio[(x_m >= from_m) & (x_m < to_m)] - 1.0) <= WITHIN
    if not here[-1]:
        return None
    wrong = np.flatnonzero(~here)
    return 1e3 * TICK_S * (int(wrong[-1]) + 1 if len(wrong) else 0)


def _slope(seed: int) -> Iterator[dict[str, Any]]:
    """Stroke up a slope; yield the time until the slope is identified, and its accuracy."""
    wall = np.array(RESTED_N_M[1:])
    touches = stroked(lambda _: wall, wall, 1.5, STROKE_FROM_S + 1.5, slope=SLOPE)
    for finger, identified in enumerate(_identified(touches, _chance(seed, "slope"))):
        sloped = identified.slope != 0.0
        late = sloped & (touches.time_s > STROKE_FROM_S + 0.5)
        yield {
            "stiffness_n_m": RESTED_N_M[1:][finger],
            "after_ms": 1e3 * TICK_S * float(np.argmax(sloped)) - 1e3 * STROKE_FROM_S,
            "mean": float(identified.slope[late].mean()),
            "sd": float(identified.slope[late].std()),
        }


def _cost(rng: np.random.Generator) -> list[dict[str, Any]]:
    """Return the processor time of one finger's tick while pressing and stroking, beside an empty call."""
    wall = np.array([500.0])
    pressing = pressed(wall, rng)[0]
    cases = {"pressing": pressing, "stroking": stroked(lambda _: wall, wall, 2.0, STROKE_FROM_S + 1.5, slope=0.02)}
    rows = []
    for name, touches in cases.items():
        force_n, z_m = sense(touches, rng, STEPS["12 bits"])
        samples = [
            (TICK_S * tick, force, x, 0.0, z)
            for tick, (force, x, z) in enumerate(zip(force_n[:, 0], touches.x_m[:, 0], z_m[:, 0], strict=True))
            if force > 0.1
        ]
        plain = [tuple(map(float, sample)) for sample in samples]
        own, bare = zip(
            *((_seconds(SurfaceEstimate(), plain), _seconds(_Bare(), plain)) for _ in range(7)), strict=True
        )
        rows.append(
            {
                "while": name,
                "us_a_tick": 1e6 * min(own) / len(plain),
                "bare_call_us": 1e6 * min(bare) / len(plain),
                "times_a_bare_call": min(own) / min(bare),
            }
        )
    return rows


class _Bare:
    """Identification with the same call that does nothing."""

    def step(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float) -> None:
        """Do nothing."""


def _seconds(finger: SurfaceEstimate | _Bare, samples: list[tuple[float, ...]]) -> float:
    start = time.process_time()
    for sample in samples:
        finger.step(*sample)
    return time.process_time() - start


def _course(along: Floats, **columns: Floats) -> dict[str, list[float]]:
    """Return every fifth value for the figure; `along` is a time, s, or a distance, mm."""
    return {name: values[::5].round(4).tolist() for name, values in ({"along": along} | columns).items()}
