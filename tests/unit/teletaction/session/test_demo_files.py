"""Configurations of a session lead to its keys and files, wherever the processes are started."""

from pathlib import Path

import pytest

from common.config.file import load_config
from common.config.site_models import OperatorConfig, RemoteConfig
from common.link.keys import load_keys
from teletaction.session.demo_files import DemoOptions, prepare


def test_a_folder_may_be_relative_to_the_working_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    files = prepare(DemoOptions(fingers=1), Path("out"))
    monkeypatch.chdir("/")
    remote, operator = load_config(files["remote"], RemoteConfig), load_config(files["operator"], OperatorConfig)
    for config in (remote, operator):
        load_keys(config.link.keys)
        assert config.record is not None
        assert config.record.parent == tmp_path / "out"
