"""The Python of a page runs with the wheel and pandas alone, from an empty folder."""

from pathlib import Path

import pytest

from tests.docs.pages import blocks
from tests.packaging.requirements import EXTRAS, PROJECT
from tests.packaging.wheel import Built, install, run

pytestmark = [pytest.mark.exports, pytest.mark.timeout(600)]

PAGE = "README.md"
"""Page whose first block of Python is run, beside the session that it opens, `demo-out`."""


def test_python_of_the_page_runs_with_the_wheel_and_pandas(built: Built, tmp_path: Path) -> None:
    block = next(block for block in blocks(PAGE) if block.info == ("python",))
    python = install(built, tmp_path, [*PROJECT["dependencies"], *EXTRAS["pandas"]])
    empty = tmp_path / "empty"
    empty.mkdir()
    demo = ("demo", "--headless", "--seconds", 3, "--fingers", 2, "--out", "demo-out")
    run(python.parent / "teletaction", *demo, folder=empty)
    run(python, "-c", block.text, folder=empty)
