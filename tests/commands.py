"""A command of the program run in this process, with what a shell would see of it."""

import io
import time
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass

from teletaction.cli import main


@dataclass(frozen=True, slots=True)
class Told:
    """How a command ended: exit code, what it wrote, and when it was begun and done, s."""

    code: int
    out: str
    err: str
    begun_s: float
    done_s: float

    @property
    def said(self) -> tuple[int, str, str]:
        """Exit code, output, and what it wrote to standard error."""
        return self.code, self.out, self.err


def command(*arguments: object) -> Told:
    """Run one command of the command line."""
    out, err = io.StringIO(), io.StringIO()
    begun_s = time.monotonic()
    with redirect_stdout(out), redirect_stderr(err):
        code = main([str(argument) for argument in arguments])
    return Told(code, out.getvalue(), err.getvalue(), begun_s, time.monotonic())


def one_line(told: Told, code: int) -> str:
    """The one line of a command that ended with this code and printed nothing else."""
    assert (told.code, told.out) == (code, ""), told
    lines = told.err.splitlines()
    assert len(lines) == 1, told.err
    assert lines[0].startswith("teletaction: ")
    return lines[0]
