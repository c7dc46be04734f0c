"""Shows the progress of long commands and defines their option --processes."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

from teletaction.session.terminal import show

Processes = Annotated[int, typer.Option(min=0, help="Number of worker processes; 0: one for each processor.")]


@contextmanager
def progress_line(label: str) -> Iterator[Callable[[float | str], None]]:
    """Show a progress line on a terminal; show nothing elsewhere.

    Yields a function that takes the share done (0..1) or a text.
    """
    try:
        yield lambda far: show(f"{label}: {far if isinstance(far, str) else f'{far:.0%}'}")
    finally:
        show("")
