"""Options that every command has: version, help, level of the log."""

import logging
import os
import re
from collections.abc import Iterator

import pytest

from common.logs import LEVEL_VARIABLE, LEVELS, log_level
from common.version import software_version, source_commit
from common.wire.packets import SCHEMA_VERSION
from tests.commands import command, one_line


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
        rf"teletaction {re.escape(software_version())}{commit}, packet schema {SCHEMA_VERSION}, Python 3\.\d+\.\d+\n"
    )
    assert re.fullmatch(expected, shown.out)


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


def test_an_unknown_level_is_one_line() -> None:
    assert "no level 'loud'; choose one of debug, info" in one_line(command("--log-level", "loud", "scene"), 2)


def test_an_unknown_level_of_the_environment_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LEVEL_VARIABLE, "quiet")
    assert "no level 'quiet'" in one_line(command("doctor", "--config", "site.toml"), 2)


def test_completion_is_there() -> None:
    assert "--install-completion" in command("-h").out
