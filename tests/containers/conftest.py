"""An engine is needed."""

import shutil

import pytest


@pytest.fixture(autouse=True, scope="session")
def engine() -> None:
    """Fail where there is none."""
    if shutil.which("docker") is None:
        pytest.fail('no docker here: `eval "$(tests/containers/engine.sh)"` first')
