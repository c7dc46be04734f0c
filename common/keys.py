"""CurveZMQ keys of a site and the list of those it trusts.

A key folder holds `site.key` (public) and `site.key_secret` (0600, looser refused), as the zmq
library writes them, and `trusted`: one `NAME PUBLIC_KEY` per line, followed by `observer` where the
owner of the key may only look on.
"""

import base64
import hashlib
import os
import stat
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import zmq.auth
import zmq.utils.z85

KEY_LENGTH = 40
_NAME = "site"


class KeyProblem(ValueError):
    """A key folder that cannot be used; the message names the file and what to do."""


@dataclass(frozen=True, slots=True)
class KeyPair:
    """A site's own keys, Z85 text."""

    public: str
    secret: bytes

    def __repr__(self) -> str:
        return f"KeyPair({fingerprint(self.public)})"


def fingerprint(public_key: str) -> str:
    """Short name of a public key for people and logs."""
    digest = hashlib.sha256(public_key.encode()).digest()
    return "curve:" + base64.b32encode(digest[:10]).decode().lower()


def create_keys(folder: Path) -> str:
    """Make a new key pair in `folder`; return the public key.

    Raises:
        KeyProblem: there is a secret key already, which is never overwritten.
    """
    secret_file = folder / f"{_NAME}.key_secret"
    if secret_file.exists():
        raise KeyProblem(f"{secret_file}: exists; remove it by hand if this site shall get a new identity")
    folder.mkdir(parents=True, exist_ok=True)
    before = os.umask(0o077)
    try:
        zmq.auth.create_certificates(folder, _NAME)
    finally:
        os.umask(before)
    secret_file.chmod(0o600)
    return load_keys(folder).public


def load_keys(folder: Path) -> KeyPair:
    """Read a site's own keys.

    Raises:
        KeyProblem: no keys there, unreadable, or the secret key's file is open to others.
    """
    secret_file = folder / f"{_NAME}.key_secret"
    if not secret_file.is_file():
        raise KeyProblem(f"{secret_file}: no key; make one with `teletaction keys init --keys {folder}`")
    mode = stat.S_IMODE(secret_file.stat().st_mode)
    if mode & 0o077:
        raise KeyProblem(f"{secret_file}: mode {mode:04o} lets others read it; `chmod 600` it or make a new key")
    try:
        public, secret = zmq.auth.load_certificate(secret_file)
    except (OSError, ValueError) as error:
        raise KeyProblem(f"{secret_file}: {error}") from None
    if secret is None:
        raise KeyProblem(f"{secret_file}: holds no secret key")
    return KeyPair(public.decode(), secret)


def check_public_key(text: str) -> str:
    """Return `text` when it is a Z85 public key.

    Raises:
        KeyProblem: it is not.
    """
    try:
        if len(text) == KEY_LENGTH and len(zmq.utils.z85.decode(text)) == 32:
            return text
    except (KeyError, ValueError):
        pass
    raise KeyProblem(f"{text!r} is no public key: expected {KEY_LENGTH} Z85 characters")


class Role(Enum):
    """What the owner of a trusted key may do."""

    PARTNER = "partner"
    """Take part in a session: an operator at a remote site's list, the remote site at an operator's."""
    OBSERVER = "observer"
    """Look on, and change nothing."""


@dataclass(frozen=True, slots=True)
class Trusted:
    """Whose a trusted key is, and what for."""

    name: str
    role: Role = Role.PARTNER


@dataclass(slots=True)
class TrustedKeys:
    """The allow-list of a key folder; reads the file again when it changed."""

    folder: Path
    _stamp: tuple[int, int] | None = None
    _owners: dict[str, Trusted] | None = None

    @property
    def file(self) -> Path:
        """Where the list stands."""
        return self.folder / "trusted"

    def owners(self) -> dict[str, Trusted]:
        """Trusted public keys and the owner of each.

        Raises:
            KeyProblem: a line is not `NAME PUBLIC_KEY [observer]`, or the file cannot be read.
        """
        try:
            status = self.file.stat()
            stamp = (status.st_mtime_ns, status.st_size)
            if self._owners is None or stamp != self._stamp:
                self._owners = self._read()
                self._stamp = stamp
        except FileNotFoundError:
            return {}
        except OSError as error:
            raise KeyProblem(f"{self.file}: {error.strerror}") from None
        return self._owners

    def role(self, public_key: str) -> Role | None:
        """What the owner of this key may do now; None for nothing. A damaged list allows nobody anything."""
        try:
            owner = self.owners().get(public_key)
        except KeyProblem:
            return None
        return None if owner is None else owner.role

    def trust(self, name: str, public_key: str, role: Role = Role.PARTNER) -> None:
        """Add a key under a name; raises KeyProblem on a bad key or a name with white space."""
        if not name or len(name.split()) != 1:
            raise KeyProblem(f"{name!r} is no name for a key: use one word")
        self._write({**self.owners(), check_public_key(public_key): Trusted(name, role)})

    def revoke(self, name: str) -> int:
        """Remove all keys of a name; return how many. Raises KeyProblem when there is none."""
        owners = self.owners()
        kept = {key: owner for key, owner in owners.items() if owner.name != name}
        if len(kept) == len(owners):
            known = ", ".join(sorted({owner.name for owner in owners.values()}))
            raise KeyProblem(f"{self.file}: trusts no {name!r}; known: {known or 'nobody'}")
        self._write(kept)
        return len(owners) - len(kept)

    def _read(self) -> dict[str, Trusted]:
        owners = {}
        for number, line in enumerate(self.file.read_text("utf-8").splitlines(), start=1):
            words = line.split()
            if not words:
                continue
            role = Role.OBSERVER if words[2:] == [Role.OBSERVER.value] else Role.PARTNER
            if len(words) - (role is Role.OBSERVER) != 2:
                raise KeyProblem(f"{self.file}:{number}: expected NAME PUBLIC_KEY, and `observer` or nothing")
            owners[check_public_key(words[1])] = Trusted(words[0], role)
        return owners

    def _write(self, owners: dict[str, Trusted]) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        temporary = self.file.with_suffix(".new")
        lines = (
            f"{owner.name} {key}{' observer' if owner.role is Role.OBSERVER else ''}\n" for key, owner in owners.items()
        )
        temporary.write_text("".join(lines), "utf-8")
        temporary.replace(self.file)
        self._owners = None
