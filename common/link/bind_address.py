"""Checks the address that a remote site binds to: one open to a network needs a trusted key."""

import ipaddress

from common.link.curve import LinkProblem
from common.link.host_name import bare_host
from common.link.keys import TrustedKeys


def check_bind(host: str, trusted: TrustedKeys) -> None:
    """Raise an error where a remote site may not bind to `host`.

    Raises:
        LinkProblem: `host` is open to a network and no key is trusted.
        KeyProblem: the list of trusted keys is damaged.
    """
    owners = trusted.owners()
    try:
        loopback = host == "localhost" or ipaddress.ip_address(bare_host(host)).is_loopback
    except ValueError:
        loopback = False
    if not loopback and not owners:
        raise LinkProblem(
            f"{host} is open to a network and {trusted.file} trusts nobody: "
            f"`teletaction keys trust --keys {trusted.folder} -- NAME KEY` first, or bind to 127.0.0.1"
        )
