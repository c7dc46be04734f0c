"""Perceptual deadband: packets against error, error after a lost packet, and the refresh interval that is needed.

Motion: eight recorded hands at a handle, at the 1 kHz of the recordings and at a site's 500 Hz, and the scripted hand
over the scene. Touch: the recordings' forces, and packets of five simulated fingers. Between packets the receiver holds
the last value, or extrapolates the motion linearly (dead reckoning).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from common.limits import GAP_S
from common.link.deadband import HEIGHT_M, REPEATS
from common.timing.timeouts import REFRESH_S
from studies.compared import Compared
from studies.deadband.channel import RECKONINGS, error_m, sent
from studies.deadband.courses import RECORDED_HZ, Course, recorded, recorded_forces_n, scripted
from studies.deadband.loss import LIMIT_M, LOSSES, REPEATS_TRIED, after_loss_rows, lossy_rows
from studies.deadband.touch import force_rows, touch_rows
from studies.pieces import HERE, Piece, Work, rows_of
from studies.running import Progress

Row = dict[str, Any]
RATES_HZ = (RECORDED_HZ, 500.0)
STEPS_MM = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
SPARED = 0.85
"""Goal: share of the packets on the recorded motions that is not sent."""
MOST_GAPS_IN_AN_HOUR = 1.0
REFRESHES_S = (0.004, 0.006, 0.008, 0.010, 0.012, 0.014, 0.016, 0.020, 0.025, 0.033, 0.050)
GAP_LOSSES = (0.01, 0.05, 0.10, 0.20)
TABLES = ("sweep", "recordings", "loss", "after_loss", "gaps", "forces", "touch")
COMPARED = (
    Compared("recordings", "sent_share", "less", ("recording", "rate_hz"), absolute=0.005),
    Compared("recordings", "largest_mm", "less", ("recording", "rate_hz"), absolute=0.005),
    Compared("loss", "mended_p99_mm", "less", ("rate_hz", "reckoning", "repeats", "loss"), absolute=0.05, relative=0.3),
    Compared("touch", "sent_share", "less", ("act",), absolute=0.03),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Send all motions and forces through deadbands; returns rows of TABLES. `skipped` names missing recordings.

    A quick run takes two recordings, one draw, and 2 to 3 s of simulated work.
    """
    hands, forces_n = recorded(), recorded_forces_n()
    skipped = [] if hands else ["recorded motions: no bilateral_1dof in the folder that TELETACTION_DATA names"]
    if quick:
        hands, forces_n = hands[::4], forces_n[::4]
    seconds, draws = (3.0, 1) if quick else (30.0, 5)
    hand = scripted(RECORDED_HZ, seconds, seed)
    pieces: dict[str, list[Piece]] = {name: [] for name in TABLES}
    # The longest piece first, so that no processor waits for it at the end.
    pieces["touch"].append((touch_rows, (2.0 if quick else 60.0, seed)))
    for rate_hz in RATES_HZ:
        at_rate = [course.thinned(rate_hz) for course in hands]
        pieces["sweep"].append((_sweep, ("scripted", [hand.thinned(rate_hz)])))
        if hands:
            every = round(RECORDED_HZ / rate_hz)
            pieces["sweep"].append((_sweep, ("recorded", at_rate)))
            pieces["recordings"].append((_recordings, (at_rate,)))
            pieces["forces"].append((force_rows, ([force_n[::every] for force_n in forces_n], rate_hz)))
            pieces["loss"] += [
                (lossy_rows, (at_rate, way, n, draws, seed)) for way, n in product(RECKONINGS, REPEATS_TRIED)
            ]
    if hands:
        ways = product(RECKONINGS, REPEATS_TRIED[:2])
        pieces["after_loss"] += [(after_loss_rows, (hands, way, repeats, draws, seed)) for way, repeats in ways]
    pieces["gaps"].append((_gaps, (seed,)))
    found = rows_of(pieces, work, progress)
    return {
        "skipped": skipped,
        "recorded_seconds": sum(len(course.place_m) for course in hands) / RECORDED_HZ,
        "limit_mm": 1e3 * LIMIT_M,
        "refresh_ms": 1e3 * REFRESH_S,
        "repeats": REPEATS,
        "problems": problems(found),
        **found,
    }


def tables(data: Mapping[str, Any]) -> dict[str, list[Row]]:
    """All tables that have rows, by name."""
    return {name.replace("_", "-"): data[name] for name in TABLES if data[name]}


