"""Work in pieces: the same results here, in processes and on a cluster; what is done is kept, whole or not at all."""

import json
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies import registry
from studies.kept_pieces import KeptPieces
from studies.pieces import HERE, ROOMS, OtherCode, Piece, Workers, code_version, do, here, rows_of, working
from studies.workers import Processes, WorkersLost, workers
from teletaction.cli import main
from tests.commands import command, one_line
from tests.unit.studies import pieces_of_work
from tests.unit.studies.pieces_of_work import dies, drawn, emptied, noted, numbers
from tests.waiting import wait_until

PIECES: list[Piece] = [(drawn, (seed, 60)) for seed in range(5)]
LINES = "done\n"


@pytest.fixture
def two() -> Iterator[Workers]:
    own = Processes(2)
    yield own
    own.end()


@pytest.mark.long
def test_the_results_are_the_same_to_the_last_bit_here_and_in_processes(two: Workers) -> None:
    shares: list[float] = []
    expected = working(here)(PIECES, shares.append)
    assert expected == [drawn(*arguments) for _, arguments in PIECES]
    assert shares == [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
    assert working(two)(PIECES) == expected
    assert working(two)(PIECES[::-1]) == expected[::-1]


def test_the_end_of_the_processes_leaves_no_thread_to_the_end_of_the_program() -> None:
    before = threading.active_count()
    with workers(2) as own:
        assert len(list(own([pickle.dumps((len, ("abc",)))] * 3))) == 3
    assert threading.active_count() == before


@pytest.mark.long
@given(order=st.permutations(range(len(PIECES))), kept=st.sets(st.sampled_from(range(len(PIECES)))))
def test_the_order_in_which_pieces_are_done_changes_nothing(
    tmp_path_factory: pytest.TempPathFactory, order: list[int], kept: set[int]
) -> None:
    """Some are kept from before, the others are done in any order."""
    store = KeptPieces(tmp_path_factory.mktemp("kept"))
    pieces: list[Piece] = [(divmod, (100 + number, 7)) for number in range(len(PIECES))]
    working(here, store)([pieces[number] for number in sorted(kept)])

    def in_order(packed: Sequence[bytes]) -> Iterator[tuple[int, bytes]]:
        assert len(packed) == len(pieces) - len(kept)
        for place in (each for each in order if each < len(packed)):
            yield place, do(code_version(), packed[place])

    assert working(in_order, store)(pieces) == [divmod(100 + number, 7) for number in range(len(pieces))]


def test_a_piece_cannot_change_what_another_one_sees() -> None:
    shared = [3]
    assert HERE([(emptied, (shared,)), (emptied, (shared,))]) == [3, 3]
    assert shared == [3]


def test_without_what_studies_need_one_line_says_what(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "threadpoolctl", None)
    with pytest.raises(ValueError, match=r"pip install 'teletaction\[studies\]'"):
        HERE(PIECES[:1])


def test_rows_come_in_the_order_of_their_pieces_and_what_is_yielded_is_a_list() -> None:
    assert HERE([(numbers, (2, 3))]) == [[0, 1, 0, 1, 2]]
    found = rows_of({"a": [(numbers, (2,)), (numbers, (1,))], "b": []}, HERE, lambda _: None)
    assert found == {"a": [0, 1, 0], "b": []}
    assert HERE([]) == []


def test_what_was_done_is_not_done_again(tmp_path: Path) -> None:
    kept, shares = KeptPieces(tmp_path / "kept"), []
    pieces: list[Piece] = [(noted, (tmp_path, name, name == "b")) for name in "abc"]
    with pytest.raises(RuntimeError, match="interrupted"):
        working(here, kept)(pieces)
    (tmp_path / "mended").touch()
    assert working(here, kept)(pieces, shares.append) == ["a", "b", "c"]
    assert [(tmp_path / name).read_text() for name in "abc"] == [LINES, 2 * LINES, LINES]
    assert shares == [1 / 3, 2 / 3, 1.0]
    kept.forget()
    assert not (tmp_path / "kept").exists()


@given(result=st.binary(max_size=50), data=st.data())
def test_a_half_written_piece_is_never_taken_for_a_whole_one(
    tmp_path_factory: pytest.TempPathFactory, result: bytes, data: st.DataObject
) -> None:
    folder = tmp_path_factory.mktemp("kept")
    kept = KeptPieces(folder)
    kept.keep("key", result)
    assert kept.find("key") == result
    assert kept.find("another") is None
    whole = (folder / "key").read_bytes()
    (folder / "key").write_bytes(whole[: data.draw(st.integers(0, len(whole) - 1))])
    assert kept.find("key") is None
    at = data.draw(st.integers(0, len(whole) - 1))
    (folder / "key").write_bytes(whole[:at] + bytes([whole[at] ^ data.draw(st.integers(1, 255))]) + whole[at + 1 :])
    assert kept.find("key") is None
    assert [path.name for path in folder.iterdir()] == ["key"]


def test_a_worker_with_other_code_does_nothing() -> None:
    with pytest.raises(OtherCode, match="install the same"):
        do(f"not {code_version()}", b"never read")


def test_results_are_kept_for_the_code_of_every_study() -> None:
    assert {module.partition(".")[0] for module in registry.STUDIES.values()} <= set(ROOMS)


@pytest.mark.long
def test_a_process_that_is_killed_costs_time_only(two: Workers, tmp_path: Path) -> None:
    pieces: list[Piece] = [*PIECES, (dies, (tmp_path, "once", 1)), (dies, (tmp_path, "twice", 2))]
    assert working(two)(pieces) == [*HERE(PIECES), "once", "twice"]


@pytest.mark.long
def test_a_piece_that_kills_every_process_ends_the_run(tmp_path: Path) -> None:
    with pytest.raises(WorkersLost, match="in a row"), workers(2) as own:
        working(own)([(dies, (tmp_path, "always", 99))])


@pytest.mark.long
def test_a_piece_that_fails_says_so_wherever_it_is_done(two: Workers, tmp_path: Path) -> None:
    for doing in (here, two):
        with pytest.raises(RuntimeError, match="interrupted"):
            working(doing)([(noted, (tmp_path, "a", True)), *PIECES])
    assert working(two)(PIECES[:1]) == HERE(PIECES[:1]), "and the next work is done"


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """The only study there is: `plain`, nothing but pieces."""
    module = ModuleType("plain_study", "What it shows.")
    vars(module).update(run=pieces_of_work.run, plot=lambda data, path: path.write_text("drawn"))
    monkeypatch.setitem(sys.modules, "plain_study", module)
    monkeypatch.setattr(registry, "STUDIES", {"plain": "plain_study"})


@pytest.mark.long
@pytest.mark.usefixtures("plain")
def test_a_study_writes_the_same_file_with_any_number_of_processes(tmp_path: Path) -> None:
    written = []
    for processes in ("1", "2"):
        out = tmp_path / processes
        assert main(["study", "plain", "--seed", "3", "--processes", processes, "--out", str(out)]) == 0
        written.append((out / "plain.json").read_bytes())
        assert sorted(path.name for path in out.iterdir()) == ["plain.json", "plain.png"], "no piece is kept"
    assert written[0] == written[1]
    assert json.loads(written[0])["numbers"] == [[0, 1, 0, 1, 2]]


@pytest.mark.usefixtures("plain")
def test_a_cluster_that_is_not_there_is_one_line_and_exit_2(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    plain = ("study", "plain", "--out", tmp_path, "--dask", "tcp://127.0.0.1:1")
    assert "teletaction[dask]" in one_line(command(*plain), 2)
    assert one_line(command(*plain, "--processes", 2), 2)
    assert not list(tmp_path.iterdir())


@pytest.mark.study
@pytest.mark.parametrize(("number", "code"), [(signal.SIGKILL, -signal.SIGKILL), (signal.SIGINT, 130)])
def test_a_run_that_is_ended_continues_and_gives_the_same(number: signal.Signals, code: int, tmp_path: Path) -> None:
    """The command is killed, or interrupted as by Ctrl-C, when some pieces are done; its processes end with it."""
    command = [sys.executable, "-m", "teletaction", "study", "groove-spacing", "--processes", "2", "--out"]
    kept = tmp_path / "out" / registry.PIECES / "groove-spacing"
    with subprocess.Popen([*command, str(tmp_path / "out")], stderr=subprocess.DEVNULL) as running:
        wait_until(lambda: sum(path.suffix == "" for path in kept.glob("*")) >= 2, patience_s=60.0)
        running.send_signal(number)
        assert running.wait(20.0) == code
    assert not (tmp_path / "out" / "groove-spacing.json").exists()
    shares: list[float | str] = []
    registry.run_study("groove-spacing", tmp_path / "out", progress=shares.append)
    assert shares[0] >= 2 / 14
    registry.run_study("groove-spacing", tmp_path / "second")
    written = [(tmp_path / out / "groove-spacing.json").read_bytes() for out in ("out", "second")]
    assert written[0] == written[1]
    assert not kept.exists()


def test_a_run_takes_the_processors_that_it_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 3, 5})
    with workers() as many, workers(1) as one:
        assert isinstance(many, Processes)
        assert many.count == 3
        assert one is here
