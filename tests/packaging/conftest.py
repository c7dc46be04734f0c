"""Shared by the tests of what is installed: source distribution and wheel, built once."""

import pytest

from tests.packaging.wheel import Built, build
from tests.places import ROOT


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """Source distribution and wheel of this checkout."""
    if not (ROOT / ".git").exists():
        pytest.skip("only a checkout knows which files are its own")
    return build(tmp_path_factory.mktemp("built"))
