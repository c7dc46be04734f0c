"""Files of a user have places by default; explicit paths win."""

import stat
from pathlib import Path

import pytest

from common.files.user_folders import config_folder, state_folder
from common.link.keys import load_keys
from tests.commands import command, one_line


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's folder of configurations and keys, not yet there; sessions are in `state` beside `config`."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "config" / "teletaction"


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize(
    ("command_line", "name"),
    [
        (["remote"], "remote"),
        (["operator"], "operator"),
        (["console"], "console"),
        (["observe"], "observer"),
        (["virtual", "--scene", "materials"], "operator"),
    ],
)
def test_a_process_reads_the_configuration_of_the_user(command_line: list[str], name: str, folder: Path) -> None:
    expected = f"teletaction: no configuration: give --config FILE, or write {folder}/{name}.toml"
    assert one_line(command(*command_line), 2) == expected
    folder.mkdir(parents=True)
    for file in (folder / f"{name}.toml", folder / "other.toml"):
        file.write_text("colour = 1\n", "utf-8")
    assert f"{folder}/{name}.toml:1: colour: no such field" in one_line(command(*command_line), 2)
    other = one_line(command(*command_line, "--config", folder / "other.toml"), 2)
    assert f"{folder}/other.toml:1: colour: no such field" in other


def test_a_command_to_a_running_site_prefers_the_operator_site(folder: Path) -> None:
    expected = f"no configuration: give --config FILE, or write {folder}/operator.toml or {folder}/remote.toml"
    assert expected in one_line(command("session", "status"), 2)
    folder.mkdir(parents=True)
    for name in ("remote", "operator"):
        (folder / f"{name}.toml").write_text("colour = 1\n", "utf-8")
        assert f"{folder}/{name}.toml:1: colour" in one_line(command("session", "estop"), 2)


def test_the_console_takes_a_configuration_or_a_recording() -> None:
    both = one_line(command("console", "--config", "console.toml", "--play", "session.mcap"), 2)
    assert "either --config FILE or --play SESSION.mcap" in both


def test_keys_are_in_a_folder_of_the_user_alone(folder: Path, tmp_path: Path) -> None:
    assert str(folder / "keys") in one_line(command("keys", "show"), 2)
    assert not folder.exists()
    public = command("keys", "init").out.strip()
    assert public == load_keys(folder / "keys").public
    assert [mode(each) for each in (folder / "keys", folder, tmp_path / "config")] == [0o700] * 3
    other = command("keys", "init", "--keys", tmp_path / "other").out.strip()
    assert other != public
    assert command("keys", "trust", "--", "remote", other).said == (0, "", "")
    assert "trusted remote (partner)" in command("keys", "show").out
    assert command("keys", "revoke", "remote").said == (0, "", "revoked 1 key of remote\n")


def test_a_demo_writes_into_the_state_of_the_user(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sessions: list[Path] = []

    def enough(_: object, out: Path) -> None:
        (out / "begun").touch()
        sessions.append(out)
        raise ValueError("enough")

    monkeypatch.setattr("teletaction.session.demo.prepare", enough)
    monkeypatch.chdir(tmp_path)
    assert one_line(command("demo", "--headless", "--rates", "250,500"), 2) == "teletaction: enough"
    (session,) = (tmp_path / "state" / "teletaction").iterdir()
    assert sessions == [session]
    assert session.name.startswith("session-")
    assert mode(session.parent) == 0o700
    assert [path.name for path in tmp_path.iterdir()] == ["state"]


def test_a_relative_folder_is_ignored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    for variable in ("XDG_CONFIG_HOME", "XDG_STATE_HOME"):
        monkeypatch.setenv(variable, "here")
    assert config_folder() == tmp_path / ".config" / "teletaction"
    assert state_folder() == tmp_path / ".local" / "state" / "teletaction"


def test_a_user_without_a_home_is_asked_for_paths(monkeypatch: pytest.MonkeyPatch) -> None:
    def nobody(_: int) -> None:
        raise KeyError

    monkeypatch.setattr("pwd.getpwuid", nobody)
    for variable in ("HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME"):
        monkeypatch.delenv(variable, raising=False)
    for arguments, variable in (
        (["remote"], "XDG_CONFIG_HOME"),
        (["demo", "--headless", "--rates", "250,500"], "XDG_STATE_HOME"),
    ):
        expected = f"no home directory for teletaction's files: set {variable}, or give their path"
        assert expected in one_line(command(*arguments), 2)
