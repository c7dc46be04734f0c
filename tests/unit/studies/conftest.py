"""Recordings of the studies' tests."""

from collections.abc import Iterator

import pytest

from tests.places import DATA


@pytest.fixture(scope="package", autouse=True)
def recordings() -> Iterator[None]:
    """Studies look for recordings where tests do."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TELETACTION_DATA", str(DATA))
        yield
