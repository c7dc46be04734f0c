"""Work of a study in pieces that share nothing: where and in which order they are done changes no result.

A piece is a function of a module and arguments that can be pickled, the seeds of all that is random among them; what
it yields, if it does, is its result as a list. It is done on one thread: processors are shared out by piece, cost is
compared by thread, and sums are added up in one order. What has been done is kept, so that a run that was interrupted
goes on where it was.
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
from typing import Any, Protocol

from studies.kept_pieces import KeptPieces

Piece = tuple[Callable[..., Any], tuple[Any, ...]]
TellShare = Callable[[float], object]
Workers = Callable[[Sequence[bytes]], Iterator[tuple[int, bytes]]]
"""Does packed pieces in any order: yields the place of each and its packed result, as soon as it is done."""

ROOMS = ("common", "remote_site", "operator_site", "sim_sensors", "teletaction", "studies")
_LIBRARIES = ("numpy", "scipy", "scikit-learn")
_CODE = {".py", ".json", ".toml", ".dbc"}
_PROTOCOL = 5
_ONE_AT_A_TIME = Lock()
"""The number of threads is the process's: a worker with several threads does no two pieces at once."""


class OtherCode(ValueError):
    """A worker would do a piece with other code than that of the study."""


class Work(Protocol):
    """Does pieces somewhere: their results in their order, whatever the order in which they are done."""

    def __call__(self, pieces: Sequence[Piece], tell: TellShare = ...) -> list[Any]:
        """Do all; `tell` is told the share done, 0..1, first that which was kept. Raises what a piece raises."""
        ...


def here(packed: Sequence[bytes]) -> Iterator[tuple[int, bytes]]:
    """Do pieces in this process, one after the other."""
    for place, each in enumerate(packed):
        yield place, do(code_version(), each)


def working(workers: Workers = here, kept: KeptPieces | None = None) -> Work:
    """Work done by `workers`; what is kept already is not done again."""

    def work(pieces: Sequence[Piece], tell: TellShare = lambda _: None) -> list[Any]:
        packed = [pickle.dumps(piece, _PROTOCOL) for piece in pieces]
        keys = [hashlib.sha256(code_version().encode() + each).hexdigest() for each in packed]
        done = {place: found for place, key in enumerate(keys) if kept and (found := kept.find(key)) is not None}
        left = [place for place in range(len(pieces)) if place not in done]
        tell(len(done) / max(1, len(pieces)))
        for number, result in workers([packed[place] for place in left]):
            place = left[number]
            if kept:
                kept.keep(keys[place], result)
            done[place] = result
            tell(len(done) / len(pieces))
        return [pickle.loads(done[place]) for place in range(len(pieces))]

    return work


def rows_of(pieces: Mapping[str, Sequence[Piece]], work: Work, tell: TellShare) -> dict[str, list[Any]]:
    """Do pieces that make rows, all at once; all rows of each name, in the order of its pieces."""
    done = iter(work([piece for each in pieces.values() for piece in each], tell))
    return {name: [row for _ in each for row in next(done)] for name, each in pieces.items()}


def part_of(tell: TellShare, begin: float, end: float) -> TellShare:
    """Tells how far all is, by how far the part of it from `begin` to `end`, 0..1, is."""
    return lambda share: tell(begin + (end - begin) * share)


HERE = working()
"""Work done in this process, and not kept."""


def do(version_asked: str, packed: bytes) -> bytes:
    """Do one piece; its result packed.

    Raises:
        OtherCode: this process has other code than whoever asks.
    """
    if version_asked != code_version():
        raise OtherCode("a worker has other code or libraries than this study: install the same there, and begin again")
    with _ONE_AT_A_TIME, one_thread():
        function, arguments = pickle.loads(packed)
        result = function(*arguments)
        return pickle.dumps(list(result) if isinstance(result, Iterator) else result, _PROTOCOL)


def one_thread() -> Any:
    """Keep linear algebra to one thread; returns what restores it, as a context.

    Raises:
        ValueError: what studies need beside the product is not installed.
    """
    try:
        return import_module("threadpoolctl").threadpool_limits(1)
    except ModuleNotFoundError as missing:
        raise ValueError(f"studies need {missing.name}: pip install 'teletaction[studies]'") from None


@cache
def code_version() -> str:
    """Tells this code and the libraries that its numbers come from, from any other."""
    installed = {(each.name, each.version) for each in distributions() if each.name in _LIBRARIES}
    digest = hashlib.sha256(repr((python_version(), sorted(installed))).encode())
    for room in ROOMS:
        folder = Path(import_module(room).__path__[0])
        for path in sorted(folder.rglob("*")):
            if path.suffix in _CODE:
                digest.update(f"{room}/{path.relative_to(folder)}".encode() + path.read_bytes())
    return digest.hexdigest()
