"""A process reports bad input in either form of log."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from teletaction.session.processes import SessionProcesses

CONFIG = """
log = "{form}"
fingers = ["index"]
[link]
keys = "absent"
[tacttip]
index = "socket://127.0.0.1:1"
[exoskeleton]
interface = "virtual"
"""


@pytest.mark.parametrize(
    ("form", "command"), [("text", ["-m", "operator_site"]), ("json", ["-m", "teletaction", "operator"])]
)
def test_bad_input_is_one_line_of_the_chosen_form_and_exit_2(tmp_path: Path, form: str, command: list[str]) -> None:
    config = tmp_path / "operator.toml"
    config.write_text(CONFIG.format(form=form), "utf-8")
    ended = subprocess.run(
        [sys.executable, *command, "--config", str(config)], capture_output=True, text=True, timeout=50, check=False
    )
    assert ended.returncode == 2
    assert ended.stdout == ""
    (line,) = ended.stderr.splitlines()
    if form == "json":
        logged = json.loads(line)
        assert (logged["level"], logged["process"]) == ("critical", "operator")
    (tmp_path / "operator.log").write_text(ended.stderr, "utf-8")
    words = SessionProcesses(tmp_path).last_words("operator")
    assert not words.startswith("{")
    assert "absent/site.key_secret: no key; make one with" in words


@pytest.mark.parametrize(
    ("room", "arguments", "expected"),
    [
        ("remote_site", "", "the following arguments are required: --config"),
        ("operator_site", "--config absent.toml", "absent.toml: No such file or directory"),
        ("sim_sensors", "", "the following arguments are required: process, --config"),
        ("sim_sensors", "remote --config absent.toml", "absent.toml: No such file or directory"),
        ("sim_sensors", "voice --config absent.toml", "argument process: invalid choice: 'voice' "),
    ],
)
def test_a_wrong_line_of_a_room_is_one_line_with_its_name(room: str, arguments: str, expected: str) -> None:
    line = [sys.executable, "-m", room, *arguments.split()]
    ended = subprocess.run(line, capture_output=True, text=True, timeout=50, check=False)
    assert (ended.returncode, ended.stdout) == (2, "")
    (said,) = ended.stderr.splitlines()
    assert said.startswith(f"python -m {room}: {expected}")


def test_a_process_without_output_is_reported_as_silent(tmp_path: Path) -> None:
    (tmp_path / "remote.log").write_text("\n", "utf-8")
    assert SessionProcesses(tmp_path).last_words("remote") == "its log is empty"


UNTIL_STOPPED = """
import os, signal, sys
from common.process import StopSignal
signal.signal(signal.SIGHUP, getattr(signal, sys.argv[1]))
stop = StopSignal()
os.kill(os.getpid(), signal.SIGHUP)
print("stopped" if stop() else "continues")
"""


@pytest.mark.parametrize(("handler", "outcome"), [("SIG_DFL", "stopped"), ("SIG_IGN", "continues")])
def test_a_closed_terminal_ends_a_process_in_order_unless_nohup_started_it(handler: str, outcome: str) -> None:
    """Without an orderly end the far site waits for a silent one, and the status file stays as it was."""
    command = [sys.executable, "-c", UNTIL_STOPPED, handler]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=50, check=False)
    assert (ended.returncode, ended.stdout.strip()) == (0, outcome)
