"""`doctor`: whether a site could work."""

import typer

from teletaction.commands.config_file import ConfigFile
from teletaction.commands.failed import Failed

app = typer.Typer()


@app.command()
def doctor(config: ConfigFile) -> None:
    """Find and name each device of a site's configuration; check keys and clocks; say what to do."""
    from teletaction.doctor import examine

    findings = examine(config)
    for finding in findings:
        typer.echo(f"{'ok  ' if finding.good else 'FAIL'} {finding.what}: {finding.result}")
    bad = [finding for finding in findings if not finding.good]
    if bad:
        raise Failed(f"{len(bad)} of {len(findings)} checks failed; first: {bad[0].what}: {bad[0].result}")
