"""Opens a recording for reading, and creates one that is encrypted where its sources are.

The secret keys come from the environment variable TELETACTION_KEY: one file or key folder, or several separated by `:`.
"""

import io
import os
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import IO, TYPE_CHECKING, cast

from common.files.private_file import create_private
from common.privacy.key_variable import KEY_VARIABLE
from common.recording.encrypted_file import (
    CHUNK_BYTES,
    HEADER_BYTES,
    CannotDecrypt,
    EncryptedReader,
    EncryptedWriter,
    Header,
    decrypting,
    is_encrypted,
)

if TYPE_CHECKING:
    from common.link.keys import KeyPair

_SHOWN = 8
"""Number of characters of a public key in an error."""
_EXTRA = "needs `pip install teletaction[privacy]`"


def open_recording(path: Path) -> IO[bytes]:
    """Open a file for reading; the content of an encrypted one is decrypted as it is read.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is encrypted, and no given key opens it; the message says which one is needed.
    """
    with ExitStack() as opened:
        file = opened.enter_context(path.open("rb"))
        if not file.seekable():
            raise ValueError(f"{path}: is a pipe; a recording is read from a file")
        try:
            content = _decrypted(file) if is_encrypted(file) else file
        except ModuleNotFoundError:
            raise ValueError(f"{path}: reading an encrypted file {_EXTRA}") from None
        except CannotDecrypt as error:
            raise CannotDecrypt(f"{path}: {error}") from None
        opened.pop_all()  # the caller closes it
        return content


def create_recording(path: Path, public_key: str | None, *, replace: bool = False) -> IO[bytes]:
    """Create a private file, encrypted for the owner of a Z85 public key where one is given.

    Raises:
        FileExistsError: the file exists, and `replace` is false.
        OSError: the file cannot be created.
        ValueError: the extra `privacy` is not installed.
    """
    if public_key is None:
        return create_private(path, replace=replace)
    try:
        header, key = Header.make(public_key)
    except ModuleNotFoundError:
        raise ValueError(f"{path}: an encrypted file {_EXTRA}") from None
    return cast(IO[bytes], EncryptedWriter(create_private(path, replace=replace), header, key))


def recipient_of(files: Iterable[IO[bytes]]) -> str | None:
    """Return the public key that encrypts what is made of open files; None if all of them are plain.

    It is the first of the given keys that opened one of them.
    """
    recipients = [reader.header.public_key for reader in map(decrypting, files) if reader is not None]
    if not recipients:
        return None
    return next((pair.public for pair in _given_keys().values() if pair.public in recipients), None)


def _decrypted(file: IO[bytes]) -> IO[bytes]:
    needed = Header.read(file.read(HEADER_BYTES)).public_key
    given = _given_keys()
    pair = next((pair for pair in given.values() if pair.public == needed), None)
    if pair is None:
        have = ", ".join(f"{name} is the key {pair.public[:_SHOWN]}..." for name, pair in given.items())
        raise CannotDecrypt(
            f"encrypted for the key {needed[:_SHOWN]}...; "
            + (have or f"set {KEY_VARIABLE} to the file of its secret key, such as keys/site.key_secret")
        )
    return io.BufferedReader(EncryptedReader(file, pair.secret), CHUNK_BYTES)


def _given_keys() -> "dict[str, KeyPair]":
    """Return the key pairs of the environment by the names of their files; raises KeyProblem."""
    from common.link.keys import load_key_file  # noqa: PLC0415 - a reader of plain recordings has no link

    given = os.environ.get(KEY_VARIABLE, "")
    names = [given] if os.path.exists(given) else given.split(os.pathsep)  # a name may have the separator in it
    return {name: load_key_file(Path(name)) for name in names if name}
