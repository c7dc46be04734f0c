"""A demo with a console, as the command runs it: its process, its page, its network."""

import re
import signal
import socket
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from teletaction.session.demo_ports import HOST
from tests.waiting import wait_until


@dataclass
class Demo:
    """The command's process, where its page is, and its output folder."""

    process: subprocess.Popen[str]
    address: str
    out: Path

    def command(self, process: str, line: str) -> None:
        """Command a failure of a simulation, or end it."""
        port = tomllib.loads((self.out / "config" / f"{process}.toml").read_text("utf-8"))["fault_port"]
        with socket.create_connection((HOST, port), timeout=5.0) as connection:
            connection.sendall(line.encode() + b"\n")
            assert connection.makefile().readline().startswith("ok")

    def say(self, *words: str) -> None:
        """Run another command of the product beside it."""
        subprocess.run([sys.executable, "-m", "teletaction", *words], check=True)

    def finish(self) -> Path:
        """End it as Ctrl-C does; its recording."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            assert self.process.stderr is not None
            said = self.process.stderr.read()
            code = self.process.wait()
            assert code == 0, f"the demo ended with {code}: {said[-500:]}"
            wait_until((self.out / "report.html").is_file, "the report is not made", 60.0)
        return self.out / "session.mcap"


@contextmanager
def running(out: Path, *options: str) -> Iterator[Demo]:
    """Run `teletaction demo` with these options; it is there when its page has an address."""
    process = subprocess.Popen(
        [sys.executable, "-m", "teletaction", "demo", "--out", str(out), *options], stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    try:
        for line in process.stderr:
            if (found := re.search(r"console at (http://[\w.]+:\d+)", line)) is not None:
                break
        else:
            raise AssertionError("it ended without a console")
        yield Demo(process, found[1], out)
    finally:
        process.kill()
        process.wait()
        process.stderr.close()
