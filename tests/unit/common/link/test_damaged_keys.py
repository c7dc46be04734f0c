"""Key folders that are damaged, or that others may change: nobody is allowed, and nothing but KeyProblem is raised."""

import logging
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from common.link.keys import KeyProblem, Role, TrustedKeys, create_keys, load_keys
from tests.conftest import Keys
from tests.unit.common.link.links import ask, operator_link, remote_link
from tests.waiting import wait_until

BELONGS = r"belongs to .*: run as that user, or `chown"
NO_UTF_8 = b"\xff"
ANY_LINE = st.binary(max_size=80) | st.text(max_size=80).map(lambda text: text.encode("utf-8", "surrogatepass"))
ANY_LIST = st.lists(ANY_LINE | st.just(b"operator " + b"0" * 40), max_size=8).map(b"\n".join)
SAME_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)


@pytest.fixture
def trusted(tmp_path: Path) -> TrustedKeys:
    """A list with the key of an operator."""
    trusted = TrustedKeys(tmp_path / "site")
    trusted.trust("operator", create_keys(tmp_path / "operator"))
    return trusted


def own_key(trusted: TrustedKeys) -> str:
    return load_keys(trusted.folder.parent / "operator").public


@SAME_FOLDER
@given(ANY_LIST)
@example(b"operator " + b"#" * 40)
@example(NO_UTF_8)
@example(b"\x1b[2J " + b"0" * 40)
def test_any_bytes_are_a_list_or_a_key_problem(trusted: TrustedKeys, content: bytes) -> None:
    trusted.file.write_bytes(content)
    reader = TrustedKeys(trusted.folder)
    roles = [reader.role(key) for key in ("0" * 40, own_key(trusted))]
    if reader.problem:
        assert str(trusted.file) in reader.problem
        assert reader.problem.isprintable()
        assert roles == [None, None]
        with pytest.raises(KeyProblem):
            reader.owners()
    else:
        assert all(owner.name.isprintable() for owner in reader.owners().values())


@SAME_FOLDER
@given(st.binary(max_size=300) | ANY_LIST.map(lambda text: b"curve\n public-key = " + text + b"\n secret-key = x\n"))
@example(b"")
@example(b"curve\n")
@example(b"public-key\n")
@example(b'metadata\n\ncurve\n    public-key = "abc"\n')
@example(b'public-key = "\xff"\nsecret-key = "' + b"0" * 40 + b'"\n')
@example(b'public-key = "' + b"0" * 40 + b'"\nsecret-key = "' + b"#" * 40 + b'"\n')
def test_any_bytes_are_a_secret_key_or_a_key_problem(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "site.key_secret"
    file.touch(0o600)
    file.write_bytes(content)
    with pytest.raises(KeyProblem, match=r"site\.key_secret"):
        load_keys(tmp_path)


def test_a_damaged_line_is_logged_once_with_file_line_and_remedy(
    trusted: TrustedKeys, caplog: pytest.LogCaptureFixture
) -> None:
    key = own_key(trusted)
    sound = trusted.file.read_bytes()
    assert trusted.role(key) is Role.PARTNER
    assert trusted.problem == ""
    with caplog.at_level(logging.INFO):
        for damage in (NO_UTF_8, b"nokey\n"):
            trusted.file.write_bytes(sound + damage)
            for _ in range(3):
                assert trusted.role(key) is None
            (record,) = caplog.records
            assert record.levelno == logging.ERROR
            assert f"{trusted.file}:2: " in record.getMessage()
            assert "nobody is trusted" in record.getMessage()
            assert trusted.problem in record.getMessage()
            caplog.clear()
        trusted.file.write_bytes(sound)
        assert trusted.role(key) is Role.PARTNER
    assert trusted.problem == ""
    (record,) = caplog.records
    assert "sound again" in record.getMessage()


@pytest.mark.parametrize(
    ("place", "mode", "sound_mode"),
    [
        *(("trusted", mode, 0o644) for mode in (0o620, 0o602, 0o666)),
        # Secrets of Kubernetes lie in a folder with mode 1777: others cannot replace a file in it.
        *((".", mode, 0o1777) for mode in (0o770, 0o707, 0o777)),
    ],
)
def test_a_list_or_a_folder_that_others_may_write_allows_nobody(
    trusted: TrustedKeys, place: str, mode: int, sound_mode: int
) -> None:
    key, path = own_key(trusted), trusted.folder / place
    assert trusted.role(key) is Role.PARTNER
    path.chmod(mode)
    assert trusted.role(key) is None
    with pytest.raises(KeyProblem, match=f"{path.name}: mode {mode:04o} lets others change it; `chmod go-w"):
        trusted.owners()
    if place == ".":
        with pytest.raises(KeyProblem, match="lets others change it"):
            create_keys(trusted.folder)
    path.chmod(sound_mode)
    assert trusted.role(key) is Role.PARTNER


def test_a_list_of_another_user_allows_nobody_and_one_of_root_is_fine(
    trusted: TrustedKeys, monkeypatch: pytest.MonkeyPatch
) -> None:
    key, me = own_key(trusted), os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: me + 1)
    if me != 0:
        assert trusted.role(key) is None
        with pytest.raises(KeyProblem, match=BELONGS):
            trusted.owners()
        return
    assert trusted.role(key) is Role.PARTNER
    os.chown(trusted.file, me + 2, -1)
    assert trusted.role(key) is None
    with pytest.raises(KeyProblem, match=f"trusted: {BELONGS}"):
        trusted.owners()


