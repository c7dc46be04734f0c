"""Reads and writes configurations as TOML files; an error names every problem with its line."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

from pydantic import BaseModel, ValidationError

from common.config.advice import COMMANDS, advice, command_for
from common.config.site_models import OperatorConfig, RemoteConfig
from common.files.printable import printable
from common.files.read_files import NotToml, read_toml

M = TypeVar("M", bound=BaseModel)
_LONGEST_FIELD = 200
_MOST_PROBLEMS = 5
"""Number of problems of a file that its error names."""


class ConfigProblem(ValueError):
    """An invalid configuration; the message names file, line and field."""


def load_config(path: Path, model: type[M]) -> M:
    """Read a TOML file into `model`; relative paths in it start at the file's own folder.

    Raises:
        ConfigProblem: the file is missing or not TOML, or fields are missing, unknown or break a rule; the message
            names each problem with its line.
    """
    try:
        text, values = read_toml(path)
    except OSError as error:
        raise ConfigProblem(f"{path}: {error.strerror}") from None
    except NotToml as error:
        raise ConfigProblem(f"{path}: {error}") from None
    try:
        checked = model.model_validate(values)
    except ValidationError as error:
        if model in COMMANDS.values() and (command := command_for(values)):
            raise ConfigProblem(f"{path}: a configuration for `teletaction {command}`, not for this command") from None
        problems = sorted(error.errors(), key=lambda problem: problem["type"] != "extra_forbidden")
        stated = [f"{path}:{_problem(text, problem, model)}" for problem in problems[:_MOST_PROBLEMS]]
        if more := len(problems) - len(stated):
            stated.append(f"and {more} more")
        raise ConfigProblem("; ".join(stated)) from None
    return cast(M, _anchored(checked, path.parent))


def _problem(text: str, problem: Mapping[str, Any], model: type[BaseModel]) -> str:
    """Return line, field and message of one problem."""
    location = [part for part in problem["loc"] if part != "[key]"]
    where = printable(".".join(map(str, location)), _LONGEST_FIELD)
    message = problem["msg"].removeprefix("Value error, ")
    if problem["type"] == "extra_forbidden":
        message = advice(location, problem["input"], model)
    elif problem["type"] in {"model_type", "dict_type"}:
        message = f"must be a table: [{where}]"
    return f"{_line_of(text, location)}: {where + ': ' if where else ''}{printable(message)}"


def load_site(path: Path) -> "RemoteConfig | OperatorConfig":
    """Read the configuration of either site: of the one that has more of the file's fields and tables.

    Raises:
        ConfigProblem: as `load_config`.
    """
    try:
        _, values = read_toml(path)
    except (OSError, NotToml):
        values = {}  # load_config reports the error
    if len(values.keys() & OperatorConfig.model_fields) > len(values.keys() & RemoteConfig.model_fields):
        return load_config(path, OperatorConfig)
    return load_config(path, RemoteConfig)


def _line_of(text: str, location: Sequence[str | int]) -> int:
    """Return the line of the deepest part of `location` that the file mentions; 1 when it mentions none."""
    found = 1
    lines = [line[:_LONGEST_FIELD] for line in text.splitlines()]
    for above, part in zip(["", *location], location, strict=False):
        if isinstance(part, int):
            entry = re.compile(rf"^\s*\[\[\s*{re.escape(str(above))}\s*\]\]")
            entries = [number for number, line in enumerate(lines, 1) if entry.match(line)]
            found = entries[part] if part < len(entries) else found
            continue
        name = re.escape(part)
        pattern = re.compile(rf"^\s*\[.*\b{name}\b.*\]|^.*\b{name}\b\"?\s*=")
        for number in range(found, len(lines) + 1):
            if pattern.match(lines[number - 1]):
                found = number
                break
    return found


def _anchored(value: object, folder: Path) -> object:
    """Return a value of a configuration whose relative paths start at `folder`."""
    if isinstance(value, Path):
        return folder / value
    if isinstance(value, dict):
        return {name: _anchored(part, folder) for name, part in value.items()}
    if isinstance(value, BaseModel):
        return value.model_copy(update={name: _anchored(part, folder) for name, part in value})
    return value


def to_toml(model: BaseModel) -> str:
    """Return the resolved configuration as TOML that `load_config` reads; it is stored in every recording.

    Raises:
        ValueError: a number is infinite or NaN; `load_config` refuses these.
    """
    values = model.model_dump(mode="json", exclude_none=True)
    lines = [f"{key} = {_toml(value)}" for key, value in values.items() if not isinstance(value, dict)]
    for key, table in values.items():
        if isinstance(table, dict):
            lines += ["", f"[{key}]", *(f"{name} = {_toml(value)}" for name, value in table.items())]
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    # TOML and JSON write scalars and lists of scalars alike, except for this one character.
    return json.dumps(value, ensure_ascii=False, allow_nan=False).replace("\x7f", "\\u007f")
