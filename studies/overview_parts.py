"""Reads cost and error of every compared way from each study's data, for the overview."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import fmean, median
from typing import Any

from studies.counting import grouped
from studies.overview import Part, Way
from studies.thermal_identification.pieces import ONE

Data = Mapping[str, Any]
OURS = "model of the touch"
IDENTIFIED_S, TEXTURE_S = 2.0, 0.5
MATERIALS = 4
HZ = 1000.0
STEPS_MM = (0.05, 0.1, 0.2)
PERCENT = 100.0
LINK_LATE, LINK_LOAD, BARE = "link, encoded to checked", "link", "bare CurveZMQ"
"""Ways of the study `link`: of its latency, of its processor load, and of both."""


def identification(data: Data) -> Part:
    """Material after two seconds of touch, one finger."""
    right = {
        row["method"]: row["right"]
        for row in data["accuracy"]
        if (row["materials"], row["t_s"]) == (MATERIALS, IDENTIFIED_S) and row["right"] is not None
    }
    costs = {row["method"]: row["ratio_all"] for row in data["cost"]}
    ways = [
        Way(OURS if name == ONE else name, cost, PERCENT * (1.0 - right[name]), name != ONE)
        for name, cost in costs.items()
        if name in right
    ]
    return Part(
        f"Identification: {MATERIALS} materials, one finger, {IDENTIFIED_S:g} s",
        "cost of a reading (products of two 100 x 100 matrices)",
        "likeliest material wrong (%)",
        ways,
    )


def rendering(data: Data) -> Part:
    """Heat at the finger: every skin model over all objects, and the choice among them."""
    chosen = [row for row in data["models"] if row["chosen"]]
    named = [(name, each, True) for (name,), each in grouped(data["models"], "model").items()]
    named.append(("chosen for each object", chosen, False))
    ways = [
        Way(name, fmean(row["products"] for row in each), max(row["share_of_tolerance"] for row in each), baseline)
        for name, each, baseline in named
        if each
    ]
    return Part(
        "Heat at the finger: skin models by their cells, all objects",
        "cost of a step of five fingers (bare products)",
        "worst error (tolerances)",
        ways,
        "y",
    )


def texture(data: Data) -> Part:
    """Surface after half a second of stroking."""
    wrong = {row["method"]: PERCENT * (1.0 - row["share"]) for row in data["accuracy"] if row["time_s"] == TEXTURE_S}
    ways = [
        Way(row["method"], PERCENT * row["of_one_core"], wrong[row["method"]], row["method"] != "shipped")
        for row in data["cost"]["methods"]
        if row["method"] in wrong
    ]
    return Part(
        f"Texture: six surfaces, {TEXTURE_S:g} s of stroking",
        "cost of one finger (% of a core)",
        "surface wrong (%)",
        ways,
    )


def packets(data: Data) -> Part:
    """Motion through a deadband: share of packets sent, and error of the receiver; recorded hands where available."""
    motion = "recorded" if any(row["motion"] == "recorded" for row in data["sweep"]) else "scripted"
    mine = [row for row in data["sweep"] if (row["motion"], row["rate_hz"]) == (motion, HZ)]
    ways = [
        Way(
            f"{row['reckoning']}, {row['step_mm']:g} mm",
            PERCENT * row["sent_share"],
            row["p95_mm"],
            row["reckoning"] != "linear",
        )
        for row in mine
        if row["step_mm"] in STEPS_MM
    ]
    return Part(
        f"Motion packets: {motion} hands at {HZ:g} Hz, deadband",
        "packets sent (% of all)",
        "place off, 95 % below (mm)",
        [*ways, Way("every packet", PERCENT, 0.0)],
        "",
    )


def link(data: Data) -> Part:
    """A touch packet from site to site, beside a bare socket."""
    late_us = {row["way"]: row["median_us"] for row in data["latency"]["ways"]}
    share = data["cpu"]["all_cpu"]
    ways = [
        Way("link", PERCENT * share[LINK_LOAD], late_us[LINK_LATE], baseline=False),
        Way("bare CurveZMQ", PERCENT * share[BARE], late_us[BARE]),
    ]
    return Part("Link: both ends, 500 Hz touch, 1 kHz motion", "cost (% of a core)", "one way, median (us)", ways, "")


def stability(data: Data) -> Part:
    """Couplings over all delays and links: share of failed runs, and error of the displayed stiffness."""
    ways = []
    for (name,), runs in grouped(data["matrix"], "architecture").items():
        wrong = sum(not row["stable"] or row["produced_mj"] > 1.0 for row in runs) / len(runs)
        errors = [
            abs(row["felt_n_m"] / row["wall_n_m"] - 1.0)
            for row in runs
            if row["link"] == "steady" and row["stable"] and row["felt_n_m"] is not None
        ]
        if errors:
            ways.append(Way(name, PERCENT * wrong, PERCENT * median(errors), name != "local model"))
    return Part(
        "Stability: all delays, walls, hands and links",
        "runs that swing on or make more than 1 mJ (%)",
        "displayed stiffness wrong, median (%)",
        ways,
        "",
    )


PARTS: dict[str, Callable[[Data], Part]] = {
    "thermal-identification": identification,
    "thermal-rendering": rendering,
    "texture": texture,
    "deadband": packets,
    "link": link,
    "teleoperation-stability": stability,
}
"""Function that reads the data of each study, by the study's name."""


def parts_in(folder: Path) -> dict[str, Part | None]:
    """Parts by study, from their data in a folder; None where it is missing."""
    found: dict[str, Part | None] = {}
    for study, part in PARTS.items():
        file = folder / f"{study}.json"
        found[study] = part(json.loads(file.read_text("utf-8"))) if file.exists() else None
    return found
