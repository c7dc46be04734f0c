"""Shared by the tests of the program: a recorded session, configurations of a session, and small pictures."""

from pathlib import Path

import pytest

from teletaction.session.demo_files import DemoOptions, prepare
from teletaction.testbed.virtual_recording import record_session


@pytest.fixture(scope="session")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short session on the test bed, with all recorded streams; nobody changes the file."""
    return record_session(DemoOptions(seconds=4.0, fingers=2), tmp_path_factory.mktemp("session"))


@pytest.fixture
def configs(tmp_path: Path) -> dict[str, Path]:
    """Configurations of a session with one finger."""
    return prepare(DemoOptions(fingers=1), tmp_path)


@pytest.fixture
def usual_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The doctor finds a machine of the usual speed, however busy this one is."""
    monkeypatch.setattr("teletaction.doctor.doctor.reference_step_s", lambda: 1e-4)


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small pictures in the page of a report: what is tested does not depend on their size."""
    monkeypatch.setattr("teletaction.report.report_parts.DPI", 20)
