"""`study`: measurements of the system under conditions set on purpose."""

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from teletaction.commands.failed import Failed
from teletaction.commands.progress import progress_line

app = typer.Typer()


@app.command("study")
def study_command(
    name: Annotated[str | None, typer.Argument(help="Which study; --list tells what there are.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for NAME.json, NAME-TABLE.csv and NAME.png.")] = None,
    list_studies: Annotated[bool, typer.Option("--list", help="Print each study's name and what it shows.")] = False,
    all_studies: Annotated[bool, typer.Option("--all", help="Run all studies, one after the other.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Measure less, and sooner.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random in a study.")] = 0,
) -> None:
    """Measure the system under conditions set on purpose: data as JSON and CSV, and a figure."""
    # By name: nothing but this command may depend on the studies, and they may depend on everything.
    registry = import_module("studies.registry")
    if list_studies:
        for study_name, line in registry.described().items():
            typer.echo(f"{study_name}: {line}")
        return
    if all_studies == (name is not None):
        raise ValueError(f"name one study, or --all; there are {', '.join(registry.STUDIES)}")
    names: list[str] = list(registry.STUDIES) if name is None else [name]
    for study_name in names:
        registry.study(study_name)
    if out is None:
        raise ValueError("a study needs --out DIR")
    found = []
    for study_name in names:
        try:
            with progress_line(study_name) as tell:
                result = registry.run_study(study_name, out, quick=quick, seed=seed, tell=tell)
        except registry.Unavailable as missing:
            if not all_studies:
                raise
            typer.echo(f"{study_name}: skipped: {missing}", err=True)
            continue
        typer.echo(f"{study_name}: wrote {', '.join(str(path) for path in result.written)}", err=True)
        found += [f"{study_name}: {problem}" for problem in result.problems]
    for problem in found:
        typer.echo(problem, err=True)
    if found:
        raise Failed(f"problems found: {len(found)}")
