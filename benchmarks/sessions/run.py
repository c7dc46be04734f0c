"""Number of sessions that one machine carries: 1, 2, 4 and 8 side by side, and the loops that miss their rates.

Each session runs real processes with simulated devices and one finger over the real transports. New sessions join the
running ones, so the first session runs beside more and more others. Each number of sessions is measured after its last
session has started working. Measured are rate and lateness of the loops, packets and their age, processor time, waiting
and memory.
"""

import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.sessions.look import Look, look
from benchmarks.sessions.recorded import TICKS, Recorded
from common.runtime.machine import ProcessorTime
from common.runtime.parallel_map import processors
from common.runtime.rate_monitor import HELD
from studies.compared import Compared
from studies.running import Progress, tables_of
from teletaction.session.demo_files import PROCESSES, DemoOptions, prepare
from teletaction.session.processes import SessionProcesses

MEASURES_THIS_MACHINE = "how many sessions it carries"
COUNTS, SECONDS = (1, 2, 4, 8), 20.0
QUICK_COUNTS, QUICK_SECONDS = (1, 2), 6.0
_START_S = 60.0
_SETTLE_S = 3.0
"""Pause between the last start and the measurement, s; a new process still loads code."""
_FULL = 0.1
"""Idle share of the processor time below which the machine lacks processors."""
_MEET = 0.1
"""Waiting share of a loop's time above which it lacks a free processor when it needs one."""
_SURELY = 0.02
"""Margin below HELD at which a rate counts as not held in every interval."""
tables = tables_of("counts", "loops", "streams")
COMPARED = (
    Compared("counts", "cores", "less", ("sessions",), absolute=0.1, relative=0.2),
    Compared("counts", "memory_mib", "less", ("sessions",), relative=0.1),
    Compared("counts", "made_least", "more", ("sessions",), absolute=0.1),
)
Row = dict[str, Any]


def run(*, quick: bool, seed: int, progress: Progress) -> dict[str, Any]:
    """Measure all numbers of sessions, or only one and two if `quick`."""
    if quick:
        return measure(QUICK_COUNTS, QUICK_SECONDS, seed, progress)
    return measure(COUNTS, SECONDS, seed, progress)


def measure(counts: Sequence[int], seconds: float, seed: int, progress: Progress) -> dict[str, Any]:
    """Measure rising numbers of sessions, each for `seconds`.

    `does_not_fit` lists the rates that are not held, with the lacking resource. `problems` lists those of them that the
    process itself does not report.
    """
    late: list[str] = []
    stages: list[Stage] = []
    with TemporaryDirectory(prefix="sessions-") as spare:
        folders = [Path(spare) / f"session-{number + 1}" for number in range(max(counts))]
        with ExitStack() as running:
            pairs: list[SessionProcesses] = []
            for count in counts:
                for number in range(len(pairs), count):
                    progress(f"session {number + 1} of {max(counts)} begins")
                    pairs.append(SessionProcesses(folders[number]))
                    running.callback(pairs[-1].end)
                    if not _begin(pairs[-1], seed + number):
                        late.append(f"session {number + 1} did not start working within {_START_S:g} s")
                progress(f"{count} at work")
                time.sleep(_SETTLE_S)
                stages.append(Stage.measured(pairs, seconds))
            progress("all end")
        recorded = [Recorded.read(folder) for folder in folders]
    loops = [row for stage in stages for row in stage.loops(recorded)]
    counted = [stage.counted(loops) for stage in stages]
    return {
        "seconds": seconds,
        "processors": processors(),
        "counts": counted,
        "loops": loops,
        "streams": [row for stage in stages for row in stage.streams(recorded)],
        "does_not_fit": late + [line for row in counted for line in does_not_fit(row, loops)],
        "problems": silent(loops),
    }


