"""Sessions on simulated devices for Python programs."""

import tempfile
from pathlib import Path

from teletaction.api.recording import Recording
from teletaction.session.demo_files import DemoOptions
from teletaction.testbed.virtual_recording import record_session


def simulate(
    scene: str = "materials", seconds: float = 10.0, fingers: int = 5, seed: int = 0, out: Path | str | None = None
) -> Recording:
    """Run a session on simulated devices and a virtual clock, and return its recording.

    Args:
        scene: name of a shipped scene, or path of a scene file.
        seconds: duration of the exploration, s.
        fingers: number of fingers, 1..5.
        seed: seed of the simulated world; the same seed gives the same session.
        out: folder for configurations and recordings; without one, they are deleted after reading.

    Raises:
        ValueError: an argument is out of range, or the scene has no calibrated table.
        OSError: a file cannot be written.
    """
    if not 0.0 < seconds <= 3600.0:
        raise ValueError(f"seconds must be above 0 and at most 3600, not {seconds}")
    options = DemoOptions(seconds=seconds, scene=scene, fingers=fingers, seed=seed)
    if out is not None:
        return Recording(record_session(options, Path(out)))
    with tempfile.TemporaryDirectory() as temporary:
        recording = Recording(record_session(options, Path(temporary)))
        recording.read()
        return recording
