"""A console that plays a recording, as its command does."""

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def playing(path: Path) -> Iterator[str]:
    """The address of its page."""
    command = [sys.executable, "-m", "teletaction", "console", "--play", str(path), "--port", "0"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    try:
        for line in process.stderr:
            if (found := re.search(r"http://\S+", line)) is not None:
                yield found[0]
                break
        else:
            raise AssertionError("it ended without an address")
    finally:
        process.terminate()
        process.stderr.read()
        process.stderr.close()
        assert process.wait(10.0) == 0
