"""Command `doctor`: checks a site's configuration, or lists the devices on this host."""

from pathlib import Path
from typing import Annotated

import typer

from common.files.printable import printable
from teletaction.commands.as_json import Json, print_json
from teletaction.commands.failed import Failed

app = typer.Typer()

PORTS = Path("/dev/serial/by-id")
"""Folder in which udev names serial ports; it is missing where there are none."""
WARNING = (
    "This drives each device in turn: motors for half a second with up to 1 V, Peltier elements for 1 s with 300 "
    "thousandths, the exoskeleton with 0.3 N on each finger, the telemanipulator by 1 mm (its fingers first down by up "
    "to 2 mm where they have no room above). Nobody and nothing touches them?"
)


@app.command()
def doctor(
    config: Annotated[
        Path | None, typer.Option("--config", help="TOML file of a site; without it, list the devices on this host.")
    ] = None,
    exercise: Annotated[
        bool, typer.Option("--exercise", help="Also drive each device a little; asks for confirmation first.")
    ] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask; nobody touches the devices.")] = False,
    ports: Annotated[Path, typer.Option(help="Folder of serial ports to look for devices in.")] = PORTS,
    as_json: Json = False,
) -> None:
    """Find and name each device of a site's configuration; check keys, files and clocks; say what to do."""
    from common.logs import quiet_libraries
    from teletaction.doctor.doctor import examine
    from teletaction.session.interrupt import ended_as_by_hand

    quiet_libraries()
    if config is None:
        if exercise:
            raise ValueError("--exercise needs --config: only configured devices are driven")
        _list(ports, as_json)
        return
    if exercise and not yes:
        typer.confirm(WARNING, abort=True, err=True)
    findings = []
    with ended_as_by_hand():
        for finding in examine(config, exercise, ports):
            if not as_json:
                typer.echo(f"{'ok  ' if finding.good else 'FAIL'} {finding.what}: {printable(finding.result)}")
            findings.append(finding)
    if as_json:
        print_json({"checks": [{"check": each.what, "good": each.good, "result": each.result} for each in findings]})
    bad = [finding for finding in findings if not finding.good]
    if bad:
        raise Failed(f"{len(bad)} of {len(findings)} checks failed; first: {bad[0].what}: {bad[0].result}")


def _list(ports: Path, as_json: bool) -> None:
    from teletaction.conformance.find_devices import find_modules, find_nodes

    found = [*find_modules(ports), *find_nodes()]
    if as_json:
        print_json({"devices": [{"address": one.address, "good": one.good, "device": one.words} for one in found]})
    for one in found if not as_json else ():
        typer.echo(f"{one.address}: {printable(one.words)}")
    if not any(one.good for one in found):
        absent = "" if ports == PORTS or ports.is_dir() else f"; there is no folder {ports}"
        raise Failed(f"no device answers at the serial ports in {ports} or on a CAN interface of this host{absent}")