def _sweep(motion: str, courses: Sequence[Course]) -> Iterator[Row]:
    """Packets and errors for each deadband step; nothing is lost."""
    for reckoning in RECKONINGS:
        for step_mm in STEPS_MM:
            sent_at = [sent(course, reckoning, 1e-3 * step_mm) for course in courses]
            pairs = zip(courses, sent_at, strict=True)
            error = np.concatenate([error_m(course, reckoning, ticks) for course, ticks in pairs])
            yield {
                "motion": motion,
                "rate_hz": courses[0].rate_hz,
                "reckoning": reckoning,
                "step_mm": step_mm,
                "sent_share": float(np.concatenate(sent_at).mean()),
                "p95_mm": 1e3 * float(np.quantile(error, 0.95)),
                "largest_mm": 1e3 * float(error.max()),
            }


def _recordings(courses: Sequence[Course]) -> Iterator[Row]:
    """Packets and largest error of each recording, with the deadband step of a finger's height."""
    for course in courses:
        ticks = sent(course, "linear", HEIGHT_M)
        largest_mm = 1e3 * float(error_m(course, "linear", ticks).max())
        yield {
            "recording": course.name,
            "rate_hz": course.rate_hz,
            "ticks": len(ticks),
            "sent": int(ticks.sum()),
            "sent_share": float(ticks.mean()),
            "largest_mm": largest_mm,
        }


def _gaps(seed: int) -> Iterator[Row]:
    """Rate at which losses alone silence a resting hand for GAP_S: computed, and drawn where it is frequent enough."""
    rng = np.random.default_rng(seed)
    for loss in GAP_LOSSES:
        for refresh_s in REFRESHES_S:
            within = math.floor(GAP_S / refresh_s + 1e-9)
            lost = rng.random(1_000_000) < loss
            came = np.flatnonzero(~lost)
            gaps, hours = int((np.diff(came) > within).sum()), len(lost) * refresh_s / 3600.0
            yield {
                "loss": loss,
                "refresh_ms": 1e3 * refresh_s,
                "lost_in_a_row": within,
                "in_an_hour": 3600.0 / refresh_s * (1.0 - loss) * loss**within,
                "drawn_in_an_hour": gaps / hours if gaps >= 20 else None,
            }


def problems(found: Mapping[str, list[Row]]) -> list[str]:
    """Return a line for each goal that the rows miss."""
    return [*_too_many(found["recordings"]), *_too_far_off(found["loss"]), *_gone_too_often(found["gaps"])]


def _too_many(recordings: Sequence[Row]) -> Iterator[str]:
    at_recorded = [row for row in recordings if row["rate_hz"] == RECORDED_HZ]
    ticks, sent_ticks = (sum(row[count] for row in at_recorded) for count in ("ticks", "sent"))
    if ticks - sent_ticks < SPARED * ticks:
        spared = 1.0 - sent_ticks / ticks
        yield f"recorded motions: {spared:.1%} of the packets are spared, the goal is {SPARED:.0%}"
    for row in recordings:
        if row["largest_mm"] > 1e3 * LIMIT_M:
            yield f"{row['recording']}: {row['largest_mm']:.2f} mm off without any loss"


def _too_far_off(losses: Sequence[Row]) -> Iterator[str]:
    limit_mm, refresh_ms = 1e3 * LIMIT_M, 1e3 * REFRESH_S
    for row in losses:
        if (row["reckoning"], row["repeats"], row["loss"]) != ("linear", REPEATS, LOSSES[-1]):
            continue
        if row["mended_p99_mm"] > limit_mm:
            yield f"{row['rate_hz']:g} Hz: {row['mended_p99_mm']:.2f} mm off after the packet that mends a loss"
        if row["right_again_ms"] > refresh_ms:
            yield (
                f"{row['rate_hz']:g} Hz: {row['right_again_ms']:.0f} ms after a loss of {row['loss']:.0%} until the "
                f"error is below {limit_mm:g} mm, a refresh is {refresh_ms:g} ms"
            )


def _gone_too_often(gaps: Sequence[Row]) -> Iterator[str]:
    for row in gaps:
        mine = row["loss"] == GAP_LOSSES[-1] and row["refresh_ms"] == 1e3 * REFRESH_S
        if mine and row["in_an_hour"] > MOST_GAPS_IN_AN_HOUR:
            yield f"a resting hand is taken for gone {row['in_an_hour']:.1f} times in an hour"
