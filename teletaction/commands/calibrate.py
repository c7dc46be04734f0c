"""Command `calibrate`: makes look-up tables from labelled recordings."""

from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from common.files.read_files import read_json
from common.runtime.parallel_map import processors
from teletaction.commands.out_file import out_folder, require_place
from teletaction.commands.progress import Processes, progress_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure

app = typer.Typer(name="calibrate", help="Look-up tables from labelled recordings.", no_args_is_help=True)


@app.command("thermal")
def calibrate_thermal_command(
    traces: Annotated[Path, typer.Option(help="Folder with traces and labels.csv (file,material[,object_c]).")],
    out: Annotated[Path, typer.Option(help="Table to write.")],
    serial: Annotated[str, typer.Option(help="Serial number of the calibrated sensor.")] = "unknown",
    report: Annotated[
        Path | None,
        typer.Option(callback=out_folder, help="Folder for report.txt and fit.png, which show the quality of the fit."),
    ] = None,
    processes: Processes = 0,
) -> None:
    """Make a material look-up table from labelled touches."""
    from remote_site.thermal.calibration.thermal_calibration import calibrate_thermal
    from teletaction.report.calibration_report import calibration_figure, calibration_text

    _require_place(out, report)
    with progress_line("calibrate") as progress:
        fit = calibrate_thermal(
            traces,
            out,
            sensor_serial=serial,
            made_on=f"{date.today()}",
            processes=processes or processors(),
            progress=progress,
        )
    _report(calibration_text(fit), out, report, calibration_figure(fit) if report is not None else None)


@app.command("temperature")
def calibrate_temperature_command(
    table: Annotated[Path, typer.Option(help="Table of `calibrate thermal`.")],
    traces: Annotated[Path, typer.Option(help="Folder with traces and labels.csv (file,material,object_c).")],
    out: Annotated[Path, typer.Option(help="Table to write.")],
    serial: Annotated[
        str | None, typer.Option(help="Serial number of the calibrated sensor; by default that of the table.")
    ] = None,
    report: Annotated[
        Path | None, typer.Option(callback=out_folder, help="Folder for report.txt with the accuracy to expect.")
    ] = None,
    processes: Processes = 0,
) -> None:
    """Learn the errors of object temperatures from touches of references of known temperature."""
    from remote_site.thermal.calibration.temperature_calibration import calibrate_temperature
    from teletaction.report.accuracy_text import temperature_text

    _require_place(out, report)
    with progress_line("calibrate") as progress:
        fit = calibrate_temperature(
            table,
            traces,
            out,
            sensor_serial=serial,
            made_on=f"{date.today()}",
            processes=processes or processors(),
            progress=progress,
        )
    _report(temperature_text(fit), out, report)


@app.command("texture")
def calibrate_texture_command(
    strokes: Annotated[
        Path, typer.Option(help="Folder with strokes and labels.csv (file,surface[,speed_mm_s][,roughness_um]).")
    ],
    out: Annotated[Path, typer.Option(help="Table to write.")],
    signal: Annotated[str | None, typer.Option(help="Signal column, or `best` or `mean` of all.")] = None,
    speed: Annotated[float | None, typer.Option(help="Stroke speed for files without one, mm/s.")] = None,
    serial: Annotated[str, typer.Option(help="Serial number of the calibrated sensor.")] = "unknown",
    report: Annotated[
        Path | None, typer.Option(callback=out_folder, help="Folder for report.txt with the recognition rates.")
    ] = None,
) -> None:
    """Make a surface look-up table from labelled strokes."""
    from remote_site.texture.calibration.spectrum_calibration import calibrate_spectra, of_slow_strokes, read_labelled
    from remote_site.texture.calibration.texture_calibration import calibrate_texture
    from teletaction.report.calibration_report import spectrum_text, texture_text

    _require_place(out, report)
    if not of_slow_strokes(strokes, signal):
        made = calibrate_texture(
            strokes, out, signal=signal, speed_mm_s=speed, sensor_serial=serial, made_on=f"{date.today()}"
        )
        _report(texture_text(made), out, report)
        return
    fit = calibrate_spectra(read_labelled(strokes, signal, speed), sensor_serial=serial, made_on=f"{date.today()}")
    fit.table.save(out)
    _report(spectrum_text(fit), out, report)


def _require_place(out: Path, report: Path | None) -> None:
    """Raise an error for a table that cannot be written, or would overwrite another file, before minutes of fitting.

    The folder of the report is created.
    """
    if out.is_file() and not _is_table(out):
        raise ValueError(f"{out}: exists and is no table; name another file with --out")
    require_place(out)
    if report is not None:
        report.mkdir(parents=True, exist_ok=True)


def _is_table(file: Path) -> bool:
    """Return whether a table, or nothing, would be overwritten."""
    try:
        return file.stat().st_size == 0 or "content_hash" in read_json(file)
    except (OSError, ValueError, TypeError):
        return False


def _report(text: str, out: Path, folder: Path | None, figure: "Figure | None" = None) -> None:
    """Print a report and the names of the written files; write report.txt and a figure's fit.png to `folder`."""
    typer.echo(text, err=True)
    written = [out]
    if folder is not None:
        written.append(folder / "report.txt")
        written[-1].write_text(text + "\n", "utf-8")
        if figure is not None:
            written.append(folder / "fit.png")
            figure.savefig(written[-1], dpi=130)
    typer.echo(f"wrote {', '.join(map(str, written))}", err=True)
