"""Soak test: one long session with random faults, which must work at the end as it did at the beginning.

    python -m robustness.soak --seconds 600 --seed 1 --out soak-out

It uses real processes, a proxied network and simulated devices, as the fault matrix does. `run` lists the checks.
"""

import argparse
import json
import statistics
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from robustness.soak_figure import plot
from robustness.soak_growth import GROWTH_MIB_H, STEP_MIB, Life, lives
from robustness.soak_judge import LIMITS, Episode, account, over_limits
from robustness.soak_plan import FAULTS
from robustness.soak_records import Records, read_records
from robustness.soak_session import Progress, Soak
from robustness.soak_watch import Sample, read_samples
from studies.compared import Compared

__all__ = ["plot", "run"]
MEASURES_THIS_MACHINE = "a session of real processes, in real time"
USUAL_S, QUICK_S = 600.0, 75.0
_SAMPLES_KEPT = 500
"""Largest number of samples that the figure shows of each life."""
COMPARED = (Compared("again_s", "max", "less", absolute=2.0, relative=0.5),)


def run(
    quick: bool = False,
    seed: int = 0,
    seconds: float | None = None,
    out: Path | None = None,
    progress: Progress = lambda _: None,
) -> dict[str, Any]:
    """Run a session, inject random faults, and check these requirements.

    - The session works again within WORKS_AGAIN_S after each fault, by itself or after a person cleared it.
    - Each fault leaves a trace at each process that must detect it.
    - All limits hold at the simulated devices.
    - No process grows in memory, open files or threads.
    - Every recording can be read to its end.

    Args:
        quick: a little more than a minute instead of ten minutes.
        seed: seed of the faults, their order and the pauses.
        seconds: duration from when the session works, s. The last fault is still ended and judged.
        out: folder for the files of the processes, about 1 MB/s; must not hold a soak. None keeps nothing.
        progress: receives a line for each fault.

    Returns:
        Faults and findings. `problems` is empty when all is well, and `summary` is the result in one line.

    Raises:
        NotWorking: the session does not start working.
        FileExistsError: there is a soak in `out`.
    """
    length_s = seconds if seconds is not None else (QUICK_S if quick else USUAL_S)
    with tempfile.TemporaryDirectory(prefix="soak-") as spare:
        folder = (out or Path(spare)) / "session"
        folder.mkdir(parents=True)
        soak = Soak(folder, progress)
        soak.live(length_s, seed)
        samples = read_samples(soak.log)
        records = read_records(folder, soak.ends_s)
    return _judged(soak, samples, records, seed)


def _judged(soak: Soak, samples: Sequence[Sample], records: Records, seed: int) -> dict[str, Any]:
    by_process: dict[str, list[Sample]] = {}
    for sample in samples:
        by_process.setdefault(sample.process, []).append(sample)
    for episode in soak.episodes:
        account(episode, by_process, records.faults)
    found = lives(samples)
    grown = [life.growth() for life in found]
    killed = {process: len(ends_s) - 1 for process, ends_s in soak.ends_s.items() if len(ends_s) > 1}
    problems = [f"{episode.turn.name}: {each}" for episode in soak.episodes for each in episode.wrong]
    problems += over_limits(records.extremes, soak.episodes)
    problems += [each for life in grown for each in life["wrong"]]
    problems += records.wrong
    if killed != soak.restarts:
        problems.append(f"killed {killed}, started again {soak.restarts}")
    for process, seen in by_process.items():
        if lost := max(int(sample.status.get("recording_lost", 0)) for sample in seen):
            problems.append(f"{process}: {lost} messages lost by its recording")
    again_s = [episode.again_s for episode in soak.episodes if episode.again_s is not None]
    data = {
        "seconds": round(soak.end_s - soak.begin_s, 1),
        "seed": seed,
        "problems": problems,
        "episodes": [_reported(episode, soak.begin_s) for episode in soak.episodes],
        "faults": sum(len(episode.turn.faults) for episode in soak.episodes),
        "kinds": len({fault.key for episode in soak.episodes for fault in episode.turn.faults}),
        "kinds_in_all": len(FAULTS),
        "latched": sum(bool(episode.latched) for episode in soak.episodes),
        "restarts": soak.restarts,
        "again_s": {"median": round(statistics.median(again_s), 1), "max": round(max(again_s), 1)} if again_s else None,
        "limits": {
            name: {"max": round(records.extremes[name][0], 3), "limit": limit}
            for name, limit in LIMITS.values()
            if name in records.extremes
        },
        "lives": grown,
        "recordings": records.messages,
        "curves": [_curve(life, soak.begin_s) for life in found],
    }
    return {**data, "summary": summary(data)}


def _reported(episode: Episode, zero_s: float) -> dict[str, Any]:
    return {
        "faults": [fault.name for fault in episode.turn.faults],
        "where": [fault.where for fault in episode.turn.faults],
        "begin_s": round(episode.begin_s - zero_s, 2),
        "end_s": round(episode.end_s - zero_s, 2),
        "latched": [f"{site}: {reason}" for site, reason in episode.latched],
        "again_s": None if episode.again_s is None else round(episode.again_s, 2),
        "wrong": episode.wrong,
    }


def _curve(life: Life, zero_s: float) -> dict[str, Any]:
    step = 1 + len(life.time_s) // _SAMPLES_KEPT
    return {
        "process": life.process,
        "time_s": [round(float(value) - zero_s, 1) for value in life.time_s[::step]],
        "rss_mib": life.rss_mib[::step].tolist(),
    }


def summary(data: dict[str, Any]) -> str:
    """Return the result of a soak in one line."""
    rates = [life["rss_mib_h"] for life in data["lives"] if life["rss_mib_h"] is not None]
    allowed = f"allowed {STEP_MIB:g} MiB once, and {GROWTH_MIB_H:g} MiB/h"
    memory = f"memory at most +{max(rates):.0f} MiB/h ({allowed})" if rates else "memory flat"
    again = f"works again after {data['again_s']['max']:.1f} s at most, " if data["again_s"] else ""
    return (
        f"soak of {data['seconds']:.0f} s, seed {data['seed']}: {data['faults']} faults of {data['kinds']} kinds, "
        f"{data['latched']} latched, {sum(data['restarts'].values())} restarts, {again}{memory}: "
        + (f"{len(data['problems'])} problems" if data["problems"] else "all well")
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0 when all is well, or 1 after printing the problems."""
    parser = argparse.ArgumentParser(prog="python -m robustness.soak", description="run a session with random faults")
    parser.add_argument("--seconds", type=float, default=USUAL_S)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, required=True, help="folder for soak.json, soak.png and the recordings")
    options = parser.parse_args(arguments)
    if not 0.0 < options.seconds < 3600.0:
        parser.error("--seconds: must be above 0 and below 3600, the working time of the simulated hand")
    if (options.out / "session").exists():
        parser.error(f"{options.out}: already holds a soak; choose another folder")
    data = run(False, options.seed, options.seconds, options.out, lambda text: print(text, file=sys.stderr, flush=True))
    (options.out / "soak.json").write_text(json.dumps(data, indent=1) + "\n", "utf-8")
    plot(data, options.out / "soak.png")
    for problem in data["problems"]:
        print(problem, file=sys.stderr)
    print(data["summary"])
    return 1 if data["problems"] else 0


if __name__ == "__main__":
    sys.exit(main())
