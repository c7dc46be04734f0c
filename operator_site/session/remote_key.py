"""Finds the public key that the remote site must have."""

from shlex import quote

from common.config.link_models import OperatorLinkConfig
from common.link.keys import KeyProblem, TrustedKeys, check_public_key

NAME = "remote"


def remote_public_key(link: OperatorLinkConfig) -> str:
    """Return the remote site's public key from the configuration, or the trusted key named `remote`.

    Raises:
        KeyProblem: there is neither, or the configured key is invalid.
    """
    if link.remote_key is not None:
        return check_public_key(link.remote_key)
    trusted = TrustedKeys(link.keys)
    for key, owner in trusted.owners().items():
        if owner.name == NAME:
            return key
    raise KeyProblem(
        f"{trusted.file}: no key named `{NAME}`; "
        f"add it with `teletaction keys trust --keys {quote(str(trusted.folder))} -- {NAME} KEY`"
    )
