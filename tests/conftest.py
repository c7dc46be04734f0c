"""Fixtures of all tests: the bytes of the protocol document, and hypothesis without chance or stopwatch."""

import gc
import re
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import settings

from common.link.keys import TrustedKeys, create_keys
from common.runtime.containment import NAMED_IN
from common.runtime.parallel_map import processors
from tests.not_judged import NotJudged
from tests.ports import free_ports
from tests.shared_imports import SharedImports

LONG_S = 600.0
"""Timeout of a test with the mark `long`, s. Each takes less than a minute on an idle machine."""
settings.register_profile("suite", deadline=None, derandomize=True, print_blob=True, max_examples=50)
settings.register_profile("search", settings.get_profile("suite"), max_examples=1000)
settings.load_profile("suite")

# Where a shell runs all this in the background Ctrl-C is ignored, and would be by every process that a test interrupts.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_configure(config: pytest.Config) -> None:
    """A failure beside a standstill of the machine is no finding, and processes share the first import."""
    config.pluginmanager.register(NotJudged(), "not-judged")
    config.pluginmanager.register(SharedImports(), "shared-imports")


def pytest_xdist_auto_num_workers() -> int:
    """One more than the processors: many tests wait for processes and sockets."""
    return processors() + 1


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Start tests with the longest timeouts first, and give long computations time for a busy machine."""
    marks = {item: item.get_closest_marker("timeout") for item in items}
    items.sort(key=lambda item: -mark.args[0] if (mark := marks[item]) else 0.0)
    for item in items:
        if item.get_closest_marker("long") and not marks[item]:
            item.add_marker(pytest.mark.timeout(LONG_S))


def pytest_collection_finish() -> None:
    """Exempt the collected tests and what they imported from garbage collection, which runs thousands of times."""
    gc.collect()
    gc.freeze()


PROTOCOLS = Path(__file__).parent.parent / "docs" / "protocols.md"
_BLOCK = re.compile(r"^```golden (\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="session")
def golden() -> dict[str, bytes]:
    """The golden blocks of docs/protocols.md by name."""
    blocks = _BLOCK.findall(PROTOCOLS.read_text("utf-8"))
    found = {name: bytes.fromhex(text) for name, text in blocks}
    assert len(found) == len(blocks), "two golden blocks have one name"
    return found


@pytest.fixture
def base_port() -> int:
    """First port of a link on loopback; its ports were free a moment ago."""
    return free_ports()


class Contained:
    """Exceptions that sites contained during a test, in this process or in those that it started."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def take(self) -> list[str]:
        """Their names; what is taken is expected."""
        names = self._file.read_text("utf-8").splitlines()
        self._file.write_text("", "utf-8")
        return names


@pytest.fixture(scope="session")
def contained_file(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Where every process of this test run names what it contains."""
    file = tmp_path_factory.mktemp("contained") / "names"
    file.touch()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(NAMED_IN, str(file))
        yield file


@pytest.fixture(autouse=True)
def contained(contained_file: Path) -> Iterator[Contained]:
    """Fails a test during which a site contained an exception that the test did not take."""
    contained = Contained(contained_file)
    yield contained
    unexpected = contained.take() if contained_file.stat().st_size else []
    assert not unexpected, "contained: " + "; ".join(unexpected)


@dataclass(frozen=True)
class Keys:
    """Key folders of two sites that trust each other, and of a stranger."""

    remote: Path
    operator: Path
    stranger: Path


@pytest.fixture
def keys(tmp_path: Path) -> Keys:
    """Keys of both sites; the remote site trusts the operator."""
    folders = Keys(tmp_path / "remote", tmp_path / "operator", tmp_path / "stranger")
    public = {name: create_keys(getattr(folders, name)) for name in ("remote", "operator", "stranger")}
    TrustedKeys(folders.remote).trust("operator", public["operator"])
    TrustedKeys(folders.operator).trust("remote", public["remote"])
    return folders
