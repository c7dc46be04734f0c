"""Has all commands, and runs one.

Text for people goes to stderr, data to stdout. Exit code 0 is success, 1 a failure, 2 bad input (one clear line).
A reader of the output that ends early, such as `head -1`, ends the command silently with code 141, as by SIGPIPE.
"""

import os
import platform
import signal
import sys
from types import FunctionType
from typing import Annotated

import typer

from common.files.printable import printable
from common.logs import LEVEL_VARIABLE, log_level
from common.version import software_version, source_commit
from teletaction.commands import (
    calibrate,
    conformance,
    demo,
    doctor,
    identify,
    keys,
    map,
    metrics,
    outlet,
    privacy,
    processes,
    recordings,
    render,
    scene,
    session,
    simulate,
    study,
)
from teletaction.commands.failed import Failed

_LAST_STANDARD_STREAM = 2
"""Number of standard error."""
_OUTPUT_CLOSED = 128 + signal.SIGPIPE
"""Exit code that a shell reports of a program that SIGPIPE has ended."""

app = typer.Typer(
    name="teletaction",
    help="Feel a remote place with five fingers: texture, temperature and stiffness over an ordinary network.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(wanted: bool) -> None:
    if not wanted:
        return
    # Imported here, so that help and completion stay fast.
    from msgpack import unpackb  # noqa: PLC0415

    from common.buses import serial_messages  # noqa: PLC0415
    from common.wire.packets import SCHEMA_VERSION  # noqa: PLC0415

    compiled = {"COBS": serial_messages.COMPILED, "msgpack": not isinstance(unpackb, FunctionType)}
    facts = [
        f"teletaction {software_version()}",
        f"commit {source_commit()}",
        f"packet schema {SCHEMA_VERSION}",
        f"Python {platform.python_version()}",
        *(f"{name} {'compiled' if is_compiled else 'pure Python'}" for name, is_compiled in compiled.items()),
    ]
    typer.echo(", ".join(fact for fact in facts if fact != "commit "))
    raise typer.Exit


@app.callback()
def _options(
    log_level_name: Annotated[
        str | None, typer.Option("--log-level", help="Lowest level that processes log: debug, info, warning or error.")
    ] = None,
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    if log_level_name is not None:
        os.environ[LEVEL_VARIABLE] = log_level_name  # the processes of a demo inherit it
    log_level()


# The help lists the commands in this order.
for module in (
    demo,
    processes,
    outlet,
    recordings,
    privacy,
    doctor,
    conformance,
    metrics,
    study,
    keys,
    session,
    calibrate,
    identify,
    map,
    simulate,
    render,
    scene,
):
    app.add_typer(module.app)


def run(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit code."""
    _open_closed_streams()
    try:
        # Only a command that is interrupted or ends early returns a code of its own.
        return app(args=arguments, standalone_mode=False) or 0
    except typer.TyperException as error:
        message = error.format_message()
        if "\n" in message:  # For a command without arguments the message is its help.
            typer.echo(message, err=True)
            return 2
        return _complain(message, 2)
    except (ValueError, KeyError, OSError) as error:
        return _complain(_message(error), 2)
    except Failed as failure:
        return _complain(str(failure), 1)
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except SystemExit as ended:  # typer turns a broken pipe into exit code 1, which is a failed check here
        if isinstance(ended.__context__, BrokenPipeError):
            return _OUTPUT_CLOSED
        raise


def _open_closed_streams() -> None:
    """Open the null device for each closed standard stream, so that no other file gets its number."""
    while (number := os.open(os.devnull, os.O_RDWR)) <= _LAST_STANDARD_STREAM:
        pass
    os.close(number)
    sys.stdout = sys.stdout or os.fdopen(1, "w", encoding="utf-8", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", encoding="utf-8", closefd=False)


def _message(error: ValueError | KeyError | OSError) -> str:
    """Return the error for people: of a file its name and what is wrong, without the system's number."""
    if isinstance(error, KeyError):
        return str(error.args[0])
    if isinstance(error, OSError) and isinstance(error.filename, str | os.PathLike) and error.filename2 is None:
        return f"{os.fspath(error.filename)}: {error.strerror}"
    if isinstance(error, OSError) and error.strerror and error.filename is None:
        return error.strerror
    return str(error)


def _complain(message: str, code: int) -> int:
    typer.echo("teletaction: " + printable(" ".join(message.split())), err=True)
    return code
