"""Lists the studies, runs one, and writes its data, its tables and its figure to a folder.

Each study has a folder with its name, here or in `benchmarks`: `run.py` measures, `figure.py` draws, and other modules
are its parts. `soak` is in `robustness`. `run.py` contains:

- a docstring whose first line describes the study;
- `run(quick=..., seed=..., progress=..., work=...)`, which returns the data for JSON;
- `COMPARED`, the numbers by which two runs are compared;
- optionally `tables(data)`, the rows that are written as CSV, by name.

`figure.py` contains `plot(data, path)`, which draws the data as PNG.

`work` runs pieces on all processors (studies/pieces.py). A study measures times of this machine in its own process
while no piece runs. A study of such times alone has no `work`, and names them in `MEASURES_THIS_MACHINE`. The study
calls `progress` with the share done, 0..1, or with its present step in words. `problems` in its data are optional, a
line for each problem.
"""

import csv
import hashlib
import json
import math
import os
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from studies.kept_pieces import KeptPieces
from studies.overview import overview_rows
from studies.overview import plot as draw_overview
from studies.overview_parts import parts_in
from studies.pieces import Workers, code_version, here, working
from studies.running import Progress, Unavailable

STUDIES = {
    "link": "benchmarks.link.run",
    "soak": "robustness.soak",
    "thermal-identification": "studies.thermal_identification.run",
    "second-world": "studies.second_world.run",
    "other-objects": "studies.other_objects.run",
    "recorded-touches": "studies.recorded_touches.run",
    "thermal-rendering": "studies.thermal_rendering.run",
    "texture": "studies.texture.run",
    "recorded-strokes": "studies.recorded_strokes.run",
    "palpation": "studies.palpation.run",
    "texture-world": "studies.texture_world.run",
    "exploration-modes": "studies.exploration_modes.run",
    "groove-spacing": "studies.groove_spacing.run",
    "vibration": "studies.vibration.run",
    "surface-identification": "studies.surface_identification.run",
    "teleoperation-stability": "studies.teleoperation_stability.run",
    "deadband": "studies.deadband.run",
    "kinesthetic-loop": "benchmarks.kinesthetic_loop.run",
    "observer": "studies.observer.run",
    "tactile-map": "studies.tactile_map.run",
    "nodules": "studies.nodules.run",
    "tenderness": "studies.tenderness.run",
    "consoles": "benchmarks.consoles.run",
    "sessions": "benchmarks.sessions.run",
    "rates": "benchmarks.rates.run",
    "runtime-cost": "benchmarks.runtime_cost.run",
    "paper-figures": "studies.paper_figures.run",
}
"""Module of each study by its name."""
PIECES = ".pieces"
"""Folder within the results' folder for the finished pieces of an interrupted run."""


class UnknownStudy(ValueError):
    """There is no study of this name."""


@dataclass(frozen=True, slots=True)
class Result:
    """Outcome of a study.

    Attributes:
        written: its files.
        problems: the problems that it found, a line each; empty when all is well.
    """

    written: list[Path]
    problems: list[str]


def study(name: str) -> ModuleType:
    """Load a study; raises UnknownStudy."""
    if name not in STUDIES:
        raise UnknownStudy(f"no study {name!r}; there are {', '.join(STUDIES)}")
    return import_module(STUDIES[name])


def plot_of(name: str) -> Callable[[Mapping[str, Any], Path], None]:
    """Load the function that draws a study."""
    module = study(name)
    plot: Callable[[Mapping[str, Any], Path], None] = (
        module.plot if hasattr(module, "plot") else import_module(f"{module.__package__}.figure").plot
    )
    return plot


def described() -> dict[str, str]:
    """One line for each study on what it shows."""
    return {name: (study(name).__doc__ or "").partition("\n")[0] for name in STUDIES}


def run_study(
    name: str,
    out: Path,
    *,
    quick: bool = False,
    seed: int = 0,
    progress: Progress = lambda _: None,
    workers: Workers = here,
) -> Result:
    """Run a study and write NAME.json, NAME-TABLE.csv and NAME.png to `out`.

    Args:
        name: of the study.
        out: folder; made when it is not there. It keeps pieces until the study is done, so that an interrupted study
            continues where it stopped.
        quick: whether to measure less.
        seed: seed of everything random in it.
        progress: called with its progress.
        workers: runs its pieces.

    Raises:
        UnknownStudy: there is none of this name.
        Unavailable: something that the study needs is missing.
        OSError: the folder cannot be written to.
    """
    module = study(name)
    out.mkdir(parents=True, exist_ok=True)
    kept = KeptPieces(out / PIECES / name)
    who = {} if hasattr(module, "MEASURES_THIS_MACHINE") else {"work": working(workers, kept)}
    data = {"quick": quick, "seed": seed} | module.run(quick=quick, seed=seed, progress=progress, **who)
    written = [out / f"{name}.json"]
    written[0].write_text(json.dumps(_finite(data), indent=1) + "\n", "utf-8")
    for table, rows in module.tables(data).items() if hasattr(module, "tables") else ():
        written.append(out / f"{name}-{table}.csv")
        write_table(written[-1], rows)
    written.append(out / f"{name}.png")
    plot_of(name)(data, written[-1])
    kept.forget()
    return Result(written, data.get("problems", []))


def _finite(value: Any) -> Any:
    """Return a value for JSON, which has neither infinite numbers nor NaN: each of them becomes None."""
    if isinstance(value, dict):
        return {name: _finite(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def run_all(
    out: Path,
    *,
    quick: bool,
    seed: int,
    show_progress: Callable[[str], AbstractContextManager[Progress]],
    workers: Workers,
) -> Iterator[tuple[str, Result | Unavailable]]:
    """Run every study, one after the other, and draw an overview; yields the result of each as soon as it is there.

    Studies that the same code finished with the same recordings before an interruption are not run again.
    `show_progress` makes the function that takes a study's progress. The other arguments are those of `run_study`.
    """
    finished = KeptPieces(out / PIECES / "all")
    run = code_version(), os.environ.get("TELETACTION_DATA"), quick, seed
    for name in STUDIES:
        key = hashlib.sha256(repr((name, *run)).encode()).hexdigest()
        if (before := finished.find(key)) is not None:
            yield name, pickle.loads(before)
            continue
        try:
            with show_progress(name) as progress:
                result = run_study(name, out, quick=quick, seed=seed, progress=progress, workers=workers)
        except Unavailable as missing:
            yield name, missing
            continue
        finished.keep(key, pickle.dumps(result))
        yield name, result
    parts = parts_in(out)
    table, figure = out / "overview.csv", out / "overview.png"
    write_table(table, overview_rows(parts))
    draw_overview(parts, figure)
    finished.forget()
    yield "overview", Result([table, figure], [])


def write_table(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows with the same keys as CSV; None becomes an empty cell."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]) if rows else [])
        writer.writeheader()
        writer.writerows(rows)
