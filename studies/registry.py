"""The studies there are, and how one is run: its data, its tables and its figure are written to a folder.

A study is a module with `run(quick=..., seed=..., tell=...)` that returns what can be written as JSON, and
`plot(data, path)`. It may have `tables(data)`: rows by name, written as CSV. Its data may have `problems`: what is
wrong, a line each. While it runs it tells how far it is: the share done, 0..1, or what it is at, in words. The first
line of its docstring says what it shows.
"""

import csv
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

Tell = Callable[[float | str], object]
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
    "paper-figures": "studies.paper_figures",
}
"""Module of each study by its name."""


class UnknownStudy(ValueError):
    """There is no study of this name."""


class Unavailable(ValueError):
    """Something that a study measures with is not here; the message says what, and how to name it."""


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


def run_study(name: str, out: Path, *, quick: bool = False, seed: int = 0, tell: Tell = lambda _: None) -> Result:
    """Run a study and write NAME.json, NAME-TABLE.csv and NAME.png to `out`.

    Args:
        name: of the study.
        out: folder; made when it is not there.
        quick: whether to measure less.
        seed: of everything random in it.
        tell: is told how far it is.

    Raises:
        UnknownStudy: there is none of this name.
        Unavailable: what it measures with is not here.
        OSError: the folder cannot be written to.
    """
    module = study(name)
    out.mkdir(parents=True, exist_ok=True)
    data = module.run(quick=quick, seed=seed, tell=tell)
    written = [out / f"{name}.json"]
    written[0].write_text(json.dumps(data, indent=1) + "\n", "utf-8")
    for table, rows in module.tables(data).items() if hasattr(module, "tables") else ():
        written.append(out / f"{name}-{table}.csv")
        write_table(written[-1], rows)
    written.append(out / f"{name}.png")
    module.plot(data, written[-1])
    return Result(written, data.get("problems", []))


def write_table(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows with the same keys as CSV; a value that is None is an empty cell."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]) if rows else [])
        writer.writeheader()
        writer.writerows(rows)
