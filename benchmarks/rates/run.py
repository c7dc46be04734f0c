"""Tick rates of both sites: speed, correctness and cost of a live session of five fingers.

The study runs whole demonstrations on this machine, with real processes, device lines and links. The rates take turns,
seed by seed, so that other load on the machine falls on all of them. Costs are given in processors and in reference
steps.
"""

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

from common.runtime.parallel_map import processors
from common.runtime.reference_step import reference_step_s
from studies.compared import Compared
from studies.running import Progress
from teletaction.session.session_rates import Rates

MEASURES_THIS_MACHINE = "how fast a live session is on it, by its tick rates"
RATES = tuple(Rates(*pair) for pair in ((250, 500), (500, 500), (500, 1000), (1000, 1000)))
SEEDS, SECONDS = 3, 60.0
QUICK_RATES, QUICK_SECONDS = (RATES[0], RATES[-1]), 9.0
LEAST_HELD_S = 2.0
"""Shortest touch of a calibrated material that should be named, s."""
COMPARED = (
    Compared("rates", "contact_to_motor_p50_ms", "less", ("rates",), relative=0.33),
    Compared("rates", "reference_steps_s", "less", ("rates",), relative=0.33),
    Compared("rates", "named_rightly", "more", ("rates",), absolute=2.0, relative=0.1),
    Compared("rates", "named_wrongly", "less", ("rates",)),
    Compared("rates", "grooves_wrong", "less", ("rates",), absolute=4.0),
)
Row = dict[str, Any]


def run(*, quick: bool, seed: int, progress: Progress) -> dict[str, Any]:
    """Measure; quick: two pairs of rates, one short session each.

    Raises:
        RuntimeError: a session failed; the message says how.
    """
    if quick:
        return measure(QUICK_RATES, [seed], QUICK_SECONDS, progress)
    return measure(RATES, range(seed, seed + SEEDS), SECONDS, progress)


def measure(choices: Sequence[Rates], seeds: Sequence[int], seconds: float, progress: Progress) -> dict[str, Any]:
    """A row for each session and for each pair of rates: sums of its counts, and medians of everything else."""
    sessions: list[Row] = []
    for seed in seeds:
        for rates in choices:
            progress(len(sessions) / (len(seeds) * len(choices)))
            step_s = reference_step_s()
            sessions.append({"rates": str(rates), "seed": seed} | _figures(_summary(rates, seed, seconds), step_s))
    return {
        "processors": processors(),
        "seconds": seconds,
        "sessions": sessions,
        "rates": [_together([row for row in sessions if row["rates"] == str(rates)]) for rates in choices],
    }


def tables(data: Mapping[str, Any]) -> dict[str, list[Row]]:
    """Tables by session, and by pair of rates."""
    return {"session": data["sessions"], "rates": data["rates"]}


def _summary(rates: Rates, seed: int, seconds: float) -> dict[str, Any]:
    """Summary of one demonstration, from a process of its own."""
    with TemporaryDirectory(prefix="rates-") as out:
        words = f"demo --headless --seconds {seconds:g} --seed {seed} --rates {rates} --out".split()
        ended = subprocess.run(
            [sys.executable, "-m", "teletaction", *words, out], stderr=subprocess.PIPE, text=True, check=False
        )
        if ended.returncode:
            raise RuntimeError(f"rates {rates}, seed {seed}: {ended.stderr.strip()}")
        found: dict[str, Any] = json.loads((Path(out) / "summary.json").read_text("utf-8"))
        return found


def _figures(summary: Mapping[str, Any], step_s: float) -> Row:
    loops: Mapping[str, Mapping[str, Any]] = summary["loop"]
    delay, impulses, taps = summary["latency_ms"]["contact_to_motor"], summary["impulses"], summary["taps"]
    held = [
        touch
        for touch in summary["contacts"]
        if touch["true_material"] in MATERIALS and touch["held_s"] >= LEAST_HELD_S
    ]
    right = [touch["seconds"] for touch in held if touch["material"] == touch["true_material"]]
    return {
        "reference_step_us": round(step_s * 1e6, 1),
        "cores": summary["cpu_cores"],
        "reference_steps_s": round(summary["cpu_cores"] / step_s),
        **{f"{name}_steps_s": round(loop["cpu"] / step_s) for name, loop in loops.items()},
        "on_time": min(round(loop["ticks"] / (loop["ticks"] + loop["missed"]), 4) for loop in loops.values()),
        "contact_to_motor_p50_ms": delay["p50"],
        "contact_to_motor_p99_ms": delay["p99"],
        "grooves": impulses["crossed"],
        "grooves_wrong": impulses["missed"] + impulses["invented"],
        "taps": taps["made"],
        "taps_felt": taps["played"],
        "touches": len(held),
        "named_rightly": len(right),
        "named_wrongly": sum(touch["material"] not in {None, touch["true_material"]} for touch in held),
        "named_after_s": median(right) if right else None,
        "modes_agree": summary["modes"]["agreement"],
    }


COUNTS = frozenset({"grooves", "grooves_wrong", "taps", "taps_felt", "touches", "named_rightly", "named_wrongly"})
MATERIALS = frozenset({"aluminium", "ceramic_tile", "pine", "pvc"})
"""Calibrated materials of the scene."""


def _together(rows: Sequence[Row]) -> Row:
    found: Row = {"rates": rows[0]["rates"], "sessions": len(rows)}
    for name in rows[0]:
        if name not in found and name != "seed":
            values = [row[name] for row in rows if row[name] is not None]
            together = sum if name in COUNTS else median
            found[name] = round(together(values), 4) if values else None
    return found
