"""Option --json of commands that print text for people."""

import json
from typing import Annotated, Any

import typer

Json = Annotated[bool, typer.Option("--json", help="Print the results as one JSON object.")]


def print_json(result: dict[str, Any]) -> None:
    """Print one JSON object to standard output."""
    typer.echo(json.dumps(result, indent=1))
