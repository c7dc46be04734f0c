"""A hundred textures of the world: roughness, names, strangers, and rendered against sensed vibration.

Public haptic models of a hundred materials (Culbertson, Lopez Delgado & Kuchenbecker 2014) are rendered at random
speeds and forces. They are independent of this project's own simulator and know nothing of its identification. The
files are others' and are looked for in the folder `textures` of TELETACTION_DATA. The acceleration of their tool stands
for the signal of the texture sensor.
"""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
from scipy.stats import binomtest

from studies.compared import Compared
from studies.counting import grouped
from studies.pieces import HERE, Piece, Work, chunks, part_of, rows_of
from studies.running import Progress, Unavailable, data_folder
from studies.texture_world.models import read_models
from studies.texture_world.recognition import FOLDS, METHODS, SECONDS, SHIPPED, TOP, named, strangers
from studies.texture_world.rendering_quality import MISSING, installed, qualities, quality_rows
from studies.texture_world.roughness import EACH, ranking, roughnesses, sensor_law

Row = dict[str, Any]
JUDGED, REPEATS = 6, 2
"""Judged strokes of each texture, and independent repeats of the whole."""
FIRST_SEED = 10
"""Seed of the first repeat; choices were made with smaller ones."""
KNOWN = ("many", "few")
"""Numbers of calibrated textures beside strangers."""
LEAST_TEXTURES = 2 * FOLDS
"""Least number of textures: each group that is calibrated alone has two."""
QUICK_TEXTURES = 20
"""Number of textures of a quick run, evenly over all."""
MOVED_S, QUARTERS = 1.0, 4
"""Duration of the strokes that are judged by speed and force, s, and number of parts of each."""
_IN_A_PIECE = 5
COMPARED = (
    Compared("roughness", "spearman_five_strokes", "more", absolute=0.02),
    Compared("accuracy", "top_1", "more", ("method", "seconds"), {"method": SHIPPED}, counted="strokes"),
    Compared("accuracy", "top_3", "more", ("method", "seconds"), {"method": SHIPPED}, counted="strokes"),
    Compared("strangers", "strange_unknown_share", "more", ("known_textures", "seconds"), counted="strange"),
    Compared("strangers", "own_unknown_share", "less", ("known_textures", "seconds"), counted="own"),
    Compared("quality", "off_db", "less", ("way", "bits_s"), absolute=1.0),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Measure all parts.

    Raises:
        Unavailable: there are no texture models, or too few.
        ValueError: a file is no texture model.
    """
    folder = data_folder("textures")
    models = read_models(folder)
    if len(models) < LEAST_TEXTURES:
        raise Unavailable(f"{folder}: {len(models)} texture models, fewer than {LEAST_TEXTURES}")
    models = models[:: max(1, len(models) // QUICK_TEXTURES)] if quick else models
    repeats = 1 if quick else REPEATS
    (law,) = work([(sensor_law, (models, seed))], part_of(progress, 0.0, 0.15))
    first = FIRST_SEED + REPEATS * seed
    pieces: dict[str, list[Piece]] = {
        "strokes": [(roughnesses, (models, part, law, seed)) for part in chunks(range(len(models)), _IN_A_PIECE)],
        "named": [(named, (models, JUDGED, first + k)) for k in range(repeats)],
        "strangers": [(strangers, (models, JUDGED, first, 1 if quick else FOLDS, known)) for known in KNOWN],
    }
    found = rows_of(pieces, work, part_of(progress, 0.15, 0.85))
    ln_v = np.array([row["ln_roughness"] for row in found["strokes"]]).reshape(-1, EACH).mean(axis=1).tolist()
    parts = chunks(range(len(models)), _IN_A_PIECE)
    judging = {"quality": [(qualities, (models, part, ln_v, seed)) for part in parts]}
    quality = rows_of(judging, work, part_of(progress, 0.85, 1.0))["quality"]
    return {
        "textures": [model.material for model in models],
        "law": law.model_dump(),
        "strokes": found["strokes"],
        "roughness": ranking(found["strokes"]),
        "accuracy": accuracy(found["named"]),
        "by_motion": by_motion(found["named"]),
        "by_texture": by_texture(found["named"]),
        "strangers": pooled(found["strangers"]),
        "quality": quality_rows(quality),
        "without": [] if installed() else [MISSING],
    }


def tables(data: Mapping[str, Any]) -> dict[str, list[Row]]:
    """Return the parts of the data that are tables."""
    return {name: data[name] for name in ("strokes", "accuracy", "by_motion", "by_texture", "strangers", "quality")} | {
        "roughness": [data["roughness"]]
    }


def accuracy(rows: Sequence[Row]) -> list[Row]:
    """Return the shares of strokes whose texture is first, and among the first three, with exact 95 % intervals."""
    found = []
    for method, seconds in product(METHODS, SECONDS):
        ranks = np.array([row["rank"] for row in rows if (row["method"], row["seconds"]) == (method, seconds)])
        first, of = int((ranks == 0).sum()), len(ranks)
        low, high = binomtest(first, of).proportion_ci()
        row: Row = {"method": method, "seconds": seconds, "strokes": of, "top_1": first / of}
        found.append(row | {"top_1_low": float(low), "top_1_high": float(high), "top_3": float((ranks < TOP).mean())})
    return found


def by_motion(rows: Sequence[Row]) -> list[Row]:
    """Return the share of right names of the shipped method by quarters of speed and force."""
    mine = [row for row in rows if row["method"] == SHIPPED and row["seconds"] == MOVED_S]
    moved = np.array([[row["ln_speed"], row["ln_force"]] for row in mine])
    edges = np.quantile(moved, np.linspace(0.0, 1.0, QUARTERS + 1)[1:-1], axis=0).T
    cells = [np.searchsorted(edge, column) for edge, column in zip(edges, moved.T, strict=True)]
    right = np.array([row["rank"] == 0 for row in mine])
    found = []
    for speed, force in product(range(QUARTERS), repeat=2):
        inside = (cells[0] == speed) & (cells[1] == force)
        found.append(
            {
                "speed_part": speed,
                "force_part": force,
                "strokes": int(inside.sum()),
                "top_1": float(right[inside].mean()) if inside.any() else None,
            }
        )
    return found


def by_texture(rows: Sequence[Row], seconds: float = SECONDS[-1]) -> list[Row]:
    """Return the share of right names of the shipped method by texture, the least first."""
    judged = [row for row in rows if row["method"] == SHIPPED and row["seconds"] == seconds]
    each = [
        {"material": name, "strokes": len(mine), "top_1": float(np.mean([row["rank"] == 0 for row in mine]))}
        for (name,), mine in grouped(judged, "material").items()
    ]
    return sorted(each, key=lambda row: (row["top_1"], row["material"]))


def pooled(rows: Sequence[Row]) -> list[Row]:
    """Return the counts of all groups together, and their shares."""
    found = []
    for (known, seconds), mine in grouped(rows, "known_textures", "seconds").items():
        names = ("own", "own_unknown", "own_right", "strange", "strange_unknown")
        line: Row = {"known_textures": known, "seconds": seconds} | {
            name: sum(row[name] for row in mine) for name in names
        }
        shares = (("own_unknown", "own"), ("own_right", "own"), ("strange_unknown", "strange"))
        found.append(line | {f"{name}_share": line[name] / line[of] for name, of in shares})
    return found
