"""The record of what ran: counts from what pytest prints, the newest run of each piece, no unknown pieces."""

import re
from pathlib import Path

import pytest

from tests import everything
from tests.everything import PIECES, Run, counted, main, read, write

MAKEFILE = Path(__file__).parent.parent / "Makefile"
PRINTED = """
FAILED tests/a.py::test_one[x] - AssertionError: in 3 words
============ 1 failed, 12 passed, 2 skipped, 100 deselected in 62.10s (0:01:02) ============
tests/b.py ....
NOT JUDGED tests/c.py::test_late - the machine stood still for 73 ms
============================== 30 passed in 1.00s ==============================
MISSED timeout doubled (a.py; tests/b.py)
1 passed, 1 failed
"""
RUN = Run("dask", "abc123", "2026-11-26", 1.5, 2, 101.0, 9, 1, ("tests/c.py::z - 73 ms",), ())


def test_tests_of_all_runs_are_counted_and_failures_named() -> None:
    late = "tests/c.py::test_late - the machine stood still for 73 ms"
    failed = ("tests/a.py::test_one[x]", "timeout doubled (a.py; tests/b.py)")
    assert counted(PRINTED) == (43, 2, (late,), failed)
    assert counted("make: *** no rule") == (0, 0, (), ())


def test_the_record_is_read_as_it_was_written(tmp_path: Path) -> None:
    record, page = tmp_path / "record.json", tmp_path / "page.md"
    assert read(record) == {}
    write([RUN, Run("hardening", "abc123", "2026-11-26", 2.0, 2, 101.0, 5, 0, (), ("tests/x.py::y",))], record, page)
    assert read(record)["dask"] == RUN
    assert page.read_text("utf-8").index("| hardening |") < page.read_text("utf-8").index("| dask | abc123 |")
    assert "`tests/x.py::y`" in page.read_text("utf-8")


def test_pieces_that_passed_at_this_commit_are_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ran = []

    def run_piece(piece: str, commit: str) -> Run:
        ran.append(piece)
        return Run(piece, commit, "2026-11-26", 0.0, 2, 100.0, 1, 0, (), ("t",) if piece == "soak" else ())

    monkeypatch.chdir(tmp_path)
    Path("docs").mkdir()
    monkeypatch.setattr(everything, "run_piece", run_piece)
    monkeypatch.setattr(everything, "this_commit", lambda: "abc")
    assert main([]) == 1
    assert ran == list(PIECES)
    ran.clear()
    assert main([]) == 1
    assert ran == ["soak"]


def test_an_unknown_piece_is_refused_with_a_list_of_the_pieces(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fault"]) == 2
    assert "no piece 'fault'; there are: breaks" in capsys.readouterr().err


@pytest.mark.parametrize("target", sorted({words[0] for words in PIECES.values()}))
def test_each_piece_is_a_target_of_make(target: str) -> None:
    assert re.search(rf"^{target}:", MAKEFILE.read_text("utf-8"), re.MULTILINE)
