"""Encrypts a recording for one public key in chunks; each chunk is authenticated, so any part is read by itself.

The file begins with a header: magic, version, public key of the recipient, key of this file sealed to it (libsodium's
sealed box), and a random prefix. Chunks follow: u32 little-endian with the length of the content and the flag of the
last chunk, then the content encrypted by XChaCha20-Poly1305 with its tag. The nonce is the prefix, the number of the
chunk and the flag; the header is authenticated with each chunk. A flush ends a chunk, so that nothing is written twice
and a file that was cut is readable up to its last whole chunk.
"""

import io
import os
import struct
from bisect import bisect_right
from dataclasses import dataclass
from types import TracebackType
from typing import IO, Self

MAGIC = b"\x89TACENC\n"
VERSION = 1
CHUNK_BYTES = 1 << 16
"""Maximum number of bytes of content in a chunk."""
KEY_BYTES = 32
_HEADER = struct.Struct("<8sB32s80s15s")
HEADER_BYTES = _HEADER.size
_LENGTH = struct.Struct("<I")
_LAST = 1 << 31
_TAG_BYTES = 16
_KEPT = 8
"""Number of decrypted chunks that a reader keeps; a chunk of MCAP lies in at most six."""


class DamagedChunk(ValueError):
    """A chunk whose content is not what was written at its place."""


class CannotDecrypt(ValueError):
    """An encrypted file that cannot be opened with the given keys."""


@dataclass(frozen=True, slots=True)
class Header:
    """Head of an encrypted file.

    Attributes:
        recipient: public key of the recipient, 32 bytes.
        sealed: key of the file, sealed to the recipient, 80 bytes.
        prefix: first 15 bytes of each nonce.
    """

    recipient: bytes
    sealed: bytes
    prefix: bytes

    @classmethod
    def make(cls, public_key: str) -> tuple[Self, bytes]:
        """Return a header for the owner of a Z85 public key, and the new key of the file.

        Raises:
            ModuleNotFoundError: the extra `privacy` is not installed.
        """
        from nacl.public import PublicKey, SealedBox  # noqa: PLC0415 - an extra, loaded for encrypted files only
        from zmq.utils import z85  # noqa: PLC0415 - a reader of plain recordings has no link

        recipient, key = z85.decode(public_key), os.urandom(KEY_BYTES)
        return cls(recipient, SealedBox(PublicKey(recipient)).encrypt(key), os.urandom(15)), key

    @classmethod
    def read(cls, content: bytes) -> Self:
        """Read the first bytes of a file; raises CannotDecrypt where they are no header, or of another version."""
        if len(content) < HEADER_BYTES or not content.startswith(MAGIC):
            raise CannotDecrypt("cut within its head: nothing in it can be read")
        _, version, recipient, sealed, prefix = _HEADER.unpack_from(content)
        if version != VERSION:
            raise CannotDecrypt(f"encrypted in format {version}, and this program reads format {VERSION}")
        return cls(recipient, sealed, prefix)

    def pack(self) -> bytes:
        """Return the bytes of the header."""
        return _HEADER.pack(MAGIC, VERSION, self.recipient, self.sealed, self.prefix)

    @property
    def public_key(self) -> str:
        """Public key of the recipient, Z85."""
        from zmq.utils import z85  # noqa: PLC0415

        return z85.encode(self.recipient).decode("ascii")

    def open(self, secret_key: bytes) -> bytes:
        """Return the key of the file.

        Args:
            secret_key: secret key of the recipient, Z85.

        Raises:
            CannotDecrypt: it is another key, or the header is damaged.
            ModuleNotFoundError: the extra `privacy` is not installed.
        """
        from nacl.exceptions import CryptoError  # noqa: PLC0415
        from nacl.public import PrivateKey, SealedBox  # noqa: PLC0415
        from zmq.utils import z85  # noqa: PLC0415

        try:
            return SealedBox(PrivateKey(z85.decode(secret_key))).decrypt(self.sealed)
        except CryptoError:
            raise CannotDecrypt("its head is damaged: the key of the file cannot be opened") from None


def is_encrypted(file: IO[bytes]) -> bool:
    """Return whether a seekable file begins as an encrypted one; the position returns to the start."""
    file.seek(0)
    found = file.read(len(MAGIC)) == MAGIC
    file.seek(0)
    return found


