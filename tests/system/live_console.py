"""The console's process beside a real operator site on a virtual environment, with simulated devices."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from common.config.file import load_config, to_toml
from common.config.page_models import ConsoleConfig
from robustness.fault_session import read_figures
from teletaction.session.demo_files import DemoOptions, prepare
from teletaction.session.processes import SessionProcesses
from tests.system.page import PATIENCE_S


@dataclass
class Session:
    """The processes of a session, and where the page is."""

    folder: Path
    processes: SessionProcesses
    address: str

    def restart_console(self) -> None:
        """Kill it, as nothing but a crash or a person does, and start it again."""
        old = int(read_figures(self.folder, "console")["pid"])
        self.processes.running["console"].kill()
        self.processes.running["console"].wait()
        self.processes.start("console", self.folder / "config" / "console.toml")
        self.address = _address(self.folder, self.processes, old)


def _address(folder: Path, processes: SessionProcesses, but: int = 0) -> str:
    """Where the page is, once its process, which is not number `but`, is there."""
    end_s = time.monotonic() + PATIENCE_S
    while not (figures := read_figures(folder, "console")).get("address") or figures["pid"] == but:
        ended = {name: processes.last_words(name) for name in processes.ended()}
        assert not ended, ended
        assert time.monotonic() < end_s, "the console did not start"
        time.sleep(0.02)
    return str(figures["address"])


def without_remote_site(configuration: Path) -> None:
    """There is none beside a virtual environment, and the report is made of the recordings that there are."""
    config = load_config(configuration, ConsoleConfig)
    command = tuple(part for part in config.report_command if not part.endswith("remote.mcap"))
    configuration.write_text(to_toml(config.model_copy(update={"report_command": command})), "utf-8")


@contextmanager
def running(folder: Path) -> Iterator[Session]:
    """Start all of it; at the end every process must have ended gently."""
    options = DemoOptions(seconds=600.0, fingers=2, scene="phantom", console=True)
    configurations = prepare(options, folder)
    without_remote_site(configurations["console"])
    processes = SessionProcesses(folder)
    processes.start("sim-operator", configurations["sim-operator"])
    processes.start("virtual", configurations["operator"], "--scene", "phantom", "--seed", "3")
    processes.start("console", configurations["console"])
    try:
        yield Session(folder, processes, _address(folder, processes))
    finally:
        killed = processes.end()
    assert killed == []
