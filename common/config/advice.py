"""Finds where an unknown field or table of a configuration belongs."""

import difflib
from collections.abc import Mapping, Sequence
from typing import get_args, get_origin

from pydantic import BaseModel, ValidationError

from common.config.link_models import ObserverConfig, RendezvousConfig, TunnelConfig
from common.config.page_models import ConsoleConfig, PatientPageConfig
from common.config.simulation_models import SimNetworkConfig, SimOperatorConfig, SimRemoteConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from common.config.stream_models import CameraConfig, VoiceConfig
from common.files.printable import printable

COMMANDS: dict[str, type[BaseModel]] = {
    "remote": RemoteConfig,
    "operator": OperatorConfig,
    "console": ConsoleConfig,
    "observe": ObserverConfig,
    "camera": CameraConfig,
    "patient-page": PatientPageConfig,
    "voice": VoiceConfig,
    "rendezvous": RendezvousConfig,
    "tunnel": TunnelConfig,
    "sim-remote": SimRemoteConfig,
    "sim-operator": SimOperatorConfig,
    "sim-network": SimNetworkConfig,
}
"""Model of the configuration that each command of `teletaction` reads."""
_SIMILAR = 0.75
"""Smallest ratio of `difflib` at which a name counts as misspelt."""
_LONGEST_NAME = 60
"""Number of characters of an unknown name that its error shows."""


def command_for(values: Mapping[str, object]) -> str:
    """Return the command whose configuration these values are; empty if no command accepts them."""
    for command, model in COMMANDS.items():
        try:
            model.model_validate(values)
        except ValidationError:
            continue
        return command
    return ""


def advice(location: Sequence[str | int], value: object, model: type[BaseModel]) -> str:
    """Return the error of a field or table that `model` does not have, with the place where it belongs if one is known.

    Args:
        location: names of the tables around it, numbers in lists of tables, and its own name last.
        value: its content in the file.
        model: model of the file.
    """
    *above, last = location
    name = str(last)
    table, tables = ".".join(part for part in above if isinstance(part, str)), _tables(model)
    here = tables[table].model_fields if table in tables else {}
    what = "table" if isinstance(value, dict) else "field"
    if near := difflib.get_close_matches(name, here, 1, _SIMILAR):
        return f"no such {what}; did you mean {_dotted(table, near[0])}?"
    inner = next((each for each in here if isinstance(value, dict) and isinstance(value.get(each), dict)), None)
    if inner is not None:
        wrong = _dotted(table, printable(name, _LONGEST_NAME), inner)
        return f"no such table; write [{_dotted(table, inner)}] instead of [{wrong}]"
    places = [_place(other, name, what) for other, kind in tables.items() if name in kind.model_fields]
    commands = [
        command
        for command, kind in COMMANDS.items()
        if kind is not model and table in (found := _tables(kind)) and name in found[table].model_fields
    ]
    if commands:
        places.append(f"in a configuration for {' or '.join(f'`teletaction {command}`' for command in commands)}")
    if places:
        return f"no such {what} here; it belongs {', or '.join(places)}"
    everywhere = {field: other for other, kind in tables.items() for field in kind.model_fields}
    if near := difflib.get_close_matches(name, everywhere, 1, _SIMILAR):
        return f"no such {what} here; did you mean {_dotted(everywhere[near[0]], near[0])}?"
    if what == "table" and not table:
        return f"no such table; there are {', '.join(f'[{each}]' for each in _names_of_tables(model))}"
    return f"no such {what}"


def _tables(model: type[BaseModel]) -> dict[str, type[BaseModel]]:
    """Return the model of each table of a file by the table's name; the top of the file has an empty name."""
    found = {"": model}
    for name, field in model.model_fields.items():
        for kind in (field.annotation, *get_args(field.annotation)):  # the arguments of a list of tables
            if isinstance(kind, type) and issubclass(kind, BaseModel):
                found[name] = kind
    return found


def _names_of_tables(model: type[BaseModel]) -> list[str]:
    tables = _tables(model)
    fields = model.model_fields.items()
    return [name for name, field in fields if name in tables or get_origin(field.annotation) is dict]


def _place(table: str, name: str, what: str) -> str:
    if what == "table":
        return f"at [{_dotted(table, name)}]"
    return f"in [{table}]" if table else "at the top of the file, above all tables"


def _dotted(*names: str) -> str:
    return ".".join(name for name in names if name)
