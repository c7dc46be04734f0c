"""A rendezvous and both ends of a tunnel in threads."""

import json
from pathlib import Path
from typing import Any, Literal

from common.config.link_models import RendezvousConfig, TunnelConfig
from teletaction.tunnel.rendezvous import run_rendezvous
from teletaction.tunnel.room_secret import create_secret
from teletaction.tunnel.tunnel_end import run_tunnel
from tests.ports import free_port
from tests.unit.common.link.listener import running

ROOM = "ward-3"


class Way:
    """Way from the remote site at one port to an operator at another.

    Attributes:
        folder: has the secret, and the status files.
        remote_port, operator_port: first port of the link at each site.
        port: port of the rendezvous.
    """

    def __init__(self, folder: Path, remote_port: int, operator_port: int) -> None:
        self.folder = folder
        self.remote_port, self.operator_port = remote_port, operator_port
        self.port = free_port()
        self.secret = folder / "secret"
        create_secret(self.secret)

    def status(self, name: str) -> dict[str, Any]:
        """Status of `rendezvous`, or of the end `remote` or `operator`; empty before its first."""
        file = self.folder / f"{name}.json"
        content: dict[str, Any] = json.loads(file.read_text()) if file.exists() else {}
        return content

    def rendezvous(self) -> Any:
        rooms = {ROOM: self.secret}
        return running(
            run_rendezvous, RendezvousConfig(port=self.port, rooms=rooms, status=self.folder / "rendezvous.json")
        )

    def end(self, side: Literal["remote", "operator"], secret: Path | None = None, port: int | None = None) -> Any:
        return running(
            run_tunnel,
            TunnelConfig(
                side=side,
                host="127.0.0.1",
                port=port or self.port,
                room=ROOM,
                secret=secret or self.secret,
                base_port=self.remote_port if side == "remote" else self.operator_port,
                status=self.folder / f"{side}.json",
            ),
        )
