"""Imports what needs a package that is installed only with an extra."""

from importlib import import_module
from typing import Any


def load_optional(module: str, name: str, extra: str) -> Any:
    """Import a module and return its attribute `name`.

    Args:
        module: full name of the module.
        name: name in it.
        extra: extra of this project that installs the packages of the module.

    Raises:
        ValueError: a package is missing; the message names it and the extra.
    """
    try:
        return getattr(import_module(module), name)
    except ModuleNotFoundError as error:
        raise ValueError(f"needs {error.name}: pip install 'teletaction[{extra}]'") from None
