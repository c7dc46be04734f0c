"""Describes what the processes of a session have recorded, and which recordings are incomplete."""

from collections.abc import Sequence
from pathlib import Path
from shlex import quote

from common.health import NoStatus, read_status
from common.privacy.recording_file import open_recording
from common.recording.truncated_mcap import has_end
from teletaction.recordings.recording_loss import recording_loss
from teletaction.session.demo_files import CONSOLE, PROCESSES


def saved_words(out: Path, seconds: float, incomplete: Sequence[str]) -> str:
    """Return in one line how long a session was recorded (s), where, and if the recordings are complete."""
    count = len(_recordings(out))
    found = "1 recording" if count == 1 else f"{count} recordings"
    whole = f"not complete: {'; '.join(incomplete)}" if incomplete else "complete"
    return f"saved {seconds:.0f} s of exploration in {out}: {found}, {whole}"


def incomplete_recordings(out: Path) -> list[str]:
    """Return for each incomplete recording of a session that has ended: its process and the reason."""
    found = []
    for path in _recordings(out):
        with open_recording(path) as file:
            if not has_end(file):
                found.append(f"{path.stem}: cut off, `teletaction recover {quote(str(path))}` reads the rest")
    for name in PROCESSES:
        try:
            status = read_status(out / f"{name}.json", 0)[0]
        except NoStatus:
            continue
        if words := recording_loss(status):
            found.append(f"{name}: {words}")
    return found


def _recordings(out: Path) -> list[Path]:
    """Return the recordings of all processes, and those set aside before a restart."""
    return sorted(path for name in (*PROCESSES, CONSOLE) for path in out.glob(f"{name}*.mcap"))
