"""How many sessions one machine carries: 1, 2, 4 and 8 pairs of sites side by side, and what does not fit.

Real processes with simulated devices over the real transports, one finger each. Pairs are added to those that work
already, so that the first one is seen beside more and more others. Each number is measured for a while after its last
pair has come to work: rate and lateness of the loops, packets and their age, processor time, waiting and memory.
"""

import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from common.held_rate import HELD
from common.in_parallel import processors
from common.machine import ProcessorTime
from studies.compared import Compared
from studies.running import Tell
from studies.sessions_figure import plot
from studies.sessions_look import Look, look
from studies.sessions_recorded import TICKS, Recorded
from teletaction.demo_files import PROCESSES, DemoOptions, prepare
from teletaction.processes import SessionProcesses

__all__ = ["plot", "run", "tables"]
MEASURES_THIS_MACHINE = "how many sessions it carries"
COUNTS, SECONDS = (1, 2, 4, 8), 20.0
QUICK_COUNTS, QUICK_SECONDS = (1, 2), 6.0
_START_S = 60.0
_SETTLE_S = 3.0
"""A process that has just started still loads."""
_FULL = 0.1
"""With less of the processors' time idle than this, it is processors that are lacking."""
_MEET = 0.1
"""With a larger share of its time spent waiting than this, a loop finds no processor when it wants one."""
_SURELY = 0.02
"""So far below HELD a rate is not held in whatever seconds one looks."""
COMPARED = (
    Compared("counts", "cores", "less", ("sessions",), absolute=0.1, relative=0.2),
    Compared("counts", "memory_mib", "less", ("sessions",), relative=0.1),
    Compared("counts", "made_least", "more", ("sessions",), absolute=0.1),
)
Row = dict[str, Any]


def run(*, quick: bool, seed: int, tell: Tell) -> dict[str, Any]:
    """Measure; quick: two sessions at most."""
    if quick:
        return measure(QUICK_COUNTS, QUICK_SECONDS, seed, tell)
    return measure(COUNTS, SECONDS, seed, tell)


def measure(counts: Sequence[int], seconds: float, seed: int, tell: Tell) -> dict[str, Any]:
    """Rows for rising numbers of sessions, each measured for so long.

    `does_not_fit` says which rates are not held, and what is lacking; `problems`, of which of these a process itself
    says nothing.
    """
    late: list[str] = []
    stages: list[Stage] = []
    with TemporaryDirectory(prefix="sessions-") as spare:
        folders = [Path(spare) / f"session-{number + 1}" for number in range(max(counts))]
        with ExitStack() as running:
            pairs: list[SessionProcesses] = []
            for count in counts:
                for number in range(len(pairs), count):
                    tell(f"session {number + 1} of {max(counts)} begins")
                    pairs.append(SessionProcesses(folders[number]))
                    running.callback(pairs[-1].end)
                    if not _begin(pairs[-1], seed + number):
                        late.append(f"session {number + 1} did not come to work within {_START_S:g} s")
                tell(f"{count} at work")
                time.sleep(_SETTLE_S)
                stages.append(Stage.measured(pairs, seconds))
            tell("they end")
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


def tables(data: Mapping[str, Any]) -> dict[str, list[Row]]:
    """By number of sessions, by process, and by stream."""
    return {name: data[name] for name in ("counts", "loops", "streams")}


