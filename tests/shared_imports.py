"""Shares the first import of all test modules between the processes of pytest-xdist.

pytest rewrites the assertions of a module at its first import, and keeps the result in a file. In a fresh checkout all
processes would rewrite all modules, in the same order and at the same time. Here each imports a part of its own first,
and finds the others rewritten.
"""

import importlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest


class SharedImports:
    """The plugin."""

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection(self, session: pytest.Session) -> None:
        """Import the part of this process. The collection imports a module that fails again, and reports it."""
        worker = getattr(session.config, "workerinput", None)
        if worker is None:
            return
        number = int(worker["workerid"].removeprefix("gw"))
        for name in sorted(_modules(session.config))[number :: worker["workercount"]]:
            with suppress(Exception, pytest.skip.Exception):
                importlib.import_module(name)


def _modules(config: pytest.Config) -> Iterator[str]:
    """Yield the names of the modules that the collection will import from folders."""
    ignored = {Path(path).resolve() for path in config.getoption("ignore") or ()}
    for folder in (Path(argument).resolve() for argument in config.args):
        for file in folder.rglob("test_*.py"):
            in_package = (file.parent / "__init__.py").exists()  # it has another name there
            if not in_package and ignored.isdisjoint(file.parents):
                yield ".".join(file.relative_to(config.rootpath).with_suffix("").parts)
