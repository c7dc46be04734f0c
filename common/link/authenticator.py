"""Authenticates connections to the link's sockets in a thread of its own (ZeroMQ RFC 27, ZAP).

Each socket has a domain, and each domain requires a role of the key. Admitted keys are remembered, so that connections
of a key can be cut when it is revoked. A key with too many handshakes is refused for a while.
"""

import logging
import threading
import time
from collections import Counter
from collections.abc import Callable

import zmq
import zmq.utils.z85

from common.link.keys import fingerprint
from common.link.rate_limiter import RateLimiters

log = logging.getLogger(__name__)

Admits = Callable[[str, str], bool]
"""Function of a domain and a public key that returns whether the key may connect to the domain."""

MOST_FOR_OBSERVERS = 32
"""Maximum number of connections to one port at which an observer's further one is admitted. The library sets no limit,
and idle connections of one key would take all file descriptors of the process."""
KNOCKS_PER_S = 20.0
"""Maximum rate of one key's handshakes, 1/s; a site retries at most twice a second."""
KNOCKS_AT_ONCE = 40
"""Maximum number of one key's handshakes at once; a site opens all its streams at once."""
_QUIET_S = 10.0
"""Minimum time between two log lines about refusals, s: a flood cannot fill a disk. All refusals are counted."""
_ADDRESS = "inproc://zeromq.zap.01"
_END = b"end"


class Authenticator:
    """Authenticates the connections of one ZeroMQ context, which may have only one authenticator."""

    def __init__(
        self,
        context: "zmq.Context[zmq.Socket[bytes]]",
        admits: Admits,
        now_s: Callable[[], float] = time.monotonic,
        *,
        limited: bool = True,
        full: Admits = lambda domain, key: False,
    ):
        """Start answering; create it before the first socket is bound.

        Args:
            context: context of the sockets.
            admits: decides whether a key may connect to a domain.
            now_s: a steady clock, s.
            limited: whether a key with too many handshakes is refused for a while.
            full: returns whether a domain has no place for one more connection of an admitted key.
        """
        self.answers: Counter[str] = Counter()
        """Number of handshakes by result: `admitted`, `refused` (key not trusted for this), `too_many`, `expelled`, or
        `failed` (the check raised an exception)."""
        self._context = context
        self._admits, self._full = admits, full
        self._now_s = now_s
        self._knocks: RateLimiters[str] | None = RateLimiters(KNOCKS_PER_S, KNOCKS_AT_ONCE) if limited else None
        self._inside: dict[str, set[str]] = {}
        self._refused_until_s: dict[tuple[str, str], float] = {}
        self._lock = threading.Lock()
        self._said_s = -_QUIET_S
        socket = context.socket(zmq.REP)
        socket.setsockopt(zmq.LINGER, 0)
        socket.bind(_ADDRESS)
        self._thread = threading.Thread(target=self._serve, args=(socket,), name="authenticator", daemon=True)
        self._thread.start()

    def revoked(self) -> dict[str, set[str]]:
        """Return the keys admitted to each domain that have lost this right, and forget them."""
        with self._lock:
            inside = {domain: set(keys) for domain, keys in self._inside.items()}
        out = {domain: {key for key in keys if not self._admits(domain, key)} for domain, keys in inside.items()}
        with self._lock:
            for domain, keys in out.items():
                self._inside[domain] -= keys
        return {domain: keys for domain, keys in out.items() if keys}

    def refuse(self, domain: str, key: str, refuse_s: float) -> None:
        """Answer handshakes of `key` at `domain` with status 300 for `refuse_s` seconds."""
        now_s = self._now_s()
        with self._lock:
            still = {whom: until_s for whom, until_s in self._refused_until_s.items() if until_s > now_s}
            self._refused_until_s = {**still, (domain, key): now_s + refuse_s}

    def forgive(self, key: str) -> None:
        """Answer handshakes of `key` again; ends every `refuse` of it."""
        with self._lock:
            kept = {whom: until_s for whom, until_s in self._refused_until_s.items() if whom[1] != key}
            self._refused_until_s = kept

    def close(self) -> None:
        """End the thread; call it before the context is destroyed."""
        end = self._context.socket(zmq.REQ)
        end.setsockopt(zmq.LINGER, 0)
        end.connect(_ADDRESS)
        end.send(_END)
        self._thread.join(timeout=2.0)
        end.close()

    def _serve(self, socket: "zmq.Socket[bytes]") -> None:
        while (question := socket.recv_multipart()) != [_END]:
            socket.send_multipart(self._answer(question))
        socket.close()

    def _answer(self, question: list[bytes]) -> list[bytes]:
        """Answer one handshake; an exception refuses it, and the thread continues."""
        try:
            return self._judged(question)
        except Exception as error:
            self.answers["failed"] += 1
            if self._may_say():
                log.exception("refused a connection that could not be judged: %s", type(error).__name__)
            version, request = (*question[:2], b"", b"")[:2]
            return [version, request, b"400", b"not trusted", b"", b""]

    def _judged(self, question: list[bytes]) -> list[bytes]:
        version, request, domain_bytes, address, _, mechanism, *credentials = question
        status, reason, user = b"400", b"not trusted", b""
        if mechanism == b"CURVE" and len(credentials) == 1:
            key = zmq.utils.z85.encode(credentials[0]).decode()
            domain = domain_bytes.decode("utf-8", errors="replace")
            if not self._admits(domain, key):
                self.answers["refused"] += 1
                self._say("refused a connection to %s from %s: key %s is not trusted", domain, address, key)
            elif self._refused_until_s.get((domain, key), 0.0) > self._now_s():
                self.answers["expelled"] += 1
                self._say("refused a connection to %s from %s: key %s was expelled", domain, address, key)
                status, reason = b"300", b"expelled for a while"
            elif (self._knocks is not None and not self._knocks.allows(key, self._now_s())) or self._full(domain, key):
                # The far side's library retries by itself after status 300.
                self.answers["too_many"] += 1
                self._say("too many connections to %s from %s with key %s", domain, address, key)
                status, reason = b"300", b"too many connections"
            else:
                self.answers["admitted"] += 1
                with self._lock:
                    self._inside.setdefault(domain, set()).add(key)
                status, reason, user = b"200", b"OK", key.encode()
        return [version, request, status, reason, user, b""]

    def _say(self, text: str, domain: str, address: bytes, key: str) -> None:
        if self._may_say():
            log.warning(text, domain, address.decode("ascii", errors="replace"), fingerprint(key))

    def _may_say(self) -> bool:
        now_s = self._now_s()
        if now_s - self._said_s < _QUIET_S:
            return False
        self._said_s = now_s
        return True
