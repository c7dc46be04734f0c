"""A site's local control without the site."""

import threading
import time
from typing import Any

from common.link.keys import load_keys
from common.link.local_control import LocalControlSocket
from common.link.session_state import Refused
from tests.conftest import Keys


class Site:
    """A local control that a thread serves as often as a site does."""

    def __init__(self, port: int, keys: Keys):
        self.asked: list[str] = []
        self.mute = False
        self._control = LocalControlSocket(port, load_keys(keys.operator))
        self._on = True
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        while self._on:
            if not self.mute:
                self._control.serve(time.monotonic_ns(), self._do)
            time.sleep(0.002)  # a tick

    def _do(self, verb: str, details: dict[str, Any]) -> dict[str, Any]:
        self.asked.append(verb)
        if verb == "engage":
            raise Refused("a fault is latched")
        return {"state": "connected", "verb": verb, **details}

    def close(self) -> None:
        self._on = False
        self._thread.join()
        self._control.close()
