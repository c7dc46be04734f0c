"""Runs tests that take too long for each commit, piece by piece, and keeps a record of the runs.

`python -m tests.everything` runs the pieces that have not passed at this commit, one after the other. Interrupted, it
begins with the piece that was interrupted. `python -m tests.everything NAME ...` runs pieces by name.
"""

import json
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from datetime import date
from pathlib import Path
from typing import NamedTuple

from common.runtime.machine import Machine
from common.runtime.parallel_map import processors

PIECES: dict[str, tuple[str, ...]] = {
    "breaks": ("breaks",),
    "long": ("long",),
    "examples": ("examples",),
    "hardening": ("hardening",),
    "properties": ("properties",),
    "costs": ("costs",),
    "study-tests": ("study-tests",),
    "netns": ("netns",),
    "image": ("image",),
    "pages": ("pages",),
    "dask": ("dask",),
    "console": ("console",),
    "exports": ("exports",),
    "faults": ("faults",),
    "faults-real": ("faults", "FAULTS=real"),
    "soak": ("soak", "SOAK_OUT=build/everything/soak"),
    "studies": ("results", "ARGUMENTS=--quick", "RESULTS=build/everything/results"),
}
"""Targets and settings of `make`, each of them in less than 45 minutes."""
SCRATCH = Path("build/everything")
"""What pieces leave; each begins without it."""
RECORD = Path("docs/verification.json")
PAGE = Path("docs/verification.md")
WRITTEN = (str(RECORD), str(PAGE), "docs/faults.md", "docs/faults.json")
"""What a run itself changes."""
HEAD = """# Verification record

`make test` and `.ci/run` pass for each commit. `make everything` runs the longer tests in pieces, and writes this page.
It has the newest run of each piece. The reference step measures the speed of the machine (0.1 ms is a usual value).
*Not judged* is a real-time test that failed while the machine stood still.

| piece | commit | day | minutes | processors, reference step | passed | skipped | not judged | failed |
|---|---|---|---|---|---|---|---|---|
"""
_COUNT = re.compile(r"(\d+) (passed|failed|skipped|error)")
_SUMMARY = re.compile(r"^(?:=+ .*\bin [\d.]+s\b.* =+|\d+ passed, \d+ failed)$", re.MULTILINE)
_FAILED = re.compile(r"^(?:FAILED|ERROR|MISSED) (\S.*?)(?: - .*)?$", re.MULTILINE)
_NOT_JUDGED = re.compile(r"^NOT JUDGED (.+)$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Run:
    """One run of a piece.

    Attributes:
        piece: key of PIECES.
        commit: what was tried; with a `+` where files were changed.
        day: as in ISO 8601.
        minutes: how long it took.
        processors: of the machine.
        reference_step_us: of the machine just before, us.
        passed, skipped: tests; the latter include those of `not_judged`.
        not_judged: what a machine that stood still took away, a line each.
        failed: names of tests, or what else failed; empty where nothing did.
    """

    piece: str
    commit: str
    day: str
    minutes: float
    processors: int
    reference_step_us: float
    passed: int
    skipped: int
    not_judged: tuple[str, ...]
    failed: tuple[str, ...]


def read(record: Path = RECORD) -> dict[str, Run]:
    """The newest run of each piece; none where nothing is recorded."""
    if not record.is_file():
        return {}
    rows = json.loads(record.read_text("utf-8"))
    runs = (Run(**row | {key: tuple(row[key]) for key in ("not_judged", "failed")}) for row in rows)
    return {run.piece: run for run in runs}


def write(runs: Iterable[Run], record: Path = RECORD, page: Path = PAGE) -> None:
    """Write the newest runs down, as data and as a page."""
    ordered = sorted(runs, key=lambda run: list(PIECES).index(run.piece))
    record.write_text(json.dumps([asdict(run) for run in ordered], indent=1) + "\n", "utf-8")
    page.write_text(HEAD + "".join(_row(run) for run in ordered), "utf-8")


def _row(run: Run) -> str:
    machine = f"{run.processors}, {run.reference_step_us:.0f} us"
    named = (" ".join(f"`{name}`" for name in names) or "none" for names in (run.not_judged, run.failed))
    cells = (run.piece, run.commit, run.day, f"{run.minutes:.1f}", machine, run.passed, run.skipped, *named)
    return f"| {' | '.join(map(str, cells))} |\n"


class Counted(NamedTuple):
    """What a run of tests came to, as in `Run`."""

    passed: int
    skipped: int
    not_judged: tuple[str, ...]
    failed: tuple[str, ...]


def counted(output: str) -> Counted:
    """What the output of one pytest after the other says."""
    found = {"passed": 0, "skipped": 0}
    for summary in _SUMMARY.findall(output):
        for count, what in _COUNT.findall(summary):
            if what in found:
                found[what] += int(count)
    names = (tuple(dict.fromkeys(pattern.findall(output))) for pattern in (_NOT_JUDGED, _FAILED))
    return Counted(found["passed"], found["skipped"], *names)


def run_piece(piece: str, commit: str) -> Run:
    """Run a piece, show what it prints, and say what came of it."""
    shutil.rmtree(SCRATCH, ignore_errors=True)
    SCRATCH.mkdir(parents=True)
    machine, begun_s = Machine.measured(), time.monotonic()
    lines = []
    words = ["make", *PIECES[piece]]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as make:
        assert make.stdout is not None
        for line in make.stdout:
            print(line, end="", flush=True)
            lines.append(line)
    found = counted("".join(lines))
    if make.returncode and not found.failed:
        found = found._replace(failed=(f"{' '.join(words)}: exit code {make.returncode}",))
    return Run(
        piece,
        commit,
        date.today().isoformat(),
        round((time.monotonic() - begun_s) / 60.0, 1),
        processors(),
        round(machine.step_s * 1e6, 1),
        *found,
    )


def this_commit() -> str:
    """The commit of the working tree, with a `+` where files were changed other than by a run."""

    def git(*words: str) -> str:
        return subprocess.run(["git", *words], capture_output=True, text=True, check=True).stdout.strip()

    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", *(f":!{file}" for file in WRITTEN))
    return git("rev-parse", "--short=9", "HEAD") + ("+" if changed else "")


def main(names: Sequence[str]) -> int:
    """Run pieces; returns 1 where one failed, and 2 where a name is unknown."""
    if unknown := [name for name in names if name not in PIECES]:
        print(f"no piece {unknown[0]!r}; there are: {', '.join(PIECES)}", file=sys.stderr)
        return 2
    commit, runs = this_commit(), read()
    chosen = names or [name for name in PIECES if name not in runs or runs[name].commit != commit or runs[name].failed]
    for name in chosen:
        print(f"== {name}", flush=True)
        runs[name] = run_piece(name, commit)
        write(runs.values())
    failed = [name for name in chosen if runs[name].failed]
    print(f"{len(chosen) - len(failed)} of {len(chosen)} pieces passed; {PAGE} has all of them")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
