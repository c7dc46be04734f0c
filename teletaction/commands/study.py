"""Command `study`: runs the studies and compares their results."""

import csv
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import typer

from teletaction.commands.failed import Failed
from teletaction.commands.out_file import out_folder
from teletaction.commands.progress import progress_line

app = typer.Typer()


@app.command("study")
def study_command(
    name: Annotated[str | None, typer.Argument(help="Name of a study; --list shows all names.")] = None,
    out: Annotated[
        Path | None, typer.Option(callback=out_folder, help="Folder for NAME.json, NAME-TABLE.csv and NAME.png.")
    ] = None,
    list_studies: Annotated[bool, typer.Option("--list", help="Print the name and subject of each study.")] = False,
    all_studies: Annotated[bool, typer.Option("--all", help="Run all studies in turn and draw an overview.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Use fewer samples to finish sooner.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random in a study.")] = 0,
    processes: Annotated[
        int | None, typer.Option(min=1, help="Number of worker processes.", show_default="one for each processor")
    ] = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Share the work on the Dask cluster with this scheduler.")
    ] = None,
    compare: Annotated[
        tuple[Path, Path] | None,
        typer.Option(metavar="OLD NEW", help="Print differences between the results in two folders; exit 1 if worse."),
    ] = None,
) -> None:
    """Run a study: measure the system under chosen conditions; write data as JSON and CSV, and a figure.

    All random values derive from the seed. The same seed gives the same data on any number of processors. An
    interrupted run continues from its last result when it is called again with the same folder.
    """
    from studies import registry

    if list_studies:
        for study_name, line in registry.described().items():
            typer.echo(f"{study_name}: {line}")
        return
    if name is not None:
        registry.study(name)
    if compare is not None:
        _compare(*compare, name)
        return
    if all_studies == (name is not None):
        raise ValueError(f"name one study, or --all; there are {', '.join(registry.STUDIES)}")
    if out is None:
        raise ValueError("a study needs --out DIR")
    if processes is not None and dask is not None:
        raise ValueError("--processes applies to this machine only and excludes --dask")
    from studies.workers import WorkersLost, workers

    try:
        with workers(processes, dask) as who:
            found = _run(name, out, {"quick": quick, "seed": seed, "workers": who})
    except WorkersLost as lost:
        raise Failed(f"{lost}; the same command continues this run") from None
    for problem in found:
        typer.echo(problem, err=True)
    if found:
        raise Failed(f"problems found: {len(found)}")


def _run(name: str | None, out: Path, how: dict[str, Any]) -> list[str]:
    """Run one study, or all if `name` is None; return the problems found."""
    from studies import registry
    from studies.running import Unavailable

    results: Iterable[tuple[str, registry.Result | Unavailable]]
    if name is None:
        results = registry.run_all(out, show_progress=progress_line, **how)
    else:
        with progress_line(name) as progress:
            results = [(name, registry.run_study(name, out, progress=progress, **how))]
    found = []
    for study_name, result in results:
        if isinstance(result, Unavailable):
            typer.echo(f"{study_name}: skipped: {result}", err=True)
            continue
        typer.echo(f"{study_name}: wrote {', '.join(str(path) for path in result.written)}", err=True)
        found += [f"{study_name}: {problem}" for problem in result.problems]
    return found


def _compare(old: Path, new: Path, name: str | None) -> None:
    """Print the differences between two folders as CSV; raise Failed if a number became worse."""
    from studies import comparison

    changes, alone = comparison.compare_folders(old, new, *([] if name is None else [[name]]))
    differ = [change for change in changes if change.verdict != "same"]
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(("verdict", "study", "number", "old", "new", "may_differ"))
    for each in sorted(differ, key=lambda change: comparison.ORDER.index(change.verdict)):
        writer.writerow((each.verdict, each.study, each.number, each.old, each.new, each.may_differ))
    if alone:
        typer.echo(f"not compared, in one folder only: {', '.join(alone)}", err=True)
    counts = ", ".join(f"{sum(each.verdict == verdict for each in changes)} {verdict}" for verdict in comparison.ORDER)
    typer.echo(f"{len(changes)} numbers: {counts}", err=True)
    if worse := [each for each in changes if each.verdict in comparison.WORSE]:
        raise Failed(f"worse or gone: {len(worse)} numbers")
