"""Print the addresses of the simulated devices; a pseudo terminal gets its name only when it is opened."""

import json
from collections.abc import Mapping


def announce(addresses: Mapping[str, str]) -> None:
    """Print one JSON line per device to stdout: `{"device": "tacttip index", "address": "socket://127.0.0.1:7001"}`."""
    for device, address in addresses.items():
        print(json.dumps({"device": device, "address": address}), flush=True)
