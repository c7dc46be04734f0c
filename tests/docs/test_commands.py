"""Every command of README and pages is run in order, each page in a folder of its own. Others give their reason.

Demos are cut short and have one finger, calibrations have fewer touches and strokes. Two demos that differ in nothing
but their folder are run once.
"""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.commands import command
from tests.docs.pages import LASTING, NAMES, NOT_RUN, RUN_BY, Block, blocks
from tests.places import ROOT

pytestmark = [pytest.mark.pages, pytest.mark.timeout(300)]

RECORD = "docs/results.md"
"""Not a page to follow: what was run, and when."""
DEMO_S = "3"
PATIENCE_S = 30.0
FEWER = {"--touches": "5", "--strokes": "2"}
SHELL = set("|<>&;()")
"""What only a shell understands."""


def given(block: Block) -> bool:
    """Whether commands of this block, or its Python, are run here."""
    return (block.commands or block.info == ("python",)) and not {RUN_BY, NOT_RUN} & block.said.keys()


PAGES = [name for name in NAMES if name != RECORD and any(given(block) for block in blocks(name))]
_demos: dict[str, Path] = {}
"""What was left by demos of these options."""


class Reader:
    """Follows one page: writes its files, gives its commands."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.lasting: list[tuple[str, subprocess.Popen[str]]] = []
        (folder / ".venv").mkdir()
        (folder / ".venv" / "bin").symlink_to(Path(sys.executable).parent)
        self.environment = os.environ | {"PYTHONPATH": str(ROOT), "PWD": str(folder)}

    def write(self, block: Block) -> None:
        """A block of TOML is a file where it has a name."""
        if block.info[:1] == ("toml",) and block.info[2:] != ("part",):
            (self.folder / f"{block.info[-1]}.toml").write_text(block.text, "utf-8")

    def give(self, line: str, block: Block) -> None:
        """Give one command; it has to succeed."""
        if re.match(r"\s*make ", line):
            return  # the tests themselves were begun by one; that its target exists is tested
        line = line.replace(".venv/bin/teletaction", "teletaction")
        if LASTING in block.said:
            self._start(line)
            return
        code, printed = self._give(line)
        end_s = time.monotonic() + PATIENCE_S
        while code and self.lasting and time.monotonic() < end_s:  # what was started needs some time
            time.sleep(0.2)
            code, printed = self._give(line)
        assert code == 0, f"{block.where}: {line}\n{printed}\n{self._last_words()}"

    def run(self, block: Block) -> None:
        """Run a block of Python; it has to succeed."""
        words = [sys.executable, "-c", block.text]
        run = subprocess.run(words, capture_output=True, text=True, timeout=120, env=self.environment, check=False)
        assert run.returncode == 0, f"{block.where}: {run.stderr}"

    def _give(self, line: str) -> tuple[int, str]:
        if not line.startswith("teletaction ") or any(set(word) <= SHELL for word in _words(line)):
            run = subprocess.run(
                ["bash", "-euc", line], capture_output=True, text=True, timeout=120, env=self.environment, check=False
            )
            return run.returncode, run.stdout + run.stderr
        words = _words(line)[1:]
        if words[0] == "demo":
            return self._explore(words)
        for option in FEWER.keys() & set(words) if words[0] == "simulate" else ():
            words[words.index(option) + 1] = FEWER[option]
        printed = command(*words)
        return printed.code, printed.out + printed.err

    def _explore(self, words: list[str]) -> tuple[int, str]:
        """A demo, cut short; or what one with the same options left."""
        words[words.index("--seconds") + 1] = DEMO_S
        words += [] if "--fingers" in words else ["--fingers", "1"]
        out = words.index("--out") + 1
        options = " ".join(words[:out] + words[out + 1 :])
        if options in _demos:
            shutil.copytree(_demos[options], words[out])
            return 0, ""
        run = subprocess.run(self._python(words), capture_output=True, text=True, env=self.environment, check=False)
        _demos[options] = self.folder / words[out]
        return run.returncode, run.stderr

    def _python(self, words: list[str]) -> list[str]:
        return [sys.executable, "-m", "teletaction", *words]

    def _start(self, line: str) -> None:
        words = _words(line)[1:]
        with (self.folder / f"{len(self.lasting)}.log").open("w") as log:
            process = subprocess.Popen(self._python(words), stderr=log, text=True, env=self.environment)
        self.lasting.append((line, process))
        end_s = time.monotonic() + PATIENCE_S
        while not _catches_sigterm(process.pid):
            assert process.poll() is None, f"{line}\n{self._last_words()}"
            assert time.monotonic() < end_s, f"{line}: does not begin"
            time.sleep(0.05)

    def end(self) -> None:
        """End what lasts, as Ctrl-C does; it must not have ended before, and must end well."""
        early = [line for line, process in self.lasting if process.poll() is not None]
        said = self._last_words()
        for _, process in reversed(self.lasting):
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        try:
            codes = [process.wait(10.0) for _, process in self.lasting]
        finally:
            for _, process in self.lasting:
                process.kill()
        assert early == [], said
        assert set(codes) <= {0}, (codes, self._last_words())

    def _last_words(self) -> str:
        logs = [self.folder / f"{number}.log" for number in range(len(self.lasting))]
        return "\n".join(log.read_text("utf-8")[-500:] for log in logs)


def _catches_sigterm(pid: int) -> bool:
    """Whether a process has come so far that it ends in order when it is printed to: it catches SIGTERM."""
    caught = re.search(r"(?m)^SigCgt:\s*(\w+)$", Path(f"/proc/{pid}/status").read_text("utf-8"))
    return caught is not None and bool(int(caught[1], 16) >> (signal.SIGTERM - 1) & 1)


def _words(line: str) -> list[str]:
    """Words of a command; what only a shell understands stands by itself, comments are left out."""
    words = shlex.shlex(line, posix=True, punctuation_chars=True)
    words.whitespace_split = True
    return list(words)


def one_by_one(block: Block) -> list[str]:
    """The commands of a block; a line that ends in a backslash continues."""
    return [line for line in block.text.replace("\\\n", " ").splitlines() if line.strip()]


@pytest.mark.parametrize("name", PAGES)
def test_commands_of_a_page_succeed(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = blocks(name)
    reader = Reader(tmp_path)
    for block in page:
        reader.write(block)
    try:
        for block in page:
            if given(block) and block.info == ("python",):
                reader.run(block)
            for line in one_by_one(block) if given(block) and block.commands else ():
                reader.give(line, block)
    finally:
        reader.end()


def test_pages_with_commands_are_among_them() -> None:
    assert {"docs/howto/first-session.md", "docs/howto/your-own.md", "docs/howto/calibration.md"} <= set(PAGES)
