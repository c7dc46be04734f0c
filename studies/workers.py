"""Runs the pieces of a study's work in processes of this machine or on a running Dask cluster."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import active_children, get_context
from typing import Any

from common.runtime.parallel_map import processors
from studies.pieces import OtherCode, Workers, code_version, do, here
from teletaction.session.processes import die_with_parent

CONNECT_S = 10.0
_DEATHS = 3
"""Deaths of processes in a row, without a finished piece between them, after which the work is given up."""


class WorkersLost(RuntimeError):
    """No workers are left for the work; finished pieces are kept."""


@contextmanager
def workers(processes: int | None = None, dask: str | None = None) -> Iterator[Workers]:
    """Open workers: processes of this machine or a Dask cluster.

    Args:
        processes: number of processes; None for one per processor, 1 for this process alone.
        dask: address of a cluster's scheduler; it takes precedence over `processes`.

    Raises:
        ValueError: Dask is not installed, or a worker of the cluster has other code.
        OSError: no cluster answers at this address, or it has no workers.
    """
    if dask is not None:
        with _cluster(dask) as cluster:
            yield cluster
        return
    count = processes or processors()
    if count == 1:
        yield here
        return
    own = Processes(count)
    try:
        yield own
    finally:
        own.end()


class Processes:
    """Processes that start with the first piece; when one dies, new ones do the remaining pieces."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._before = set(active_children())
        self._pool: ProcessPoolExecutor | None = None

    def __call__(self, packed: Sequence[bytes]) -> Iterator[tuple[int, bytes]]:
        """Do packed pieces; raise WorkersLost when processes die repeatedly without finishing one."""
        left, deaths = set(range(len(packed))), 0
        while left:
            try:
                for place, result in self._try(packed, left):
                    left.remove(place)
                    deaths = 0
                    yield place, result
            except BrokenProcessPool:
                self.end()
                deaths += 1
                if deaths >= _DEATHS:
                    raise WorkersLost(
                        f"{deaths} processes in a row died of their work; is there enough memory?"
                    ) from None

    def _try(self, packed: Sequence[bytes], left: set[int]) -> Iterator[tuple[int, bytes]]:
        if self._pool is None:
            self._pool = ProcessPoolExecutor(self.count, get_context("spawn"), die_with_parent)
        futures = {self._pool.submit(do, code_version(), packed[place]): place for place in sorted(left)}
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        finally:
            for future in futures:
                future.cancel()

    def end(self) -> None:
        """End all processes, even during a piece."""
        if self._pool is not None:
            for process in set(active_children()) - self._before:
                process.terminate()
            # It waits for its thread, which would otherwise meet the end of the program; only the first call can wait.
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None


@contextmanager
def _cluster(address: str) -> Iterator[Workers]:
    try:
        distributed = import_module("distributed")
    except ModuleNotFoundError as missing:
        raise ValueError(f"--dask: {missing.name} is not installed: pip install 'teletaction[dask]'") from None
    try:
        # A client that fails on its address is left half-initialised and takes 20 s to close.
        import_module("distributed.comm").get_address_host_port(address)
    except ValueError as wrong:
        raise ValueError(f"--dask {address}: {wrong}; a scheduler's is tcp://HOST:8786") from None
    with distributed.Client(address, timeout=CONNECT_S, set_as_default=False) as client:
        _refuse_other_code(client, address)

        def cluster(packed: Sequence[bytes]) -> Iterator[tuple[int, bytes]]:
            futures = {client.submit(do, code_version(), each, pure=False): place for place, each in enumerate(packed)}
            try:
                for future in distributed.as_completed(futures, loop=client.loop):
                    yield futures[future], _result(future, address)
            finally:
                client.cancel(list(futures), force=True)

        yield cluster


def _refuse_other_code(client: Any, address: str) -> None:
    """Check that each worker has the code of this study.

    Raises:
        OtherCode: a worker has other code.
        ConnectionError: the cluster has no workers.
    """
    try:
        found = client.run(code_version)
    except Exception as failed:  # errors of a worker's imports have no common base class
        raise OtherCode(f"{address}: a worker cannot load this study: {failed}; install the same there") from failed
    if not found:
        raise ConnectionError(f"{address}: this cluster has no workers: start `dask worker --nthreads 1 {address}`")
    if any(version != code_version() for version in found.values()):
        raise OtherCode(f"{address}: a worker has other code or libraries than this study: install the same there")


def _result(future: Any, address: str) -> bytes:
    """Return the result of a finished piece; raise the piece's own error, or WorkersLost."""
    try:
        return bytes(future.result())
    except Exception as failed:
        if type(failed).__module__.startswith(("distributed", "dask")):
            raise WorkersLost(f"{address}: {failed}") from failed
        raise
