"""Keeps what the launcher of a demo measured until the summary is made."""

from pathlib import Path

import msgspec

from common.files.private_file import write_private

LAUNCHER = "launcher.json"


class LauncherFigures(msgspec.Struct, frozen=True):
    """What the launcher of a demo measured, in its output folder."""

    usage: dict[str, tuple[float, float]]
    """CPU share of one core and peak memory (MiB) of each process."""
    wall_s: float
    """Duration of the exploration, s."""
    round_trips_s: list[float]
    """Round trips of a bare ping that ran beside the session, s."""

    def write(self, folder: Path) -> None:
        """Write the file into the demo's folder."""
        write_private(folder / LAUNCHER, msgspec.json.encode(self))

    @classmethod
    def read(cls, folder: Path) -> "LauncherFigures | None":
        """Read the file, None where no demo wrote one; raises ValueError where it is damaged."""
        path = folder / LAUNCHER
        if not path.exists():
            return None
        try:
            return msgspec.json.decode(path.read_bytes(), type=cls)
        except msgspec.DecodeError as error:
            raise ValueError(f"{path}: {error}; delete it to use the figures of the status files") from None
