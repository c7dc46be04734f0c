import errno
import os
import stat
import threading
import time
from pathlib import Path
from unittest.mock import Mock

import pytest
import zmq.auth

from common.link.keys import (
    KEY_LENGTH,
    KeyProblem,
    Role,
    Trusted,
    TrustedKeys,
    check_public_key,
    create_keys,
    fingerprint,
    load_keys,
)
from tests.conftest import Keys
from tests.unit.common.link.links import ask, operator_link, remote_link


@pytest.fixture
def key(tmp_path: Path) -> str:
    return create_keys(tmp_path / "other")


def test_a_new_secret_key_is_for_its_owner_only_and_its_name_reveals_nothing(tmp_path: Path, key: str) -> None:
    public = create_keys(tmp_path / "site")
    secret_file = tmp_path / "site" / "site.key_secret"
    assert stat.S_IMODE(secret_file.stat().st_mode) == 0o600
    pair = load_keys(tmp_path / "site")
    assert pair.public == public
    assert len(public) == len(pair.secret) == KEY_LENGTH
    assert pair.secret.decode() not in repr(pair)
    assert fingerprint(public) in repr(pair)
    assert fingerprint(public).startswith("curve:")
    assert fingerprint(public) != fingerprint(key)
    assert public[:8] not in fingerprint(public)


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o660, 0o644, 0o601])
def test_a_looser_secret_key_is_refused(tmp_path: Path, mode: int) -> None:
    create_keys(tmp_path)
    (tmp_path / "site.key_secret").chmod(mode)
    with pytest.raises(KeyProblem, match=f"mode {mode:04o} lets others read it; `chmod 600`"):
        load_keys(tmp_path)


def test_a_secret_key_is_never_overwritten_and_a_missing_one_is_explained(tmp_path: Path) -> None:
    with pytest.raises(KeyProblem, match=r"no key; make one with `teletaction keys init"):
        load_keys(tmp_path)
    public = create_keys(tmp_path)
    with pytest.raises(KeyProblem, match="exists"):
        create_keys(tmp_path)
    assert load_keys(tmp_path).public == public


def test_keys_that_do_not_fit_on_the_disk_leave_no_secret_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(folder: Path, name: str) -> None:
        (folder / f"{name}.key_secret").touch()
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(zmq.auth, "create_certificates", full)
        with pytest.raises(KeyProblem, match=r"site\.key_secret: No space left on device$"):
            create_keys(tmp_path)
    create_keys(tmp_path)


@pytest.mark.parametrize(
    "text", ["", "short", "x" * 39, "x" * 41, *(one * 40 for one in ("é", "~", '"', "#", "\0", "\udc80"))]
)
def test_a_wrong_public_key_is_refused(text: str) -> None:
    with pytest.raises(KeyProblem, match="no public key"):
        check_public_key(text)


def test_trust_revoke_and_reload(tmp_path: Path, key: str) -> None:
    here, elsewhere = TrustedKeys(tmp_path / "site"), TrustedKeys(tmp_path / "site")
    assert not here.role(key)
    elsewhere.trust("operator", key)
    assert here.role(key)
    assert here.owners() == {key: Trusted("operator")}
    second = create_keys(tmp_path / "second")
    elsewhere.trust("student", second, Role.OBSERVER)
    assert here.role(key) is Role.PARTNER
    assert here.role(second) is Role.OBSERVER
    with pytest.raises(KeyProblem, match="trusts no 'remote'; known: operator"):
        elsewhere.revoke("remote")
    assert elsewhere.revoke("operator") == 1
    assert not here.role(key)
    assert here.role(second)


def test_every_key_can_be_trusted(tmp_path: Path) -> None:
    """Z85 has characters like # in it, which must not cut a line short."""
    trusted = TrustedKeys(tmp_path)
    alphabet = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#"
    for start in range(0, len(alphabet) - 5, 5):
        five = alphabet[start : start + 4]
        key = f"0{five}" * 8
        trusted.trust(f"k{start}", key)
        assert TrustedKeys(tmp_path).role(key)


@pytest.mark.parametrize(
    "name", ["", "two words", " ", "tab\tname", "\x1b[2Jx", "\u202eoperator", "\udc80", "a\0b", "x" * 65]
)
def test_a_name_is_one_word_that_can_be_shown(tmp_path: Path, key: str, name: str) -> None:
    with pytest.raises(KeyProblem, match="no name for a key: use one word"):
        TrustedKeys(tmp_path).trust(name, key)


@pytest.mark.parametrize(
    "line", ["nokey", "operator short", "a b c", "operator " + "~" * 40, "a b observer c", "a observer"]
)
def test_a_damaged_list_allows_nobody(tmp_path: Path, key: str, line: str) -> None:
    trusted = TrustedKeys(tmp_path)
    trusted.trust("operator", key)
    assert trusted.role(key)
    with trusted.file.open("a") as file:
        file.write(line + "\n")
    os.utime(trusted.file, ns=(1, 1))
    assert not trusted.role(key)
    with pytest.raises(KeyProblem, match=r"trusted:2|no public key"):
        trusted.owners()


def test_two_commands_at_once_lose_no_change(tmp_path: Path, key: str, monkeypatch: pytest.MonkeyPatch) -> None:
    other = create_keys(tmp_path / "site")
    TrustedKeys(tmp_path / "site").trust("old", key)
    written = threading.Event()

    def slow(number: int) -> None:
        written.set()
        time.sleep(0.1)

    monkeypatch.setattr(os, "fsync", slow)
    revoking = threading.Thread(target=TrustedKeys(tmp_path / "site").revoke, args=("old",))
    revoking.start()
    assert written.wait(5.0)
    TrustedKeys(tmp_path / "site").trust("new", other)
    revoking.join()
    assert TrustedKeys(tmp_path / "site").owners() == {other: Trusted("new")}


def test_a_revoked_key_stays_revoked_after_a_loss_of_power(
    tmp_path: Path, key: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    trusted = TrustedKeys(tmp_path / "site")
    trusted.trust("old", key)
    synced: list[tuple[bool, set[str]]] = []

    def note(number: int) -> None:
        owners = {owner.name for owner in TrustedKeys(trusted.folder).owners().values()}
        synced.append((stat.S_ISDIR(os.fstat(number).st_mode), owners))

    monkeypatch.setattr(os, "fsync", note)
    trusted.revoke("old")
    assert synced == [(False, {"old"}), (True, set())], "the new list, then its name"


def test_a_key_is_revoked_while_strangers_hold_all_descriptors(
    keys: Keys, base_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their connections cannot be counted then."""
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator:
        ask(remote, operator)
        monkeypatch.setattr(os, "listdir", Mock(side_effect=OSError(errno.EMFILE, "Too many open files")))
        TrustedKeys(keys.remote).revoke("operator")
        assert remote.recheck_keys() == {load_keys(keys.operator).public}
