"""How far long work is, told on a terminal; nothing where nobody looks on."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import typer


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


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None] | None]:
    """A progress bar on a terminal that takes the share done, 0..1; nothing elsewhere."""
    if not sys.stderr.isatty():
        yield None
        return
    with typer.progressbar(length=1000, label=label, file=sys.stderr) as bar:
        yield lambda share: bar.update(round(share * 1000) - bar.pos)
