"""Every script and every notebook of the examples runs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.places import ROOT

EXAMPLES = ROOT / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
NOTEBOOKS = sorted(EXAMPLES.glob("notebooks/*.ipynb"))
LONGEST_S = 300
pytestmark = pytest.mark.examples


def test_the_page_lists_each_example() -> None:
    page = (EXAMPLES / "README.md").read_text("utf-8")
    assert [path.name for path in (*SCRIPTS, *NOTEBOOKS) if f"[{path.name}](" not in page] == []


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_runs(script: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-W", "error", str(script)]
    settings = {**os.environ, "MPLBACKEND": "agg"}
    ran = subprocess.run(
        command, cwd=tmp_path, env=settings, timeout=LONGEST_S, capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(notebook: Path, tmp_path: Path) -> None:
    import nbformat
    from nbclient import NotebookClient

    content = nbformat.read(notebook, as_version=4)
    folder = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(content, timeout=LONGEST_S, record_timing=False, resources=folder).execute()
    if kept := os.environ.get("NOTEBOOKS"):
        nbformat.write(content, ROOT / kept / notebook.name)
