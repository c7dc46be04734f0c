import resource
from pathlib import Path

import pytest

from common.link.key_folder import KeyProblem
from teletaction.tunnel.room_secret import create_secret, read_secret


def test_a_secret_is_made_once_and_for_its_owner_only(tmp_path: Path) -> None:
    file = tmp_path / "ward-3.secret"
    with pytest.raises(KeyProblem, match=r"no such file: `teletaction keys secret"):
        read_secret(file)
    create_secret(file)
    assert len(read_secret(file)) == 64
    with pytest.raises(KeyProblem, match=r"ward-3\.secret: File exists$"):
        create_secret(file)
    file.chmod(0o644)
    with pytest.raises(KeyProblem, match=r"lets others read it"):
        read_secret(file)
    file.write_text("short\n")
    file.chmod(0o600)
    with pytest.raises(KeyProblem, match=r"has 5 characters, at least 32 are needed"):
        read_secret(file)


def test_a_secret_that_does_not_fit_leaves_no_file(tmp_path: Path) -> None:
    file = tmp_path / "ward-3.secret"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10, before[1]))
    try:
        with pytest.raises(KeyProblem, match=r"ward-3\.secret: File too large$"):
            create_secret(file)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    create_secret(file)
