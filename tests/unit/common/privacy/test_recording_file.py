"""Encrypted recordings: written by the recorder, opened in one place, and the errors of missing and wrong keys."""

import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

pytest.importorskip("nacl")

from common.link.keys import KeyProblem, create_keys, load_key_file
from common.privacy.key_variable import KEY_VARIABLE, given_key
from common.privacy.recording_file import create_recording, open_recording, recipient_of
from common.recording.encrypted_file import CannotDecrypt, is_encrypted
from common.recording.reader import DamagedRecording, RecordingReader
from common.recording.recorder import Recorder
from common.recording.truncated_mcap import TruncatedMcap, has_end
from tests.places import ROOT


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("private") / "keys"
    create_keys(folder)
    return folder


@pytest.fixture(autouse=True)
def _given(keys: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(KEY_VARIABLE, str(keys))


def public(keys: Path) -> str:
    return load_key_file(keys).public


def recorded(path: Path, keys: Path | None, *, durable: bool = False) -> Path:
    encrypt_for = None if keys is None else public(keys)
    with Recorder(
        path, {"a": {}, "b": {}}, {"key": "x"}, {"t": b"table"}, durable=durable, encrypt_for=encrypt_for
    ) as r:
        for number in range(3000):
            r.write("ab"[number % 2], number * 1_000_000, b"pseudonym P-0417" * 10)
    assert r.failed is None
    return path


def content(path: Path) -> tuple[Counter[str], dict[str, bytes], list[tuple[int, bytes]]]:
    with open_recording(path) as file:
        assert has_end(file)
        found = RecordingReader(path, file)
        messages = [(message.log_time, message.data) for _, _, message in found.messages()]
        return Counter(found.counts), {name: each.data for name, each in found.attachments.items()}, messages


@pytest.mark.parametrize("durable", [False, True])
def test_a_recording_is_the_same_encrypted_and_plain(keys: Path, tmp_path: Path, durable: bool) -> None:
    plain, sealed = (recorded(tmp_path / name, key, durable=durable) for name, key in (("p", None), ("s", keys)))
    assert content(plain) == content(sealed)
    assert b"P-0417" in plain.read_bytes()
    assert b"P-0417" not in sealed.read_bytes()
    with sealed.open("rb") as file:
        assert is_encrypted(file)


def test_a_killed_recording_is_read_up_to_its_last_part(keys: Path, tmp_path: Path) -> None:
    path = recorded(tmp_path / "s.mcap", keys)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 2 // 3])
    with open_recording(path) as file:
        assert not has_end(file)
        with pytest.raises(ValueError, match="cut, without its end"):
            RecordingReader(path, file)
        found = sum(type(record).__name__ == "Message" for record in TruncatedMcap(file).records())
    assert 1000 < found < 3000


def test_a_changed_recording_is_damaged_and_the_rest_is_read(keys: Path, tmp_path: Path) -> None:
    path = recorded(tmp_path / "s.mcap", keys)
    changed = bytearray(path.read_bytes())
    changed[len(changed) // 4] ^= 1
    path.write_bytes(changed)
    with open_recording(path) as file:
        with pytest.raises(DamagedRecording, match="of the encrypted file was changed"):
            RecordingReader(path, file)
        found = sum(type(record).__name__ == "Message" for record in TruncatedMcap(file).records())
    assert 1000 < found < 3000


def test_a_plain_file_is_opened_without_any_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(KEY_VARIABLE, "/absent")
    (tmp_path / "plain").write_bytes(b"plain")
    with open_recording(tmp_path / "plain") as file:
        assert file.read() == b"plain"
        assert recipient_of([file]) is None


def test_a_missing_or_wrong_key_is_named(keys: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = recorded(tmp_path / "s.mcap", keys)
    monkeypatch.delenv(KEY_VARIABLE)
    with pytest.raises(CannotDecrypt) as caught:
        open_recording(path)
    assert f"{path}: encrypted for the key {public(keys)[:8]}...; set TELETACTION_KEY" in str(caught.value)
    other = tmp_path / "other"
    create_keys(other)
    monkeypatch.setenv(KEY_VARIABLE, str(other))
    with pytest.raises(CannotDecrypt, match="other is the key ") as caught:
        open_recording(path)
    assert public(other)[:8] in str(caught.value)
    monkeypatch.setenv(KEY_VARIABLE, f"{other}:{keys / 'site.key_secret'}")
    with open_recording(path) as file:
        assert recipient_of([file]) == public(keys)


def test_an_unusable_key_file_is_named(keys: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = recorded(tmp_path / "s.mcap", keys)
    monkeypatch.setenv(KEY_VARIABLE, str(tmp_path / "absent"))
    with pytest.raises(KeyProblem, match="absent: no such file"):
        open_recording(path)
    open_to_all = tmp_path / "site.key_secret"
    open_to_all.write_bytes((keys / "site.key_secret").read_bytes())
    open_to_all.chmod(0o644)
    monkeypatch.setenv(KEY_VARIABLE, str(open_to_all))
    with pytest.raises(KeyProblem, match="lets others read it"):
        open_recording(path)
    open_to_all.chmod(0o600)
    open_to_all.write_text("no key\n")
    with pytest.raises(KeyProblem, match="holds no public key"):
        open_recording(path)


def test_a_file_that_was_cut_within_its_head_is_named(keys: Path, tmp_path: Path) -> None:
    path = recorded(tmp_path / "s.mcap", keys)
    path.write_bytes(path.read_bytes()[:50])
    with pytest.raises(CannotDecrypt, match=r"s\.mcap: cut within its head"):
        open_recording(path)


def test_without_the_extra_it_says_what_to_install(keys: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = recorded(tmp_path / "s.mcap", keys)
    for name in ("nacl", "nacl.public", "nacl.bindings", "nacl.exceptions"):
        monkeypatch.setitem(sys.modules, name, None)
    for attempt in (lambda: open_recording(path), lambda: create_recording(tmp_path / "new", public(keys))):
        with pytest.raises(ValueError, match=r"pip install teletaction\[privacy\]"):
            attempt()
    monkeypatch.setattr("common.recording.recorder.find_spec", lambda _: None)
    with pytest.raises(ValueError, match=r"pip install teletaction\[privacy\]"):
        Recorder(tmp_path / "new", {}, {}, encrypt_for=public(keys))
    assert not (tmp_path / "new").exists()


def test_nothing_of_the_library_is_loaded_for_plain_recordings() -> None:
    program = (
        "import sys, remote_site.site, operator_site.site, operator_site.console.run, common.recording.writer_process\n"
        "print('nacl' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert run.stdout == "False\n"


def test_a_key_may_lie_in_a_folder_with_a_colon_in_its_name(tmp_path: Path) -> None:
    folder = tmp_path / "2026-11-30T10:00" / "keys"
    with create_recording(tmp_path / "plain", create_keys(folder)) as file:
        file.write(b"felt")
    with given_key(folder), open_recording(tmp_path / "plain") as file:
        assert file.read() == b"felt"
