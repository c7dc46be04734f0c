"""Work of a study in independent pieces: the place and the order of their execution change no result.

A piece is a function of a module and arguments that can be pickled, including the seeds of everything random. If it
yields, its result is the list of what it yields. It runs on one thread: processors are shared out by piece, cost is
compared by thread, and sums are added up in one order. Results are kept, so that an interrupted run continues where it
stopped.
"""

import hashlib
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from importlib import import_module
from importlib.metadata import distributions
from pathlib import Path
from platform import python_version
from threading import Lock
from typing import Any, Protocol, TypeVar

from studies.kept_pieces import KeptPieces

Piece = tuple[Callable[..., Any], tuple[Any, ...]]
ReportShare = Callable[[float], object]
Key = TypeVar("Key")
Workers = Callable[[Sequence[bytes]], Iterator[tuple[int, bytes]]]
"""Runs packed pieces in any order; yields the place of each and its packed result, as soon as it is done."""

ROOMS = ("common", "remote_site", "operator_site", "sim_sensors", "teletaction", "studies", "benchmarks", "robustness")
_LIBRARIES = ("numpy", "scipy", "scikit-learn")
_CODE = {".py", ".json", ".toml", ".dbc", ".npz"}
_PROTOCOL = 5
_ONE_AT_A_TIME = Lock()
"""Lock around each piece: the limit of threads is the process's, so a worker with several threads runs one piece at a
time."""


class OtherCode(ValueError):
    """The code of a worker differs from that of the study."""


class Work(Protocol):
    """Runs pieces somewhere; returns their results in the order of the pieces, whatever the order of execution."""

    def __call__(self, pieces: Sequence[Piece], progress: ReportShare = ...) -> list[Any]:
        """Run all pieces; `progress` gets the share done, 0..1, kept ones first. Raises what a piece raises."""
        ...


def here(packed: Sequence[bytes]) -> Iterator[tuple[int, bytes]]:
    """Run pieces in this process, one after the other."""
    for place, each in enumerate(packed):
        yield place, do(code_version(), each)


def working(workers: Workers = here, kept: KeptPieces | None = None) -> Work:
    """Work that runs on `workers`; results that are already kept are not computed again."""

    def work(pieces: Sequence[Piece], progress: ReportShare = lambda _: None) -> list[Any]:
        packed = [pickle.dumps(piece, _PROTOCOL) for piece in pieces]
        keys = [hashlib.sha256(code_version().encode() + each).hexdigest() for each in packed]
        done = {place: found for place, key in enumerate(keys) if kept and (found := kept.find(key)) is not None}
        left = [place for place in range(len(pieces)) if place not in done]
        progress(len(done) / max(1, len(pieces)))
        for number, result in workers([packed[place] for place in left]):
            place = left[number]
            if kept:
                kept.keep(keys[place], result)
            done[place] = result
            progress(len(done) / len(pieces))
        return [pickle.loads(done[place]) for place in range(len(pieces))]

    return work


def results_of(pieces: Mapping[Key, Sequence[Piece]], work: Work, progress: ReportShare) -> dict[Key, list[Any]]:
    """Run pieces, all at once; returns the results of each key, in the order of its pieces."""
    done = iter(work([piece for each in pieces.values() for piece in each], progress))
    return {name: [next(done) for _ in each] for name, each in pieces.items()}


def rows_of(pieces: Mapping[str, Sequence[Piece]], work: Work, progress: ReportShare) -> dict[str, list[Any]]:
    """Run pieces that make rows, all at once; returns all rows of each name, in the order of its pieces."""
    found = results_of(pieces, work, progress)
    return {name: [row for rows in results for row in rows] for name, results in found.items()}


def chunks(items: Sequence[Any], size: int) -> list[Any]:
    """Cut items, such as the seeds of many pieces, into parts of a size; the last one may be smaller."""
    return [items[at : at + size] for at in range(0, len(items), size)]


def part_of(progress: ReportShare, begin: float, end: float) -> ReportShare:
    """Map the share done of a part, 0..1, to the range from `begin` to `end` of the whole, 0..1."""
    return lambda share: progress(begin + (end - begin) * share)


HERE = working()
"""Work in this process, without kept results."""


def do(version_asked: str, packed: bytes) -> bytes:
    """Run one piece; returns its packed result.

    Raises:
        OtherCode: the code of this process differs from that of the caller.
    """
    if version_asked != code_version():
        raise OtherCode("a worker has other code or libraries than this study: install the same there, and begin again")
    with _ONE_AT_A_TIME, one_thread():
        function, arguments = pickle.loads(packed)
        result = function(*arguments)
        return pickle.dumps(list(result) if isinstance(result, Iterator) else result, _PROTOCOL)


def one_thread() -> Any:
    """Keep linear algebra to one thread; returns a context that restores the limit on exit.

    Raises:
        ValueError: the further dependencies of studies are not installed.
    """
    try:
        return import_module("threadpoolctl").threadpool_limits(1)
    except ModuleNotFoundError as missing:
        raise ValueError(f"studies need {missing.name}: pip install 'teletaction[studies]'") from None


@cache
def code_version() -> str:
    """Digest of this code and of the libraries that its numbers come from."""
    installed = {(each.name, each.version) for each in distributions() if each.name in _LIBRARIES}
    digest = hashlib.sha256(repr((python_version(), sorted(installed))).encode())
    for room in ROOMS:
        folder = Path(import_module(room).__path__[0])
        for path in sorted(folder.rglob("*")):
            if path.suffix in _CODE:
                digest.update(f"{room}/{path.relative_to(folder)}".encode() + path.read_bytes())
    return digest.hexdigest()
