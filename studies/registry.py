"""The studies there are, and how one is run: its data, its tables and its figure are written to a folder.

A study is a module with `run(quick=..., seed=..., tell=..., work=...)` that returns what can be written as JSON, and
`plot(data, path)`. Its `work` does pieces wherever there are processors for them (studies/pieces.py); what it times on
this machine it times in its own process, while no piece is being done. A study of such times alone has no `work`, and
says in `MEASURES_THIS_MACHINE` what they are. `COMPARED` are the numbers by which two runs are compared. It may have
`tables(data)`: rows by name, written as CSV. Its data may have `problems`: what is wrong, a line each. While it runs it
tells how far it is: the share done, 0..1, or what it is at, in words. The first line of its docstring says what it
shows.
"""

import csv
import hashlib
import json
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
from studies.running import Tell, Unavailable

STUDIES = {
    "link": "studies.link",
    "soak": "studies.soak",
    "thermal-identification": "studies.thermal_identification",
    "recorded-touches": "studies.recorded_touches",
    "thermal-rendering": "studies.thermal_rendering",
    "texture": "studies.texture",
    "recorded-strokes": "studies.recorded_strokes",
    "exploration-modes": "studies.exploration_modes",
    "groove-spacing": "studies.groove_spacing",
    "vibration": "studies.vibration",
    "surface-identification": "studies.surface_identification",
    "teleoperation-stability": "studies.teleoperation_stability",
    "deadband": "studies.deadband",
    "kinesthetic-loop": "studies.kinesthetic_loop",
    "observer": "studies.observer",
    "tactile-map": "studies.tactile_map",
    "consoles": "studies.consoles",
    "sessions": "studies.sessions",
    "rates": "studies.rates",
    "runtime-cost": "benchmarks.runtime_cost.study",
    "paper-figures": "studies.paper_figures",
}
"""Module of each study by its name."""
PIECES = ".pieces"
"""Folder, in that of the results, of what an interrupted run has done."""


class UnknownStudy(ValueError):
    """There is no study of this name."""


@dataclass(frozen=True, slots=True)
class Result:
    """How a study ended.

    Attributes:
        written: its files.
        problems: what it found wrong, a line each; empty when all is well.
    """

    written: list[Path]
    problems: list[str]


def study(name: str) -> ModuleType:
    """Load a study; raises UnknownStudy."""
    if name not in STUDIES:
        raise UnknownStudy(f"no study {name!r}; there are {', '.join(STUDIES)}")
    return import_module(STUDIES[name])


def described() -> dict[str, str]:
    """What each study shows, in a line."""
    return {name: (study(name).__doc__ or "").partition("\n")[0] for name in STUDIES}


def run_study(
    name: str,
    out: Path,
    *,
    quick: bool = False,
    seed: int = 0,
    tell: Tell = lambda _: None,
    workers: Workers = here,
) -> Result:
    """Run a study and write NAME.json, NAME-TABLE.csv and NAME.png to `out`.

    Args:
        name: of the study.
        out: folder; made when it is not there. Pieces are kept in it until the study is done: one that was interrupted
            goes on where it was.
        quick: whether to measure less.
        seed: of everything random in it.
        tell: is told how far it is.
        workers: who does its pieces.

    Raises:
        UnknownStudy: there is none of this name.
        Unavailable: what it measures with is not here.
        OSError: the folder cannot be written to.
    """
    module = study(name)
    out.mkdir(parents=True, exist_ok=True)
    kept = KeptPieces(out / PIECES / name)
    who = {} if hasattr(module, "MEASURES_THIS_MACHINE") else {"work": working(workers, kept)}
    data = {"quick": quick, "seed": seed} | module.run(quick=quick, seed=seed, tell=tell, **who)
    written = [out / f"{name}.json"]
    written[0].write_text(json.dumps(data, indent=1) + "\n", "utf-8")
    for table, rows in module.tables(data).items() if hasattr(module, "tables") else ():
        written.append(out / f"{name}-{table}.csv")
        write_table(written[-1], rows)
    written.append(out / f"{name}.png")
    module.plot(data, written[-1])
    kept.forget()
    return Result(written, data.get("problems", []))


def run_all(
    out: Path, *, quick: bool, seed: int, telling: Callable[[str], AbstractContextManager[Tell]], workers: Workers
) -> Iterator[tuple[str, Result | Unavailable]]:
    """Run every study, one after the other, and draw an overview: what became of each, as soon as it is there.

    Where this was interrupted before, what the same code has finished is not run again. `telling` makes what a study
    tells how far it is; for the rest see `run_study`.
    """
    finished = KeptPieces(out / PIECES / "all")
    for name in STUDIES:
        key = hashlib.sha256(repr((code_version(), name, quick, seed)).encode()).hexdigest()
        if (before := finished.find(key)) is not None:
            yield name, pickle.loads(before)
            continue
        try:
            with telling(name) as tell:
                result = run_study(name, out, quick=quick, seed=seed, tell=tell, workers=workers)
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
    """Write rows with the same keys as CSV; a value that is None is an empty cell."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]) if rows else [])
        writer.writeheader()
        writer.writerows(rows)
