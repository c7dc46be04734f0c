from pathlib import Path

import pytest

from common.config import OperatorLinkConfig
from common.keys import KeyProblem, TrustedKeys, create_keys
from operator_site.remote_key import remote_public_key


@pytest.fixture
def key(tmp_path: Path) -> str:
    return create_keys(tmp_path / "remote")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "operator"


def test_it_is_the_one_trusted_under_the_name_remote(folder: Path, key: str, tmp_path: Path) -> None:
    trusted = TrustedKeys(folder)
    trusted.trust("another", create_keys(tmp_path / "another"))
    trusted.trust("remote", key)
    assert remote_public_key(OperatorLinkConfig(keys=folder)) == key


def test_a_configured_one_comes_first_and_needs_no_list(folder: Path, key: str, tmp_path: Path) -> None:
    assert remote_public_key(OperatorLinkConfig(keys=folder, remote_key=key)) == key
    TrustedKeys(folder).trust("remote", create_keys(tmp_path / "another"))
    assert remote_public_key(OperatorLinkConfig(keys=folder, remote_key=key)) == key


def test_without_either_it_says_what_to_do(folder: Path, key: str) -> None:
    TrustedKeys(folder).trust("another", key)
    with pytest.raises(
        KeyProblem, match=r"no key named `remote`; add it with `teletaction keys trust .* -- remote KEY`"
    ):
        remote_public_key(OperatorLinkConfig(keys=folder))


def test_once_revoked_it_is_not_known_any_more(folder: Path, key: str) -> None:
    trusted = TrustedKeys(folder)
    trusted.trust("remote", key)
    trusted.revoke("remote")
    with pytest.raises(KeyProblem, match="no key named `remote`"):
        remote_public_key(OperatorLinkConfig(keys=folder))


def test_a_configured_one_that_is_no_key_is_refused(folder: Path) -> None:
    with pytest.raises(KeyProblem, match="no public key"):
        remote_public_key(OperatorLinkConfig(keys=folder, remote_key="~" * 40))


def test_a_damaged_list_is_named(folder: Path, key: str) -> None:
    TrustedKeys(folder).trust("remote", key)
    (folder / "trusted").write_text(f"remote {key} perhaps\n", "utf-8")
    with pytest.raises(KeyProblem, match="trusted:1: expected NAME PUBLIC_KEY"):
        remote_public_key(OperatorLinkConfig(keys=folder))