@dataclass(frozen=True, slots=True)
class Stage:
    """Measurement of a number of sessions.

    Attributes:
        begin, end: for each session, a look at each process by name, at the start and at the end.
        shares: idle and stolen shares of the machine's processor time.
    """

    begin: list[dict[str, Look]]
    end: list[dict[str, Look]]
    shares: dict[str, float]

    @classmethod
    def measured(cls, pairs: Sequence[SessionProcesses], seconds: float) -> "Stage":
        """Look at all processes, wait, and look again."""
        begin, before = [look(pair) for pair in pairs], ProcessorTime.now()
        time.sleep(seconds)
        shares = ProcessorTime.now().shares(before)
        return cls(begin, [look(pair) for pair in pairs], shares)

    def loops(self, recorded: Sequence[Recorded]) -> list[Row]:
        """Return a row for each process; only sites have a lateness of their ticks."""
        rows = []
        for number, (begin, end) in enumerate(zip(self.begin, self.end, strict=True)):
            for name in PROCESSES:
                if name not in begin or name not in end:
                    continue  # it never started, or ended by itself
                row: Row = {"sessions": len(self.end), "session": number + 1, "process": name} | end[name].since(
                    begin[name]
                )
                while_s = begin[name].status_s, end[name].status_s
                rows.append(row | recorded[number].lateness(name, *while_s, 1.0 / row["wanted_hz"]))
        return rows

    def streams(self, recorded: Sequence[Recorded]) -> list[Row]:
        """Return a row for each session's motion and touch: packets per second, their age, and the longest gap."""
        rows = []
        for number, (begin, end) in enumerate(zip(self.begin, self.end, strict=True)):
            for stream, sender, receiver in (("motion", "operator", "remote"), ("touch", "remote", "operator")):
                if not {sender, receiver} <= begin.keys() & end.keys():
                    continue
                while_s = begin[receiver].status_s, end[receiver].status_s
                rows.append(
                    {"sessions": len(self.end), "session": number + 1, "stream": stream}
                    | end[sender].packets(begin[sender], stream, ("sent", "spared"))
                    | end[receiver].packets(begin[receiver], stream, ("received", "superseded", "refused"))
                    | recorded[number].arrivals(stream, *while_s)
                )
        return rows

    def counted(self, loops: Sequence[Row]) -> Row:
        """Return one row of what all sessions did and used.

        `made_least` is the share of its ticks that the worst loop made. `others` is the share of processor time that
        other programs used, and the kernel outside any process.
        """
        count = len(self.end)
        mine = [row for row in loops if row["sessions"] == count]
        behind = {row["session"] for row in mine if row["made"] < HELD}
        engaged = [all(site in end and end[site].status["state"] == "engaged" for site in TICKS) for end in self.end]
        return {
            "sessions": count,
            "hold_their_rates": len({row["session"] for row in mine} - behind),
            "engaged_at_end": sum(engaged),
            "made_least": min((row["made"] for row in mine), default=0.0),
            "cores": (cores := round(sum(row["core"] for row in mine), 3)),
            "memory_mib": round(sum(row["memory_mib"] for row in mine), 1),
            **self.shares,
            "others": round(max(0.0, 1.0 - self.shares["idle"] - self.shares["stolen"] - cores / processors()), 4),
        }


def does_not_fit(counted: Row, loops: Sequence[Row]) -> list[str]:
    """Describe the loops that do not hold their rates, one line per process, with the lacking resource."""
    count, lines = counted["sessions"], []
    sessions = f"{count} session{'s' if count > 1 else ''}"
    shares = f"{counted['idle']:.0%} of processor time is idle, {counted['stolen']:.0%} is stolen by the host"
    shares += f", {counted['others']:.0%} goes to other programs"
    for process in PROCESSES:
        mine = [row for row in loops if (row["sessions"], row["process"]) == (count, process)]
        behind = sorted((row for row in mine if row["made"] < HELD), key=lambda row: float(row["made"]))
        if behind:
            worst = behind[0]
            if counted["idle"] < _FULL:
                lacking = "processors"
            elif worst["loop_waits"] > _MEET:
                lacking = "a free processor when one is needed"
            else:
                lacking = "time of the loop itself, not processors"
            lines.append(
                f"{sessions}: {len(behind)} x {process} behind, {worst['rate_hz']:.0f} of {worst['wanted_hz']:g} ticks "
                f"a second at worst; works {worst['loop_works']:.0%} of the time and waits for a processor "
                f"{worst['loop_waits']:.0%}; lacks {lacking}: {shares}"
            )
    if fallen := count - counted["engaged_at_end"]:
        lines.append(f"{sessions}: {fallen} no longer engaged")
    return lines


def silent(loops: Sequence[Row]) -> list[str]:
    """List the loops that were clearly behind and did not report it in their status files."""
    return [
        f"{row['sessions']} sessions: {row['process']} of session {row['session']} makes {row['made']:.0%} of its "
        "ticks, and its status does not report it"
        for row in loops
        if row["made"] < HELD - _SURELY and not row["said"]
    ]


def _begin(pair: SessionProcesses, seed: int) -> bool:
    """Start a session and wait until both sites are engaged and the hand works; return False if they do not."""
    pair.out.mkdir()
    options = DemoOptions(seconds=3600.0, fingers=1, seed=seed)
    for name, configuration in prepare(options, pair.out).items():
        pair.start(name, configuration)
    end_s = time.monotonic() + _START_S
    while time.monotonic() < end_s and not pair.ended():
        statuses = {name: seen.status for name, seen in look(pair).items()}
        engaged = all(statuses.get(site, {}).get("state") == "engaged" for site in TICKS)
        if engaged and statuses.get("sim-operator", {}).get("script_s"):
            return True
        time.sleep(0.2)
    return False
