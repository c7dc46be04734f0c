"""Makes recording, summary and report of a session from the files of its processes."""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from common.files.private_file import write_private
from common.files.read_files import NotToml, parse_toml
from common.fingers import FINGERS
from common.health import read_status
from common.scenes.scene import load_scene
from teletaction.recordings.merge import merge_recordings
from teletaction.recordings.session_data import SessionData
from teletaction.recordings.summary import summarise
from teletaction.report.examination import Examination
from teletaction.report.found_lumps import found_lumps
from teletaction.report.found_targets import found_targets
from teletaction.report.report import write_report
from teletaction.report.session_report import report
from teletaction.session.demo_files import CONSOLE, NETWORK, PROCESSES, SIMULATORS, SITES
from teletaction.session.launcher_figures import LauncherFigures

_SESSION = {"scene", "seed", "fingers"}


class _Simulated(msgspec.Struct, frozen=True):
    """What the simulated remote site has in its configuration, or its defaults."""

    scene: str = "materials"
    seed: int = 0
    fingers: Sequence[str] = FINGERS


def conclude(
    folder: Path, out: Path, given: Mapping[str, Any], stage: Callable[[str], None] = lambda _: None
) -> dict[str, Any]:
    """Merge the recordings in `folder`, and write `session.mcap`, `summary.json` and `report.html` into `out`.

    The folder of a demo then loses the recordings of its processes, unless one of them is incomplete.

    A session on real devices has no recordings of simulators, and so no truth: recording and report are made of what
    the folder has, without a summary.

    Args:
        folder: folder with `PROCESS.mcap` and `PROCESS.json` (status) of all processes. A restarted process adds
            `PROCESS-1.mcap` and so on; a simulated network adds `network.json`, and a demo `launcher.json`.
        out: folder for the results, created if it does not exist.
        given: `scene`, `seed` and number of `fingers` of the session, where they are not those that it recorded.
        stage: is called with a description of each stage of the work.

    Returns:
        The summary; empty for a session on real devices.

    Raises:
        ValueError: the scene is unknown, or a recording or a status is missing or cannot be read.
        OSError: `out` cannot be written.
    """
    if "scene" in given:
        load_scene(given["scene"])  # a wrong one is named before anything is written
    if real := _of_real_devices(folder):
        _conclude_real(real, out, stage)
        return {}
    recordings = [path for name in PROCESSES for path in recordings_of(folder, name)]
    if any(folder.glob(f"{CONSOLE}*.mcap")):
        recordings += recordings_of(folder, CONSOLE)
    statuses = {name: _status(folder / f"{name}.json") for name in PROCESSES}
    if (folder / f"{NETWORK}.json").exists():
        statuses[NETWORK] = _status(folder / f"{NETWORK}.json")
    launcher = LauncherFigures.read(folder)
    measured = launcher or LauncherFigures(
        usage={name: (status["loop"]["cpu"], status["rss_mib"]) for name, status in statuses.items()},
        wall_s=float(statuses["sim-operator"]["script_s"]),
        round_trips_s=[],
    )
    out.mkdir(parents=True, exist_ok=True)
    stage("merging the recordings")
    merge_recordings(recordings, out / "session.mcap")
    stage("computing the summary")
    data = SessionData.read(out / "session.mcap")
    examination = Examination.read(out / "session.mcap")
    session = given if given.keys() >= _SESSION else {**_recorded(examination), **given}
    scene = load_scene(session["scene"])
    summary = summarise(
        data,
        statuses,
        statuses.get(NETWORK),
        measured.usage,
        measured.wall_s,
        measured.round_trips_s,
        objects=scene.objects,
        **session,
    )
    summary["targets"] = found_targets(scene, examination.felt)
    summary["lumps"] = found_lumps(examination.felt, scene.nodules)
    write_private(out / "summary.json", json.dumps(summary, indent=1).encode() + b"\n")
    stage("drawing the report")
    write_report(data, summary, out / "report.html", examination)
    if launcher is not None and folder == out:
        remove_merged(recordings, summary)
    return summary


def _of_real_devices(folder: Path) -> list[Path]:
    """Return the recordings of a session without simulators; none where a simulator or both sites are missing."""
    found = {name: _recordings(folder, name) for name in (*PROCESSES, CONSOLE)}
    if any(found[name] for name in SIMULATORS) or not any(found[name] for name in SITES):
        return []
    return [path for paths in found.values() for path in paths]


def _conclude_real(recordings: Sequence[Path], out: Path, stage: Callable[[str], None]) -> None:
    """Write `session.mcap` and `report.html` of a session on real devices."""
    out.mkdir(parents=True, exist_ok=True)
    stage("merging the recordings")
    merge_recordings(list(recordings), out / "session.mcap")
    stage("drawing the report")
    report([out / "session.mcap"], out / "report.html")


def _recorded(examination: Examination) -> dict[str, Any]:
    """Return scene, seed and number of fingers that the simulated remote site recorded."""
    text = examination.facts.get("sim-remote", {}).get("configuration", "")
    try:
        recorded = msgspec.convert(parse_toml(text), _Simulated)
        return {"scene": recorded.scene, "seed": recorded.seed, "fingers": len(recorded.fingers)}
    except (NotToml, msgspec.ValidationError) as error:
        raise ValueError(f"sim-remote.mcap: its configuration: {error}; give --scene, --seed and --fingers") from None


def remove_merged(recordings: Sequence[Path], summary: Mapping[str, Any]) -> None:
    """Remove the recordings of a session that were merged, unless its summary calls one of them incomplete."""
    if not incomplete_of(summary):
        for path in recordings:
            path.unlink()


def incomplete_of(summary: Mapping[str, Any]) -> list[str]:
    """Return the process and the loss of each incomplete recording of a summary."""
    return [f"{fault['site']}: {fault['fault']}" for fault in summary["faults"] if fault["what"] == "recording"]


def recordings_of(folder: Path, process: str) -> list[Path]:
    """Return all recordings of one process: `PROCESS.mcap` and those set aside before a restart.

    Raises:
        ValueError: the process has no recording.
    """
    found = _recordings(folder, process)
    if found:
        return found
    if not folder.is_dir():
        raise ValueError(f"{folder}: no such folder")
    missing = f"{folder}: no recording of {process} ({process}.mcap)"
    if (merged := folder / "session.mcap").exists():
        raise ValueError(f"{missing}; {merged} is merged already: `teletaction report` makes its report")
    raise ValueError(missing)


def _recordings(folder: Path, process: str) -> list[Path]:
    name = re.compile(rf"{re.escape(process)}(-\d+)?\.mcap")
    return sorted(path for path in folder.glob("*.mcap") if name.fullmatch(path.name))


def _status(path: Path) -> dict[str, Any]:
    if not path.exists():
        raise ValueError(f"{path}: missing; a process writes it when `status` is configured")
    return read_status(path, 0)[0]