def test_new_folders_and_lists_are_for_their_owner_only(tmp_path: Path) -> None:
    before = os.umask(0o002)
    try:
        key = create_keys(tmp_path / "site")
        trusted = TrustedKeys(tmp_path / "site")
        trusted.trust("operator", key)
    finally:
        os.umask(before)
    assert trusted.role(key) is Role.PARTNER
    assert trusted.folder.stat().st_mode & 0o777 == 0o700
    assert trusted.file.stat().st_mode & 0o777 == 0o600
    assert {file.name for file in trusted.folder.iterdir()} == {"site.key", "site.key_secret", "trusted"}


def test_a_replaced_list_of_the_same_size_and_time_is_read_again(trusted: TrustedKeys) -> None:
    key, status = own_key(trusted), trusted.file.stat()
    other = create_keys(trusted.folder.parent / "other")
    assert trusted.role(key) is Role.PARTNER
    new = trusted.folder / "new"
    new.write_text(f"operator {other}\n")
    os.utime(new, ns=(status.st_atime_ns, status.st_mtime_ns))
    new.replace(trusted.file)
    after = trusted.file.stat()
    assert (after.st_size, after.st_mtime_ns) == (status.st_size, status.st_mtime_ns)
    assert trusted.role(key) is None
    assert trusted.role(other) is Role.PARTNER


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir])
def test_a_list_that_is_no_file_is_refused_without_waiting(trusted: TrustedKeys, make: object) -> None:
    trusted.file.unlink()
    assert callable(make)
    make(trusted.file)
    assert trusted.role("0" * 40) is None
    with pytest.raises(KeyProblem, match="trusted: "):
        trusted.owners()
    (trusted.folder / "site.key_secret").unlink(missing_ok=True)
    make(trusted.folder / "site.key_secret")
    with pytest.raises(KeyProblem, match=r"site\.key_secret: "):
        load_keys(trusted.folder)


def test_a_list_behind_a_link_is_read_and_never_written(trusted: TrustedKeys) -> None:
    """Secrets of Kubernetes are links; what they point to is checked."""
    key, there = own_key(trusted), trusted.folder / "there"
    trusted.file.rename(there)
    trusted.file.symlink_to(there)
    assert trusted.role(key) is Role.PARTNER
    with pytest.raises(KeyProblem, match="is a symbolic link"):
        trusted.revoke("operator")
    there.chmod(0o666)
    assert trusted.role(key) is None


def test_a_path_with_a_zero_byte_is_a_key_problem(tmp_path: Path) -> None:
    with pytest.raises(KeyProblem):
        TrustedKeys(tmp_path / "a\0b").owners()
    with pytest.raises(KeyProblem):
        load_keys(tmp_path / "a\0b")


def test_a_running_site_outlives_a_damaged_list_and_serves_again_once_it_is_sound(keys: Keys, base_port: int) -> None:
    trusted = TrustedKeys(keys.remote)
    sound = trusted.file.read_bytes()
    key = load_keys(keys.operator).public
    with remote_link(keys, base_port) as remote:
        with operator_link(keys, base_port) as operator:
            ask(remote, operator)
            trusted.file.write_bytes(sound + NO_UTF_8)
            assert remote.recheck_keys() == {key}
            assert f"{trusted.file}:2: " in remote.keys_problem
            operator.reconnect()
            # `requests` binds again what still held its port.
            wait_until(lambda: remote.requests("control") == [] and operator.key_refused())
            assert not operator.send("control", b"?")
        trusted.file.write_bytes(sound)
        with operator_link(keys, base_port) as operator:
            ask(remote, operator)
        assert remote.recheck_keys() == set()
        assert remote.keys_problem == ""


def test_a_site_does_not_start_with_a_damaged_list(keys: Keys, base_port: int) -> None:
    file = TrustedKeys(keys.remote).file
    file.write_bytes(file.read_bytes() + NO_UTF_8)
    with pytest.raises(KeyProblem, match=r"trusted:2: not UTF-8"):
        remote_link(keys, base_port)
