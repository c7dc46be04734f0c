"""The command `study` and the folder it fills, with studies that measure nothing."""

import csv
import json
import math
import sys
from collections.abc import Callable
from inspect import signature
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from studies import registry
from studies.running import Unavailable
from teletaction.cli import main
from tests.commands import command, one_line


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """The only study there is: `plain`; what it was asked is kept."""
    asked: list[object] = []

    def run(quick: bool, seed: int, progress: Callable[[object], object]) -> dict[str, Any]:
        asked.append((quick, seed))
        progress(0.5)
        progress("in words")
        return {"rows": [{"a": 1, "b": None}, {"a": 2, "b": "x,y"}]}

    module = ModuleType("plain_study", "What it shows.\n\nMore of it.")
    vars(module).update(
        MEASURES_THIS_MACHINE="nothing",
        run=run,
        plot=lambda data, path: path.write_text(f"{len(data['rows'])}"),
        tables=lambda data: {"rows": data["rows"], "none": []},
    )
    monkeypatch.setitem(sys.modules, "plain_study", module)
    monkeypatch.setattr(registry, "STUDIES", {"plain": "plain_study"})
    return asked


@pytest.fixture
def problems(asked: list[object], monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What a second study finds wrong, which runs before `plain`: `strict`."""
    found: list[str] = []
    module = ModuleType("strict_study", "What it shows.")
    vars(module).update(
        run=lambda quick, seed, progress, work: {"problems": found}, plot=lambda data, path: path.write_text("drawn")
    )
    monkeypatch.setitem(sys.modules, "strict_study", module)
    monkeypatch.setattr(registry, "STUDIES", {"strict": "strict_study", **registry.STUDIES})
    return found


def test_a_study_fills_its_folder(asked: list[object], tmp_path: Path) -> None:
    out = tmp_path / "new" / "out"
    said = command("study", "plain", "--quick", "--seed", 3, "--out", out)
    assert (said.code, said.out) == (0, "")
    assert asked == [(True, 3)]
    assert json.loads((out / "plain.json").read_text())["rows"][0] == {"a": 1, "b": None}
    with (out / "plain-rows.csv").open(newline="") as file:
        assert list(csv.DictReader(file)) == [{"a": "1", "b": ""}, {"a": "2", "b": "x,y"}]
    assert (out / "plain.png").read_text() == "2"
    assert said.err.count("\n") == 1, "nothing but where it was written, when nobody looks on"
    assert "50%" not in said.err


@pytest.mark.usefixtures("asked")
def test_numbers_that_are_none_are_null_in_the_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = {"rows": [{"a": math.nan, "b": [1.5, -math.inf]}]}
    monkeypatch.setattr(sys.modules["plain_study"], "run", lambda **_: data)
    assert command("study", "plain", "--out", tmp_path).code == 0
    assert json.loads((tmp_path / "plain.json").read_text())["rows"] == [{"a": None, "b": [1.5, None]}]


def test_on_a_terminal_a_line_shows_the_progress(
    asked: list[object], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    assert main(["study", "--all", "--out", str(tmp_path)]) == 0
    err = capsys.readouterr().err
    assert asked == [(False, 0)]
    assert "plain: 50%" in err
    assert "plain: in words" in err
    assert err.count("\n") == 2, "where plain was written, and the overview"


def test_problems_that_a_study_finds_are_said_and_a_failure(problems: list[str], tmp_path: Path) -> None:
    good = command("study", "strict", "--out", tmp_path)
    assert (good.code, good.err.count("\n")) == (0, 1)
    problems += ["it grew", "it stopped"]
    bad = command("study", "strict", "--out", tmp_path)
    assert (bad.code, bad.out) == (1, "")
    _, *problem_lines, last = bad.err.splitlines()
    assert problem_lines == ["strict: it grew", "strict: it stopped"]
    assert last == "teletaction: problems found: 2"
    assert json.loads((tmp_path / "strict.json").read_text()) == {"quick": False, "seed": 0, "problems": problems}
    assert (tmp_path / "strict.png").read_text() == "drawn"


def test_what_one_study_finds_wrong_does_not_keep_another_from_running(
    problems: list[str], asked: list[object], tmp_path: Path
) -> None:
    problems.append("it grew")
    assert main(["study", "--all", "--out", str(tmp_path)]) == 1
    assert asked == [(False, 0)]
    assert (tmp_path / "plain.json").exists()
    assert {path.name for path in tmp_path.glob("overview.*")} == {"overview.csv", "overview.png"}


def test_the_list_says_what_each_shows(asked: list[object]) -> None:
    assert command("study", "--list").said == (0, "plain: What it shows.\n", "")
    assert asked == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nothing", "--out", "x"], ("no study 'nothing'", "plain")),
        (["nothing"], ("no study 'nothing'", "plain")),
        ([], ("name one study, or --all", "plain")),
        (["plain", "--all", "--out", "x"], ("name one study, or --all", "plain")),
        (["plain"], ("--out DIR",)),
    ],
)
def test_a_wrong_request_is_one_line_and_exit_2(
    asked: list[object], arguments: list[str], words: tuple[str, ...]
) -> None:
    line = one_line(command("study", *arguments), 2)
    assert all(word in line for word in words)
    assert asked == []


@pytest.mark.parametrize("name", registry.STUDIES)
def test_each_study_has_what_the_registry_asks_for(name: str) -> None:
    module = registry.study(name)
    shares_its_work = "work" in signature(module.run).parameters
    assert shares_its_work != hasattr(module, "MEASURES_THIS_MACHINE")
    assert callable(registry.plot_of(name))
    line = registry.described()[name]
    assert line.endswith(".")
    assert len(line) < 120


def test_all_studies_continue_past_one_that_lacks_something_and_that_one_alone_fails(
    problems: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def run(**_: object) -> dict[str, Any]:
        raise Unavailable("RECORDINGS has to name a folder")

    monkeypatch.setattr(sys.modules["strict_study"], "run", run)
    said = command("study", "--all", "--out", tmp_path)
    assert said.code == 0
    assert (tmp_path / "plain.json").is_file()
    assert "strict: skipped: RECORDINGS has to name a folder" in said.err
    assert "RECORDINGS has to name a folder" in one_line(command("study", "strict", "--out", tmp_path), 2)


def interrupted(*arguments: str) -> None:
    """All studies, of which `strict` has ended when `plain` is interrupted; what `strict` left is deleted."""

    def run(**_: object) -> dict[str, Any]:
        raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys.modules["plain_study"], "run", run)
        assert main(["study", "--all", *arguments]) == 130
    (Path(arguments[-1]) / "strict.json").unlink()


@pytest.mark.long
def test_all_studies_continue_where_they_were_interrupted(
    problems: list[str], asked: list[object], tmp_path: Path
) -> None:
    problems.append("it grew")
    interrupted("--quick", "--out", str(tmp_path))
    assert main(["study", "--all", "--quick", "--out", str(tmp_path)]) == 1, "what was wrong still is"
    assert asked == [(True, 0)]
    assert not (tmp_path / "strict.json").exists(), "it was not run again"
    assert main(["study", "--all", "--quick", "--out", str(tmp_path)]) == 1
    assert (tmp_path / "strict.json").exists(), "a run that came to its end begins again"


@pytest.mark.long
@pytest.mark.usefixtures("problems")
def test_another_seed_begins_again(tmp_path: Path) -> None:
    interrupted("--out", str(tmp_path))
    assert main(["study", "--all", "--seed", "2", "--out", str(tmp_path)]) == 0
    assert json.loads((tmp_path / "strict.json").read_text())["seed"] == 2


@pytest.mark.long
@pytest.mark.usefixtures("problems")
def test_other_recordings_begin_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("TELETACTION_DATA")
    interrupted("--out", str(tmp_path))
    monkeypatch.setenv("TELETACTION_DATA", str(tmp_path))
    assert main(["study", "--all", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "strict.json").exists(), "it may need the recordings"
