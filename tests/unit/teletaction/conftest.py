"""Shared by the tests of the program: configurations of a session, and small pictures."""

from pathlib import Path

import pytest

from teletaction.session.demo_files import DemoOptions, prepare


@pytest.fixture
def configs(tmp_path: Path) -> dict[str, Path]:
    """Configurations of a session with one finger."""
    return prepare(DemoOptions(fingers=1), tmp_path)


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small pictures in the page of a report: what is tested does not depend on their size."""
    monkeypatch.setattr("teletaction.report.report_parts.DPI", 20)
