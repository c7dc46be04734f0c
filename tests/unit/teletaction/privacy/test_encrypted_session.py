"""An encrypted session is merged, reported, replayed, exported and played as the plain one."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("nacl")

from common.link.keys import create_keys
from common.privacy.key_variable import KEY_VARIABLE
from common.privacy.recording_file import open_recording, recipient_of
from common.recording.encrypted_file import is_encrypted
from operator_site.console.examination.journal import Journal
from operator_site.console.playback.playback import Recording as Played
from teletaction.api.recording import Recording
from teletaction.privacy.encrypt import encrypt
from teletaction.recordings.merge import merge_recordings
from teletaction.session.demo_files import PROCESSES, DemoOptions, prepare
from teletaction.testbed.testbed import SessionConfigs
from teletaction.testbed.virtual_recording import recorded_testbed
from tests.commands import command, one_line

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Key folders of both sites, of a further person, and of nobody who has to do with it."""
    folder = tmp_path_factory.mktemp("keys")
    for name in ("remote", "operator", "expert", "stranger"):
        create_keys(folder / name)
    return {path.name: path for path in folder.iterdir()}


@pytest.fixture(autouse=True)
def _no_key(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(KEY_VARIABLE, raising=False)


@pytest.fixture(scope="module")
def sites(session: Path, keys: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The session's recordings, those of the two sites each encrypted for its own key."""
    folder = tmp_path_factory.mktemp("sites")
    for path in session.parent.glob("*.mcap"):
        if path.stem in keys:
            assert encrypt(path, folder / path.name, str(keys[path.stem]))
        elif path != session:
            shutil.copy(path, folder)
    return folder


@pytest.fixture(scope="module")
def merged(sites: Path, keys: dict[str, Path]) -> Path:
    """The merged session, made by somebody with both keys."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(KEY_VARIABLE, f"{keys['operator']}:{keys['remote']}")
        merge_recordings([sites / f"{name}.mcap" for name in PROCESSES], sites / "session.mcap")
        with open_recording(sites / "session.mcap") as file:
            assert recipient_of([file]) == public(keys["operator"])
    return sites / "session.mcap"


def test_both_sites_record_encrypted_and_replay_is_identical(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = prepare(DemoOptions(seconds=0.5, fingers=1), tmp_path)
    own = [tmp_path / "keys" / site for site in ("operator", "remote")]
    for site in ("operator", "remote"):
        text = files[site].read_text("utf-8")
        files[site].write_text(text.replace("encrypt = false", "encrypt = true"), "utf-8")
    with recorded_testbed(SessionConfigs.read(files)) as bed:
        bed.run(0.5)
    sites = [tmp_path / f"{site}.mcap" for site in ("operator", "remote")]
    for path in sites:
        with path.open("rb") as file:
            assert is_encrypted(file)
    monkeypatch.setenv(KEY_VARIABLE, ":".join(map(str, own)))
    merge_recordings(sites, tmp_path / "session.mcap")
    with open_recording(tmp_path / "session.mcap") as file:
        assert recipient_of([file]) == public(own[0])
    done = command("replay", tmp_path / "session.mcap", "--out", tmp_path / "replay")
    assert done.code == 0, done.err
    assert done.err.count("all of") == 2


def public(keys: Path) -> str:
    return command("keys", "show", "--keys", keys, "--json").out.split('"own": "')[1].split('"')[0]


def test_replay_is_identical(session: Path, merged: Path, keys: dict[str, Path], tmp_path: Path) -> None:
    for path, out, key in ((session, "plain", []), (merged, "sealed", ["--key", keys["operator"]])):
        done = command("replay", path, "--out", tmp_path / out, *key)
        assert done.code == 0, done.err
        assert "all of" in done.err
    for name in ("identification.jsonl", "rendering.csv", "replay.json"):
        assert (tmp_path / "plain" / name).read_bytes() == (tmp_path / "sealed" / name).read_bytes()


def test_report_and_export_are_identical(
    session: Path, merged: Path, keys: dict[str, Path], tmp_path: Path, coarse: None
) -> None:
    for path, out, key in ((session, "plain", []), (merged, "sealed", ["--key", keys["operator"]])):
        for words in (
            ["report", path, "--out", tmp_path / f"{out}.html"],
            ["export", path, "--to", "csv", "--out", tmp_path / out],
        ):
            done = command(*words, *key)
            assert done.code == 0, done.err
    assert (tmp_path / "plain.html").read_bytes() == (tmp_path / "sealed.html").read_bytes()
    plain = {path.name: path.read_bytes() for path in (tmp_path / "plain").iterdir()}
    assert plain == {path.name: path.read_bytes() for path in (tmp_path / "sealed").iterdir()}


def test_python_and_playback_read_it(
    session: Path, merged: Path, keys: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(KEY_VARIABLE, str(keys["operator"]))
    assert (Recording(merged).touch.wall_ns == Recording(session).touch.wall_ns).all()
    played, plain = Played(merged), Played(session)
    assert list(played.messages(played.start_ns)) == list(plain.messages(plain.start_ns))
    played.close()
    plain.close()


@pytest.mark.parametrize(
    "words",
    [
        lambda path, out: ["report", path, "--out", out / "r.html"],
        lambda path, out: ["replay", path, "--out", out],
        lambda path, out: ["export", path, "--to", "csv", "--out", out],
        lambda path, out: ["recover", path],
        lambda path, out: ["decrypt", path, out / "plain.mcap"],
        lambda path, out: ["console", "--play", path, "--port", 0],
    ],
)
def test_each_command_names_the_missing_key(
    words: Callable[[Path, Path], list[object]], merged: Path, keys: dict[str, Path], tmp_path: Path
) -> None:
    said = one_line(command(*words(merged, tmp_path)), 2)
    assert f"encrypted for the key {public(keys['operator'])[:8]}...; set TELETACTION_KEY" in said
    said = one_line(command(*words(merged, tmp_path), "--key", keys["stranger"]), 2)
    assert f"stranger is the key {public(keys['stranger'])[:8]}..." in said


def test_a_cut_recording_is_recovered_and_stays_encrypted(sites: Path, keys: dict[str, Path], tmp_path: Path) -> None:
    cut = tmp_path / "remote.mcap"
    content = (sites / "remote.mcap").read_bytes()
    cut.write_bytes(content[: len(content) // 2])
    done = command("recover", cut, "--key", keys["remote"])
    assert done.code == 0, done.err
    whole = tmp_path / "remote-recovered.mcap"
    assert "encrypted for the key" in one_line(command("recover", whole), 2)
    assert command("recover", whole, "--key", keys["remote"]).err == f"{whole} is whole: nothing needs repair\n"


def test_a_changed_recording_is_recovered_without_the_changed_part(
    sites: Path, keys: dict[str, Path], tmp_path: Path
) -> None:
    changed, key = tmp_path / "remote.mcap", ["--key", keys["remote"]]
    content = bytearray((sites / "remote.mcap").read_bytes())
    content[len(content) // 2] ^= 1
    changed.write_bytes(content)
    assert "damaged: chunk" in one_line(command("export", changed, "--to", "csv", "--out", tmp_path / "out", *key), 2)
    done = command("recover", changed, *key)
    assert done.code == 0, done.err
    assert command("recover", tmp_path / "remote-recovered.mcap", *key).err.endswith("is whole: nothing needs repair\n")
    content[200] ^= 1
    changed.write_bytes(content)
    said = one_line(command("recover", changed, "--out", tmp_path / "again.mcap", *key), 2)
    assert "chunk 0 of the encrypted file was changed: without its beginning, nothing can be recovered" in said


def test_a_recording_is_handed_to_another_person(
    session: Path, merged: Path, keys: dict[str, Path], tmp_path: Path
) -> None:
    given, plain = tmp_path / "given.mcap", tmp_path / "plain.mcap"
    mine, hers = ["--key", keys["operator"]], ["--key", keys["expert"]]
    assert command("encrypt", merged, given, "--for", public(keys["expert"]), *mine).code == 0
    assert "stranger is the key" in one_line(command("decrypt", given, plain, "--key", keys["stranger"]), 2)
    assert command("decrypt", given, plain, *hers).code == 0
    assert command("decrypt", merged, tmp_path / "same.mcap", *mine).code == 0
    assert plain.read_bytes() == (tmp_path / "same.mcap").read_bytes()
    assert plain.stat().st_mode & 0o777 == 0o600
    assert one_line(command("decrypt", given, plain, *hers), 2).endswith("plain.mcap: exists; name another file")
    assert one_line(command("decrypt", plain, tmp_path / "again", *hers), 2).endswith("plain.mcap: is not encrypted")


def test_what_was_cut_or_changed_is_said(merged: Path, keys: dict[str, Path], tmp_path: Path) -> None:
    content = merged.read_bytes()
    (tmp_path / "cut").write_bytes(content[:-100])
    done = command("decrypt", tmp_path / "cut", tmp_path / "a", "--key", keys["operator"])
    assert done.code == 0
    assert "was cut; " in done.err
    (tmp_path / "changed").write_bytes(content[:5000] + b"x" + content[5001:])
    said = one_line(command("decrypt", tmp_path / "changed", tmp_path / "b", "--key", keys["operator"]), 2)
    assert "damaged: chunk 0 of the encrypted file was changed" in said
    assert not (tmp_path / "b").exists()


@pytest.mark.parametrize(
    ("recipient", "said"),
    [
        ("short", "short: neither a public key of 40 characters nor a file"),
        ("x" * 39 + '"', "is no public key: expected 40 Z85 characters"),
    ],
)
def test_a_wrong_recipient_is_named(recipient: str, said: str, merged: Path, tmp_path: Path) -> None:
    assert said in one_line(command("encrypt", merged, tmp_path / "out", "--for", recipient), 2)
    assert not (tmp_path / "out").exists()


def test_a_console_continues_an_encrypted_examination(
    keys: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(KEY_VARIABLE, str(keys["operator"]))
    journal = Journal(tmp_path / "console.mcap", {}, public(keys["operator"]))
    begin = {"what": "begin", "at_s": 1.0, "pseudonym": "P-0417"}
    journal.write("console/session", 1.0, begin)
    journal.close()
    assert b"P-0417" not in (tmp_path / "console.mcap").read_bytes()
    again = Journal(tmp_path / "console.mcap", {}, public(keys["operator"]))
    assert again.unfinished.records == (("console/session", begin),)
    again.close()
