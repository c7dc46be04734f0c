"""Stores finished pieces of a study's work in a folder; each is there whole, or not at all."""

import hashlib
import os
import shutil
from contextlib import suppress
from pathlib import Path

_DIGEST_BYTES = hashlib.sha256().digest_size


class KeptPieces:
    """Results by their key, a file each, which begins with the digest of what follows.

    A file gets its name after it is complete, so that a killed writer leaves no result. The digest detects a file that
    a power failure has damaged. Results are pickles: trust the folder as much as the program.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def find(self, key: str) -> bytes | None:
        """Result kept under this key; None where it is missing or damaged."""
        try:
            found = (self._folder / key).read_bytes()
        except FileNotFoundError:
            return None
        digest, result = found[:_DIGEST_BYTES], found[_DIGEST_BYTES:]
        return result if hashlib.sha256(result).digest() == digest else None

    def keep(self, key: str, result: bytes) -> None:
        """Keep a result; raises OSError where the folder cannot be written to."""
        self._folder.mkdir(parents=True, exist_ok=True)
        begun = self._folder / f"{key}.{os.getpid()}.begun"
        begun.write_bytes(hashlib.sha256(result).digest() + result)
        begun.replace(self._folder / key)

    def forget(self) -> None:
        """Remove all, and the folder above if it is empty then."""
        shutil.rmtree(self._folder, ignore_errors=True)
        with suppress(OSError):
            self._folder.parent.rmdir()
