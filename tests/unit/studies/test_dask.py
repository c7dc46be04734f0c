"""Pieces on a Dask cluster with two workers of this machine: the same results, also when a worker is killed."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from studies.pieces import HERE, Piece, working
from studies.workers import workers
from teletaction.cli import main
from tests.unit.studies.pieces_of_work import become_another_version, dies, drawn, noted

distributed = pytest.importorskip("distributed", reason="no Dask: pip install 'teletaction[dask]'")
pytestmark = [pytest.mark.dask, pytest.mark.filterwarnings("default")]
PIECES: list[Piece] = [(drawn, (seed, 60)) for seed in range(8)]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, silence_logs=50
    ) as made:
        yield made


def test_a_study_writes_the_same_file_on_a_cluster_as_here(cluster: Any, tmp_path: Path) -> None:
    for way in (("--processes", "1"), ("--processes", "2"), ("--dask", cluster.scheduler_address)):
        assert main(["study", "groove-spacing", "--quick", *way, "--out", str(tmp_path / way[1][:1])]) == 0
    one, two, dask = ((tmp_path / way / "groove-spacing.json").read_bytes() for way in "12t")
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


@pytest.fixture
def lone() -> Iterator[Any]:
    """A cluster of its own, still without workers."""
    with distributed.LocalCluster(
        n_workers=0, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, silence_logs=50
    ) as made:
        yield made


def refused(made: Any, out: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The one line that a study ends with on this cluster, before it has begun."""
    address = made.scheduler_address
    assert main(["study", "vibration", "--quick", "--dask", address, "--out", str(out)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert address in said
    assert not out.exists()
    return said


def test_a_cluster_without_workers_or_with_one_of_other_code_is_refused(
    lone: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "no workers" in refused(lone, tmp_path / "out", capsys)
    lone.scale(2)
    with distributed.Client(lone, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=30.0)
        client.run(become_another_version, workers=list(client.scheduler_info()["workers"])[1:])
    assert "other code" in refused(lone, tmp_path / "out", capsys)


def test_workers_that_cannot_load_the_study_are_refused(
    lone: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One is started where another module has the name of this package."""
    (tmp_path / "studies.py").touch()
    command = [sys.executable, "-m", "distributed.cli.dask_worker", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    without = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    with subprocess.Popen(
        [*command, lone.scheduler_address], cwd=tmp_path, env=without, stderr=subprocess.DEVNULL
    ) as worker:
        try:
            with distributed.Client(lone, set_as_default=False) as client:
                client.wait_for_workers(1, timeout=30.0)
            assert "cannot load" in refused(lone, tmp_path / "out", capsys)
        finally:
            worker.kill()


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "127.0.0.1:1", "nonsense"])
def test_no_cluster_is_one_line(
    address: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("studies.workers.CONNECT_S", 0.5)
    assert main(["study", "vibration", "--quick", "--dask", address, "--out", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert address in said
