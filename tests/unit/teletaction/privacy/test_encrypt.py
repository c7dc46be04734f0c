"""A copy that is interrupted leaves no part of a file behind."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from common.link.keys import create_keys
from teletaction.privacy.encrypt import encrypt


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError])
def test_an_interrupted_copy_leaves_nothing(
    error: type[BaseException], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("nacl")

    def copy(source: object, made: Callable[..., object], length: int) -> None:
        raise error

    monkeypatch.setattr(shutil, "copyfileobj", copy)
    create_keys(tmp_path / "keys")
    (tmp_path / "notes.txt").write_text("of an examination", "utf-8")
    with pytest.raises(error):
        encrypt(tmp_path / "notes.txt", tmp_path / "notes.enc", str(tmp_path / "keys"))
    assert not (tmp_path / "notes.enc").exists()
    leader, follower = os.openpty()
    with pytest.raises(error):  # a device stays
        encrypt(tmp_path / "notes.txt", Path(os.ttyname(follower)), str(tmp_path / "keys"))
    os.close(leader)
    os.close(follower)
