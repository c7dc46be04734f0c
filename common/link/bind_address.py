"""Which address a remote site may bind to: one that is open to a network only when it trusts somebody."""

import ipaddress

from common.link.curve import LinkProblem
from common.link.host_name import bare_host
from common.link.keys import TrustedKeys


def check_bind(host: str, trusted: TrustedKeys) -> None:
    """Whether a remote site may bind to `host`.

    Raises:
        LinkProblem: `host` is open to a network and nobody is trusted: keys come first.
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
