"""CurveZMQ keys of a site, and the list of the keys that it trusts.

A key folder holds `site.key` (public) and `site.key_secret` (mode 0600; wider access is refused), as the zmq library
writes them. Its file `trusted` has one `NAME PUBLIC_KEY` per line, followed by `observer` for a read-only client.
"""

import base64
import fcntl
import hashlib
import logging
import os
import re
import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from shlex import quote

import zmq
import zmq.auth
import zmq.utils.z85

from common.files.printable import printable
from common.files.private_file import create_private, discard, refuse_link
from common.link.key_folder import KeyProblem, check_folder, read_own, shown

__all__ = ["KeyPair", "KeyProblem", "Role", "Trusted", "TrustedKeys"]

log = logging.getLogger(__name__)

KEY_LENGTH = 40
_NAME = "site"
_LONGEST_NAME = 64
_PUBLIC = re.compile(rb"""^\s*public-key\s*=\s*["']([^"']*)["']\s*$""", re.MULTILINE)
_SECRET = re.compile(rb"""^\s*secret-key\s*=\s*["']([^"']*)["']\s*$""", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class KeyPair:
    """A site's own keys; Z85 text."""

    public: str
    secret: bytes

    def __repr__(self) -> str:
        return f"KeyPair({fingerprint(self.public)})"


def fingerprint(public_key: str) -> str:
    """Return a short name of a public key for people and logs."""
    digest = hashlib.sha256(public_key.encode()).digest()
    return "curve:" + base64.b32encode(digest[:10]).decode().lower()


def create_keys(folder: Path) -> str:
    """Create a key pair in `folder`; return the public key.

    Raises:
        KeyProblem: there is a secret key, which is never overwritten; or the files cannot be written.
    """
    secret_file = folder / f"{_NAME}.key_secret"
    if secret_file.exists():
        raise KeyProblem(f"{shown(secret_file)}: exists; remove it by hand if this site shall get a new identity")
    _make_folder(folder)
    before = os.umask(0o077)
    try:
        zmq.auth.create_certificates(folder, _NAME)
    except OSError as error:
        discard(secret_file)  # otherwise the next try finds part of a key
        raise KeyProblem(f"{shown(secret_file)}: {error.strerror}") from None
    finally:
        os.umask(before)
    secret_file.chmod(0o600)
    return load_keys(folder).public


def load_keys(folder: Path) -> KeyPair:
    """Read a site's own keys.

    Raises:
        KeyProblem: the keys are missing, unreadable or damaged, or others may read or change the secret key's file.
    """
    secret_file = folder / f"{_NAME}.key_secret"
    try:
        return _read_pair(secret_file)
    except FileNotFoundError:
        name = quote(shown(folder))
        raise KeyProblem(f"{shown(secret_file)}: no key; make one with `teletaction keys init --keys {name}`") from None


def load_key_file(path: Path) -> KeyPair:
    """Read a key pair from the file of its secret key, or from a key folder; raises KeyProblem as `load_keys`."""
    secret_file = path / f"{_NAME}.key_secret" if os.path.isdir(path) else path
    try:
        return _read_pair(secret_file)
    except FileNotFoundError:
        raise KeyProblem(f"{shown(secret_file)}: no such file") from None


def public_key_in(path: Path) -> str:
    """Return the public key of a key folder or of the file of a public key.

    Raises:
        FileNotFoundError: there is no such file.
        KeyProblem: it holds no public key, or others may change it.
    """
    file = path / f"{_NAME}.key" if os.path.isdir(path) else path
    public = _PUBLIC.search(read_own(file))
    if public is None:
        raise KeyProblem(f"{shown(file)}: holds no public key")
    return check_public_key(public[1].decode("latin-1"))


def _read_pair(secret_file: Path) -> KeyPair:
    content = read_own(secret_file, secret=True)
    public, secret = _PUBLIC.search(content), _SECRET.search(content)
    if public is None or secret is None:
        raise KeyProblem(f"{shown(secret_file)}: holds no {'secret' if public else 'public'} key")
    try:
        if zmq.curve_public(secret[1]) == public[1]:
            return KeyPair(public[1].decode("ascii"), secret[1])
    except (ValueError, TypeError, zmq.ZMQError):
        pass
    raise KeyProblem(f"{shown(secret_file)}: is no key pair; copy it again, or make a new one")


def _make_folder(folder: Path) -> None:
    """Create a key folder for its owner only; raises KeyProblem where others may change an existing one."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        check_folder(folder)
    except OSError as error:
        raise KeyProblem(f"{shown(folder)}: {error.strerror}") from None


def check_public_key(text: str) -> str:
    """Return `text` when it is a Z85 public key; raises KeyProblem where it is none."""
    try:
        if len(text) == KEY_LENGTH and len(zmq.utils.z85.decode(text)) == 32:
            return text
    except (KeyError, ValueError, struct.error):  # struct.error: beyond 32 bits
        pass
    raise KeyProblem(f"{printable(text, KEY_LENGTH)!r} is no public key: expected {KEY_LENGTH} Z85 characters")


class Role(Enum):
    """Role of a trusted key."""

    PARTNER = "partner"
    """Takes part in a session: an operator in a remote site's list, the remote site in an operator's."""
    OBSERVER = "observer"
    """Reads without changing anything."""


@dataclass(frozen=True, slots=True)
class Trusted:
    """Owner and role of a trusted key."""

    name: str
    role: Role = Role.PARTNER


_Stamp = tuple[int, int, int, int, int, int, int]
_Owners = dict[str, Trusted]


@dataclass(slots=True)
class TrustedKeys:
    """The allow-list of a key folder; reads the file again when it has changed. Threads may share it."""

    folder: Path
    problem: str = ""
    """Error in the list as of the last `role`, as text; empty while the list is valid."""
    _kept: tuple[_Stamp, _Owners] | None = None

    @property
    def file(self) -> Path:
        """Path of the list."""
        return self.folder / "trusted"

    def owners(self) -> dict[str, Trusted]:
        """Return trusted public keys and the owner of each; empty without a list.

        Raises:
            KeyProblem: a line is not `NAME PUBLIC_KEY [observer]`, the file cannot be read, or others may change it.
        """
        try:
            # Taken before reading: a change during reading gives another stamp, and the next call reads again.
            stamp = self._stamp()
            kept = self._kept
            if kept is None or kept[0] != stamp:
                content = read_own(self.file)
                # One assignment: another thread sees both this stamp and these owners, or neither.
                self._kept = kept = (stamp, self._parsed(content))
        except FileNotFoundError:
            return {}
        except KeyProblem:
            raise
        except (OSError, ValueError) as error:  # ValueError: an invalid file name
            raise KeyProblem(f"{shown(self.file)}: {getattr(error, 'strerror', error)}") from None
        return kept[1]

    def _stamp(self) -> _Stamp:
        """Return a stamp that changes with the list, its owner and mode, and those of its folder."""
        own, of_folder = self.file.stat(), self.folder.stat()
        file = (own.st_ino, own.st_ctime_ns, own.st_mtime_ns, own.st_size)
        return (*file, of_folder.st_ino, of_folder.st_mode, of_folder.st_uid)

    def role(self, public_key: str) -> Role | None:
        """Return the present role of this key; None where it has none. An invalid list gives no key a role.

        A new error is logged once, and so is its end.
        """
        try:
            owner = self.owners().get(public_key)
        except KeyProblem as problem:
            self._notice(str(problem))
            return None
        self._notice("")
        return None if owner is None else owner.role

    def _notice(self, problem: str) -> None:
        before, self.problem = self.problem, problem
        if problem and problem != before:
            log.error("nobody is trusted until this is corrected: %s", problem)
        elif before and not problem:
            log.warning("%s is sound again", self.file)

    def trust(self, name: str, public_key: str, role: Role = Role.PARTNER) -> Trusted | None:
        """Add a key under a name; return its owner before, None for a new key.

        Raises:
            KeyProblem: the key is none, the name has white space, or the list cannot be read or written.
        """
        if not _is_name(name):
            raise KeyProblem(f"{printable(name, _LONGEST_NAME)!r} is no name for a key: use one word")
        check_public_key(public_key)
        _make_folder(self.folder)
        with _locked(self.folder) as folder:
            owners = self.owners()
            self._write({**owners, public_key: Trusted(name, role)}, folder)
        return owners.get(public_key)

    def revoke(self, name: str) -> int:
        """Remove all keys of a name; return how many. Raises KeyProblem when the name has none."""
        names = {owner.name for owner in self.owners().values()}
        if name not in names:
            raise KeyProblem(f"{self.file}: trusts no {name!r}; known: {', '.join(sorted(names)) or 'nobody'}")
        with _locked(self.folder) as folder:
            owners = self.owners()
            kept = {key: owner for key, owner in owners.items() if owner.name != name}
            self._write(kept, folder)
        return len(owners) - len(kept)

    def _parsed(self, content: bytes) -> _Owners:
        owners = {}
        for number, line in enumerate(content.split(b"\n"), start=1):
            where = f"{shown(self.file)}:{number}"
            try:
                words = line.decode("utf-8").split()
            except UnicodeDecodeError:
                raise KeyProblem(f"{where}: not UTF-8; remove this line") from None
            if not words:
                continue
            role = Role.OBSERVER if words[2:] == [Role.OBSERVER.value] else Role.PARTNER
            if len(words) - (role is Role.OBSERVER) != 2 or not _is_name(words[0]):
                raise KeyProblem(f"{where}: expected NAME PUBLIC_KEY, and `observer` or nothing")
            try:
                owners[check_public_key(words[1])] = Trusted(words[0], role)
            except KeyProblem as problem:
                raise KeyProblem(f"{where}: {problem}") from None
        return owners

    def _write(self, owners: _Owners, folder: int) -> None:
        """Replace the list in the open `folder`, and wait for the disk."""
        text = "".join(
            f"{owner.name} {key}{' observer' if owner.role is Role.OBSERVER else ''}\n" for key, owner in owners.items()
        )
        temporary = self.folder / f".trusted.{os.getpid()}"
        try:
            refuse_link(self.file)
            with create_private(temporary, replace=True) as file:
                file.write(text.encode())
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(self.file)
            with suppress(OSError):  # a file system that cannot do this for folders
                os.fsync(folder)  # otherwise a loss of power brings a revoked key back
        except OSError as error:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
            raise KeyProblem(f"{shown(self.file)}: {error.strerror}") from None


@contextmanager
def _locked(folder: Path) -> Iterator[int]:
    """Open a folder for one command at a time: of two at once, the later would undo the change of the other."""
    try:
        number = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError as error:
        raise KeyProblem(f"{shown(folder)}: {error.strerror}") from None
    try:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(number, fcntl.LOCK_EX)
        yield number
    finally:
        os.close(number)


def _is_name(text: str) -> bool:
    """Return whether `text` is one printable word of at most 64 characters."""
    return 0 < len(text) <= _LONGEST_NAME and text.isprintable() and text.split() == [text]
