"""What long work has in common on the command line: how far it is, and how many processes share it."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

Processes = Annotated[int, typer.Option(min=0, help="Processes that share the work; 0: one for each processor.")]


@contextmanager
def progress_line(label: str) -> Iterator[Callable[[float | str], None]]:
    """A line on a terminal that says how far something is, the share done (0..1) or in words; nothing elsewhere."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    clear = "\r\x1b[K"
    try:
        yield lambda far: typer.echo(
            f"{clear}{label}: {far if isinstance(far, str) else f'{far:.0%}'}", err=True, nl=False
        )
    finally:
        typer.echo(clear, err=True, nl=False)
