"""A command of the program run in this process, with its exit code and output."""

import io
import time
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass

from teletaction.cli import main


@dataclass(frozen=True, slots=True)
class Outcome:
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


def command(*arguments: object) -> Outcome:
    """Run one command of the command line."""
    out, err = io.StringIO(), io.StringIO()
    begun_s = time.monotonic()
    with redirect_stdout(out), redirect_stderr(err):
        code = main([str(argument) for argument in arguments])
    return Outcome(code, out.getvalue(), err.getvalue(), begun_s, time.monotonic())


def one_line(outcome: Outcome, code: int) -> str:
    """The one line of a command that ended with this code and printed nothing else."""
    assert (outcome.code, outcome.out) == (code, ""), outcome
    lines = outcome.err.splitlines()
    assert len(lines) == 1, outcome.err
    assert lines[0].startswith("teletaction: ")
    return lines[0]
