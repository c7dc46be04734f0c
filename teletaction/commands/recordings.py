"""Commands on the recordings of a session: `summarise`, `report`, `export`, `recover` and `replay`."""

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any

import typer

from common.runtime.parallel_map import processors
from teletaction.commands.as_json import Json, print_json
from teletaction.commands.key_option import Key
from teletaction.commands.out_file import out_folder, require_place
from teletaction.commands.progress import Processes, progress_line

app = typer.Typer()


@app.command("summarise")
def summarise_command(
    recordings: Annotated[Path, typer.Option(help="Folder with the recordings and status files of all processes.")],
    out: Annotated[
        Path, typer.Option(callback=out_folder, help="Folder for session.mcap, summary.json and report.html.")
    ],
    scene: Annotated[str | None, typer.Option(help="Scene that was explored; by default the recorded one.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the simulated world; likewise.")] = None,
    fingers: Annotated[int | None, typer.Option(min=1, max=5, help="Number of fingers, 1 to 5; likewise.")] = None,
    key: Key = None,
    as_json: Json = False,
) -> None:
    """Merge the recordings of a session whose processes were started one by one; write summary and report.

    A session on real devices gets no summary.
    """
    from teletaction.recordings.machine_verdict import machine_verdict
    from teletaction.session.conclude import conclude, incomplete_of
    from teletaction.session.terminal import say, show

    session = {"scene": scene, "seed": seed, "fingers": fingers}
    given = {name: value for name, value in session.items() if value is not None}
    summary = conclude(recordings, out, given, show)
    if as_json:
        print_json(summary)
    if not summary:
        say("no summary: it compares with simulated devices, whose recordings are not there")
        say(f"recording {out / 'session.mcap'}, report {out / 'report.html'}")
        return
    for line in filter(None, (machine_verdict(summary), *incomplete_of(summary))):
        say(line)
    say(f"summary {out / 'summary.json'}, report {out / 'report.html'}")


@app.command("report")
def report_command(
    recordings: Annotated[list[Path], typer.Argument(help="A merged session.mcap, or the recordings to merge.")],
    out: Annotated[Path, typer.Option(help="HTML file to write, or a PDF, which Chromium prints without the annex.")],
    key: Key = None,
    blur: Annotated[
        bool, typer.Option("--blur", help="Cover the camera's pictures but for the surroundings of the marks.")
    ] = False,
) -> None:
    """Write a session's report: map, findings, figures, link, audit trail. A summary.json beside it is included."""
    from teletaction.report.session_report import report
    from teletaction.session.terminal import say, show

    require_place(out)
    show("reading the recording and drawing the report")
    report(recordings, out, blur=blur)
    say(f"report {out}")


@app.command("export")
def export_command(
    recording: Annotated[Path, typer.Argument(help="A merged session.mcap, or the recording of one site.")],
    to: Annotated[str, typer.Option(help="Format: csv, parquet, foxglove, rerun, fhir or dicom-sr.")],
    out: Annotated[Path, typer.Option(callback=out_folder, help="Folder for the files; it is created.")],
    began: Annotated[
        str | None,
        typer.Option(
            help="Time of the first message, such as 2026-11-27T10:00:00+00:00; for a recording of version 0.1.0."
        ),
    ] = None,
    body_site: Annotated[
        str | None,
        typer.Option(
            help="Examined part of the body, for fhir and dicom-sr: a text, or a SNOMED CT code as "
            "SCT:80248007:left breast."
        ),
    ] = None,
    key: Key = None,
) -> None:
    """Write a recording in a format that other tools read, with named fields and wall-clock times."""
    from teletaction.export.export import export

    for name, count in export(recording, to, out, None if began is None else _began(began), body_site).items():
        typer.echo(f"{count:9d} {name}", err=True)
    typer.echo(f"wrote {out}", err=True)


def _began(text: str) -> datetime:
    try:
        began = datetime.fromisoformat(text)
    except ValueError:
        began = datetime.min
    if began.tzinfo is None:
        raise ValueError(
            f"--began {text!r}: expected date, time and offset from UTC, such as 2026-11-27T10:00:00+00:00"
        )
    return began


@app.command("recover")
def recover_command(
    recording: Annotated[Path, typer.Argument(help="Recording of a process that crashed or was killed.")],
    out: Annotated[Path | None, typer.Option(help="File to write; by default NAME-recovered.mcap beside it.")] = None,
    key: Key = None,
) -> None:
    """Make a whole recording out of a truncated or damaged one. The original is not changed."""
    from teletaction.recordings.recover import recover

    recovered = recover(recording, out)
    if recovered is None:
        typer.echo(f"{recording} is whole: nothing needs repair", err=True)
        return
    for stream, count in sorted(recovered.messages.items()):
        typer.echo(f"{count:9d} {stream}", err=True)
    typer.echo(
        f"wrote {recovered.out}: {recovered.messages.total()} messages over {recovered.seconds:.3f} s; "
        f"{recovered.unreadable_bytes} bytes and {recovered.damaged_parts} damaged parts could not be read",
        err=True,
    )
    if recovered.doubtful:
        typer.echo("the checksum of the whole file is wrong: configuration and metadata may be wrong", err=True)


@app.command("replay")
def replay_command(
    recordings: Annotated[list[Path], typer.Argument(help="Recordings of sessions, or of one site each.")],
    out: Annotated[
        Path,
        typer.Option(
            callback=out_folder,
            help="Folder for identification.jsonl, rendering.csv and replay.json; one subfolder for each of several.",
        ),
    ],
    processes: Processes = 0,
    key: Key = None,
) -> None:
    """Run identification and rendering again on recordings and compare with the recorded results."""
    from teletaction.replay.replay_each import replay_each

    results: list[tuple[Path, dict[str, Any]]] = []
    try:
        with progress_line("replay") as progress:
            results += replay_each(recordings, out, processes or processors(), progress)
    finally:  # an error of one recording comes after the results of the others
        for recording, result in results:
            before = f"{recording}: " if len(recordings) > 1 else ""
            for line in _compared(result):
                typer.echo(before + line, err=True)


def _compared(result: dict[str, Any]) -> Iterator[str]:
    """Describe the results of a replay, line by line."""
    from teletaction.replay.replay_named import in_words

    for site, what in (("remote", "touch_packets"), ("operator", "rendered_rows")):
        for name, part in result[site].items():
            same = "all" if part["identical"] == part[what] else f"only {part['identical']}"
            yield f"{name}: {part['ticks']} ticks; {same} of {part[what]} {what.replace('_', ' ')} are identical"
    for name, part in result["remote"].items():
        for touch in part["changed_by_waiting"]:
            yield f"{name}: without late ticks, {in_words(touch)}"
