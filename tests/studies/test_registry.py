"""The command `study` and the folder it fills, with studies that measure nothing."""

import csv
import json
import sys
from collections.abc import Callable
from inspect import signature
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from studies import registry
from teletaction.cli import main


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """The only study there is: `plain`; what it was asked is kept."""
    asked: list[object] = []

    def run(quick: bool, seed: int, tell: Callable[[object], object]) -> dict[str, Any]:
        asked.append((quick, seed))
        tell(0.5)
        tell("in words")
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
def problems(told: list[object], monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What a second study finds wrong, which runs before `plain`: `strict`."""
    found: list[str] = []
    module = ModuleType("strict_study", "What it shows.")
    vars(module).update(
        run=lambda quick, seed, tell, work: {"problems": found}, plot=lambda data, path: path.write_text("drawn")
    )
    monkeypatch.setitem(sys.modules, "strict_study", module)
    monkeypatch.setattr(registry, "STUDIES", {"strict": "strict_study", **registry.STUDIES})
    return found


def test_a_study_fills_its_folder(told: list[object], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "new" / "out"
    assert main(["study", "plain", "--quick", "--seed", "3", "--out", str(out)]) == 0
    assert told == [(True, 3)]
    assert json.loads((out / "plain.json").read_text())["rows"][0] == {"a": 1, "b": None}
    with (out / "plain-rows.csv").open(newline="") as file:
        assert list(csv.DictReader(file)) == [{"a": "1", "b": ""}, {"a": "2", "b": "x,y"}]
    assert (out / "plain.png").read_text() == "2"
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1, "nothing but where it was written, when nobody looks on"
    assert "50%" not in said.err


def test_on_a_terminal_a_line_tells_how_far_it_is(
    told: list[object], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    assert main(["study", "--all", "--out", str(tmp_path)]) == 0
    err = capsys.readouterr().err
    assert told == [(False, 0)]
    assert "plain: 50%" in err
    assert "plain: in words" in err
    assert err.count("\n") == 2, "where plain was written, and the overview"


def test_problems_that_a_study_finds_are_told_and_a_failure(
    problems: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["study", "strict", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err.count("\n") == 1
    problems += ["it grew", "it stopped"]
    assert main(["study", "strict", "--out", str(tmp_path)]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    _, *told, last = said.err.splitlines()
    assert told == ["strict: it grew", "strict: it stopped"]
    assert last == "teletaction: problems found: 2"
    assert json.loads((tmp_path / "strict.json").read_text()) == {"quick": False, "seed": 0, "problems": problems}
    assert (tmp_path / "strict.png").read_text() == "drawn"


def test_what_one_study_finds_wrong_does_not_keep_another_from_running(
    problems: list[str], told: list[object], tmp_path: Path
) -> None:
    problems.append("it grew")
    assert main(["study", "--all", "--out", str(tmp_path)]) == 1
    assert told == [(False, 0)]
    assert (tmp_path / "plain.json").exists()
    assert {path.name for path in tmp_path.glob("overview.*")} == {"overview.csv", "overview.png"}


def test_the_list_tells_what_each_shows(told: list[object], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "--list"]) == 0
    assert capsys.readouterr().out == "plain: What it shows.\n"
    assert told == []


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
    told: list[object], arguments: list[str], words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["study", *arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert all(word in said.err for word in words)
    assert told == []


@pytest.mark.parametrize("name", registry.STUDIES)
def test_each_study_has_what_the_registry_asks_for(name: str) -> None:
    module = registry.study(name)
    shares_its_work = "work" in signature(module.run).parameters
    assert shares_its_work != hasattr(module, "MEASURES_THIS_MACHINE")
    assert callable(module.plot)
    line = registry.described()[name]
    assert line.endswith(".")
    assert len(line) < 120


def test_all_studies_go_on_past_one_that_lacks_something_and_that_one_alone_does_not(
    problems: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(**_: object) -> dict[str, Any]:
        raise registry.Unavailable("RECORDINGS has to name a folder")

    monkeypatch.setattr(sys.modules["strict_study"], "run", run)
    assert main(["study", "--all", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "plain.json").is_file()
    assert "strict: skipped: RECORDINGS has to name a folder" in capsys.readouterr().err
    assert main(["study", "strict", "--out", str(tmp_path)]) == 2
    assert "RECORDINGS has to name a folder" in capsys.readouterr().err


def test_all_studies_go_on_where_they_were_interrupted(
    problems: list[str], told: list[object], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """`strict` has ended, and found something wrong, when `plain` is interrupted."""
    problems.append("it grew")
    plain = sys.modules["plain_study"]
    measured = plain.run

    def interrupted(**_: object) -> dict[str, Any]:
        raise KeyboardInterrupt

    monkeypatch.setattr(plain, "run", interrupted)
    assert main(["study", "--all", "--quick", "--out", str(tmp_path)]) == 130
    (tmp_path / "strict.json").unlink()
    monkeypatch.setattr(plain, "run", measured)
    assert main(["study", "--all", "--quick", "--out", str(tmp_path)]) == 1, "what was wrong still is"
    assert told == [(True, 0)]
    assert not (tmp_path / "strict.json").exists(), "it was not run again"
    assert main(["study", "--all", "--quick", "--out", str(tmp_path)]) == 1
    assert (tmp_path / "strict.json").exists(), "a run that came to its end begins anew"


def test_another_seed_goes_on_from_nothing(
    problems: list[str], told: list[object], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    plain = sys.modules["plain_study"]
    measured = plain.run

    def interrupted(**_: object) -> dict[str, Any]:
        raise KeyboardInterrupt

    monkeypatch.setattr(plain, "run", interrupted)
    assert main(["study", "--all", "--out", str(tmp_path)]) == 130
    monkeypatch.setattr(plain, "run", measured)
    (tmp_path / "strict.json").unlink()
    assert main(["study", "--all", "--seed", "2", "--out", str(tmp_path)]) == 0
    assert json.loads((tmp_path / "strict.json").read_text())["seed"] == 2
