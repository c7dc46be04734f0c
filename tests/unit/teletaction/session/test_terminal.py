"""A demo prints to a terminal that may be closed."""

import os
from contextlib import suppress

import pytest

from teletaction.session.terminal import say, show


def test_a_closed_terminal_takes_no_line_and_raises_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A demo whose terminal closes still ends its processes in order and has its report made."""
    master, slave = os.openpty()
    terminal = os.fdopen(slave, "w", encoding="utf-8")
    monkeypatch.setattr("sys.stderr", terminal)
    say("a line")
    os.close(master)
    monkeypatch.setattr(terminal, "isatty", lambda: True)
    for number in range(2):
        say(f"stopped {number}")
        show("drawing the report")
    monkeypatch.undo()
    with suppress(OSError):  # the unwritten lines
        terminal.close()


def test_a_full_disk_is_an_error_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    with open("/dev/full", "w", encoding="utf-8", buffering=1) as full:
        monkeypatch.setattr("sys.stderr", full)
        with pytest.raises(OSError, match="No space left"):
            say("a line")
        monkeypatch.undo()
        with suppress(OSError):
            full.close()