@dataclass(frozen=True, slots=True)
class Stage:
    """So many sessions, each looked at when a while began and when it was over: its processes by name.

    Attributes:
        shares: of the machine's processors' time that was idle and stolen.
    """

    begin: list[dict[str, Look]]
    end: list[dict[str, Look]]
    shares: dict[str, float]

    @classmethod
    def measured(cls, pairs: Sequence[SessionProcesses], seconds: float) -> "Stage":
        """Look, wait, look."""
        begin, before = [look(pair) for pair in pairs], ProcessorTime.now()
        time.sleep(seconds)
        shares = ProcessorTime.now().shares(before)
        return cls(begin, [look(pair) for pair in pairs], shares)

    def loops(self, recorded: Sequence[Recorded]) -> list[Row]:
        """A row for each process; the lateness of its ticks is known of sites."""
        rows = []
        for number, (begin, end) in enumerate(zip(self.begin, self.end, strict=True)):
            for name in PROCESSES:
                if name not in begin or name not in end:
                    continue  # it never came so far, or ended by itself
                row: Row = {"sessions": len(self.end), "session": number + 1, "process": name} | end[name].since(
                    begin[name]
                )
                while_s = begin[name].told_s, end[name].told_s
                rows.append(row | recorded[number].lateness(name, *while_s, 1.0 / row["wanted_hz"]))
        return rows

    def streams(self, recorded: Sequence[Recorded]) -> list[Row]:
        """A row for each session's motion and touch: packets a second, their age, and the longest gap."""
        rows = []
        for number, (begin, end) in enumerate(zip(self.begin, self.end, strict=True)):
            for stream, sender, receiver in (("motion", "operator", "remote"), ("touch", "remote", "operator")):
                if not {sender, receiver} <= begin.keys() & end.keys():
                    continue
                while_s = begin[receiver].told_s, end[receiver].told_s
                rows.append(
                    {"sessions": len(self.end), "session": number + 1, "stream": stream}
                    | end[sender].packets(begin[sender], stream, ("sent", "spared"))
                    | end[receiver].packets(begin[receiver], stream, ("received", "superseded", "refused"))
                    | recorded[number].arrivals(stream, *while_s)
                )
        return rows

    def counted(self, loops: Sequence[Row]) -> Row:
        """One row: what all sessions did and used.

        `made_least` is the share of its ticks that the worst loop made; `others`, of the processors' time what went to
        whatever else ran on this machine, and to its kernel on nobody's account.
        """
        count = len(self.end)
        mine = [row for row in loops if row["sessions"] == count]
        behind = {row["session"] for row in mine if row["made"] < HELD}
        engaged = [all(site in end and end[site].told["state"] == "engaged" for site in TICKS) for end in self.end]
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
    """Which loops of so many sessions do not hold their rates, a line for each process, and what is lacking."""
    count, lines = counted["sessions"], []
    sessions = f"{count} session{'s' if count > 1 else ''}"
    shares = f"{counted['idle']:.0%} of their time is idle, {counted['stolen']:.0%} has the machine's host taken"
    shares += f", {counted['others']:.0%} goes to others"
    for process in PROCESSES:
        mine = [row for row in loops if (row["sessions"], row["process"]) == (count, process)]
        behind = sorted((row for row in mine if row["made"] < HELD), key=lambda row: float(row["made"]))
        if behind:
            worst = behind[0]
            if counted["idle"] < _FULL:
                lacking = "processors"
            elif worst["loop_waits"] > _MEET:
                lacking = "a free processor when it is wanted"
            else:
                lacking = "no processor but the loop's own time"
            lines.append(
                f"{sessions}: {len(behind)} x {process} behind, {worst['rate_hz']:.0f} of {worst['wanted_hz']:g} ticks "
                f"a second at worst; works {worst['loop_works']:.0%} of the time and waits for a processor "
                f"{worst['loop_waits']:.0%}; lacking is {lacking}: {shares}"
            )
    if fallen := count - counted["engaged_at_end"]:
        lines.append(f"{sessions}: {fallen} not engaged any more")
    return lines


def silent(loops: Sequence[Row]) -> list[str]:
    """Loops that were surely behind, and whose own status files did not say so."""
    return [
        f"{row['sessions']} sessions: {row['process']} of session {row['session']} makes {row['made']:.0%} of its "
        "ticks, and its status says nothing of it"
        for row in loops
        if row["made"] < HELD - _SURELY and not row["said"]
    ]


def _begin(pair: SessionProcesses, seed: int) -> bool:
    """Start a session, and wait until both sites are engaged and the hand works; False where that does not come."""
    pair.out.mkdir()
    options = DemoOptions(seconds=3600.0, fingers=1, seed=seed)
    for name, configuration in prepare(options, pair.out).items():
        pair.start(name, configuration)
    end_s = time.monotonic() + _START_S
    while time.monotonic() < end_s and not pair.ended():
        told = {name: seen.told for name, seen in look(pair).items()}
        if all(told.get(site, {}).get("state") == "engaged" for site in TICKS) and _hand_works(told):
            return True
        time.sleep(0.2)
    return False


def _hand_works(told: Mapping[str, Mapping[str, Any]]) -> bool:
    return bool(told.get("sim-operator", {}).get("script_s"))
