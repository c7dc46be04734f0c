"""Fixtures of tests on two hosts: they are skipped where these are impossible, and print their tables at the end."""

from collections.abc import Iterator

import pytest

from tests.network.link_bench import HEAD
from tests.network.two_hosts import why_not


@pytest.fixture(scope="module", autouse=True)
def possible() -> None:
    """Skip where it cannot be done."""
    if reason := why_not():
        pytest.skip(reason)


@pytest.fixture(scope="module")
def table() -> Iterator[list[str]]:
    """Rows, printed after the last test of the module."""
    rows: list[str] = []
    yield rows
    print("\n".join(rows))


@pytest.fixture(scope="module")
def link_table(table: list[str]) -> list[str]:
    """As `table`, below the head of `Measured.row`."""
    table.append(HEAD)
    return table
