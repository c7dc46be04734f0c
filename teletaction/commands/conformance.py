"""Command `conformance`: tests one device against the protocol document."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from common.files.printable import printable
from common.fingers import FINGERS
from teletaction.commands.as_json import Json, print_json
from teletaction.commands.failed import Failed

if TYPE_CHECKING:
    from teletaction.conformance.checklist import Tried

app = typer.Typer()


class DeviceName(StrEnum):
    """Kinds of devices that a user may name."""

    TEXTURE_SENSOR = "texture-sensor"
    THERMAL_SENSOR = "thermal-sensor"
    TACTTIP = "tacttip"
    PATIENT_SWITCH = "patient-switch"
    EXOSKELETON = "exoskeleton"
    TELEMANIPULATOR = "telemanipulator"


Address = Annotated[
    str, typer.Argument(help="Serial port, socket://HOST:PORT, or CAN: socketcan:can0, socketcand://HOST:PORT/can0.")
]
Device = Annotated[DeviceName | None, typer.Option(help="Expected kind; by default the kind that the device reports.")]
Finger = Annotated[str | None, typer.Option(help="Expected finger: thumb, index, middle, ring, little.")]
Exercise = Annotated[
    bool, typer.Option("--exercise", help="Also drive the outputs a little; asks for confirmation first.")
]
Heat = Annotated[
    bool, typer.Option("--heat", help="Also test its temperature limit: heats the plate to 42 C. Includes --exercise.")
]
Yes = Annotated[bool, typer.Option("--yes", help="Do not ask; nobody touches the device.")]


@app.command()
def conformance(
    address: Address,
    device: Device = None,
    finger: Finger = None,
    exercise: Exercise = False,
    heat: Heat = False,
    yes: Yes = False,
    as_json: Json = False,
) -> None:
    """Test one serial module or CAN node against docs/protocols.md, duty by duty; exit 1 if it fails in one."""
    from common.buses.serial_messages import DeviceKind
    from common.logs import quiet_libraries
    from teletaction.conformance.checklist import How, Verdict
    from teletaction.conformance.examination import opened
    from teletaction.conformance.node_talk import NodeName
    from teletaction.session.interrupt import ended_as_by_hand

    quiet_libraries()
    if finger is not None and finger not in FINGERS:
        raise ValueError(f"--finger {finger}: there are {', '.join(FINGERS)}")
    expected: DeviceKind | NodeName | None = None
    if device is not None:
        serial = device.name in DeviceKind.__members__
        expected = DeviceKind[device.name] if serial else NodeName(device.value)
    allowed = {How.LISTEN, *([How.EXERCISE] if exercise or heat else []), *([How.HEAT] if heat else [])}
    with (
        ended_as_by_hand(),
        opened(address, expected, FINGERS.index(finger) if finger is not None else None) as found,
    ):
        does = [words for how, words in found.warning.items() if how in allowed]
        if does and not yes:
            typer.confirm(
                f"This {', and '.join(does)}. Firmware that is wrong may do more: be ready to cut the power. "
                f"Nobody and nothing touches the {found.name}?",
                abort=True,
                err=True,
            )
        results = found.tried(allowed, (lambda tried: None) if as_json else _print)
    counts = {verdict: sum(tried.verdict is verdict for tried in results) for verdict in Verdict}
    if as_json:
        rows = [
            {"duty": t.duty.number, "verdict": t.verdict.value, "expected": t.duty.demand, "came": t.came}
            for t in results
        ]
        summary = {"address": address, "device": found.name, "counts": counts, "duties": rows}
        print_json(summary)
    counted = ", ".join(f"{count} {verdict}" for verdict, count in counts.items() if count)
    typer.echo(f"{found.name} at {address}: {counted}", err=True)
    if counts[Verdict.FAIL]:
        first = next(tried for tried in results if tried.verdict is Verdict.FAIL)
        raise Failed(f"{first.duty.number}: {first.duty.demand}: {first.came}")


def _print(tried: "Tried") -> None:
    from teletaction.conformance.checklist import Verdict

    if tried.verdict is Verdict.NOT_TRIED:
        typer.echo(f"{tried.duty.number:4} {tried.verdict:9} {printable(tried.came)}")
        return
    typer.echo(f"{tried.duty.number:4} {tried.verdict:9} expected: {tried.duty.demand}")
    typer.echo(f"{'':14} came:     {printable(tried.came)}")
