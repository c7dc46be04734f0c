"""Speed of encrypted files, MB a second of processor time; `python -m benchmarks.encryption.run` prints both ways."""

import os
import tempfile
import time
from pathlib import Path
from unittest.mock import patch

import typer

from common.link.keys import create_keys
from common.privacy.key_variable import KEY_VARIABLE
from common.privacy.recording_file import create_recording, open_recording

PART_BYTES, PARTS = 1 << 18, 400
"""Size of one write, as one of the recorder, and their number."""


def speeds_mb_s(folder: Path) -> tuple[float, float]:
    """Write and read a file in a folder; return the speeds of both, MB of content a second of processor time."""
    keys, path, part = folder / "keys", folder / "file", os.urandom(PART_BYTES)
    begun_s = time.process_time()
    with create_recording(path, create_keys(keys)) as file:
        for _ in range(PARTS):
            file.write(part)
            file.flush()
    written_s = time.process_time()
    with patch.dict(os.environ, {KEY_VARIABLE: str(keys)}), open_recording(path) as file:
        while file.read(PART_BYTES):
            pass
    megabytes = 1e-6 * PART_BYTES * PARTS
    return megabytes / (written_s - begun_s), megabytes / (time.process_time() - written_s)


def main() -> None:
    """Print both speeds."""
    with tempfile.TemporaryDirectory() as folder:
        written, read = speeds_mb_s(Path(folder))
    typer.echo(f"encrypting and writing {written:.0f} MB/s, reading and decrypting {read:.0f} MB/s")


if __name__ == "__main__":
    main()
