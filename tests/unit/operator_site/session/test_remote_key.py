"""The key that the remote site must have: configured, or trusted under its name."""

from pathlib import Path

import pytest

from common.config.link_models import OperatorLinkConfig
from common.link.keys import KeyProblem, TrustedKeys, create_keys
from operator_site.session.remote_key import remote_public_key

NOT_THERE = r"no key named `remote`; add it with `teletaction keys trust .* -- remote KEY`"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "operator"


@pytest.fixture
def key(tmp_path: Path, folder: Path) -> str:
    """The remote site's, trusted under that name."""
    made = create_keys(tmp_path / "remote")
    TrustedKeys(folder).trust("remote", made)
    return made


def test_the_remote_key_is_the_one_trusted_as_remote_until_it_is_revoked(
    folder: Path, key: str, tmp_path: Path
) -> None:
    trusted = TrustedKeys(folder)
    trusted.trust("another", create_keys(tmp_path / "another"))
    assert remote_public_key(OperatorLinkConfig(keys=folder)) == key
    trusted.revoke("remote")
    with pytest.raises(KeyProblem, match=NOT_THERE):
        remote_public_key(OperatorLinkConfig(keys=folder))


def test_a_configured_key_has_precedence_and_needs_no_list(folder: Path, key: str, tmp_path: Path) -> None:
    configured = create_keys(tmp_path / "another")
    for keys in (folder, tmp_path / "nowhere"):
        assert remote_public_key(OperatorLinkConfig(keys=keys, remote_key=configured)) == configured
    with pytest.raises(KeyProblem, match="no public key"):
        remote_public_key(OperatorLinkConfig(keys=folder, remote_key="~" * 40))


def test_a_damaged_list_is_named(folder: Path, key: str) -> None:
    (folder / "trusted").write_text(f"remote {key} perhaps\n", "utf-8")
    with pytest.raises(KeyProblem, match="trusted:1: expected NAME PUBLIC_KEY"):
        remote_public_key(OperatorLinkConfig(keys=folder))
