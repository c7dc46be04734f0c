"""Pieces on a Dask cluster with two workers of this machine: the same results, also when a worker is killed."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from studies.pieces import HERE, OtherCode, Piece, code_version, working
from studies.workers import workers
from teletaction.cli import main
from tests.studies.pieces_of_work import dies, drawn, noted

distributed = pytest.importorskip("distributed", reason="no Dask: pip install 'teletaction[dask]'")
pytestmark = [pytest.mark.dask, pytest.mark.filterwarnings("default")]
PIECES: list[Piece] = [(drawn, (seed, 60)) for seed in range(8)]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, silence_logs=50
    ) as made:
        yield made


@pytest.mark.parametrize("study", ["groove-spacing", "vibration"])
def test_a_study_writes_the_same_file_on_a_cluster_as_here(study: str, cluster: Any, tmp_path: Path) -> None:
    for way in (("--processes", "1"), ("--processes", "2"), ("--dask", cluster.scheduler_address)):
        assert main(["study", study, "--quick", *way, "--out", str(tmp_path / way[1][:1])]) == 0
    one, two, dask = ((tmp_path / way / f"{study}.json").read_bytes() for way in "12t")
    assert one == two == dask


def test_a_worker_killed_in_mid_run_costs_time_only(cluster: Any, tmp_path: Path) -> None:
    pieces: list[Piece] = [*PIECES, (dies, (tmp_path, "once", 1))]
    with workers(dask=cluster.scheduler_address) as there:
        assert working(there)(pieces) == [*HERE(PIECES), "once"]
        assert (tmp_path / "once-1").exists(), "it was begun twice"


def test_any_worker_may_be_killed_from_outside(cluster: Any) -> None:
    """When a piece is done, and others are under way and wait."""
    pieces: list[Piece] = [(drawn, (seed, 400)) for seed in range(8)]

    def kill_one(share: float) -> None:
        if share == 1 / len(pieces):
            os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)

    with workers(dask=cluster.scheduler_address) as there:
        assert working(there)(pieces, kill_one) == HERE(pieces)


def test_what_a_piece_raises_is_raised(cluster: Any, tmp_path: Path) -> None:
    with workers(dask=cluster.scheduler_address) as there, pytest.raises(RuntimeError, match="interrupted"):
        working(there)([(noted, (tmp_path, "a", True))])


def test_a_cluster_with_other_code_is_refused(cluster: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("studies.workers.code_version", lambda: f"not {code_version()}")
    with pytest.raises(OtherCode, match=r"other code"), workers(dask=cluster.scheduler_address):
        pass


def test_no_cluster_is_one_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("studies.workers.CONNECT_S", 0.5)
    assert main(["study", "vibration", "--quick", "--dask", "tcp://127.0.0.1:1", "--out", str(tmp_path)]) == 2
    assert "127.0.0.1:1" in capsys.readouterr().err
