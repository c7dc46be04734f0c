"""Checks the address that a remote site binds to: one open to a network needs a trusted key."""

from shlex import quote

from common.link.curve import LinkProblem
from common.link.host_name import bare_host, is_loopback
from common.link.keys import TrustedKeys


def check_bind(host: str, trusted: TrustedKeys) -> None:
    """Raise an error where a remote site may not bind to `host`.

    Raises:
        LinkProblem: `host` is open to a network and no key is trusted.
        KeyProblem: the list of trusted keys is damaged.
    """
    owners = trusted.owners()
    if not owners and not is_loopback(bare_host(host)):
        raise LinkProblem(
            f"{host} is open to a network and {trusted.file} trusts nobody: "
            f"`teletaction keys trust --keys {quote(str(trusted.folder))} -- NAME KEY` first, or bind to 127.0.0.1"
        )
