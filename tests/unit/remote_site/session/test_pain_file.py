"""The patient's force limit is kept in a file; a damaged file is the lowest limit, never none."""

import errno
import math
import os
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

from common.limits import CONTACT_FORCE_N, PAIN_LEAST_N
from remote_site.session.pain_file import PainFile


@pytest.fixture
def status(tmp_path: Path) -> Path:
    return tmp_path / "remote.json"


def limit_later_n(status: Path | None) -> float | None:
    """Return the limit that the next process of the site finds."""
    with PainFile(status) as file:
        return file.limit_n()


def keep(status: Path | None, *limits_n: float) -> str:
    """Keep one limit after the other; return the problem."""
    with PainFile(status) as file:
        for limit_n in limits_n:
            file.keep_limit(limit_n)
    return file.problem


def test_a_limit_is_found_by_the_next_process_until_a_person_ends_it(status: Path) -> None:
    assert limit_later_n(status) is None
    assert keep(status, math.inf, 2.1, float(np.float64(1.0) / 3.0) + 1.0) == ""
    file = status.with_name("remote.pain")
    assert file.stat().st_mode & 0o777 == 0o600
    assert limit_later_n(status) == limit_later_n(status) == 1.0 + 1.0 / 3.0
    with PainFile(status) as kept:
        assert kept.limit_n() is not None
        kept.keep_limit(math.inf)
    assert [*status.parent.iterdir()] == []


def test_a_limit_that_the_default_limit_contains_is_not_kept(status: Path) -> None:
    assert keep(status, 2.0, CONTACT_FORCE_N) == ""
    assert limit_later_n(status) is None


def test_an_unchanged_limit_is_not_written_again(status: Path) -> None:
    keep(status, 2.0)
    written_ns = status.with_name("remote.pain").stat().st_mtime_ns
    with PainFile(status) as file:
        file.keep_limit(file.limit_n() or math.inf)
    assert status.with_name("remote.pain").stat().st_mtime_ns == written_ns


@pytest.mark.parametrize("content", [b"", b"nan", b"inf", b"-1", b"0.1", b"6", b"2,1", b"\xff\x00", b"1" * 100])
def test_a_damaged_file_is_the_lowest_limit_and_is_named(
    content: bytes, status: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = status.with_name("remote.pain")
    file.write_bytes(content)
    assert limit_later_n(status) == PAIN_LEAST_N
    assert f"{file} is damaged" in caplog.text
    assert keep(status, PAIN_LEAST_N) == ""
    assert file.read_text() == "0.5\n"


def test_on_a_full_disk_the_lowest_limit_holds_after_a_restart(status: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    full = Mock(side_effect=OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    with PainFile(status) as file:
        monkeypatch.setattr("remote_site.session.kept_text.os.write", full)
        file.keep_limit(2.0)
    assert file.problem.startswith("a restart of this site would use an older force limit, or the lowest: ")
    assert limit_later_n(status) == PAIN_LEAST_N


def test_a_site_that_keeps_no_limit_reports_it(tmp_path: Path) -> None:
    for status in (None, tmp_path / "missing" / "remote.json"):
        assert limit_later_n(status) is None
        assert "would end the force limit by the patient's threshold" in keep(status, 2.0)


def test_a_file_that_cannot_be_removed_limits_the_force_again(status: Path) -> None:
    keep(status, 2.0)
    file = status.with_name("remote.pain")
    file.unlink()
    file.mkdir()
    with PainFile(status) as kept:
        assert kept.limit_n() == PAIN_LEAST_N
        kept.keep_limit(math.inf)
    assert "would limit the force again" in kept.problem