class EncryptedWriter(io.BufferedIOBase):
    """Writes an encrypted file. `close` writes the last chunk and closes the file."""

    def __init__(self, file: IO[bytes], header: Header, key: bytes):
        """Write the header to an empty file; header and key come from `Header.make`."""
        from nacl.bindings import crypto_aead_xchacha20poly1305_ietf_encrypt  # noqa: PLC0415

        self._encrypt = crypto_aead_xchacha20poly1305_ietf_encrypt
        self._file, self._key, self._prefix = file, key, header.prefix
        self._head = header.pack()
        self._waiting = bytearray()
        self._written = self._number = 0
        self._ended = False
        file.write(self._head)

    def writable(self) -> bool:
        """Return True."""
        return True

    def write(self, content: object) -> int:
        """Add bytes; each full chunk is written."""
        given = memoryview(content).cast("B")  # type: ignore[arg-type]  # whatever has bytes
        self._waiting += given
        while len(self._waiting) > CHUNK_BYTES:
            self._put(CHUNK_BYTES, last=False)
        return len(given)

    def tell(self) -> int:
        """Return the number of bytes of content so far."""
        return self._written + len(self._waiting)

    def fileno(self) -> int:
        """Return the descriptor of the encrypted file."""
        return self._file.fileno()

    def flush(self) -> None:
        """End the chunk and flush the file."""
        if self._waiting:
            self._put(len(self._waiting), last=False)
        if not self._file.closed:
            self._file.flush()

    def end(self) -> None:
        """Write the last chunk, without closing the file."""
        if not self._ended:
            self._ended = True
            self._put(len(self._waiting), last=True)
            self._file.flush()

    def close(self) -> None:
        """Write the last chunk and close the file."""
        if not self.closed:
            try:
                self.end()
            finally:
                self._waiting.clear()
                self._file.close()
                super().close()

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file; after an error it stays without a last chunk."""
        self._ended = self._ended or kind is not None
        self.close()

    def __del__(self) -> None:
        """Leave an abandoned file without a last chunk, unlike the base class."""

    def _put(self, length: int, *, last: bool) -> None:
        content = bytes(self._waiting[:length])
        del self._waiting[:length]
        nonce = _nonce(self._prefix, self._number, last=last)
        self._file.write(_LENGTH.pack(length | _LAST * last) + self._encrypt(content, self._head, nonce, self._key))
        self._written += length
        self._number += 1


class EncryptedReader(io.RawIOBase):
    """Reads the content of an encrypted file at any place.

    Attributes:
        header: head of the file.
        cut: whether the file lacks its last chunk; its whole chunks are readable.
        problem: damage of the sequence of chunks, as text; empty without one.
        skips_damage: whether a changed chunk reads as zeros, to recover the others, instead of raising DamagedChunk.
    """

    def __init__(self, file: IO[bytes], secret_key: bytes):
        """Find the chunks of a seekable file, which is closed with this object.

        Args:
            file: the encrypted file.
            secret_key: secret key of the recipient, Z85.

        Raises:
            CannotDecrypt: the key of the file cannot be opened with this secret key.
            ModuleNotFoundError: the extra `privacy` is not installed.
        """
        from nacl.bindings import crypto_aead_xchacha20poly1305_ietf_decrypt  # noqa: PLC0415
        from nacl.exceptions import CryptoError  # noqa: PLC0415

        self._decrypt, self._error = crypto_aead_xchacha20poly1305_ietf_decrypt, CryptoError
        self._file = file
        file.seek(0)
        self.header = Header.read(file.read(HEADER_BYTES))
        self._head = self.header.pack()
        self._key = self.header.open(secret_key)
        self._places: list[int] = []
        self._starts = [0]
        """First byte of the content of each chunk, and its end."""
        self._kept: dict[int, bytes] = {}
        self._at = 0
        self.cut, self.problem, self.skips_damage = True, "", False
        self._find_chunks()
        if not self.cut:
            self._check_last()

    def _find_chunks(self) -> None:
        size, at = self._file.seek(0, 2), HEADER_BYTES
        while self.cut and at + _LENGTH.size <= size:
            self._file.seek(at)
            (word,) = _LENGTH.unpack(self._file.read(_LENGTH.size))
            length, place = word & ~_LAST, at + _LENGTH.size
            if length > CHUNK_BYTES:
                self.problem = f"chunk {len(self._places)} of the encrypted file has an impossible length"
                return
            at = place + length + _TAG_BYTES
            if at > size:
                return
            self._places.append(place)
            self._starts.append(self._starts[-1] + length)
            self.cut = not word & _LAST
        if not self.cut and at < size:
            self.problem = "more bytes follow the last chunk of the encrypted file"

    def _check_last(self) -> None:
        """Check the last chunk, which may be empty and would then be read by nobody."""
        try:
            self._chunk(len(self._places) - 1)
        except DamagedChunk as error:
            self.problem = self.problem or str(error)

    def readable(self) -> bool:
        """Return True."""
        return True

    def seekable(self) -> bool:
        """Return True."""
        return True

    def tell(self) -> int:
        """Return the position in the content."""
        return self._at

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move to a place of the content; raises ValueError before its start."""
        at = offset + (0, self._at, self._starts[-1])[whence]
        if at < 0:
            raise ValueError("a place before the start")
        self._at = at
        return at

    def readinto(self, buffer: object) -> int:
        """Read bytes of one chunk; raises DamagedChunk where it is not what was written."""
        room = memoryview(buffer).cast("B")  # type: ignore[arg-type]  # whatever has room
        if self._at >= self._starts[-1]:
            return 0
        number = bisect_right(self._starts, self._at) - 1
        begin = self._at - self._starts[number]
        part = self._chunk(number)[begin : begin + len(room)]
        room[: len(part)] = part
        self._at += len(part)
        return len(part)

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()

    def _chunk(self, number: int) -> bytes:
        if number in self._kept:
            return self._kept[number]
        length = self._starts[number + 1] - self._starts[number]
        last = not self.cut and number == len(self._places) - 1
        self._file.seek(self._places[number])
        sealed = self._file.read(length + _TAG_BYTES)
        try:
            content = self._decrypt(sealed, self._head, _nonce(self.header.prefix, number, last=last), self._key)
        except self._error:
            if not self.skips_damage:
                raise DamagedChunk(f"chunk {number} of the encrypted file was changed") from None
            content = bytes(length)
        if len(self._kept) >= _KEPT:
            del self._kept[next(iter(self._kept))]
        self._kept[number] = content
        return content


def decrypting(file: IO[bytes]) -> EncryptedReader | None:
    """Return the reader of an encrypted file below an open file; None for a plain file."""
    raw = getattr(file, "raw", None)
    return raw if isinstance(raw, EncryptedReader) else None


def _nonce(prefix: bytes, number: int, *, last: bool) -> bytes:
    return prefix + struct.pack("<QB", number, last)
