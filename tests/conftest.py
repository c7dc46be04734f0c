"""What all tests share: the bytes of the protocol document, and hypothesis without chance or stopwatch."""

import re
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("suite", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("suite")

PROTOCOLS = Path(__file__).parent.parent / "docs" / "protocols.md"
_BLOCK = re.compile(r"^```golden (\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="session")
def golden() -> dict[str, bytes]:
    """The golden blocks of docs/protocols.md by name."""
    blocks = _BLOCK.findall(PROTOCOLS.read_text("utf-8"))
    found = {name: bytes.fromhex(text) for name, text in blocks}
    assert len(found) == len(blocks), "two golden blocks have one name"
    return found
