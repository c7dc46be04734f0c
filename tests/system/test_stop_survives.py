"""A stop and the patient's force limit hold after the remote site was killed, until a person there ends them."""

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from common.config.file import load_config
from common.config.site_models import RemoteConfig
from common.link.curve import LinkProblem
from common.link.keys import load_keys
from common.link.local_control import ask_desk
from teletaction.session.demo_files import DemoOptions, prepare
from teletaction.session.processes import SessionProcesses
from tests.waiting import wait_until

pytestmark = [pytest.mark.session, pytest.mark.timeout(90)]


class RemoteAlone:
    """A remote site and its simulated devices, without an operator."""

    def __init__(self, folder: Path) -> None:
        self.configurations = prepare(DemoOptions(seconds=60.0, fingers=1, patient_switch=True), folder)
        self.config = load_config(self.configurations["remote"], RemoteConfig)
        self.processes = SessionProcesses(folder)
        for process in ("sim-remote", "remote"):
            self.processes.start(process, self.configurations[process])
        self.wait()

    def ask(self, verb: str) -> dict[str, Any]:
        return ask_desk(self.config.desk_port, load_keys(self.config.link.keys), verb)

    def answers(self) -> bool:
        try:
            return bool(self.ask("status"))
        except LinkProblem:
            return False

    def wait(self) -> None:
        """Wait until the site answers."""
        wait_until(self.answers, lambda: self.processes.last_words("remote"), 30.0)

    def restart(self, number: int) -> str:
        """End the process by a signal, start it again, and return the code of its latched fault."""
        process = self.processes.running["remote"]
        process.send_signal(number)
        process.wait(10.0)
        self.processes.restart("remote")
        self.wait()
        fault = self.ask("status")["fault"]
        return str(fault[0]) if fault else ""


@pytest.fixture
def site(tmp_path: Path) -> Iterator[RemoteAlone]:
    alone = RemoteAlone(tmp_path)
    try:
        yield alone
    finally:
        alone.processes.end()


def test_a_stop_outlives_the_process_that_latched_it(site: RemoteAlone) -> None:
    assert site.restart(signal.SIGKILL) == ""
    site.ask("estop")
    wait_until(site.config.status.with_suffix(".stop").exists, "the stop is not kept")  # type: ignore[union-attr]
    assert site.restart(signal.SIGKILL) == "remote-stop"
    assert site.restart(signal.SIGTERM) == "remote-stop"
    assert site.ask("clear_fault")["fault"] is None
    assert site.restart(signal.SIGTERM) == ""


def test_the_force_limit_of_the_patient_outlives_the_process(site: RemoteAlone) -> None:
    file = site.config.status.with_suffix(".pain")  # type: ignore[union-attr]
    assert "patient_limit_n" not in site.ask("status")
    file.write_text("1.25\n")
    for number in (signal.SIGKILL, signal.SIGTERM):
        assert site.restart(number) == ""
        assert site.ask("status")["patient_limit_n"] == 1.25
    assert "patient_limit_n" not in site.ask("restore_force")
    wait_until(lambda: not file.exists(), "the limit is kept")
    site.restart(signal.SIGTERM)
    assert "patient_limit_n" not in site.ask("status")
