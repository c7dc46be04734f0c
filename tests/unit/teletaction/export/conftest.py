"""A short session on the test bed, with all recorded streams."""

from pathlib import Path

import pytest

from teletaction.session.demo_files import DemoOptions
from teletaction.testbed.virtual_recording import record_session


@pytest.fixture(scope="package")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record_session(DemoOptions(seconds=4.0, fingers=2), tmp_path_factory.mktemp("session"))
