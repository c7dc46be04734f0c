"""Comparison of two runs of the studies: numbers that became worse, became better, or are missing."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from studies.compared import Compared, Number
from studies.registry import STUDIES, study

Verdict = Literal["same", "better", "worse", "gone", "new"]
ORDER: tuple[Verdict, ...] = ("worse", "gone", "better", "new", "same")
"""Verdicts by severity, the gravest first."""
WORSE: tuple[Verdict, ...] = ("worse", "gone")


@dataclass(frozen=True, slots=True)
class Change:
    """A number in two runs.

    Attributes:
        study, number: names of the study and of the number.
        old, new: the number in each run; None: missing.
        may_differ: largest difference that counts as the same; None where a number is missing.
        verdict: result of the comparison.
    """

    study: str
    number: str
    old: float | None
    new: float | None
    may_differ: float | None
    verdict: Verdict


def compare_folders(old: Path, new: Path, names: Sequence[str] = tuple(STUDIES)) -> tuple[list[Change], list[str]]:
    """Compare all studies that both folders hold; also name the studies that only one folder holds.

    Raises:
        ValueError: the folders have no study in common, a file is not a study's data, or only one of the runs was
            quick.
        OSError: a file cannot be read.
    """
    changes: list[Change] = []
    alone, compared = [], 0
    for name in names:
        files = [folder / f"{name}.json" for folder in (old, new)]
        there = [file.exists() for file in files]
        if all(there):
            compared += 1
            changes += compare(name, *_of_one_kind(files), study(name).COMPARED)
        elif any(there):
            alone.append(name)
    if not compared:
        absent = "".join(f"; there is no folder {folder}" for folder in (old, new) if not folder.is_dir())
        raise ValueError(f"{old} and {new} have no study in common{absent}")
    return changes, alone


def compare(name: str, old: Mapping[str, Any], new: Mapping[str, Any], numbers: Iterable[Compared]) -> Iterator[Change]:
    """Change of each number of a study, and of the number of problems that it finds."""
    for each in numbers:
        before, after = each.numbers(old), each.numbers(new)
        for number in before | after:
            yield _change(name, number, each, before.get(number, Number(None)), after.get(number, Number(None)))
    problems = Compared("", "problems", "less")
    counts = (Number(float(len(data.get("problems", [])))) for data in (old, new))
    yield _change(name, "problems", problems, *counts)


def _change(name: str, number: str, how: Compared, old: Number, new: Number) -> Change:
    if old.value is None or new.value is None:
        verdict: Verdict = "gone" if old.value is not None else "new" if new.value is not None else "same"
        return Change(name, number, old.value, new.value, None, verdict)
    allowed, worse_by = how.may_differ(old, new), how.worse_by(old, new)
    # 0.9 - 0.85 is a little more than 0.05.
    same = abs(worse_by) <= allowed or math.isclose(abs(worse_by), allowed)
    verdict = "same" if same else "worse" if worse_by > 0.0 else "better"
    return Change(name, number, old.value, new.value, allowed, verdict)


def _of_one_kind(files: Sequence[Path]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Data of the old run and the new run; both quick or both full."""
    runs = []
    for file in files:
        try:
            data = json.loads(file.read_text("utf-8"))
        except ValueError as wrong:
            raise ValueError(f"{file}: no JSON: {wrong}") from None
        if not isinstance(data, dict):
            raise ValueError(f"{file}: no data of a study")
        runs.append(data)
    if bool(runs[0].get("quick")) != bool(runs[1].get("quick")):
        quick, full = files if runs[0].get("quick") else files[::-1]
        raise ValueError(f"{quick} is of a quick run and {full} is not: compare runs of one kind")
    return runs[0], runs[1]
