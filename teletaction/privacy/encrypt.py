"""Encrypts a file for the owner of a public key, and decrypts it with the secret key."""

import shutil
from pathlib import Path

from common.files.private_file import creating
from common.link.keys import KEY_LENGTH, KeyProblem, check_public_key, public_key_in
from common.privacy.recording_file import create_recording, open_recording
from common.recording.encrypted_file import CHUNK_BYTES, DamagedChunk, decrypting


def encrypt(path: Path, out: Path, recipient: str) -> bool:
    """Write `path` encrypted into the new file `out`; an encrypted file is decrypted and encrypted again.

    Args:
        path: any file.
        out: file to create.
        recipient: public key in Z85, or the path of a key folder or of a public key's file.

    Returns:
        Whether `path` was whole; an encrypted file that was cut is copied up to its last whole chunk.

    Raises:
        OSError: a file cannot be read or written.
        ValueError: the key is none, `path` cannot be decrypted or was changed, or `out` exists.
    """
    return _copy(path, out, _public_key(recipient))


def decrypt(path: Path, out: Path) -> bool:
    """Write the content of an encrypted file into the new file `out`; otherwise as `encrypt`."""
    with open_recording(path) as file:
        if decrypting(file) is None:
            raise ValueError(f"{path}: is not encrypted")
    return _copy(path, out, None)


def _copy(path: Path, out: Path, public_key: str | None) -> bool:
    with open_recording(path) as source:
        reader = decrypting(source)
        if reader is not None and reader.problem:
            raise ValueError(f"{path}: damaged: {reader.problem}; `teletaction recover` keeps what can be read")
        try:
            with creating(out) as made, create_recording(made, public_key, replace=True) as copy:
                shutil.copyfileobj(source, copy, CHUNK_BYTES)
        except FileExistsError:
            raise ValueError(f"{out}: exists; name another file") from None
        except DamagedChunk as error:
            raise ValueError(f"{path}: damaged: {error}; `teletaction recover` keeps what can be read") from None
    return reader is None or not reader.cut


def _public_key(recipient: str) -> str:
    if len(recipient) == KEY_LENGTH and not Path(recipient).exists():
        return check_public_key(recipient)
    try:
        return public_key_in(Path(recipient))
    except FileNotFoundError:
        raise KeyProblem(f"{recipient}: neither a public key of {KEY_LENGTH} characters nor a file") from None
