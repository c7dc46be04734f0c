"""Options that every command has: version, help, level of the log."""

import logging
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from common.logs import LEVEL_VARIABLE, LEVELS, log_level
from common.version import software_version, source_commit
from common.wire.packets import SCHEMA_VERSION
from tests.commands import command, one_line
from tests.places import ROOT


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.delenv(LEVEL_VARIABLE, raising=False)
    yield
    os.environ.pop(LEVEL_VARIABLE, None)


def test_the_version_names_program_schema_and_python() -> None:
    shown = command("--version")
    assert shown.code == 0
    commit = f", commit {source_commit()}" if source_commit() else ""
    expected = (
        rf"teletaction {re.escape(software_version())}{commit}, packet schema {SCHEMA_VERSION}, Python 3\.\d+\.\d+, "
        r"COBS (compiled|pure Python), msgpack (compiled|pure Python)\n"
    )
    assert re.fullmatch(expected, shown.out)


def test_the_version_names_packages_that_are_not_compiled() -> None:
    without = "import sys; sys.modules.update({'corncobs': None, 'cobs.cobs._cobs_ext': None}); "
    run = subprocess.run(
        [sys.executable, "-c", without + "from teletaction.cli import main; main(['--version'])"],
        env=os.environ | {"MSGPACK_PUREPYTHON": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.endswith(", COBS pure Python, msgpack pure Python\n")


@pytest.mark.parametrize("words", [["-h"], ["report", "-h"], ["keys", "-h"], ["calibrate", "thermal", "-h"]])
def test_each_command_has_short_help(words: list[str]) -> None:
    short, long = command(*words), command(*words[:-1], "--help")
    assert (short.code, short.out) == (0, long.out)
    assert "-h, --help" in short.out


@pytest.mark.parametrize("level", LEVELS)
def test_the_level_of_the_log_reaches_this_process_and_its_children(level: str) -> None:
    assert command("--log-level", level, "keys", "-h").code == 0
    assert os.environ[LEVEL_VARIABLE] == level
    assert logging.getLevelName(log_level()) == level.upper()


@pytest.mark.parametrize(("closed", "shown"), [("2>&-", ""), (">&-", "report {out}\n"), ("<&- >&- 2>&-", "")])
def test_a_command_works_with_closed_standard_streams(closed: str, shown: str, tmp_path: Path) -> None:
    session, out = ROOT / "tests" / "golden" / "session.mcap", tmp_path / "report.html"
    line = f'exec "$0" -m teletaction report "$1" --out "$2" {closed}'
    run = subprocess.run(["sh", "-c", line, sys.executable, session, out], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", shown.format(out=out))
    csv = subprocess.run(
        ["sh", "-c", f'exec "$0" -m teletaction scene check materials --dwell 0.1 {closed}', sys.executable],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (csv.returncode, csv.stderr) == (0, "")


@pytest.mark.parametrize("words", [["--version"], ["scene", "check", "materials", "--dwell", "0.1"]])
def test_a_reader_that_ends_early_is_no_failed_check(words: list[str]) -> None:
    """Code 1 would be one, as of `doctor | head -1`; a shell reports 141 of a program that SIGPIPE ended."""
    nobody, output = os.pipe()
    os.close(nobody)
    run = subprocess.run(
        [sys.executable, "-m", "teletaction", *words], stdout=output, stderr=subprocess.PIPE, check=False
    )
    os.close(output)
    assert (run.returncode, run.stderr) == (141, b"")


INTERRUPTED_IMPORT = """
import os, signal, sys
class Interrupts:
    def find_spec(self, name, *_):
        if name == "typer":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Interrupts())
from teletaction.cli import main
sys.exit(main(["--version"]))
"""


def test_ctrl_c_while_the_commands_are_imported_ends_silently() -> None:
    result = subprocess.run([sys.executable, "-c", INTERRUPTED_IMPORT], capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout, result.stderr) == (-signal.SIGINT, "", "")


def test_a_background_job_that_ignores_ctrl_c_is_not_ended_by_it() -> None:
    program = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)" + INTERRUPTED_IMPORT
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (result.returncode, result.stderr) == (0, "")


def test_an_unknown_level_is_one_line() -> None:
    assert "no level 'loud'; choose one of debug, info" in one_line(command("--log-level", "loud", "scene"), 2)


def test_an_unknown_level_of_the_environment_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LEVEL_VARIABLE, "quiet")
    assert "no level 'quiet'" in one_line(command("doctor", "--config", "site.toml"), 2)


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """The program under its own name, as it is installed."""
    path = tmp_path / "teletaction"
    path.write_text(f"#!{sys.executable}\nimport sys\nfrom teletaction.cli import main\nsys.exit(main())\n", "utf-8")
    path.chmod(0o755)
    return path


def without_home(*words: object, **variables: str) -> str:
    """What a command prints in an environment without a home directory."""
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT), **variables}
    return subprocess.run(map(str, words), env=environment, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize(
    ("shell", "line"),
    [
        ("bash", "complete -o default -F _teletaction_completion teletaction"),
        ("zsh", "compdef _teletaction_completion teletaction"),
        ("fish", "complete --command teletaction --no-files"),
    ],
)
def test_a_shell_gets_its_completion_script(shell: str, line: str, program: Path) -> None:
    assert line in without_home(program, _TELETACTION_COMPLETE=f"source_{shell}")


def test_bash_is_recognised_and_completes_commands(program: Path) -> None:
    shown = without_home("bash", "-c", f"{program} --show-completion; true")
    assert "complete -o default -F _teletaction_completion teletaction" in shown
    words = {"COMP_WORDS": "teletaction rep", "COMP_CWORD": "1", "_TELETACTION_COMPLETE": "complete_bash"}
    assert set(without_home(program, **words).split()) == {"report", "replay"}
