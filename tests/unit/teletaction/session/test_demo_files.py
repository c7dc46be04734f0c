"""Configurations of a session lead to its keys and files, wherever the processes are started."""

from pathlib import Path

import pytest

from common.config.file import load_config
from common.config.page_models import ConsoleConfig
from common.config.recording_models import ConsentConfig
from common.config.simulation_models import SimOperatorConfig, SimRemoteConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from common.config.stream_models import VoiceConfig
from common.link.keys import load_keys
from common.scenes.scene import SCENES, load_scene
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


def test_a_scene_file_may_be_relative_to_the_working_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "own.toml").write_bytes(b'table = "materials"\n' + (SCENES / "materials.toml").read_bytes())
    monkeypatch.chdir(tmp_path)
    files = prepare(DemoOptions(fingers=1, scene="own.toml"), tmp_path / "out")
    monkeypatch.chdir("/")
    assert load_scene(load_config(files["sim-remote"], SimRemoteConfig).scene).name == "materials"
    assert load_scene(load_config(files["sim-operator"], SimOperatorConfig).scene).name == "materials"


def test_the_made_up_patients_consent_is_the_same_in_all_files_and_decides_what_is_recorded(tmp_path: Path) -> None:
    agreed = ("touch", "picture", "voice")
    files = prepare(DemoOptions(fingers=1, console=True, camera=True, voice=True, consent=agreed), tmp_path)
    console = load_config(files["console"], ConsoleConfig)
    assert console.camera is not None
    assert console.voice is not None
    assert (console.camera.record, console.voice.record) == (True, True)
    remote, operator = load_config(files["remote"], RemoteConfig), load_config(files["operator"], OperatorConfig)
    assert console.consent == remote.consent == operator.consent
    assert console.consent == ConsentConfig(touch=True, pain=False, picture=True, voice=True)
    assert load_config(files["voice"], VoiceConfig).remote == files["remote"]
    files = prepare(DemoOptions(fingers=1, console=True, camera=True), tmp_path / "silent")
    console = load_config(files["console"], ConsoleConfig)
    assert console.camera is not None
    assert (console.consent, console.camera.record) == (None, False)
    files = prepare(DemoOptions(fingers=1, console=True, scene="tender_place"), tmp_path / "tender")
    for name, model in (("console", ConsoleConfig), ("remote", RemoteConfig), ("operator", OperatorConfig)):
        assert load_config(files[name], model).consent == ConsentConfig(touch=True, pain=True)


@pytest.mark.parametrize(("consent", "why"), [(("touch", "smell"), "'smell' is none of"), (("pain",), "add touch")])
def test_an_answer_that_no_demo_can_keep_is_refused(tmp_path: Path, consent: tuple[str, ...], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        prepare(DemoOptions(fingers=1, consent=consent), tmp_path)
