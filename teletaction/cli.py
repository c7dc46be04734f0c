"""Runs the command line.

Text for people goes to stderr, data to stdout. Exit code 0 is success, 1 a failure, 2 bad input (one clear line).
"""

import typer

from common.files.printable import printable
from teletaction.commands import (
    calibrate,
    conformance,
    demo,
    doctor,
    identify,
    keys,
    metrics,
    processes,
    recordings,
    render,
    scene,
    session,
    simulate,
    study,
)
from teletaction.commands.failed import Failed

app = typer.Typer(
    name="teletaction",
    help="Feel a remote place with five fingers: texture, temperature and stiffness over an ordinary network.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
# The help lists the commands in this order.
for module in (
    demo,
    processes,
    recordings,
    doctor,
    conformance,
    metrics,
    study,
    keys,
    session,
    calibrate,
    identify,
    simulate,
    render,
    scene,
):
    app.add_typer(module.app)


def main(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit code."""
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
        if isinstance(error, BrokenPipeError):
            return 0  # The reader closed our output.
        return _complain(str(error.args[0]) if isinstance(error, KeyError) else str(error), 2)
    except Failed as failure:
        return _complain(str(failure), 1)
    except (KeyboardInterrupt, typer.Abort):
        return 130


def _complain(message: str, code: int) -> int:
    typer.echo("teletaction: " + printable(" ".join(message.split())), err=True)
    return code
