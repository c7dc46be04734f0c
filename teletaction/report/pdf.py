"""Prints an HTML file as PDF by Chromium."""

import os
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from common.files.private_file import write_private

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
_LONGEST_S = 120.0
MARK = b"% teletaction\n"
"""Comment at the end of each report, by which it is recognised as one."""


def print_pdf(html: Path, out: Path) -> None:
    """Print a page as it is, with the parts that are open.

    Args:
        html: page to print.
        out: PDF to write.

    Raises:
        ValueError: no Chromium was found, or it printed nothing.
        OSError: `out` cannot be written.
    """
    browser = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, _NAMES)), None)
    if browser is None or shutil.which(browser) is None:
        raise ValueError(
            f"{out}: a PDF needs Chromium; install it, set CHROMIUM to its path, or print the HTML report in a browser"
        )
    with TemporaryDirectory() as folder:
        made = Path(folder) / "made.pdf"
        words = [browser, "--headless", "--disable-gpu", f"--user-data-dir={folder}/profile", "--no-pdf-header-footer"]
        if os.geteuid() == 0:  # Chromium refuses its sandbox to root.
            words.append("--no-sandbox")
        try:
            run = subprocess.run(
                [*words, f"--print-to-pdf={made}", html.resolve().as_uri()],
                capture_output=True,
                timeout=_LONGEST_S,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise ValueError(f"{out}: {browser} did not print within {_LONGEST_S:g} s") from None
        if not made.is_file():
            raise ValueError(f"{out}: {browser} printed nothing and ended with exit code {run.returncode}")
        write_private(out, made.read_bytes() + MARK)
